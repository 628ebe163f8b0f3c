"""Equations from energies close for every kind of body, and find accelerations, forces and places that are wrong."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from tolerances import MACHINE

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.trust.balance import unexplained
from flexmb.trust.levels import constraint_levels

SAMPLES = (2, 5, 8)
MESH = Path(__file__).parents[2] / "meshes" / "bracket_hex8.msh"
CLOSED = 1e5 * MACHINE
"""Differences of sixth order lose four to five of sixteen digits, most where stiffness is large beside the loads."""


@cache
def bracket() -> fmb.ModalNeutralData:
    """A solid bracket, softened, between two interfaces, with all groups of geometric stiffness."""
    mesh = fem.read_mesh(MESH)
    soft = fmb.Material(young=2e8, poisson=0.3, density=2700.0)
    ends = [int(np.argmin(mesh.points[:, 0])), int(np.argmax(mesh.points[:, 0]))]
    fe = fem.solid(mesh, soft)
    near = [np.argsort(np.linalg.norm(mesh.points - mesh.points[k], axis=1))[:4].tolist() for k in ends]
    return reduction.reduce(fe, interfaces={"start": near[0], "end": near[1]}, modes=4, geometric_stiffness=True)


def line(kind, **fields):
    return kind(
        "body",
        points=((0, 0, 0), (0.5, 0.1, 0), (1.0, 0, 0.1)),
        elements=2,
        section=fem.Section.solid_circle(0.02),
        material=fmb.Material(young=2e6, poisson=0.3, density=900.0),
        velocity=(0.1, 0.2, 0),
        angular_velocity=(0, 0, 0.3),
        **fields,
    )


MOVING = {"velocity": (1.0, 2.0, 3.0), "angular_velocity": (3.0, -1.0, 2.0)}
BODIES = {
    "rigid": lambda: fmb.RigidBody(
        "body",
        mass=2.0,
        inertia=(0.3, 0.4, 0.5),
        center_of_mass=(0.1, -0.2, 0.3),
        markers={"start": (0.2, 0.1, 0)},
        **MOVING,
    ),
    "point": lambda: fmb.PointMass("body", mass=1.5, velocity=(1, 2, 3)),
    "reduced": lambda: fmb.FloatingBody("body", data=bracket(), damping=0.02, **MOVING),
    "cable": lambda: line(fmb.AncfCable, axial_damping=0.5),
    "beam": lambda: line(fmb.AncfBeam, damping=1e-3),
    "plate": lambda: fmb.AncfPlate.rectangle(
        "body",
        edges=(1.0, 0.5),
        elements=(2, 1),
        thickness=0.02,
        material=fmb.Material(young=2e6, poisson=0.3, density=900.0),
        damping=1e-3,
        markers={"start": (0.1, 0.2)},
    ),
}


@cache
def hung(kind: str) -> fmb.Solution:
    """Return a run of a body on a spring and a rod."""
    marker = "body.center" if kind == "point" else "body.start"
    spring = fmb.SpringDamper("spring", markers=("ground.A", marker), stiffness=80.0, damping=1.0, length=0.3)
    rod = fmb.Rod("rod", markers=("ground.B", marker))
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"A": (0.1, -0.3, 0.6), "B": (-0.2, 0.5, 0.9)}), BODIES[kind]()],
        joints=[rod],
        forces=[spring],
        gravity=(1.0, 2.0, -9.81),
    )
    return fmb.simulate(model, 0.02, samples=11, integrator=fmb.IDA(rtol=1e-9, atol=1e-11))


def largest_share(solution, **changed) -> float:
    phase = replace(solution.phases[0], **changed)
    found, skipped = unexplained(phase, solution.series(0).system, SAMPLES)
    assert not skipped
    return found[0].worst


@pytest.mark.parametrize("kind", BODIES)
def test_forces_explain_the_motion(kind):
    assert largest_share(hung(kind)) < CLOSED


@pytest.mark.parametrize("kind", BODIES)
def test_wrong_accelerations_and_reactions_are_found(kind):
    phase = hung(kind).phases[0]
    assert largest_share(hung(kind), a=1.05 * phase.a) > 1e-3
    assert largest_share(hung(kind), lam=phase.lam + 3.0) > 1e-3


@pytest.mark.parametrize("kind", BODIES)
def test_constraints_hold_at_three_levels(kind):
    phase, system = hung(kind).phases[0], hung(kind).series(0).system
    found = {r.level: r for r in constraint_levels(phase, system, SAMPLES)}
    assert found["position"].share < 1e-9
    assert found["velocity"].share < 1e-9
    assert found["acceleration"].share < 1e-7
    assert found["position"].equation.startswith("rod:")


@pytest.mark.parametrize(("field", "level"), [("q", "position"), ("u", "velocity"), ("a", "acceleration")])
def test_open_constraints_are_found_at_their_level(field, level):
    """The rod's end is moved, or given a speed or an acceleration, along the rod; the other levels stay closed."""
    phase, system = hung("point").phases[0], hung("point").series(0).system
    along = phase.q[:, :3] - np.array([-0.2, 0.5, 0.9])
    along /= np.linalg.norm(along, axis=1)[:, None]
    size = 1e-3 * max(1.0, np.abs(getattr(phase, field)).max())
    value = getattr(phase, field).copy()
    value[:, :3] += size * along
    found = {r.level: r for r in constraint_levels(replace(phase, **{field: value}), system, SAMPLES)}
    np.testing.assert_allclose(found[level].value, size, rtol=1e-2)
    closed = {"position": (), "velocity": ("position",), "acceleration": ("position", "velocity")}[level]
    assert all(found[other].share < 1e-9 for other in closed)


def test_rounding_is_no_moment():
    """A ball that falls without turning: its moments are rounding, and no share of each other."""
    ball = fmb.RigidBody("ball", mass=1.0, inertia=(0.004, 0.005, 0.006), velocity=(1, 2, 3))
    solution = fmb.simulate(fmb.Model(bodies=[fmb.Ground(), ball], gravity=(0, 0, -9.81)), 1.0, samples=11)
    found, _ = unexplained(solution.phases[0], solution.series(0).system, SAMPLES)
    assert found[0].worst < CLOSED
