"""One step over contacts: the midpoint rule with impulses, eq. (impulse-midpoint), and its way back onto the positions.

All impulses of the step, of joints and of contacts, act at the middle configuration. The iteration is Newton's with the
matrix of the first iterate; contacts are solved anew in each, with the impulses before as their start.
"""

from __future__ import annotations

import numpy as np

from flexmb.integrate.alpha.world_translation import move, to_body_axes
from flexmb.integrate.nonsmooth.problem import add_impulse, velocity_of
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.tables import State
from flexmb.system.program import advance, constraint_acceleration, constraint_velocity, evaluate

__all__ = [
    "UNTOLD",
    "add_all",
    "carry_impulses",
    "end_positions",
    "evaluate_middle",
    "give_back",
    "given_by_impacts",
    "open_equations",
    "resultants",
    "set_shifts",
    "works_of",
]

UNTOLD = 10.0
"""Steps of what the tolerance leaves open, after which a gap counts as one."""
ROUNDED = 1e-15
"""Mobility, relative to the largest, that is rounding: joints hold the two together there."""
SLOW = 2.0
"""Approach that is no impact, relative to what the forces add to it in a step: the last bounces, which no step tells
from each other, end there."""


@kernel
def evaluate_middle(program, work, world, t, h, q, u0, u1, lam, mid, ub, ab, signals, wanted, right):
    """Evaluate the equations of motion in the middle of a step from u0 to u1 (frames of `world`: in world axes).

    Writes configuration, velocities and accelerations of the middle (body axes), and to `right` what is left of the
    equations, times -h: of motion, and of the joints as accelerations.
    """
    nu = len(u0)
    half = np.empty(nu)
    mean = np.empty(nu)
    rate = np.empty(nu)
    for i in range(nu):
        mean[i] = 0.5 * (u0[i] + u1[i])
        rate[i] = (u1[i] - u0[i]) / h
        half[i] = 0.5 * h * mean[i]
    advance(program, q, half, 1.0, mid)
    move(world, q, half, mid)
    to_body_axes(world, mid, mean, rate, ub, ab)
    work.weights[0].wanted = wanted
    evaluate(program, State(t + 0.5 * h, mid, ub, ab, lam, signals), work)
    for i in range(nu):
        right[i] = -h * work.residual[i]
    constraint_acceleration(work, ab, right[nu:])
    for i in range(len(lam)):
        right[nu + i] = -h * right[nu + i]


@inner_kernel
def _to_body(frames, q, u, out):
    rest = np.zeros(len(u))
    body_rest = np.empty(len(u))
    to_body_axes(frames, q, u, rest, out, body_rest)


@kernel
def set_shifts(p, parts, world, mid, u0, free, h, tiny, tolerance):
    """Decide which contacts act in the step, 2: by an impact, and what they ask for, eqs. (impact-law, closing-gap).

    `free` are the velocities without impulses of contacts, in body axes as W. Returns the largest velocity (m/s) at an
    acting contact, to which tolerances are relative.
    """
    xi, was = np.zeros(6), np.zeros(6)
    _to_body(world, mid, u0, p.before[: len(u0)])
    largest, least = 0.0, 0.0
    for i in range(len(p.points)):
        least = max(least, ROUNDED * p.D[36 * i])
    for i in range(len(p.points)):
        point = p.points[i]
        velocity_of(p, i, p.before, was)
        velocity_of(p, i, free, xi)
        gap = point.gap - 0.5 * h * was[0]
        gained = max(0.0, was[0] - xi[0])
        p.active[i] = 1
        fast = was[0] < -max(SLOW * gained, tiny / h)
        point.was, point.strikes = was[0], 0
        # what rests shares its load whatever is rounded, or left open by the tolerance of steps before
        p.shift[i] = max(gap - tiny - UNTOLD * tolerance * gained * h, 0.0) / h
        e = max(point.restitution, point.poisson)
        if e > 0.0:
            if fast:  # an impact, at once or in a later step
                p.shift[i] = point.restitution * was[0]
                p.active[i] = 2 if point.gap <= tiny else 0
            elif gap > 2.0 * SLOW * gained * h + tiny:
                p.active[i] = 0
        if not p.D[36 * i] > least:
            p.active[i] = 0
        if p.active[i] == 0:
            p.P[i, :] = 0.0
            continue
        if fast and (p.active[i] == 2 or was[0] + p.shift[i] < 0.0):
            point.strikes = 1
        speed = max(-(xi[0] + p.shift[i]), abs(p.shift[i]) if e > 0.0 else 0.0)
        if p.rows[i] > 1 and xi[0] + p.shift[i] < 0.0:
            speed = max(speed, abs(xi[1]), abs(xi[2]))
        largest = max(largest, speed)
    return largest


