"""Rigid boxes on each other, turned and shifted: edges that cross, and the normal that all points of a pair share.

References: balance of moments by hand, distances of convex bodies by coal.
"""

import re

import numpy as np
import pytest

import flexmb as fmb
from flexmb.integrate.nonsmooth import step
from flexmb.integrate.nonsmooth.restitution import solve_impulses
from flexmb.surfaces.box_pairs import find_between_boxes, plane_between_boxes
from flexmb.surfaces.records import CONTACT, HEADER

G, SIDE = 9.81, 0.2


def turned(axis, angle):
    """Return the rotation by an angle about an axis."""
    x, y, z = np.array(axis, float) / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K


def boxes(*given, law=None):
    """Return boxes (size, mass, place, rotation) on a floor."""
    names = tuple(f"box {k}" for k in range(len(given)))
    bodies, surfaces = [fmb.Ground()], [fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane())]
    for name, (size, mass, at, rotation) in zip(names, given, strict=True):
        squares = np.square(size)
        inertia = tuple(mass / 12.0 * (squares.sum() - squares))
        bodies.append(fmb.RigidBody(name, mass=mass, inertia=inertia, at=at, rotation=rotation))
        surfaces.append(fmb.Surface(name, marker=f"{name}.center", shape=fmb.Cuboid(size=size)))
    touch = fmb.SurfaceContact("touch", surfaces=(("floor", *names), names), law=law or fmb.Rigid(friction=0.5))
    sensors = [fmb.Position(name, marker=f"{name}.center") for name in names]
    sensors += [fmb.AngularVelocity(f"w {name}", marker=f"{name}.center") for name in names]
    return fmb.Model(gravity=(0, 0, -G), bodies=bodies, surfaces=surfaces, forces=[touch], sensors=sensors)


def cube(place, rotation=None, mass=1.0):
    return (SIDE,) * 3, mass, place, np.eye(3) if rotation is None else rotation


def moved(model, t_end, step):
    found = fmb.simulate(model, t_end, integrator=fmb.MoreauJean(step=step), samples=3)
    return max(np.abs(found[b.name][-1] - found[b.name][0]).max() for b in model.bodies if b.name != "ground"), found


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.01, 0.3, np.pi / 4])
def test_cubes_askew_stand_on_each_other(angle):
    """No corner of either lies over the other's face: only edges that cross hold the upper one."""
    far, _ = moved(boxes(cube((0, 0, 0.1)), cube((0, 0, 0.3), turned((0, 0, 1), angle))), 0.5, 5e-3)
    assert far < 1e-8


def test_twisted_tower_stands():
    tower = [cube((0, 0, 0.1 + SIDE * k), turned((0, 0, 1), 0.3 * k)) for k in range(8)]
    assert moved(boxes(*tower), 1.0, 5e-3)[0] < 1e-8


@pytest.mark.parametrize("mass", [1e6, 1e-3])
def test_masses_far_apart(mass):
    """A million kilograms, or a gram, between cubes of 1 kg."""
    pile = [cube((0, 0, 0.1)), cube((0, 0, 0.3), turned((0, 0, 1), 0.2), mass), cube((0.03, 0, 0.5))]
    assert moved(boxes(*pile), 0.2, 5e-3)[0] < 1e-8


@pytest.mark.parametrize(("beyond", "falls"), [(-1e-3, False), (1e-3, True)])
def test_overhang(beyond, falls):
    """A cube tips where its centre is beyond the edge: w' = g x / (k^2 + r^2) about it, k^2 = side^2 / 6."""
    over = 0.5 * SIDE + beyond
    far, found = moved(boxes(cube((0, 0, 0.1), mass=1e3), cube((over, 0, 0.3))), 0.05, 1e-3)
    if not falls:
        assert far < 1e-8
        return
    rate = G * beyond / (SIDE**2 / 6.0 + 0.25 * SIDE**2)
    assert found["w box 1"][-1, 1] == pytest.approx(0.05 * rate, rel=0.06)


@pytest.mark.parametrize("tolerance", [1e-8, 1e-3])
def test_contacts_that_are_not_solved_end_the_run(tolerance):
    """Two sweeps do not carry eight cubes: the contact, by how much it misses its law, and what was asked for."""
    tower = [cube((0, 0, 0.1 + SIDE * k), turned((0, 0, 1), 0.3 * k)) for k in range(8)]
    method = fmb.MoreauJean(step=5e-3, tolerance=tolerance, sweeps=2)
    with pytest.raises(fmb.IntegrationError, match=r"laws of contact between .* are missed by .* after 2 sweeps"):
        fmb.simulate(boxes(*tower), 0.1, integrator=method, samples=3)


