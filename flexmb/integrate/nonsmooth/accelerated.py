"""Accelerated projected gradients on all contacts at once, for heaps in which sweeps pass loads on slowly.

With the slip's share of the normal velocity held, ``s = mu |xi_T|`` (De Saxce & Feng 1998; drilling and rolling have
theirs, added to it), Coulomb's law is the
condition of a minimum: of ``1/2 P.D P + P.(q + s n)`` over the cones of friction. Nesterov's method finds it in some
hundred steps where sweeps take thousands, and each step costs less than a sweep, because no contact is solved on its
own. Where nothing slips s = 0 and the minimum is the solution. Otherwise s follows the slip as soon as what is left of
the minimum is small beside its last change.

Source: Mazhar, Heyn, Negrut & Tasora, ACM Trans. Graph. 34 (2015) 32 (the method for contacts); O'Donoghue & Candes,
Found. Comput. Math. 15 (2015) 715-732 (restarts); Acary & Cadoux 2013 (the fixed point of s).
"""

from __future__ import annotations

import numpy as np

from flexmb.integrate.nonsmooth.problem import Problem, add_impulse, residuals, velocity_of
from flexmb.math.kernel import inner_kernel, kernel

__all__ = ["accelerate"]

LOOKS = 20
"""Products in which the largest eigenvalue of the scaled mobility is found, and steps between two looks at the laws."""
ABOVE = 1.1
"""Estimate of the largest eigenvalue, relative to what they give."""
PATIENT = 400
"""Steps after which s follows for the first time, whatever is left: what can stand still does so by then."""
LEAST = 10
"""Steps with one s, at least."""
CLOSER = 0.1
"""What is left of the minimum, relative to the last change of s, at which s follows."""


@inner_kernel
def _group(k):
    """Return the first and the last row of those that are projected together with row k."""
    if k == 0 or k == 3:
        return k, k
    return (1, 2) if k < 3 else (4, 5)


@inner_kernel
def _write_scales(p, scale):
    """Write the mobility of every row (n, 6), one number for those that are projected together."""
    for i in range(len(p.points)):
        m = p.rows[i]
        for k in range(m):
            first, last = _group(k)
            largest = 0.0
            for r in range(first, last + 1):
                largest = max(largest, p.D[36 * i + r * m + r])
            scale[i, k] = largest if largest > 0.0 else max(p.D[36 * i], 1e-300)


@inner_kernel
def _velocities(p, parts, base, y, v, xi, shifted):
    """Write v = base + X y, and the velocities xi (n, 6) of all active contacts, with their shifts if asked to."""
    v[:] = base
    for i in range(len(p.points)):
        if p.active[i] > 0:
            add_impulse(p, parts, i, y[i], v)
    for i in range(len(p.points)):
        if p.active[i] > 0:
            velocity_of(p, i, v, xi[i])
            if shifted:
                xi[i, 0] += p.shift[i]


@inner_kernel
def _largest_eigenvalue(p, parts, scale, nothing, v, xi):
    """Return the largest eigenvalue of the mobility with a scaled diagonal of ones, from powers."""
    n = len(p.points)
    y = np.zeros((n, 6))
    for i in range(n):
        if p.active[i] > 0:
            for k in range(p.rows[i]):
                y[i, k] = (1.0 + 0.5 * np.sin(12.9898 * i + 78.233 * k)) / scale[i, k] ** 0.5
    value = 0.0
    for _ in range(LOOKS):
        size = 0.0
        for i in range(n):
            if p.active[i] > 0:
                for k in range(p.rows[i]):
                    size += y[i, k] * y[i, k] * scale[i, k]
        size = size**0.5
        for i in range(n):
            for k in range(6):
                y[i, k] /= size
        _velocities(p, parts, nothing, y, v, xi, False)
        value = 0.0
        for i in range(n):
            if p.active[i] > 0:
                for k in range(p.rows[i]):
                    y[i, k] = xi[i, k] / scale[i, k]
                    value += xi[i, k] * y[i, k]
        value = value**0.5
    return value


@inner_kernel
def _width(point, k):
    """Return the friction, m or -, that limits a group of rows."""
    if k == 1:
        return point.friction
    return point.drilling if k == 3 else point.rolling


