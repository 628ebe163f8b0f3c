"""Products with the inertia matrix of a tree of reduced beams, beside that of all nodes of the mesh."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction

LENGTH, NODES, TURNS, GRAVITY = 0.8, 6, (0.3, -0.7), (0.0, -9.81, 0.0)
UP = np.array([0.0, 0.0, 1.0])


def about_z(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@pytest.fixture(scope="module")
def beam():
    """The mesh, and its reduced body, which has a station at every node."""
    points = np.column_stack([np.linspace(0.0, LENGTH, NODES), np.zeros((NODES, 2))])
    fe = fem.frame(points, section=fem.Section.rectangle(0.02, 0.035), material=fmb.MATERIALS["steel"])
    stations = {f"s{k}": [k] for k in range(1, NODES - 1)}
    return fe, reduction.reduce(fe, {"root": [0], "tip": [NODES - 1]}, 4, compare=0, stations=stations)


def motions(data, names):
    """Motion of all nodes of both beams (2, 6 NODES, rates), in axes of each, for unit rates, undeformed."""
    order = [data.marker_names.index(name) for name in ("root", *(f"s{k}" for k in range(1, NODES - 1)), "tip")]
    places, shift, turn = (x[order] for x in (data.marker_positions, data.marker_translations, data.marker_rotations))
    found = np.zeros((2, 6 * NODES, len(names)))
    for column, name in enumerate(names):
        hinges = [float(name == f"{joint}.turn") for joint in "AB"]
        modes = [
            np.array([float(name == f"{body}.mode_{n + 1}") for n in range(data.n_modes)]) for body in ("b1", "b2")
        ]
        v, w = np.zeros(3), hinges[0] * UP
        for body in range(2):
            eta = modes[body]
            frame_w = w - turn[0] @ eta  # the joint moves the root, which moves against the frame
            frame_v = v - np.cross(frame_w, places[0]) - shift[0] @ eta
            moved = frame_v + np.cross(frame_w, places) + shift @ eta
            turned = frame_w + turn @ eta
            found[body, :, column] = np.hstack([moved, turned]).ravel()
            back = about_z(TURNS[1]).T
            v, w = back @ moved[-1], back @ turned[-1] + hinges[1] * UP
    return found


def test_products_of_two_hinged_beams(beam):
    """M v, M^-1 f and the forces of weight; the inertia matrix is J^T M J with the nodal motion J."""
    fe, data = beam
    bodies = [
        fmb.FloatingBody("b1", data=data, rotation=(0, 0, TURNS[0])),
        fmb.FloatingBody("b2", data=data, at=about_z(TURNS[0]) @ (LENGTH, 0, 0), rotation=(0, 0, sum(TURNS))),
    ]
    joints = [
        fmb.Revolute(j, markers=m) for j, m in (("A", ("ground.origin", "b1.root")), ("B", ("b1.tip", "b2.root")))
    ]
    tree = fmb.JointTree(fmb.Model(bodies=[fmb.Ground(), *bodies], joints=joints, gravity=GRAVITY))
    J, q = motions(data, tree.rate_names), tree.start.q
    M = sum(own.T @ fe.M @ own for own in J)
    weight = np.zeros(len(M))
    for own, angle in zip(J, (TURNS[0], sum(TURNS)), strict=True):
        weight += own.T @ (fe.M @ np.tile([*(about_z(angle).T @ GRAVITY), 0.0, 0.0, 0.0], NODES))
    v = np.cos(np.arange(len(M)))
    np.testing.assert_allclose(tree.mass_product(q, v), M @ v, atol=1e-12 * np.abs(M @ v).max())
    np.testing.assert_allclose(tree.bias(q, 0.0 * v), -weight, atol=1e-12 * np.abs(weight).max())
    solved = np.linalg.solve(M, v)
    np.testing.assert_allclose(tree.mass_solution(q, v), solved, atol=1e-10 * np.abs(solved).max())


def test_centre_of_mass_and_momenta_of_two_hinged_beams(beam):
    """By the nodal motion, and what the mass matrix of the mesh makes of translations and rotations of all nodes."""
    fe, data = beam
    bodies = [
        fmb.FloatingBody("b1", data=data, rotation=(0, 0, TURNS[0])),
        fmb.FloatingBody("b2", data=data, at=about_z(TURNS[0]) @ (LENGTH, 0, 0), rotation=(0, 0, sum(TURNS))),
    ]
    hinges = {"A": ("ground.origin", "b1.root"), "B": ("b1.tip", "b2.root")}
    joints = [fmb.Revolute(name, markers=pair) for name, pair in hinges.items()]
    tree = fmb.JointTree(fmb.Model(bodies=[fmb.Ground(), *bodies], joints=joints))
    found = tree.centroid(tree.start.q)
    shift = np.tile(np.eye(6)[:, :3], (NODES, 1))
    turn = np.vstack([np.vstack([np.cross(np.eye(3), place).T, np.eye(3)]) for place in fe.nodes])
    mass = 2.0 * (shift.T @ fe.M @ shift)[0, 0]
    along = (shift.T @ fe.M @ turn)[1, 2] / (0.5 * mass)  # of the centre of one beam from its root
    origins = np.array([np.zeros(3), bodies[1].at])
    axes = [about_z(TURNS[0]), about_z(sum(TURNS))]
    center = np.mean([r + R @ (along, 0, 0) for r, R in zip(origins, axes, strict=True)], axis=0)
    expected = np.zeros((6, len(tree.rate_names)))
    for r, R, J in zip(origins, axes, motions(data, tree.rate_names), strict=True):
        linear = R @ (shift.T @ (fe.M @ J))
        expected[:3] += linear
        expected[3:] += R @ (turn.T @ (fe.M @ J)) + np.cross(r - center, linear.T).T
    np.testing.assert_allclose(found.mass, mass, rtol=1e-12)
    np.testing.assert_allclose(found.position, center, atol=1e-13)
    np.testing.assert_allclose(found.momentum_matrix, expected, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(found.jacobian, expected[:3] / mass, atol=1e-12)


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3, 1e6])
def test_units_do_not_matter(beam, scale, rng):
    """A body `scale` times as long and slow, scale^3 times as heavy: forces and motions have the powers they must."""

    def tree(data, length):
        bodies = [fmb.FloatingBody(f"b{k}", data=data, at=(k * LENGTH * length, 0, 0)) for k in range(3)]
        ends = ["ground.origin", *(f"b{k}.tip" for k in range(3))]
        kinds = (fmb.Revolute, fmb.Spherical, fmb.Cylindrical)
        joints = [kinds[k](f"j{k}", markers=(ends[k], f"b{k}.root")) for k in range(3)]
        return fmb.JointTree(fmb.Model(bodies=[fmb.Ground(), *bodies], joints=joints))

    one, other = tree(beam[1], 1.0), tree(beam[1].rescaled(length=scale, mass=scale**3, time=scale), scale)

    def lengths(names):
        return np.array([scale if ".mode_" in name or ".slide" in name else 1.0 for name in names])

    small = np.where(np.array([".mode_" in name for name in one.rate_names]), 1e-3, 1.0)
    q = one.start.q + np.where(lengths(one.names) == 1.0, 0.3, 1e-3) * rng.normal(size=len(one.names))
    v, a = small * rng.normal(size=(2, len(small)))
    at, length = q * lengths(one.names), lengths(one.rate_names)
    motions, forces = length / scale**2, scale**3 / length  # m L^2 / T^2 = scale^3 at an angle
    rate, second = v * length / scale, a * motions
    product = one.mass_product(q, a)
    for found, expected in (
        (other.torques(at, rate, second) / forces, one.torques(q, v, a)),
        (other.mass_product(at, second) / forces, product),
        (other.mass_solution(at, product * forces) / motions, one.mass_solution(q, product)),
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-11 * np.abs(expected).max())
