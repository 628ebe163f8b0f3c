"""Steps that pass over a motion which grows: a controller of far too high a gain, seen by an implicit integrator.

An implicit formula damps what changes much faster than its step, growth included: y' = s y with s h >> 1 is multiplied
by about -1/(s h) or less in every step, where the solution grows by e^(s h) (Hairer & Wanner, Solving Ordinary
Differential Equations II, 1996, section IV.3). The error that controls the step sees nothing, because from a rest all
terms are small. So the growth is read from the equations themselves, where a run ends.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import linalg, sparse

from flexmb.integrate.matrices import tangent_at
from flexmb.integrate.runs.growth_of_many import Growth, fastest_of_many, within
from flexmb.integrate.runs.runaway import REMEDY, that_follow
from flexmb.results import Status

__all__ = ["looked_at", "unstable_at_end", "unstable_in_steps"]

DENSE = 300
"""Velocities of a model up to which all eigenvalues are looked at."""
MANY = 20_000
"""And up to which those that grow are looked for."""
PASSED_OVER = 2.0
"""Growths by e in a mean step from which on no step has followed them."""
GROWN = 100.0
"""Growths by e in the run from which on rounding alone has left every model: 1e-16 becomes 1e27."""
AT_ONCE = 20.0
"""The same of a run that has failed anyhow."""
ROUNDING = 1e-6
"""Of the fastest rate: slower growth is none."""
LOOKS = 9
"""Samples of a phase at which the growth must be there: a controller may be off at the begin and at the end."""
UNDRIVEN = 1e-9
"""Part of the accelerations, with those by reactions and gravity, along a growing motion that is rounding."""
CUT_SHORT = (
    "the look for motions that grow, and that steps pass over, was cut short by Ctrl-C or the limit of time: it is not "
    "known if there are any"
)


def looked_at(interruption: Any, validity: Any, look_for: Callable[..., Any], *given: Any) -> Any:
    """Return what one of the looks below finds; None if the user or the limit of time ends it: it costs eigenvalue
    problems, and the samples are complete without it.
    """
    try:
        return look_for(*given, look=interruption.look_now)
    except KeyboardInterrupt:
        validity.note([CUT_SHORT])
        return None


def unstable_in_steps(
    system, work, start, rows, end: float, steps: int, look: Callable[[], None] = lambda: None
) -> tuple[Status | None, list[str]]:
    """Return a failure if the steps of a phase have passed over a growth that is there from its begin to its end; or a
    warning if nothing has set that motion going, so that standing still is what the equations say.

    Parameters
    ----------
    start : State
        At which the phase began: a growth that is there for a moment limits nothing.
    rows : list of dict of arrays
        Blocks of its samples, the last with its end.
    end : float, s
    steps : int
        Taken in the phase: what an earlier one was long enough for says nothing about this one.
    look : callable
        Called on the way: what it raises ends the look.
    """
    span = end - start.t
    if not rows or not steps or not span > 0.0 or not that_follow(system):
        return None, []
    known = [(block, k) for block in rows for k in range(len(block["t"])) if block["t"][k] > start.t]
    known = [known[i] for i in np.unique(np.linspace(len(known) - 1, 0, LOOKS).astype(int))[::-1]] if known else []
    least = max(GROWN, PASSED_OVER * steps)
    rate, freedom, driven = _fastest(system, start, work, least / span, look)
    for block, k in known:
        if not rate * span > least:
            break
        there = _fastest(system, _state(system, block, k), work, least / span, look, rate)
        rate, freedom = min((rate, freedom), there[:2])
    if not rate * span > least:
        return None, []
    words = _words(system, rate, freedom)
    if driven:
        return Status.failed(f"{words}; a step took {span / steps:.3g} s and passed over it", REMEDY), []
    return None, [
        f"Model '{system.model.name}': {words}; nothing sets it going, so it stands still. Disturb it a little to see."
    ]


def unstable_at_end(system, work, start, row, reached: float, look: Callable[[], None] = lambda: None) -> str | None:
    """Return the words about a growth that explains why a run has failed where it is, or None."""
    state = start if row is None else _state(system, row)
    if not that_follow(system) or not np.isfinite(reached) or not reached > start.t:
        return None
    rate, freedom, _ = _fastest(system, state, work, AT_ONCE / (reached - start.t), look)
    return _words(system, rate, freedom) if rate * (reached - start.t) > AT_ONCE else None


def _state(system, row, k: int = -1):
    return system.state(float(row["t"][k]), *(row[name][k] for name in ("q", "u", "a", "lam")))


def _words(system, rate: float, freedom: int) -> str:
    follow = ", ".join(that_follow(system))
    return (
        f"the motion of {system.owner(freedom)}, is unstable: a disturbance grows by e every {1.0 / rate:.3g} s; what "
        f"follows measurements: {follow}"
    )


def _fastest(system, state, work, least: float, look, near: float | None = None) -> tuple[float, int, bool]:
    """Return the largest growth rate, 1/s, of the linear equations at a state, the velocity that takes part most, and
    if speeds or accelerations of the state have a part along that motion.

    First-order states are velocities whose rates do not follow from their integrals: they need nothing of their own.
    Of many velocities only rates above `least`, 1/s, are looked for; near one that is known, if `near` gives it.
    """
    nothing = 0.0, 0, False
    if not 0 < system.nu <= MANY:
        return nothing
    look()
    with np.errstate(all="ignore"):
        tangent = tangent_at(system, state, work)
        M, D, K, G = tangent.M, tangent.D, tangent.K, tangent.G
        if not all(np.all(np.isfinite(part.data)) for part in (M, D, K, G)):
            return nothing
        scale = 1.0 / np.sqrt(np.maximum(np.abs(M.diagonal()), 1e-12 * np.abs(M.diagonal()).max()))
        scaled = sparse.diags(scale)
        M, D, K, G = scaled @ M @ scaled, scaled @ D @ scaled, scaled @ K @ scaled, G @ scaled
        rows = np.sqrt(np.asarray(G.multiply(G).sum(1)).ravel())
        unit = sparse.diags(1.0 / np.where(rows > 0.0, rows, 1.0)) @ G
        growth = _of_few(M, D, K, unit) if system.nu <= DENSE else fastest_of_many(M, D, K, unit, least, near, look)
    if growth is None:
        return nothing
    u, a = (within(unit, x / scale) for x in (state.u, state.a))
    of_place, of_speed = -K.T @ growth.left / growth.value.conjugate(), M.T @ growth.left
    n = min((place.start for _, place in system.state_slices.values()), default=system.nu)
    others = np.linalg.norm(G.T @ state.lam) + np.linalg.norm(np.ravel(system.model.gravity)) * np.max(1.0 / scale[:n])
    rounding = (np.linalg.norm(a[:n]) + others) * np.linalg.norm(of_speed[:n])
    rounding += np.linalg.norm(u) * np.linalg.norm(of_place)
    rounding += np.abs(of_speed[n:]) @ (np.abs(a) + abs(D) @ np.abs(u))[n:]  # of states: each in its own unit
    driven = bool(abs(np.vdot(of_place, u) + np.vdot(of_speed, a)) > UNDRIVEN * rounding)
    return growth.value.real, int(np.argmax(np.abs(scale * growth.shape))), driven


def _of_few(M, D, K, G) -> Growth | None:
    """Return the motion that grows fastest, by all eigenvalues; None if none grows."""
    M, D, K, G = (np.asarray(part.todense()) for part in (M, D, K, G))
    N = linalg.null_space(G, rcond=1e-9) if len(G) else np.eye(len(M))
    n = N.shape[1]
    try:
        back = -np.linalg.solve(N.T @ M @ N, np.hstack([N.T @ K @ N, N.T @ D @ N])) if n else np.zeros((0, 0))
        whole = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), back])
        values, left, vectors = linalg.eig(whole, left=True)
    except (np.linalg.LinAlgError, ValueError):  # motions without inertia, or no finite numbers
        return None
    if not n or not np.all(np.isfinite(values)):
        return None
    k = int(np.argmax(values.real))
    if not values[k].real > ROUNDING * float(np.abs(values).max()):
        return None
    # of a left eigenvector the part of speeds is M^T times that of s^2 M + s D + K
    of_force = np.linalg.solve((N.T @ M @ N).T, left[n:, k])
    return Growth(complex(values[k]), N @ vectors[n:, k], N @ of_force)