def test_a_tolerance_is_named_with_which_a_step_is_taken():
    tower = [cube((0, 0, 0.1 + SIDE * k), turned((0, 0, 1), 0.3 * k)) for k in range(8)]
    method = fmb.MoreauJean(step=5e-3, tolerance=1e-18, sweeps=24)
    with pytest.raises(fmb.IntegrationError, match="would take this step") as caught:
        fmb.simulate(boxes(*tower), 5e-3, integrator=method, samples=2)
    enough = float(re.search(r"tolerance = (\S+) would", str(caught.value))[1])
    assert enough > 1e-18
    looser = fmb.MoreauJean(step=5e-3, tolerance=enough, sweeps=24)
    assert fmb.simulate(boxes(*tower), 5e-3, integrator=looser, samples=2).status.ok


def test_a_first_step_that_is_refused_is_solved_once(monkeypatch):
    """Forces of the first sample come from the first step, of which the run knows that it fails."""
    solved = []

    def counted(*given):
        solved.append(1)
        return solve_impulses(*given)

    monkeypatch.setattr(step, "solve_impulses", counted)
    tower = [cube((0, 0, 0.1 + SIDE * k), turned((0, 0, 1), 0.3 * k)) for k in range(8)]
    method = fmb.MoreauJean(step=5e-3, tolerance=1e-8, sweeps=2)
    with pytest.raises(fmb.IntegrationError, match="laws of contact between"):
        fmb.simulate(boxes(*tower), 0.1, integrator=method, samples=3)
    assert len(solved) == 1


def test_a_bar_lands_on_the_edge_of_another():
    """A bar on edge across a beam on edge: one point, where two edges cross, and no rebound."""
    beam, bar = (1.0, 0.2, 0.2), (0.8, 0.05, 0.05)
    low, half = 0.1 * 2**0.5, 0.025 * 2**0.5
    on_edge = turned((1, 0, 0), np.pi / 4)
    model = fmb.Model(
        gravity=(0, 0, -G),
        bodies=[
            fmb.Ground(markers={"beam": fmb.Pose((0, 0, low), rotation=on_edge)}),
            fmb.RigidBody(
                "bar",
                mass=1.0,
                inertia=(1e-3, 0.05, 0.05),
                at=(0, 0, 2 * low + half + 0.01),
                rotation=turned((0, 0, 1), np.pi / 2) @ on_edge,
            ),
        ],
        surfaces=[
            fmb.Surface("beam", marker="ground.beam", shape=fmb.Cuboid(size=beam)),
            fmb.Surface("bar", marker="bar.center", shape=fmb.Cuboid(size=bar)),
        ],
        forces=[fmb.SurfaceContact("touch", surfaces=("beam", "bar"), law=fmb.Rigid(friction=0.5))],
        sensors=[fmb.Position("p", marker="bar.center"), fmb.ForceOf("f", force="touch")],
    )
    found = fmb.simulate(model, 0.1, integrator=fmb.MoreauJean(step=1e-3), samples=3)
    assert found["p"][-1] == pytest.approx((0, 0, 2 * low + half), abs=1e-8)
    assert found["f"][-1, 2] == pytest.approx(G, rel=1e-6)


@pytest.mark.parametrize("count", [600, pytest.param(10_000, marks=pytest.mark.slow)])
def test_planes_between_boxes_of_another_library(rng, count):
    """Random pairs: the gap is at most coal's distance (GJK), equal to it where a face or two edges are nearest,
    and equal to its depth (EPA) where boxes overlap; points lie on both boxes and are not nearer than the gap.
    """
    coal = pytest.importorskip("coal")
    contacts, n = np.zeros(40, CONTACT), np.empty(3)
    apart, deep, equal = 0, 0, 0
    for _ in range(count):
        half = rng.uniform(0.05, 1.0, (2, 3))
        d = rng.normal(size=3) * rng.uniform(0.2, 1.2)
        Q = np.ascontiguousarray(turned(rng.normal(size=3), rng.uniform(0, np.pi)))
        data = np.concatenate([np.r_[4.0, np.zeros(HEADER - 1), h] for h in half])
        gap, _ = plane_between_boxes(data, 0, HEADER + 3, d, Q, n)
        first, second = (coal.Box(*(2.0 * h)) for h in half)
        result = coal.DistanceResult()
        expected = coal.distance(
            first, coal.Transform3s(), second, coal.Transform3s(Q, d), coal.DistanceRequest(), result
        )
        if gap > 0.0:
            apart += 1
            assert gap <= expected + 1e-6
            equal += abs(gap - expected) < 1e-6
        else:
            deep += 1
            assert gap == pytest.approx(expected, abs=2e-6)
        for contact in contacts[: find_between_boxes(data, 0, HEADER + 3, 1.0, d, Q, contacts)]:
            assert contact["gap"] >= gap - 1e-9
            z = Q.T @ (contact["x"] - d)
            assert np.all(np.abs(z) < half[1] + 1e-9 + max(0.0, -contact["gap"]))
    assert min(apart, deep) > 0.2 * count
    assert equal > 0.1 * count