@inner_kernel
def _project(point, scale, m, least, z):
    """Move z (6,) to the nearest impulse in the cone, with squares weighed by the scales.

    With the normal part x the others are cut to discs of c x; x is the root of a falling function, linear by pieces.
    """
    sizes, bounds, weights = np.zeros(3), np.zeros(3), np.zeros(3)
    groups = 0
    for k in (1, 3, 4):
        if k < m:
            first, last = _group(k)
            square = 0.0
            for r in range(first, last + 1):
                square += z[r] * z[r]
            sizes[groups], bounds[groups] = square**0.5, _width(point, k)
            weights[groups] = scale[k] / scale[0]
            groups += 1
    x = max(z[0], least)
    for _ in range(groups + 1):  # those beyond their disc become fewer as x grows
        above, slope = z[0], 1.0
        for g in range(groups):
            if sizes[g] > bounds[g] * x:
                above += weights[g] * bounds[g] * sizes[g]
                slope += weights[g] * bounds[g] * bounds[g]
        new = max(above / slope, least)
        if abs(new - x) <= 1e-15 * abs(x):
            break
        x = new
    z[0] = x
    groups = 0
    for k in (1, 3, 4):
        if k < m:
            first, last = _group(k)
            radius = bounds[groups] * x
            if sizes[groups] > radius:
                for r in range(first, last + 1):
                    z[r] *= radius / sizes[groups]
            groups += 1


@inner_kernel
def _step_down(p, scale, step, slip, y, P, xi, new):
    """Write the impulses `new` (n, 6), a projected gradient step from y; add the slip (n,) to the velocities xi.

    Return what is left of the minimum, m/s, and what tells by its sign that the step goes back on the way from P.
    """
    left, uphill = 0.0, 0.0
    for i in range(len(p.points)):
        if p.active[i] == 0:
            continue
        m = p.rows[i]
        xi[i, 0] += slip[i]
        for k in range(m):
            new[i, k] = y[i, k] - step * xi[i, k] / scale[i, k]
        _project(p.points[i], scale[i], m, p.least[i], new[i])
        for k in range(m):
            off = y[i, k] - new[i, k]
            left = max(left, abs(off) * (scale[i, k] * scale[i, 0]) ** 0.5)
            uphill += off * (new[i, k] - P[i, k]) * scale[i, k]
    return left / step, uphill


@inner_kernel
def _follow_slip(p, xi, slip):
    """Let the slip (n,) of all contacts follow their velocities xi (n, 6); return its largest change, m/s."""
    change = 0.0
    for i in range(len(p.points)):
        if p.active[i] > 0 and p.rows[i] > 1:
            s = p.points[i].friction * (xi[i, 1] ** 2 + xi[i, 2] ** 2) ** 0.5
            if p.rows[i] == 6:
                s += p.points[i].drilling * abs(xi[i, 3])
                s += p.points[i].rolling * (xi[i, 4] ** 2 + xi[i, 5] ** 2) ** 0.5
            change = max(change, abs(s - slip[i]))
            slip[i] = s
    return change


@kernel
def accelerate(p: Problem, parts, v, goal, most):
    """Improve the impulses P, with which `v` comes, until all laws hold to `goal`, m/s; return the steps.

    There are at most so many. The best impulses on the way are kept, the ones at the start among them.
    """
    n = len(p.points)
    out, scale, xi = np.zeros(n), np.ones((n, 6)), np.zeros((n, 6))
    _write_scales(p, scale)
    nothing, base = np.zeros(len(v)), v.copy()
    for i in range(n):
        if p.active[i] > 0:
            add_impulse(p, parts, i, -p.P[i], base)
    speed = np.empty(len(v))
    step = 1.0 / (ABOVE * _largest_eigenvalue(p, parts, scale, nothing, speed, xi))
    least, _ = residuals(p, v, out)
    best, best_v = p.P.copy(), v.copy()
    slip, momentum = np.zeros(n), 1.0
    P, y, new = p.P.copy(), p.P.copy(), np.zeros((n, 6))
    since, change, taken = 0, 0.0, 0
    while taken < most:
        taken += 1
        since += 1
        _velocities(p, parts, base, y, speed, xi, True)
        left, uphill = _step_down(p, scale, step, slip, y, P, xi, new)
        if uphill > 0.0:
            momentum = 1.0
        follow = 0.5 * (1.0 + (1.0 + 4.0 * momentum * momentum) ** 0.5)
        for i in range(n):
            for k in range(6):
                y[i, k] = new[i, k] + (momentum - 1.0) / follow * (new[i, k] - P[i, k])
                P[i, k] = new[i, k]
        momentum = follow
        followed = (since >= LEAST and left <= max(CLOSER * change, 0.1 * goal)) or taken == PATIENT
        if not followed and taken % LOOKS != 0 and taken != most:
            continue
        _velocities(p, parts, base, P, speed, xi, False)
        p.P[:] = P
        residual, _ = residuals(p, speed, out)
        if residual < least:
            least = residual
            best[:] = P
            best_v[:] = speed
        if residual <= goal:
            break
        if followed:
            change, since = _follow_slip(p, xi, slip), 0
            if change <= 0.1 * goal and left <= 0.1 * goal:
                break
    p.P[:] = best
    v[:] = best_v
    return taken
