"""All contacts of a step: sweeps, and other methods where they are slow, until every law holds to the tolerance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flexmb.integrate.nonsmooth.accelerated import accelerate
from flexmb.integrate.nonsmooth.hastened import hasten
from flexmb.integrate.nonsmooth.newton import newton
from flexmb.integrate.nonsmooth.problem import Problem, residuals, sweep, velocity_of
from flexmb.math.kernel import kernel

__all__ = ["Solved", "solve_contacts"]

LEAST, FIRST = 2, 10
"""Sweeps in any step, and further ones before it is judged whether they will do."""
LOOK = 10
"""Sweeps between two judgements."""
SMALL, LONG = 600, 400
"""Rows up to which Newton's method tries soon, and sweeps after which it does with more: a matrix of many costs as much
as hundreds of sweeps."""
MANY, RUSH = 300, 1000
"""Rows from which on sweeps have momentum and accelerated gradients follow them, and the steps of either, which count
as sweeps."""
AGAIN = 200
"""Sweeps between two attempts of Newton's method, or of gradients; twice as many after each that did not help."""

HELPED = 0.5
"""Share of the residual that an attempt of Newton's method which helps leaves, at most."""


class _Best:
    """The best impulses so far: sweeps and momentum do not come nearer with each step."""

    def __init__(self):
        self.residual, self.worst = np.inf, 0

    def note(self, residual: float, worst: int, p, v: np.ndarray) -> None:
        """Keep the present impulses and velocities, if they miss the laws by less."""
        if residual < self.residual:
            self.residual, self.worst, self.P, self.v = residual, worst, p.P.copy(), v.copy()

    def put_back(self, p, v: np.ndarray) -> tuple[float, int]:
        """Make them the present ones; return by how much the worst contact misses its laws, and which it is."""
        p.P[:], v[:] = self.P, self.v
        return self.residual, self.worst


class Solved(NamedTuple):
    """How the contacts of a step were solved."""

    residual: float
    """m/s, by which the worst contact misses its laws"""
    worst: int
    """and which it is"""
    sweeps: int
    newton: int
    pressed: float = 0.0
    """N s, sum of the normal impulses after the last sweep"""


@kernel
def _velocities(p, v, xi):
    """Write the velocities of the rows of all active contacts, with their shifts, one after another."""
    one, at = np.zeros(6), 0
    for i in range(len(p.points)):
        if p.active[i] == 0:
            continue
        velocity_of(p, i, v, one)
        one[0] += p.shift[i]
        for k in range(p.rows[i]):
            xi[at + k] = one[k]
        at += p.rows[i]


def _is_slow(rate: float, residual: float, goal: float) -> bool:
    """Will it take more than three looks until a residual, m/s, that shrinks by `rate` from look to look is small?"""
    return not rate < 0.3 and (rate >= 1.0 or np.log(goal / residual) / np.log(rate) > 3.0)


def solve_contacts(p: Problem, parts, v: np.ndarray, goal: float, most: int, *, last: bool = False) -> Solved:
    """Find the impulses with which every contact obeys its laws to `goal`, m/s; `v` comes with the present ones.

    Many contacts are swept with momentum. Sweeps go on as long as they promise to end; otherwise gradients and Newton's
    method try from where they are, and sweeps go on where these do not get there. At most so many sweeps are made.
    Where they do not do, the best impulses that were looked at are left, and the residual is theirs; with `last`, for
    who goes on from there, those of the last sweep.
    """
    out = np.zeros(len(p.points))
    size = int(np.sum(p.rows[p.active > 0]))

    def velocities(v):
        xi = np.zeros(size)
        _velocities(p, v, xi)
        return xi

    done, steps, before, tried, rushed, wait = 0, 0, np.inf, -AGAIN, -AGAIN, AGAIN
    best = _Best()
    if not size:
        return Solved(0.0, 0, 0, 0)
    for _ in range(LEAST):  # what rests settles to rounding from step to step
        sweep(p, parts, v, done % 2 == 1)
        done += 1
    residual, worst = residuals(p, v, out)
    if residual > goal and size > MANY:
        done += hasten(p, parts, v, goal, min(RUSH, most - done))
        residual, worst = residuals(p, v, out)
    best.note(residual, worst, p, v)
    while residual > goal and done < most:
        for _ in range(FIRST if done == LEAST else LOOK):
            change, _unsolved = sweep(p, parts, v, done % 2 == 1)
            done += 1
            if change <= 0.1 * goal:
                break
        residual, worst = residuals(p, v, out)
        best.note(residual, worst, p, v)
        if not residual > goal:
            break
        rate = residual / before if before > 0.0 else 1.0
        before = residual
        slow = _is_slow(rate, residual, goal)
        if slow and size > MANY and done - rushed >= AGAIN:
            made = accelerate(p, parts, v, 0.5 * goal, min(RUSH, most - done))
            done += made
            rushed = done
            before = np.inf
            residual, worst = residuals(p, v, out)
            best.note(residual, worst, p, v)
            if not residual > goal:
                break
        if slow and done - tried >= wait and (size <= SMALL or done >= LONG):
            tried = done
            kept_P, kept_v = p.P.copy(), v.copy()
            _, made = newton(p, parts, v, velocities, 0.1 * goal)
            steps += made
            reached, at = residuals(p, v, out)
            wait = AGAIN if reached < HELPED * residual else 2 * wait
            if reached < residual:
                residual, worst = reached, at
            else:
                p.P[:], v[:] = kept_P, kept_v
            best.note(residual, worst, p, v)
            before = np.inf
    pressed = float(p.P[:, 0].sum())
    if not (last or residual <= goal) and best.residual < residual:
        residual, worst = best.put_back(p, v)
    return Solved(residual=float(residual), worst=int(worst), sweeps=done, newton=steps, pressed=pressed)
