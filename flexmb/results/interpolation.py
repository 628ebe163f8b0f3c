"""The state between two samples: cubic Hermite interpolation of coordinates and velocities.

The rate of a frame is ``r' = R v``, ``p' = 1/2 p o (0, w)``; all other rates are the velocities themselves. The errors
of q and u are of fourth order in the time between samples, the error of multipliers of second order.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.rotations import euler_to_matrix
from flexmb.results.phase import Instant, Phase
from flexmb.results.series import Series

__all__ = ["instant_at"]


def instant_at(phase: Phase, t: float) -> Instant:
    """Return the state of a phase at time `t` (s), which lies within its samples."""
    k = int(np.searchsorted(phase.t, t, side="right")) - 1
    k = min(max(k, 0), len(phase.t) - 1)
    if k == len(phase.t) - 1 or phase.t[k] == t:
        return phase.instant(k)
    h = phase.t[k + 1] - phase.t[k]
    s = (t - phase.t[k]) / h
    ends = [(phase.q[i], phase.u[i], phase.a[i]) for i in (k, k + 1)]
    rates = [_rates(phase.model, q, u) for q, u, _ in ends]
    n = _count(phase.model) + _states(phase.model, ends[0][1])
    for rate in rates:  # what comes after the bodies' coordinates tells branches: a line between the samples will do
        rate[n:] = (ends[1][0][n:] - ends[0][0][n:]) / h
    q = _hermite(s, h, ends[0][0], rates[0], ends[1][0], rates[1])
    held = _held(phase, n)
    q[held] = ends[0][0][held]
    u = _hermite(s, h, ends[0][1], ends[0][2], ends[1][1], ends[1][2])
    for iq, _ in _frames(phase.model):
        q[iq + 3 : iq + 7] /= np.linalg.norm(q[iq + 3 : iq + 7])

    def between(values):
        return (1.0 - s) * values[k] + s * values[k + 1]

    return Instant(
        t=float(t), q=q, u=u, a=between(phase.a), lam=between(phase.lam), works=between(phase.works), model=phase.model
    )


def _hermite(s, h, x0, dx0, x1, dx1):
    return (
        (1.0 + 2.0 * s) * (1.0 - s) ** 2 * x0
        + s * (1.0 - s) ** 2 * h * dx0
        + s * s * (3.0 - 2.0 * s) * x1
        - s * s * (1.0 - s) * h * dx1
    )


def _held(phase: Phase, first: int) -> list[int]:
    """Return the coordinates that hold values, among those behind the bodies' and states'."""
    if len(phase.q[0]) == first:
        return []
    from flexmb.system.holds import HELD

    names = Series(phase).system.branch_names
    return [first + k for k, name in enumerate(names) if name.startswith(HELD)]


def _frames(model):
    """Yield (first coordinate, first velocity) of every body with a frame, in the order of the model's bodies."""
    iq = iu = 0
    for body in model.bodies:
        if body.has_frame:
            yield iq, iu
        iq += 7 * body.has_frame + body.n_vector
        iu += 6 * body.has_frame + body.n_vector


def _count(model) -> int:
    """Return the number of coordinates of all bodies."""
    return sum(7 * body.has_frame + body.n_vector for body in model.bodies)


def _states(model, u) -> int:
    """Return the number of first-order states, which stand behind all bodies, as their integrals do in q."""
    return len(u) - sum(6 * body.has_frame + body.n_vector for body in model.bodies)


def _rates(model, q, u):
    """Return q' (nq,): frames by their kinematics, vector coordinates and integrals of states by their velocities."""
    rate = np.empty(len(q))
    R = np.empty((3, 3))
    iq = iu = 0
    for body in model.bodies:
        if body.has_frame:
            p, v, w = q[iq + 3 : iq + 7], u[iu : iu + 3], u[iu + 3 : iu + 6]
            euler_to_matrix(p, R)
            rate[iq : iq + 3] = R @ v
            rate[iq + 3] = -0.5 * p[1:] @ w
            rate[iq + 4 : iq + 7] = 0.5 * (p[0] * w + np.cross(p[1:], w))
            iq, iu = iq + 7, iu + 6
        rate[iq : iq + body.n_vector] = u[iu : iu + body.n_vector]
        iq, iu = iq + body.n_vector, iu + body.n_vector
    rate[iq : iq + len(u) - iu] = u[iu:]
    return rate