@kernel
def carry_impulses(p, before, P, count):
    """Give contacts the impulses (W axes, `P` (count, 6)) of the step before as a start, from the nearest point of
    the same pair; both are sorted by pairs.
    """
    first = 0
    for i in range(len(p.points)):
        point = p.points[i]
        while first < count and before[first].key < point.key:
            first += 1
        best, least = -1, np.inf
        k = first
        while k < count and before[k].key == point.key:
            away = 0.0
            for c in range(3):
                away += (before[k].local[c] - point.local[c]) ** 2
            if away < least:
                best, least = k, away
            k += 1
        for r in range(6):
            p.P[i, r] = 0.0
        if best < 0:
            continue
        for r in range(p.rows[i]):
            axis, at = (r, 0) if r < 3 else (r - 3, 3)
            for c in range(3):
                p.P[i, r] += point.axes[axis, c] * P[best, at + c]
        if p.rows[i] >= 3:
            p.P[i, 0] = max(p.P[i, 0], 0.0)


@kernel
def give_back(p, P):
    """Write the impulses of all contacts in W, force and moment (n, 6)."""
    for i in range(len(p.points)):
        for c in range(6):
            P[i, c] = 0.0
        for r in range(p.rows[i]):
            axis, at = (r, 0) if r < 3 else (r - 3, 3)
            for c in range(3):
                P[i, at + c] += p.points[i].axes[axis, c] * p.P[i, r]


@kernel
def add_all(p, parts, v):
    """Add the changes by the present impulses of all contacts to the unknowns `v`."""
    for i in range(len(p.points)):
        if p.active[i] > 0:
            add_impulse(p, parts, i, p.P[i], v)


@kernel
def end_positions(program, world, q, u0, u1, h, out):
    """Write the configuration at the end of a step."""
    dx = np.empty(len(u0))
    for i in range(len(u0)):
        dx[i] = 0.5 * h * (u0[i] + u1[i])
    advance(program, q, dx, 1.0, out)
    move(world, q, dx, out)


@kernel
def open_equations(program, work, u, right, rates):
    """Write what is open of the joints, negative, to `right` (positions, or with `rates` velocities u in body axes);
    return the largest.
    """
    nu, largest = len(u), 0.0
    right[:nu] = 0.0
    if rates:
        constraint_velocity(work, u, right[nu:])
    for i in range(len(work.equations)):
        if rates:
            right[nu + i] = -right[nu + i]
        else:
            right[nu + i] = -work.equations[i].g if program.equation_level[i] == 0 else 0.0
        largest = max(largest, abs(right[nu + i]))
    return largest


@kernel
def works_of(p, ub):
    """Return the energy (J) that contacts have taken: -P . xi with the mean velocity of the step, body axes."""
    xi, total = np.zeros(6), 0.0
    for i in range(len(p.points)):
        if p.active[i] > 0:
            velocity_of(p, i, ub, xi)
            for r in range(p.rows[i]):
                total -= p.P[i, r] * xi[r]
    return total


@kernel
def given_by_impacts(p, ub, given):
    """Add to `given` (nf,) the energy (J) that the contacts of a step with impacts have made, if they have, at the
    force that made most of it. Velocities as in `works_of`.
    """
    xi, total, most, strikes = np.zeros(6), 0.0, 0.0, False
    worst = 0
    for i in range(len(p.points)):
        if p.active[i] > 0:
            strikes = strikes or p.points[i].strikes == 1
            velocity_of(p, i, ub, xi)
            work = 0.0
            for r in range(p.rows[i]):
                work += p.P[i, r] * xi[r]
            total += work
            if work > most:
                worst, most = p.points[i].owner, work
    if strikes and total > 0.0:
        given[worst] += total


@kernel
def resultants(points, P, markers, rows, out):
    """Add the forces and moments of `P` (n, 6) on the markers to `out`, in the `rows` (nf, nm) of force and marker."""
    for i in range(len(points)):
        point = points[i]
        for side in range(2):
            m = point.b if side == 1 else point.a
            sign = 1.0 if side == 1 else -1.0
            row = rows[point.owner, m]
            lever = point.r - markers[m].r
            for c in range(3):
                d, e = (c + 1) % 3, (c + 2) % 3
                out[row, c] += sign * P[i, c]
                out[row, 3 + c] += sign * (P[i, 3 + c] + lever[d] * P[i, e] - lever[e] * P[i, d])
