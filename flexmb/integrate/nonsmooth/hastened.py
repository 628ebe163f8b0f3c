"""Sweeps over the contacts with momentum, for heaps in which plain ones pass loads on slowly.

A sweep finds every impulse exactly in its own cone, with all others as they are. In a heap what is left then falls like
that of an iteration on a long chain: by a share that is the smaller the more contacts a load has to pass. Nesterov's
momentum, ``y = P + beta (P - P_before)`` ahead of each sweep, needs the root of those sweeps. It begins anew where it
leads away from what the sweep has found. No slip has to be held, as in gradients, for each contact is solved whole: at
equal residual it takes a tenth of their steps.

All sweeps have one direction. Turned about from one to the next, they and the momentum do not fit each other and
impulses grow. Where they grow none the less, the best ones return and momentum is bounded; without it sweeps are left.

Source: Nesterov 1983; O'Donoghue & Candes, Found. Comput. Math. 15 (2015) 715-732 (when to begin anew);
Silcowitz-Hansen, Niebe & Erleben, The Visual Computer 26 (2010) 893-901 (sweeps in place of gradients).
"""

from __future__ import annotations

import numpy as np

from flexmb.integrate.nonsmooth.problem import Problem, add_impulse, residuals, sweep
from flexmb.math.kernel import inner_kernel, kernel

__all__ = ["hasten"]

LOOKS = 10
"""Sweeps between two looks at the laws, if the last one has changed more than what is asked for."""
GROWN = 16.0
"""Square of the change in a sweep, relative to the smallest so far, at which momentum has led astray."""
BOUNDED = 0.7
"""Factor on the largest momentum then."""
STALL, BETTER = 60, 0.5
"""Sweeps in which what is left has to fall to this share of itself: where bodies hold each other by friction, as in a
pyramid of balls, sweeps may turn in circles, and gradients do not."""


@inner_kernel
def _change(p, start, before):
    """Return the square of the change (n, 6) by a sweep, J-like, and its product with that since the sweep before."""
    size, ahead = 0.0, 0.0
    for i in range(len(p.points)):
        if p.active[i] > 0:
            m = p.rows[i]
            for r in range(m):
                weight = p.D[36 * i + r * m + r]
                x = p.P[i, r] - start[i, r]
                size += x * x * weight
                ahead += x * (p.P[i, r] - before[i, r]) * weight
    return size, ahead


@inner_kernel
def _go_on(p, parts, part, before, v):
    """Move all impulses on by a part of their change since `before`, which becomes the present ones, and `v` along."""
    dP = np.zeros(6)
    for i in range(len(p.points)):
        if p.active[i] > 0:
            for r in range(6):
                dP[r] = part * (p.P[i, r] - before[i, r])
                before[i, r] = p.P[i, r]
                p.P[i, r] += dP[r]
            if part > 0.0:
                add_impulse(p, parts, i, dP, v)


@kernel
def hasten(p: Problem, parts, v, goal, most):
    """Improve the impulses P, with which `v` comes, until all laws hold to `goal`, m/s; return the sweeps.

    There are at most so many, and they end where they help no longer. The best impulses that were looked at are kept,
    the ones at the start among them.
    """
    out, start, before = np.zeros(len(p.points)), p.P.copy(), p.P.copy()
    best, best_v = p.P.copy(), v.copy()
    least, _ = residuals(p, v, out)
    momentum, bound, smallest, done = 1.0, 1.0, np.inf, 0
    mark, marked = least, 0
    while done < most:
        start[:] = p.P
        largest, _ = sweep(p, parts, v, False)
        done += 1
        if largest <= goal or done % LOOKS == 0 or done == most:
            residual, _ = residuals(p, v, out)
            if residual < least:
                least = residual
                best[:] = p.P
                best_v[:] = v
            if residual <= goal:
                break
            if least < BETTER * mark:
                mark, marked = least, done
            elif done - marked >= STALL:
                break
        size, ahead = _change(p, start, before)
        if not size < GROWN * smallest:
            bound *= BOUNDED
            p.P[:] = best
            v[:] = best_v
            before[:] = best
            momentum, smallest = 1.0, np.inf
            continue
        if ahead < 0.0:
            momentum = 1.0
        smallest = min(smallest, size)
        follow = 0.5 * (1.0 + (1.0 + 4.0 * momentum * momentum) ** 0.5)
        _go_on(p, parts, min(bound, (momentum - 1.0) / follow), before, v)
        momentum = follow
    p.P[:] = best
    v[:] = best_v
    return done
