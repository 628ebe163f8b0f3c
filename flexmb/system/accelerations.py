"""Accelerations and multipliers of a state: M a - G^T lam = f, G a = -drift."""

from __future__ import annotations

import numpy as np

from flexmb.math.block_lu import lu_factor
from flexmb.math.block_substitution import lu_solve, lu_solve_softened, subtract_product
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.kernel_on_demand import kernel_on_demand
from flexmb.math.plain_loops import copy_into, largest_size
from flexmb.math.program import PROGRAM
from flexmb.math.structures import array_type
from flexmb.math.tables import CHOICE, COUNT, FLOATS, STATE, WORK, void
from flexmb.math.weights import weigh
from flexmb.system.damped_accelerations import SOLVED, damped_accelerations, load_sizes
from flexmb.system.program import constraint_acceleration, evaluate

__all__ = [
    "EXACT",
    "accelerations",
    "corrected_accelerations",
    "is_solved",
    "linear_accelerations",
    "ready_for",
    "settled_accelerations",
    "solved_accelerations",
]

EXACT = 1e-12
"""Relative change of accelerations and multipliers at which their refinement ends."""
STRAIGHT = 0.99
"""Square of the cosine between two corrections that go the same way."""
LASTING = 0.99999
"""Part that is left by each correction, from which it never ends: equations that contradict each other."""
TURNS = 4
"""Solutions with one matrix, at most, of which each refines the one before."""
SETTLED = 1e-9
"""Relative change of the multipliers at which Newton's method, which squares it, has converged."""


@kernel
def accelerations(program, state, work, right, sweeps):
    """Solve M a - G^T lam = f, G a = -drift for the accelerations and multipliers, in place of state.a and state.lam.

    The equations are linear in both, so one solve suffices; further sweeps (at most so many, fewer where nothing
    changes any more) refine, and with dependent equations (regularised) converge to the multipliers of least norm.
    Where the refinement still changes much, forces depend on the multipliers (friction): Newton's method then goes on.
    Returns -1 or the place of a vanishing pivot.
    """
    nu, ng = len(state.u), len(state.lam)
    nonlinear, curved, least = False, False, 0.0
    # dependent equations still change a little in the second sweep
    looked = 2 if len(program.pattern.softness) > 0 else 1
    before = np.zeros(ng)
    weigh(work.weights, 1.0)
    state.a[:] = 0.0
    state.lam[:] = 0.0
    for sweep in range(40):
        fresh = sweep == 0 or nonlinear
        work.weights[0].wanted = 1 if fresh else 0
        evaluate(program, state, work)
        if fresh:
            failed = lu_factor(work.S, program.pattern)
            if failed >= 0:
                return failed
        _unsolved(work, state, right)
        if sweep == 0:
            least = EXACT * largest_size(work.residual)  # multipliers that cancel to rounding
        lu_solve(work.S, program.pattern, right)
        if len(program.pattern.softness) > 0:
            _lengthened(nu, right, before)
        largest, moved = _added(state.a, right[:nu], 0.0)
        size, change = _added(state.lam, right[nu:], least)
        settled = sweep > 0 and moved <= EXACT * largest
        # signals that follow accelerations, and are limited: just before a limit little is left, and that in each sweep
        curved = curved or (sweep >= looked and len(work.channels) > 1 and moved > SOLVED * largest)
        nonlinear = nonlinear or curved or (sweep == looked and change > 1e-6 * size)
        done = not nonlinear or (change <= EXACT * size and (settled or not curved))
        if (change <= EXACT * size and settled) or (sweep + 1 >= sweeps and done):
            break
    if len(program.pattern.softness) > 0 and not nonlinear:
        _without_stress(program, state, work, right)
    return -1


