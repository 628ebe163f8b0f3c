"""The iteration matrix is the derivative of the residual: bodies, forces and constraint forces, on every kind of body.

Reference: central differences of sixth order along increments of the group; in accelerations the
residual is linear, in multipliers as well unless friction follows them: plain differences are exact there.
"""

import numpy as np
import pytest
from by_turns import every_second
from contracts.random_models import (
    FORCES,
    PAIRS,
    connected,
    derivative,
    moved,
    put_together,
    random_state,
    single,
    units,
)
from scipy.linalg import null_space
from tolerances import MACHINE, SOLVER

from flexmb import bodies, joints
from flexmb.integrate.matrices import equations_at, tangent_at
from flexmb.math.block_pattern import stored
from flexmb.math.weights import weigh
from flexmb.system import assemble
from flexmb.system.program import evaluate

H = 5e-3
BODIES = [name for name, kind in bodies.KINDS.items() if kind.table is not None]
EXACT_EVERYWHERE = [name for name in joints.KINDS if name != "Drive"] + ["slide", *FORCES]
CASES = every_second(EXACT_EVERYWHERE, PAIRS)


def residual(system, state, work):
    work.weights[0].wanted = 0
    evaluate(system.program, state, work)
    return work.residual.copy()


def plain_difference(f, _):
    """Return the slope of a linear f; the step of one loses no digits."""
    return 0.5 * (f(1.0) - f(-1.0))


def assert_tangent(system, state, tolerance=SOLVER, admissible=None, blocks=("M", "D", "K", "L")):
    """Compare M, D, K and G^T with differences of the residual; errors relative to the largest entry of a row.

    With `admissible` (nu, k), the stiffness is compared on these directions only.
    """
    work = system.workspace()
    tangent = tangent_at(system, state, work)
    linear = ("M",) if any(force.reads_reactions for force in system.model.forces) else ("M", "L")
    changes = {
        "M": lambda x, e: state._replace(a=state.a + x * e),
        "D": lambda x, e: state._replace(u=state.u + x * e),
        "K": lambda x, e: moved(system, state, e, x),
        "L": lambda x, e: state._replace(lam=state.lam + x * e),
    }
    for name in blocks:
        change = changes[name]
        matrix = getattr(tangent, name).toarray() * (-1.0 if name == "L" else 1.0)
        directions = np.eye(system.ng) if name == "L" else np.diag(units(system))
        found = matrix @ directions
        slope = plain_difference if name in linear else derivative
        columns = [slope(lambda x, d=d, c=change: residual(system, c(x, d), work), H) for d in directions]
        expected = np.array(columns).reshape(len(directions), system.nu).T
        if name == "K" and admissible is not None:
            found, expected = (
                admissible.T @ matrix @ admissible,
                admissible.T @ (expected / np.diag(directions)) @ admissible,
            )
        scale = np.abs(expected).max(axis=1, initial=1.0, keepdims=True)
        np.testing.assert_allclose(found / scale, expected / scale, rtol=0, atol=tolerance, err_msg=name)


@pytest.mark.parametrize("kind", BODIES)
def test_of_a_body(kind, rng):
    assert_tangent(*random_state(single(kind, rng), rng))


@pytest.mark.parametrize(("kind", "pair"), CASES)
def test_of_joints_and_forces(kind, pair, rng):
    """At rest and undeformed, where the matrix is complete.

    Two effects are left out of it on purpose, small beside what is there: how velocities of markers change with the
    configuration (an angle per step), and how the wrench that stiffens a reduced body changes with its deformation.
    """
    system, state = random_state(connected(kind, pair, rng), rng, strain=0.0)
    assert_tangent(system, state._replace(u=np.zeros(system.nu)))


@pytest.mark.parametrize(("kind", "pair"), CASES)
def test_of_joints_and_forces_in_motion_and_deformed(kind, pair, rng):
    system, state = random_state(connected(kind, pair, rng), rng)
    assert_tangent(system, state, blocks=("M", "L"))


@pytest.mark.parametrize(("kind", "pair"), [case for case in CASES if case.values[0] in FORCES])
def test_damping_in_motion(kind, pair, rng):
    system, state = random_state(connected(kind, pair, rng), rng, strain=0.0)
    assert_tangent(system, state, blocks=("D",))


@pytest.mark.parametrize("pair", [p for p in PAIRS if "point" not in p])
def test_of_a_driven_turn_where_its_joint_is_closed(pair, rng):
    """K of the driven angle is that of parallel axes, on the motions that the joint permits.

    The bodies are put together twice: closing a gap bends reduced bodies, by 1e-5 m here, and what K leaves out of bent
    ones (see above) is then 3e-6 of it.
    """
    system, state = assemble(put_together(connected("Drive", pair, rng), t=0.37), t=0.37)
    state = system.state(state.t, state.q, None, rng.normal(size=system.nu), rng.normal(size=system.ng))
    permitted = null_space(equations_at(system, state, system.workspace()).G.toarray()[:-1])
    assert_tangent(system, state._replace(u=np.zeros(system.nu)), admissible=permitted)


@pytest.mark.parametrize("kind", BODIES)
def test_step_correction(kind, rng):
    """The matrix for a step h holds M (I + h/2 ad(u)); the rest is unchanged."""
    model = single(kind, rng)
    if kind == "FloatingBody":
        model = model.changed("b", geometric_stiffness=False)
    system, state = random_state(model, rng)
    work = system.workspace()
    h = 0.02

    def matrix(half):
        weigh(work.weights, 1.0, 0.4, 0.1, half_step=half)
        evaluate(system.program, state, work)
        return stored(work.S, system.program.pattern).toarray()

    ad = np.zeros((system.nu, system.nu))
    if bodies.KINDS[kind].has_frame:
        v, w = (np.cross(np.eye(3), x) for x in (state.u[:3], state.u[3:6]))
        ad[:3, :3], ad[:3, 3:6], ad[3:6, 3:6] = w, v, w
    M = equations_at(system, state, work).M.toarray()
    difference = matrix(0.5 * h) - matrix(0.0)
    np.testing.assert_allclose(difference, 0.5 * h * M @ ad, atol=1e2 * MACHINE * np.abs(M).max())
