"""Planar loops of hinges whose places come from a mesh: their dependent equations contradict each other a little."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import CompileError

CRANK, COUPLER, ROCKER, FRAME = 0.1, 0.3, 0.2, 0.3  # m
STEEL = fmb.Material(young=210e9, poisson=0.3, density=7850.0)


def pin(at) -> fmb.Pose:
    """Return the pose of a hinge about the y-axis."""
    return fmb.Pose.axes(at=tuple(at), z=(0, 1, 0))


def points():
    """Return the hinges A, B, C, D with the crank upright."""
    A, B, D = np.zeros(3), np.array([0, 0, CRANK]), np.array([FRAME, 0, 0])
    d = np.linalg.norm(D - B)
    along = (COUPLER**2 - ROCKER**2 + d**2) / (2 * d)
    e = (D - B) / d
    return A, B, B + along * e + np.sqrt(COUPLER**2 - along**2) * np.array([-e[2], 0, e[0]]), D


def linkage(coupler, drive=()) -> fmb.Model:
    """Return four bars with hinges only: three of their equations are dependent."""
    A, B, C, D = points()
    rigid = {"mass": 1.0, "inertia": (0.01, 0.01, 0.011)}
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(markers={"A": pin(A), "D": pin(D)}),
            fmb.RigidBody("crank", **rigid, at=A, markers={"p": pin(A), "q": pin(B - A)}),
            coupler,
            fmb.RigidBody("rocker", **rigid, at=C, markers={"p": pin((0, 0, 0)), "q": pin(D - C)}),
        ],
        joints=[
            fmb.Revolute("A", markers=("ground.A", "crank.p")),
            fmb.Revolute("B", markers=("crank.q", "coupler.p")),
            fmb.Revolute("C", markers=("coupler.q", "rocker.p")),
            fmb.Revolute("D", markers=("rocker.q", "ground.D")),
            *drive,
        ],
        sensors=[fmb.Reaction("force at C", joint="C"), fmb.JointCoordinate("turn", joint="D")],
    )


def coupler_with(gap: float) -> fmb.RigidBody:
    """Return a coupler whose second hinge is off by `gap` sideways and turned by as many rad."""
    _, B, C, _ = points()
    off = fmb.Pose.axes(at=tuple(C - B + [0, gap, 0]), z=(gap, 1, 0))
    return fmb.RigidBody(
        "coupler", mass=1.0, inertia=(0.01, 0.01, 0.011), at=B, markers={"p": pin((0, 0, 0)), "q": off}
    )


MOTOR = fmb.Drive("motor", joint="A", angle=fmb.ramp(rate=10.0, rise=0.05))
INTEGRATORS = [
    fmb.GeneralizedAlpha(),
    fmb.GeneralizedAlpha(step=1e-3),
    fmb.Explicit(rtol=1e-7, atol=1e-9),
    fmb.IDA(rtol=1e-7, atol=1e-9),
]


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda i: f"{type(i).__name__} {getattr(i, 'step', None)}")
def test_a_misfit_within_mesh_tolerance_neither_moves_nor_stresses(integrator):
    """The reference is the exact mechanism; without care a gap of 1e-7 m would act like one in a rigid frame."""
    gap = 1e-7
    exact, found = (
        fmb.simulate(linkage(coupler_with(g), [MOTOR]), 0.5, integrator=integrator, samples=26) for g in (0.0, gap)
    )
    assert found["turn"] == pytest.approx(exact["turn"], abs=10 * gap)
    largest = np.abs(exact["force at C"]).max()
    assert np.abs(found["force at C"] - exact["force at C"]).max() < 1e-3 * largest


def test_kinematics_and_frequencies_with_a_misfit():
    gap = 1e-7
    exact, found = (fmb.kinematics(linkage(coupler_with(g), [MOTOR]), 0.5, samples=26) for g in (0.0, gap))
    assert found["turn"] == pytest.approx(exact["turn"], abs=10 * gap)
    spring = fmb.TorsionSpring("spring", joint="A", stiffness=50.0)
    exact, found = (fmb.linearize(linkage(coupler_with(g)).with_parts(forces=[spring])).frequencies for g in (0.0, gap))
    assert len(found) == len(exact) == 1
    assert found == pytest.approx(exact, rel=1e-5)


def test_check_reports_the_joints_with_their_misfits():
    report = fmb.check(linkage(coupler_with(1e-9)))
    assert report.mobility == 1
    assert len(report.redundant) == 3
    assert set(report.misfits) == {"A", "B", "C", "D"}
    assert sum(metres for metres, _ in report.misfits.values()) <= 1e-9
    assert max(max(gap) for gap in report.misfits.values()) > 1e-10
    assert "left open, without stress, are the joints\n    A: " in str(report)
    assert " m, " in str(report)
    assert not fmb.check(linkage(coupler_with(0.0))).misfits


def test_larger_misfits_are_an_error_that_names_joint_and_gap():
    with pytest.raises(CompileError) as caught:
        fmb.check(linkage(coupler_with(1e-4)))
    text = str(caught.value)
    assert "joint 'D' stays open by" in text
    assert "equations depend on others" in text
    assert all((caught.value.part, caught.value.found, caught.value.expected, caught.value.remedy))


def test_a_meshed_coupler_is_the_same_rigid_or_not():
    """A frame whose nodes have the digits of a mesh file: nine, 3e-10 m off the plane."""
    _, B, C, _ = points()
    line = np.linspace(0, 1, 5)[:, None] * (C - B) + [0, 3e-10, 0]
    line[0, 1] = 0.0
    fe = fem.frame(points=line, section=fem.Section.tube(diameter=0.02, wall=0.002), material=STEEL)
    data = reduction.reduce(fe, interfaces={"p": (0, 0, 0), "q": tuple(line[-1])}, modes=4)
    axes = {name: fmb.Pose.axes(z=(0, 1, 0)) for name in ("p", "q")}
    rigid, elastic = (
        fmb.FloatingBody("coupler", data=data, at=B, rigid=r, damping=0.02, markers=axes) for r in (True, False)
    )
    report = fmb.check(linkage(rigid))
    assert report.misfits
    turns = [fmb.simulate(linkage(body, [MOTOR]), 0.2, samples=11)["turn"] for body in (rigid, elastic)]
    assert turns[0] == pytest.approx(turns[1], abs=1e-4)