@kernel
def linear_accelerations(program, state, work, right):
    """Solve as `accelerations` does, by one evaluation: where no force follows accelerations or multipliers.

    Dependent equations, and bodies without inertia, are refined by the matrix itself: an evaluation costs several times
    as much as a product. Of dependent equations the multipliers keep the rounding in their states of self-stress, which
    do no work and move nothing. Returns -1 or the place of a vanishing pivot.
    """
    nu, pattern = len(state.u), program.pattern
    softened, lent = len(pattern.softness) > 0, len(program.floor_at) > 0
    weigh(work.weights, 1.0)
    state.a[:] = 0.0
    state.lam[:] = 0.0
    work.weights[0].wanted = 1
    evaluate(program, state, work)
    _unsolved(work, state, right)
    n = len(right)
    S, given, x, before = np.zeros(0), np.zeros(0), np.zeros(n), np.zeros(n - nu)
    if softened or lent:
        S, given = work.S.copy(), right.copy()
        for k in range(len(program.floor_at)):
            S[program.floor_at[k, 1]] -= work.weights[0].mass * program.floor[k]
    failed = lu_factor(work.S, pattern)
    if failed >= 0:
        return failed
    for turn in range(TURNS if softened or lent else 1):
        if turn > 0:
            for i in range(n):
                right[i] = given[i] + (pattern.softness[i] * x[i] if softened else 0.0)
            subtract_product(S, pattern, x, right)
        lu_solve(work.S, pattern, right)
        if softened:
            _lengthened(nu, right, before)
        largest, moved = 0.0, 0.0
        for i in range(n):
            x[i] += right[i]
        for i in range(nu):
            largest, moved = max(largest, abs(x[i])), max(moved, abs(right[i]))
        if moved <= EXACT * largest:
            break
    state.a[:] = x[:nu]
    state.lam[:] = x[nu:]
    return -1


@kernel_on_demand(CHOICE, PROGRAM, STATE, WORK, array_type(FLOATS))
def corrected_accelerations(program, state, work, right):
    """Correct accelerations and multipliers that nearly solve the equations of `accelerations`, in place of state.a
    and state.lam, by Newton's method; return if it converges.

    Friction that reads the multipliers may allow several solutions: this one stays near the given one.
    """
    nu, ng = len(state.u), len(state.lam)
    weigh(work.weights, 1.0)
    for _ in range(8):
        work.weights[0].wanted = 1
        evaluate(program, state, work)
        if lu_factor(work.S, program.pattern) >= 0:
            return False
        _unsolved(work, state, right)
        lu_solve(work.S, program.pattern, right)
        size, change = 0.0, 0.0
        for i in range(nu):
            state.a[i] += right[i]
        for i in range(ng):
            state.lam[i] += right[nu + i]
            size, change = max(size, abs(state.lam[i])), max(change, abs(right[nu + i]))
        if change <= SETTLED * size:
            return True
    return False


def solved_accelerations(system, state, work) -> tuple[np.ndarray, np.ndarray] | None:
    """Return accelerations (nu,) and multipliers (ng,) at a state by the sparse factorisation; its own are ignored.

    Friction by reactions, and forces that follow accelerations, are solved with them, by damped steps where whole ones
    do not converge. None if these do not either.
    """
    nu, right = system.nu, np.zeros(system.nu + system.ng)
    # a body of hardly any inertia in some freedom leaves the first solve few digits: more of them give them back
    for sweeps in (12,) if system.redundant else (2, 12):
        own = state._replace(a=np.zeros(nu), lam=np.zeros(system.ng))
        failed = accelerations(system.program, own, work, right, sweeps)
        if failed < 0 and is_solved(system, own, right, work):
            return own.a, own.lam
    if not (system.implicit or any(force.reads_reactions for force in system.model.forces)):
        return None
    return damped_accelerations(system, state._replace(a=np.zeros(nu), lam=np.zeros(system.ng)), work)


def settled_accelerations(system, state, work, right) -> bool:
    """Return if accelerations and multipliers that `accelerations` has just written to a state solve its equations.

    Where forces follow accelerations and whole steps have not settled, damped ones are tried, and what they find is
    written to the state.
    """
    if not system.implicit or is_solved(system, state, right, work):
        return True
    found = solved_accelerations(system, state, work)
    if found is not None:
        state.a[:], state.lam[:] = found
    return found is not None


def ready_for(system) -> None:
    """Make ready what solutions call on demand: kernels that are called through their addresses pass no errors on."""
    if system.redundant:
        for called in (_lengthened, _without_stress):
            called.ready()


