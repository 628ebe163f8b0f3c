"""Inverse kinematics against the closed form of a six-axis arm with a spherical wrist."""

import runpy
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import flexmb as fmb

PUMA = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "puma_arm.py"))
A2, A3, D3, D4 = 0.4318, 0.0203, 0.15005, 0.4318
HAND = "link_6.tool"


@pytest.fixture(scope="module")
def tree():
    return fmb.JointTree(PUMA["arm"]())


def turn(axis, angle):
    """Return a rotation about axis 0, 1 or 2."""
    return fmb.Pose((0, 0, 0), tuple(angle if k == axis else 0.0 for k in range(3))).matrix


def solutions(r, R):
    """Return the eight solutions of the PUMA 560, (8, 6), rad (Pieper 1968; Paul 1981, chapter 3, in kind).

    The wrist lies D3 beside the plane of the arm, and in that plane at the end of the links A2 and (A3, D4): shoulder
    left or right, elbow up or down; R_36 = R_z(q4) R_y(-q5) R_z(q6) leaves the wrist as it is, or flipped.
    """
    found = []
    x, y, z = r
    for shoulder, elbow, wrist in product((1, -1), repeat=3):
        q1 = np.arctan2(y, x) + np.arctan2(D3, shoulder * np.sqrt(x * x + y * y - D3**2))
        X, Y, L = np.cos(q1) * x + np.sin(q1) * y, z, np.hypot(A3, D4)
        bend = elbow * np.arccos((X * X + Y * Y - A2**2 - L * L) / (2 * A2 * L))
        q2 = np.arctan2(Y, X) - np.arctan2(L * np.sin(bend), A2 + L * np.cos(bend))
        q3 = bend - np.arctan2(D4, A3)
        R3 = turn(2, q1) @ turn(0, np.pi / 2) @ turn(2, q2 + q3) @ turn(0, -np.pi / 2)
        W = R3.T @ R
        q5 = wrist * np.arccos(W[2, 2])
        s = -np.sin(q5)
        found.append([q1, q2, q3, np.arctan2(W[1, 2] / s, W[0, 2] / s), q5, np.arctan2(W[2, 1] / s, -W[2, 0] / s)])
    return np.array(found)


def test_every_solution_of_the_closed_form_is_found(tree, rng):
    """From a start near each of the eight, in six random poses: the angles to 1e-8, not only the pose."""
    for there in rng.uniform(-1.2, 1.2, (6, 6)) + np.array([0, 0, np.pi / 2, 0, 1.5, 0]):
        r, R = tree.pose(HAND, there)
        exact = solutions(r, R)
        assert len(exact) == 8
        assert min(np.abs(np.sin((exact - there) / 2)).max(axis=1)) < 1e-9  # the arm's own angles are among them
        for q in exact:
            np.testing.assert_allclose(tree.pose(HAND, q)[0], r, atol=1e-13)
            np.testing.assert_allclose(tree.pose(HAND, q)[1], R, atol=1e-13)
            found = tree.reach(HAND, fmb.Pose(r, R), start=q + 0.1 * rng.normal(size=6))
            np.testing.assert_allclose(np.sin((found - q) / 2), 0.0, atol=1e-8)


def test_limits_choose_among_the_solutions(tree, rng):
    """Limits around one solution, a start in their middle: that one is found, wherever in the limits it lies."""
    there = np.array([0.4, -0.6, 2.0, 0.5, 0.9, -0.7])
    r, R = tree.pose(HAND, there)
    exact = solutions(r, R)
    assert len(exact) == 8
    for q in exact:
        shift = rng.uniform(-0.4, 0.4, 6)
        limits = {name: (x + s - 0.5, x + s + 0.5) for name, x, s in zip(tree.names, q, shift, strict=True)}
        found = tree.reach(HAND, fmb.Pose(r, R), start=q + shift, limits=limits)
        np.testing.assert_allclose(found, q, atol=1e-8)


def test_a_start_far_away_still_reaches(tree, rng):
    """Starts anywhere: one of the eight solutions is found, by other starts if the first gets stuck."""
    for there, start in zip(
        rng.uniform(-1.2, 1.2, (10, 6)) + [0, 0, 1.5, 0, 1.5, 0], rng.uniform(-3, 3, (10, 6)), strict=True
    ):
        r, R = tree.pose(HAND, there)
        found = tree.reach(HAND, fmb.Pose(r, R), start=start)
        assert min(np.abs(np.sin((solutions(r, R) - found) / 2)).max(axis=1)) < 1e-7


def test_wrist_in_line(tree):
    """Where the axes 4 and 6 are one line their angles are not unique and the Jacobian is singular:
    the pose is reached.
    """
    there = np.array([0.3, -0.5, 1.9, 0.7, 0.0, 0.4])
    r, R = tree.pose(HAND, there)
    found = tree.reach(HAND, fmb.Pose(r, R), start=there + 0.2)
    np.testing.assert_allclose(tree.pose(HAND, found)[0], r, atol=1e-9)
    np.testing.assert_allclose(tree.pose(HAND, found)[1], R, atol=1e-8)
    assert np.linalg.cond(tree.jacobian(HAND, there)) > 1e12
