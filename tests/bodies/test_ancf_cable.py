"""The cable against differences, rigid motions, and what its energy says."""

import numpy as np
import pytest
from bodies.ancf_states import (
    BENT,
    ROUND,
    SOFT,
    assert_marker_moves_as_its_jacobian_says,
    assert_tangent_is_the_derivative,
    cable,
    dissipation_beside_the_energy,
    disturbed,
    residual,
)
from by_turns import slow
from tolerances import MACHINE, SOLVER

import flexmb as fmb
from flexmb import fem
from flexmb.bodies.line.curve import minimal_rotation
from flexmb.errors import CompileError, ModelError
from flexmb.math.rotations import rotation_matrix
from flexmb.system.program import energies

MODELS = {
    "curved": {},
    "straight without load": {"straight": True},
    "closed": {
        "closed": True,
        "points": ((0, 0, 0), (1, 0, 0), (1, 1, 0.2), (0, 1, 0)),
        "elements": 5,
        "markers": {"m": 0.93},
    },
    "undamped": {"axial_damping": 0.0, "bending_damping": 0.0},
}


def loaded(**fields):
    """The cable with a force and a moment on the marker inside an element, and gravity."""
    load = fmb.PointLoad("f", marker="b.m", force=(3.0, -1.0, 2.0), moment=(0.8, 0.5, -0.6))
    return fmb.Model(bodies=(fmb.Ground(), cable(**fields)), forces=(load,), gravity=(1.0, -2.0, -9.0))


@pytest.mark.parametrize("fields", MODELS.values(), ids=MODELS)
def test_tangent_is_the_derivative(fields, rng):
    """Mass, damping and stiffness, the latter with the rates of the damping forces and the load on a tangent frame."""
    assert_tangent_is_the_derivative(*disturbed(loaded(**fields), rng), SOLVER)


@pytest.mark.parametrize("fields", MODELS.values(), ids=MODELS)
def test_power_changes_the_energy(fields, rng):
    """u . (M a + h) = d(T + U + V)/dt + dissipated power, without loads."""
    body = cable(**fields)
    assert (dissipation_beside_the_energy(body, rng) > 0.0) == (body.axial_damping > 0.0)


def test_marker_moves_as_its_jacobian_says(rng):
    """Velocity, spin and bias acceleration of the tangent frame are those of its motion."""
    marker = assert_marker_moves_as_its_jacobian_says(*disturbed(loaded(), rng), "b.m")
    assert marker["nu"] == 12


def test_rigid_motion_makes_no_force_and_no_damping(rng):
    """Turned by any angle and spinning, the undistorted cable has no strain energy and dissipates nothing."""
    R = rotation_matrix((1.0, 2.0, -2.5))
    body = cable(initial_strain=0.0, at=(3, 2, 1), rotation=R, velocity=(1, 2, 3), angular_velocity=(4, -5, 6))
    system, state = disturbed(fmb.Model(bodies=(fmb.Ground(), body), gravity=(0, 0, 0)), rng, 0.0)
    work = system.workspace()
    state = system.state(0.0, state.q)
    force = residual(system, state, work)
    scale = SOFT.young * ROUND.area
    np.testing.assert_allclose(force, 0.0, atol=SOLVER * scale)
    assert abs(work.energy[0].dissipation) < SOLVER * scale
    energies(system.program, state, work)
    assert work.energy[0].strain == pytest.approx(0.0, abs=MACHINE * scale)


def test_mass_and_momentum(rng):
    """A translating cable has the kinetic energy m v^2 / 2; its mass is that of the curved line."""
    body = cable(velocity=(1, 2, 3), elements=12)
    system, _ = disturbed(fmb.Model(bodies=(fmb.Ground(), body), gravity=(0, 0, 0)), rng, 0.0)
    work = system.workspace()
    energies(system.program, system.state(), work)
    assert work.energy[0].kinetic == pytest.approx(0.5 * body.mass * 14.0, rel=1e-4)
    assert body.curve.length == pytest.approx(_length(BENT), rel=1e-6)


def _length(points):
    from scipy.interpolate import CubicSpline

    p = np.array(points, float)
    knots = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    fine = CubicSpline(knots, p)(np.linspace(0.0, knots[-1], 20001))
    return np.linalg.norm(np.diff(fine, axis=0), axis=1).sum()


def test_section_forces_of_a_stretched_and_of_a_bent_line():
    """Straight, stretched by 2 %: N = 0.02 EA. On a circle of radius R: M = EI / R."""
    straight = cable(points=((0, 0, 0), (2, 0, 0)), initial_strain=0.0)
    q = straight.initial_state()[0].reshape(-1, 6) * [1.02, 0, 0, 1.02, 0, 0]
    found = straight.section_forces(q.ravel(), [0.1, 0.5])
    np.testing.assert_allclose(found[:, 0], 0.02 * SOFT.young * ROUND.area, rtol=SOLVER)
    np.testing.assert_allclose(found[:, 1:], 0.0, atol=SOLVER)
    angle = np.linspace(0.0, 1.0, 9)
    arc = np.stack([2.0 * np.sin(angle), 2.0 - 2.0 * np.cos(angle), 0.0 * angle], axis=1)
    bent = cable(points=arc, elements=8, straight=True, tangents=((1, 0, 0), (np.cos(1.0), np.sin(1.0), 0)))
    found = bent.section_forces(bent.initial_state()[0], [0.3, 0.6])
    np.testing.assert_allclose(found[:, 2], SOFT.young * ROUND.inertia_y / 2.0, rtol=1e-3)
    at_rest = cable(points=arc)
    assert at_rest.section_strains(at_rest.initial_state()[0], 0.5)[0, 1] == pytest.approx(0.0, abs=1e-12)