def is_solved(system, state, right, work) -> bool:
    """Was the last correction `right` (nu + ng,) of accelerations and multipliers rounding, of them or of the loads?"""
    change, force = (np.max(np.abs(part), initial=0.0) for part in (right[: system.nu], right[system.nu :]))
    largest = max(np.linalg.norm(system.model.gravity), np.max(np.abs(state.a), initial=0.0))
    if change <= SOLVED * largest and force <= SOLVED * np.max(np.abs(state.lam), initial=0.0):
        return True
    if not (np.isfinite(change) and np.isfinite(force)):
        return False
    loads = load_sizes(system, state, work)  # joints that carry nothing, and loads that balance, leave rounding
    if force > SOLVED * max(np.max(np.abs(state.lam), initial=0.0), loads[1]):
        return False
    if change <= SOLVED * max(largest, loads[0]):
        return True
    return _is_rounding(system, state, right[: system.nu], work)


def _is_rounding(system, state, change, work) -> bool:
    """Are the forces that a change of accelerations (nu,) needs small beside what bodies need, and beside the loads?

    They are compared by what they move of bodies that resist: the last digit of what a light body carries changes its
    own acceleration much, which matters to no other body.
    """
    weigh(work.weights, 1.0)
    evaluate(system.program, state._replace(a=np.zeros(system.nu), lam=np.zeros(system.ng)), work)
    rows, inertia = system.tables["diagonal_rows"], np.abs(work.S[system.tables["diagonal_at"]])
    resists = np.maximum(inertia, system.least_inertia[rows])
    moves = np.divide(1.0, resists, out=np.zeros(len(rows)), where=resists > 0.0)
    usual = moves @ (inertia * state.a[rows]) ** 2 + moves @ work.residual[rows] ** 2
    return bool(moves @ (inertia * change[rows]) ** 2 <= SOLVED**2 * usual)


@kernel_on_demand(void, COUNT, array_type(FLOATS), array_type(FLOATS))
def _lengthened(nu, right, before):
    """Lengthen a correction that is a part rho of the one before to what all that would follow add up to.

    Near a singular position an equation that is nearly dependent moves little, and its softness, the same for all,
    leaves most of it open: corrections then shrink by the same part again and again, rho + rho^2 + ... (Aitken).
    `before` (ng,) takes the multipliers' part, or zero after a long one.
    """
    along, square, own = 0.0, 0.0, 0.0
    for i in range(len(before)):
        along += right[nu + i] * before[i]
        square += before[i] * before[i]
        own += right[nu + i] * right[nu + i]
    rho = along / square if square > 0.0 else 0.0
    straight = along * along >= STRAIGHT * own * square
    if straight and 0.1 < rho < LASTING:
        for i in range(len(right)):
            right[i] /= 1.0 - rho
        before[:] = 0.0
    else:
        copy_into(before, right[nu:])


@inner_kernel
def _added(x, correction, least):
    """Add a correction, and return the largest entries of the sum, at least `least`, and of the correction."""
    largest, moved = least, 0.0
    for i in range(len(x)):
        x[i] += correction[i]
        largest, moved = max(largest, abs(x[i])), max(moved, abs(correction[i]))
    return largest, moved


@inner_kernel
def _unsolved(work, state, right):
    """Write what is left of the equations of motion and of the constraints at the latest evaluation to `right`."""
    nu = len(state.u)
    for i in range(nu):
        right[i] = -work.residual[i]
    constraint_acceleration(work, state.a, right[nu:])
    for i in range(len(state.lam)):
        right[nu + i] = -right[nu + i]


@kernel_on_demand(void, PROGRAM, STATE, WORK, array_type(FLOATS))
def _without_stress(program, state, work, right):
    """Take the rounding out of multipliers of least norm.

    Where equations depend on each other, only the softness r holds the states of self-stress, and the last digit of the
    loads appears in them as eps / r. The solution of (M, -G^T; G, r) (x, y) = (0, r lam) is the self-stress y, with an
    error of eps only; of all other multipliers it has a share of about r, which refinement gives back.
    """
    nu, ng = len(state.u), len(state.lam)
    right[:nu] = 0.0
    for i in range(ng):
        right[nu + i] = program.regularisation[i] * state.lam[i]
    lu_solve_softened(work.S, program.pattern, right)
    for i in range(ng):
        state.lam[i] -= right[nu + i]
    work.weights[0].wanted = 0
    for _ in range(6):
        evaluate(program, state, work)
        _unsolved(work, state, right)
        lu_solve(work.S, program.pattern, right)
        _added(state.a, right[:nu], 0.0)
        size, change = _added(state.lam, right[nu:], 0.0)
        if change <= EXACT * size:
            break
