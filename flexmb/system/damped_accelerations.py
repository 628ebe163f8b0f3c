"""Newton's method with damped steps, where forces follow the accelerations or multipliers that they make."""

from __future__ import annotations

import numpy as np

from flexmb.errors import CompileError
from flexmb.math.block_lu import lu_factor
from flexmb.math.block_substitution import lu_solve
from flexmb.math.weights import weigh
from flexmb.system.program import constraint_acceleration, evaluate

__all__ = ["SOLVED", "damped_accelerations", "largest", "load_sizes", "unsolved"]

TURNS = 100
"""Newton's steps, at most."""
HALVINGS = 40
"""Of one step: it is then rounding."""
SOLVED = 1e-10
"""Last correction of accelerations and multipliers, relative, up to which they count as solved."""


def damped_accelerations(system, state, work) -> tuple[np.ndarray, np.ndarray] | None:
    """Return accelerations (nu,) and multipliers (ng,) near those of a state; None if Newton's method finds none.

    A step is halved until the correction that would follow, with the same matrix, is shorter: the natural
    monotonicity test, for which units of equations do not matter (Deuflhard 2004). Across a corner, beyond which
    the matrix is another one, whole steps may lead to and fro for ever.
    """
    program, nu = system.program, system.nu
    x = np.concatenate([state.a, state.lam])
    least = load_sizes(system, state, work)

    def correction(of: np.ndarray, *, anew: bool) -> np.ndarray | None:
        own = state._replace(a=of[:nu].copy(), lam=of[nu:].copy())
        weigh(work.weights, 1.0)
        work.weights[0].wanted = int(anew)
        evaluate(program, own, work)
        if anew and lu_factor(work.S, program.pattern) >= 0:
            return None
        right, left = np.zeros(len(of)), np.zeros(system.ng)
        constraint_acceleration(work, own.a, left)
        right[:nu], right[nu:] = -work.residual, -left
        lu_solve(work.S, program.pattern, right)
        return right if np.all(np.isfinite(right)) else None

    for _ in range(TURNS):
        step = correction(x, anew=True)
        if step is None:
            return None
        sizes = max(least[0], largest(x[:nu])), max(least[1], largest(x[nu:]))
        if largest(step[:nu]) <= SOLVED * sizes[0] and largest(step[nu:]) <= SOLVED * sizes[1]:
            x = x + step
            return x[:nu].copy(), x[nu:].copy()
        # of both kinds, relative to what they are or would become
        units = np.concatenate(
            [
                system.units / max(sizes[0], largest(step[:nu]), np.finfo(float).tiny),
                np.full(system.ng, 1.0 / max(sizes[1], largest(step[nu:]), np.finfo(float).tiny)),
            ]
        )
        length, part = float(np.linalg.norm(units * step)), 1.0
        for _ in range(HALVINGS):
            following = correction(x + part * step, anew=False)
            if following is not None and np.linalg.norm(units * following) <= (1.0 - 0.25 * part) * length:
                break
            part *= 0.5
        else:
            return None
        x = x + part * step
    return None


def load_sizes(system, state, work) -> tuple[float, float]:
    """Return what the loads of a state would accelerate if none balanced another, and the largest load.

    Accelerations and multipliers that balance are rounding of these; what is small beside them is zero.
    """
    program, nu = system.program, system.nu
    rest = state._replace(a=np.zeros(nu), lam=np.zeros(system.ng))
    weigh(work.weights, 1.0)
    work.weights[0].wanted = 1
    evaluate(program, rest, work)
    loads = np.abs(work.residual)
    right, left = np.zeros(nu + system.ng), np.zeros(system.ng)
    constraint_acceleration(work, rest.a, left)
    right[:nu], right[nu:] = loads, np.abs(left)
    gravity = float(np.linalg.norm(system.model.gravity))
    if lu_factor(work.S, program.pattern) >= 0:
        return gravity, largest(loads)
    lu_solve(work.S, program.pattern, right)
    return max(gravity, largest(right[:nu])), largest(loads)


def unsolved(system, part: str) -> CompileError:
    """Return the error about accelerations, or multipliers that make forces, which Newton's method does not find."""
    if not system.implicit:
        return CompileError(
            part,
            found="friction by joint reactions does not converge",
            expected="joints that friction does not jam",
            remedy="Use a smaller coefficient of friction",
        )
    return CompileError(
        part,
        found="forces that follow accelerations leave no unique accelerations, or Newton's method finds none",
        expected="a regular mass matrix: a force -k a on a mass m makes it m + k",
        remedy="Lower the gain of the acceleration, or sample it (Sampled)",
    )


def largest(x: np.ndarray) -> float:
    """Return the largest size of the numbers, zero of none."""
    return float(np.max(np.abs(x), initial=0.0))
