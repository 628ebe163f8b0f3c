"""Steps that pass over a motion which grows: a controller of far too high a gain, seen by an implicit integrator.

An implicit formula damps what changes much faster than its step, growth included: y' = s y with s h >> 1 is multiplied
by about -1/(s h) or less in every step, where the solution grows by e^(s h) (Hairer & Wanner, Solving Ordinary
Differential Equations II, 1996, section IV.3). The error that controls the step sees nothing, because from a rest all
terms are small. So the growth is read from the equations themselves, where a run ends.
"""

from __future__ import annotations

import numpy as np
from scipy import linalg

from flexmb.integrate.matrices import tangent_at
from flexmb.integrate.runs.runaway import REMEDY, that_follow
from flexmb.results import Status

__all__ = ["unstable_at_end", "unstable_in_steps"]

DENSE = 300
"""Velocities of a model up to which this is looked at."""
PASSED_OVER = 2.0
"""Growths by e in a mean step from which on no step has followed them."""
GROWN = 100.0
"""Growths by e in the run from which on rounding alone has left every model: 1e-16 becomes 1e27."""
AT_ONCE = 20.0
"""The same of a run that has failed anyhow."""
ROUNDING = 1e-6
"""Of the fastest rate: slower growth is none."""


def unstable_in_steps(system, work, start, row, span: float, counts) -> Status | None:
    """Return a failure if the steps of a run have passed over a growth that is there at both ends of its phase.

    Parameters
    ----------
    start : State
        At which the phase began: a growth that is there for a moment limits nothing.
    row : dict of arrays
        Of its end.
    span : float, s
        Time of the run until here.
    counts : dict of str to int
        Of its steps.
    """
    steps = counts.get("steps", 0)
    if row is None or not steps or not span > 0.0 or not that_follow(system):
        return None
    rate, freedom = min(_fastest(system, state, work) for state in (start, _state(system, row)))
    if not rate * span > max(GROWN, PASSED_OVER * steps):
        return None
    passed = f"{_words(system, rate, freedom)}; a step took {span / steps:.3g} s and passed over it"
    return Status.failed(passed, REMEDY)


def unstable_at_end(system, work, start, row, reached: float) -> str | None:
    """Return the words about a growth that explains why a run has failed where it is, or None."""
    state = start if row is None else _state(system, row)
    if not that_follow(system) or not np.isfinite(reached):
        return None
    rate, freedom = _fastest(system, state, work)
    return _words(system, rate, freedom) if rate * (reached - start.t) > AT_ONCE else None


def _state(system, row):
    return system.state(float(row["t"][-1]), *(row[name][-1] for name in ("q", "u", "a", "lam")))


def _words(system, rate: float, freedom: int) -> str:
    follow = ", ".join(that_follow(system))
    return (
        f"the motion of {system.owner(freedom)}, is unstable: a disturbance grows by e every {1.0 / rate:.3g} s; what "
        f"follows measurements: {follow}"
    )


def _fastest(system, state, work) -> tuple[float, int]:
    """Return the largest growth rate, 1/s, of the linear equations at a state, and the velocity that takes part most.

    First-order states are velocities whose rates do not follow from their integrals: they need nothing of their own.
    """
    nothing = 0.0, 0
    if not 0 < system.nu <= DENSE:
        return nothing
    with np.errstate(all="ignore"):
        tangent = tangent_at(system, state, work)
        M, D, K, G = (np.asarray(part.todense()) for part in (tangent.M, tangent.D, tangent.K, tangent.G))
        if not all(np.all(np.isfinite(part)) for part in (M, D, K, G)):
            return nothing
        scale = 1.0 / np.sqrt(np.maximum(np.abs(M.diagonal()), 1e-12 * np.abs(M.diagonal()).max()))
        M, D, K = (scale[:, None] * part * scale for part in (M, D, K))
        G = G * scale
        rows = np.linalg.norm(G, axis=1, keepdims=True)
        N = linalg.null_space(G / np.where(rows > 0.0, rows, 1.0), rcond=1e-9) if len(G) else np.eye(system.nu)
        n = N.shape[1]
        try:
            back = -np.linalg.solve(N.T @ M @ N, np.hstack([N.T @ K @ N, N.T @ D @ N])) if n else np.zeros((0, 0))
            values, vectors = np.linalg.eig(np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), back]))
        except np.linalg.LinAlgError:  # motions without inertia, or no finite numbers
            return nothing
    if not n or not np.all(np.isfinite(values)):
        return nothing
    k = int(np.argmax(values.real))
    if not values[k].real > ROUNDING * float(np.abs(values).max()):
        return nothing
    return float(values[k].real), int(np.argmax(np.abs(scale * (N @ vectors[n:, k]))))
