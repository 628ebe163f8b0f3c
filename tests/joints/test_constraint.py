"""`Constraint`: derivatives of all measured scalars, agreement with joints, formulations and integrators, messages.

References: central differences of sixth order (as in contracts), the joint library, Udwadia's equation of motion.
"""

import numpy as np
import pytest
from contracts.random_models import SECOND, derivative, moved, pair, random_state, units
from contracts.test_tangents import assert_tangent

import flexmb as fmb
from flexmb.integrate.matrices import equations_at
from flexmb.math.weights import weigh
from flexmb.system.program import constraint_acceleration, constraint_velocity, evaluate

EQUATIONS = {
    "place": "p[0]*p[1] + 0.3*p[2]**2 = 0.4*cos(2*t) + r",
    "coordinates": "d*sin(phi) + s**2 + 0.5*c*p[0] - 0.1*t*d",
    "pfaffian": "rate(d)*p[1] + v[0]*c - w[2]*s + 0.2*rate(phi) = sin(3*t)",
    "rates": "rate(c) + rate(s)*d + rate(p[2])*rate(r) + o[1] - f[2]",
    "nonlinear": "v[0]**2 + w[1]*rate(phi) + f[1]**2*c + rate(c)*o[0] = 0.3 + 0.1*t",
}
PAIRS = ("ground-rigid", "rigid-rigid", "rigid-floating", "rigid-beam")


def everything(markers) -> list:
    """Every sort of scalar between two markers."""
    return [
        fmb.Position("p", marker=markers[1]),
        fmb.Distance("d", markers=markers),
        fmb.Distance("s", markers=markers, along="y"),
        fmb.AxisCosine("c", markers=markers, axes=("z", "x")),
        fmb.JointCoordinate("phi", joint="j", freedom="turn"),
        fmb.Velocity("v", marker=markers[1]),
        fmb.Velocity("f", marker=markers[1], axes=markers[0]),
        fmb.AngularVelocity("w", marker=markers[1]),
        fmb.AngularVelocity("o", marker=markers[0], axes=markers[1]),
    ]


def between(pairs: str, equation: str, rng, **fields) -> fmb.Model:
    parts, markers = pair(pairs, rng)
    joints = [
        fmb.Universal("j", markers=markers),
        fmb.Constraint(
            "own",
            over=everything(markers),
            equation=equation,
            parameters={"r": fmb.table([0, 1, 2], [0.1, 0.3, 0.2])},
            **fields,
        ),
    ]
    return fmb.Model(bodies=parts, joints=joints)


def residuals(system, state, work):
    work.weights[0].wanted = 0
    evaluate(system.program, state, work)
    return work.equations["g"].copy()


@pytest.mark.parametrize("pairs", PAIRS)
@pytest.mark.parametrize("name", EQUATIONS)
def test_gradient_and_rates_are_the_derivatives(name, pairs, rng):
    system, state = random_state(between(pairs, EQUATIONS[name], rng), rng)
    state = state._replace(t=0.7)
    work = system.workspace()
    k = system.joint_equations["own"].start
    at_velocity = system.program.equation_level[k] == 1
    assert at_velocity == (name not in ("place", "coordinates"))
    G = equations_at(system, state, work).G.toarray()[k]
    for d in np.diag(units(system)):
        if at_velocity:
            expected = derivative(lambda x, d=d: residuals(system, state._replace(u=state.u + x * d), work)[k], 3e-3)
        else:
            expected = derivative(lambda x, d=d: residuals(system, moved(system, state, d, x), work)[k], 3e-3)
        assert G @ d == pytest.approx(expected, rel=1e-8, abs=1e-8)

    def g(x):
        along = state.u * x + 0.5 * state.a * x * x
        now = moved(system, state, along, 1.0, t=state.t + x, u=state.u + x * state.a)
        return residuals(system, now, work)[k]

    rate = g(0.0) if at_velocity else derivative(g, 3e-3)
    second = derivative(g, 3e-3) if at_velocity else derivative(g, 3e-3, SECOND)
    residuals(system, state, work)
    velocity, acceleration = np.empty(system.ng), np.empty(system.ng)
    constraint_velocity(work, state.u, velocity)
    constraint_acceleration(work, state.a, acceleration)
    assert velocity[k] == pytest.approx(rate, rel=1e-8, abs=1e-8)
    assert acceleration[k] == pytest.approx(second, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("pairs", ["ground-rigid", "rigid-rigid"])
@pytest.mark.parametrize("name", EQUATIONS)
def test_tangent_is_the_derivative_of_the_residual(name, pairs, rng):
    """With a given force on a position and one on a velocity, which depend on both; rigid bodies in motion."""
    forces = {"p[0]": "3*d*v[1] - t*abs(v[0])", "f[2]": "-2*f[2]*p[1] + 0.1*rate(d)"}
    system, state = random_state(between(pairs, EQUATIONS[name], rng, forces=forces), rng)
    assert_tangent(system, state, blocks=("M", "L", "D"))
    assert_tangent(system, state._replace(u=np.zeros(system.nu)), blocks=("M", "L", "K"))


@pytest.mark.parametrize("name", ["pfaffian", "rates", "nonlinear"])
def test_slope_is_the_derivative_by_displacement(name, rng):
    """Row of a velocity-level equation in the iteration matrix: d psi/du + (c_K / c_D) d psi/dq."""
    system, state = random_state(between("rigid-rigid", EQUATIONS[name], rng), rng)
    work = system.workspace()
    k = system.joint_equations["own"].start
    from flexmb.math.block_pattern import stored

    rows = []
    for stiffness in (0.0, 1.0):
        weigh(work.weights, 0.0, 1.0, stiffness)
        evaluate(system.program, state, work)
        rows.append(stored(work.S, system.program.pattern).toarray()[system.nu + k, : system.nu])
    for d in np.diag(units(system)):
        expected = derivative(lambda x, d=d: residuals(system, moved(system, state, d, x), work)[k], 3e-3)
        assert (rows[1] - rows[0]) @ d == pytest.approx(expected, rel=1e-7, abs=1e-7)
