"""Every primitive equation and joint: gradient, rates, work, freedoms, reactions.

Reference of the derivatives: central differences of sixth order along increments of the group, from h = 3e-3 downwards
until their own error is below 1e-8.
"""

import numpy as np
import pytest
from by_turns import every_second
from contracts.random_models import PAIRS, SECOND, connected, derivative, moved, random_state, units
from tolerances import MACHINE

from flexmb import joints
from flexmb.constraints import EQUATIONS
from flexmb.integrate.matrices import equations_at
from flexmb.system import assemble
from flexmb.system.program import constraint_acceleration, constraint_velocity, evaluate

DIFFERENCE = 1e-8
H = 3e-4  # small: across a knot of a path, where third derivatives jump, differences are off by its cube
KINDS = (*joints.KINDS, "slide")
CASES = every_second(KINDS, PAIRS)
CASES += [pytest.param("PointOnPath", f"{body}-rigid") for body in ("cable", "beam", "plate")]


def residuals(system, state, work):
    work.weights[0].wanted = 0
    evaluate(system.program, state, work)
    return work.equations["g"].copy()


def test_joints_use_every_primitive():
    models = [connected(kind, "rigid-rigid", np.random.default_rng(1)) for kind in joints.KINDS]
    used = {type(e) for model in models for joint in model.joints for e in joint.equations_in(model)}
    assert used == set(EQUATIONS)


@pytest.mark.parametrize(("kind", "pair"), CASES)
def test_gradient_is_the_derivative(kind, pair, rng):
    system, state = random_state(connected(kind, pair, rng), rng)
    work = system.workspace()
    G = equations_at(system, state, work).G.toarray()
    at_velocity = system.program.equation_level == 1
    for d in np.diag(units(system)):
        expected = np.zeros(system.ng)
        if not at_velocity.all():
            expected = derivative(lambda x, d=d: residuals(system, moved(system, state, d, x), work), H)
        if at_velocity.any():
            by_velocity = derivative(lambda x, d=d: residuals(system, state._replace(u=state.u + x * d), work), H)
            expected = np.where(at_velocity, by_velocity, expected)
        np.testing.assert_allclose(G @ d, expected, rtol=DIFFERENCE, atol=DIFFERENCE)


@pytest.mark.parametrize(("kind", "pair"), CASES)
def test_rates_are_those_along_a_motion(kind, pair, rng):
    """g' = G u + dg/dt and g'' = G a + drift along q [+] (u x + a x^2 / 2);
    at velocity level the value and its rate.
    """
    system, state = random_state(connected(kind, pair, rng), rng)
    work = system.workspace()

    def g(x):
        along = state.u * x + 0.5 * state.a * x * x
        now = moved(system, state, along, 1.0, t=state.t + x, u=state.u + x * state.a)
        return residuals(system, now, work)

    at_velocity = system.program.equation_level == 1
    rate = np.where(at_velocity, g(0.0), derivative(g, H))
    second = np.where(at_velocity, derivative(g, H), derivative(g, H, SECOND))
    residuals(system, state, work)
    velocity, acceleration = np.empty(system.ng), np.empty(system.ng)
    constraint_velocity(work, state.u, velocity)
    constraint_acceleration(work, state.a, acceleration)
    np.testing.assert_allclose(velocity, rate, rtol=DIFFERENCE, atol=DIFFERENCE)
    np.testing.assert_allclose(acceleration, second, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(("kind", "pair"), CASES)
def test_multipliers_do_the_work_of_the_prescribed_motion_only(kind, pair, rng):
    """Admissible velocities: sum of wrench times twist is -lam dg/dt, zero for a joint that is not driven."""
    system, state = random_state(connected(kind, pair, rng), rng)
    work = system.workspace()
    equations = equations_at(system, state, work)
    G = equations.G.toarray()
    u = state.u - np.linalg.lstsq(G, equations.velocity, rcond=None)[0]
    residuals(system, state._replace(u=u), work)
    markers = work.markers
    power = np.sum(markers["wrench"][:, :3] * markers["v"]) + np.sum(markers["wrench"][:, 3:] * markers["w"])
    scale = np.abs(state.lam).max() * max(1.0, np.abs(u).max()) * max(1.0, np.abs(G).max())
    assert work.energy[0].drive_power == pytest.approx(power, abs=1e2 * MACHINE * scale)
    if not any(joint.prescribes for joint in system.model.joints):
        assert abs(power) <= 1e2 * MACHINE * scale


@pytest.mark.parametrize(("kind", "pair"), [case for case in CASES if "point" not in case.values[1]])
def test_action_is_reaction(kind, pair, rng):
    """In the assembled joint, forces and moments on both markers cancel, about the origin of W."""
    system, state = assemble(connected(kind, pair, rng))
    work = system.workspace()
    state.lam[:] = 1.0 + rng.uniform(size=system.ng)
    residuals(system, state, work)
    force, moment = work.markers["wrench"][:, :3], work.markers["wrench"][:, 3:]
    assert np.abs(force).max() + np.abs(moment).max() > 1e-3  # a path that bends little has small multiples
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=MACHINE * 1e2)
    np.testing.assert_allclose((moment + np.cross(work.markers["r"], force)).sum(axis=0), 0.0, atol=1e-9)


@pytest.mark.parametrize("kind", [name for name, joint in joints.KINDS.items() if joint.permits or name == "Fixed"])
def test_what_is_forbidden_and_what_is_permitted_complement_each_other(kind, rng):
    """Relative twists of the assembled joint: G times the permitted ones is zero, and the ranks add up to six."""
    system, state = assemble(connected(kind, "rigid-rigid", rng))
    work = system.workspace()
    residuals(system, state, work)
    joint = system.joints[0]
    a, b = (work.markers[system.marker_index[name]] for name in joint.markers)
    legs = [leg for leg in work.legs if leg["marker"] == system.marker_index[joint.markers[1]]]
    G = np.array([leg["gradient"] for leg in legs])
    d = b["r"] - a["r"]
    twists = [freedom.twists(a["R"], b["R"], d) for freedom in joint.permits]
    P = np.concatenate([*twists, np.empty((0, 6))])
    assert np.linalg.matrix_rank(G, tol=1e-8) + np.linalg.matrix_rank(P, tol=1e-8) == 6
    assert len(G) + len(P) == 6
    np.testing.assert_allclose(G @ P.T, 0.0, atol=1e-9)
    for freedom, twist in zip(joint.permits, twists, strict=True):
        # a bend of shafts that nearly oppose each other turns by little
        assert freedom.turns == bool(np.any(np.abs(twist[:, 3:]) > 1e-6)), str(freedom)