REFUSED = {
    "zero length": ({"points": ((0, 0, 0), (0, 0, 0), (1, 0, 0))}, "zero length between points 0 and 1"),
    "one point": ({"points": ((0, 0, 0),)}, "points of the shape (1, 3)"),
    "fold": ({"points": ((0, 0, 0), (1, 0, 0), (0, 0.01, 0)), "elements": 2}, "the curve turns by"),
    "no elements": ({"elements": 0}, "elements = 0"),
    "few elements": ({"closed": True, "elements": 2}, "elements = 2"),
    "no area": ({"section": type("Line", (), {"area": 0.0, "inertia_y": 1.0, "inertia_z": 1.0})()}, "without area"),
    "two inertias": ({"section": fem.Section.rectangle(0.1, 0.2)}, "moments of inertia"),
    "material": ({"material": "steel"}, "material = 'steel'"),
    "marker": ({"markers": {"m": 1.5}}, "marker m at 1.5"),
    "strain": ({"initial_strain": 2.0}, "initial_strain = 2.0"),
    "tangents": ({"tangents": ((0, 0, 0), (1, 0, 0))}, "tangents ="),
}


@pytest.mark.parametrize(("fields", "found"), REFUSED.values(), ids=REFUSED)
def test_refused(fields, found):
    with pytest.raises(ModelError, match="Body 'b'") as error:
        cable(**fields)
    assert found in str(error.value)


def test_the_recursion_over_trees_refuses_bodies_of_nodes():
    with pytest.raises(CompileError, match="Body 'b': AncfCable has no frame"):
        fmb.accelerations(fmb.Model(bodies=(fmb.Ground(), cable())), formulation=fmb.Recursive())


@pytest.mark.parametrize("off", [0.0, 1e-12, 1e-8, 5e-6, 1e-3, 1.0])
def test_smallest_rotation_between_directions_that_oppose_each_other_nearly(off):
    """Markers of a closed line pass where the line runs against the x-axis."""
    a, b = np.array([1.0, 0.0, 0.0]), np.array([-np.cos(off), np.sin(off), 0.0])
    R = minimal_rotation(a, b)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(R @ a, b, atol=1e-9)
    assert np.linalg.det(R) == pytest.approx(1.0)


def ring_arc(first, last, count):
    """Points (count, 3) of a circle of radius 1 m from one angle to another."""
    angle = np.linspace(first, last, count)
    return np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])


@pytest.mark.parametrize("closed", [True, slow(False)])
def test_ring(closed):
    """Bending frequencies in its plane, sqrt(EI / m) k (k^2 - 1) / sqrt(k^2 + 1), twice each (Hoppe 1871).

    A closed line, and two halves whose ends are joined by hinges along the line: without a kink, with their own twist.
    """
    fields = {
        "section": fem.Section.solid_circle(0.02),
        "material": fmb.Material(young=1e9, poisson=0.3, density=1000.0),
    }
    if closed:
        bodies = (
            fmb.AncfCable("ring", points=ring_arc(0.0, 2.0 * np.pi, 25)[:-1], closed=True, elements=32, **fields),
        )
    else:
        along = (0.0, 0.5 * np.pi, 0.0)
        bodies = tuple(
            fmb.AncfCable(
                name,
                points=ring_arc(first, first + np.pi, 13),
                elements=16,
                **fields,
                tangents=((-np.sin(first), np.cos(first), 0.0), (np.sin(first), -np.cos(first), 0.0)),
                markers={"a": (0.0, along), "b": (1.0, along)},
            )
            for name, first in (("up", 0.0), ("low", np.pi))
        )
    joints = (
        ()
        if closed
        else tuple(
            fmb.Revolute(name, markers=(f"{one}.b", f"{other}.a"))
            for name, one, other in (("l", "up", "low"), ("r", "low", "up"))
        )
    )
    model = fmb.Model(bodies=(fmb.Ground(), *bodies), joints=joints, gravity=(0, 0, 0))
    found = fmb.linearize(model).frequencies
    section, k = fields["section"], np.array([2.0, 3.0])
    exact = (
        np.sqrt(1e9 * section.inertia_y / (1000.0 * section.area)) * k * (k**2 - 1) / np.sqrt(k**2 + 1) / (2.0 * np.pi)
    )
    np.testing.assert_allclose(np.sort(found[found > 0.05])[:4], np.repeat(exact, 2), rtol=5e-3)
    assert fmb.check(model).redundant == ()


@pytest.mark.parametrize("marker", [0.0, 0.3])
def test_clamped_rope_has_one_dependent_equation(marker):
    """A cable has no twist: the equation that would hold it moves no coordinate, on open and on closed lines."""
    angle = np.linspace(0.0, 2.0 * np.pi, 33)[:-1]
    ring = fmb.AncfCable(
        "r",
        points=0.5 * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1),
        elements=8,
        section=fem.Section.solid_circle(0.01),
        material=fmb.MATERIALS["steel"],
        closed=True,
        markers={"m": marker},
    )
    pose = ring.marker_poses()["m"]
    clamp = fmb.Pose(ring.curve.r[0] + pose.at, pose.matrix)
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(markers={"m": clamp}), ring],
        joints=[fmb.Fixed("clamp", markers=("ground.m", "r.m"))],
        sensors=[fmb.Reaction("R", joint="clamp")],
    )
    assert len(fmb.check(model).redundant) == 1
    np.testing.assert_allclose(fmb.statics(model)["R"][-1, :3], (0.0, 0.0, ring.mass * 9.81), rtol=1e-9, atol=1e-6)
