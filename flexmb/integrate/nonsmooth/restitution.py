"""The impulses of a step by the laws of restitution: Newton's in one problem, Poisson's in two.

Poisson's law: the impulses of compression stop all approaches as without restitution; in the expansion that follows
every impact gives back e times its own, or more where something else presses, eq. (poisson-law). Both problems have a
solution whatever is behind a body, at least without friction: the velocities that contacts permit are a cone that
holds rest, and on it there is a point nearest to those that a problem begins with. Newton's law demands a velocity, and
where bodies hold each other there may be none: its impulses then grow without end.

Source: Glocker & Pfeiffer 1995, Multiple impacts with friction in rigid multibody systems.
"""

from __future__ import annotations

import numpy as np

from flexmb.integrate.nonsmooth.problem import Problem
from flexmb.integrate.nonsmooth.solve import Solved, solve_contacts
from flexmb.integrate.nonsmooth.stepping import add_all

__all__ = ["solve_impulses"]

PATIENT, LONGER = 300, 200
"""Sweeps after which impulses of Newton's law are looked at, and further ones in which they may grow."""
GROWN = 1.2
"""Ratio of the impulses after these to those before, from which on they grow without end."""


def solve_impulses(p: Problem, parts, v: np.ndarray, goal: float, most: int) -> tuple[Solved, int]:
    """Find the impulses of all contacts, and add what they do to the velocities `v`; see `solve_contacts`.

    Returns how it went, and the number of impacts that Newton's law has no solution for, and that follow Poisson's.
    """
    striking = p.active == 2
    if np.any(striking & (p.points["poisson"] > 0.0)):
        return _two_phases(p, parts, v, goal, most), 0
    newton = striking & (p.shift < 0.0)
    free = v.copy()
    add_all(p, parts, v)
    if not np.any(newton):
        return solve_contacts(p, parts, v, goal, most), 0
    solved = solve_contacts(p, parts, v, goal, min(most, PATIENT), last=most > PATIENT)
    if solved.residual <= goal or solved.sweeps >= most:
        return solved, 0
    more = solve_contacts(p, parts, v, goal, min(most, LONGER), last=True)
    if not more.residual <= goal and more.pressed < GROWN * solved.pressed:
        more = solve_contacts(p, parts, v, goal, most)
    if more.residual <= goal or more.pressed < GROWN * solved.pressed:
        return _both(solved, more), 0
    p.shift[newton] = 0.0
    p.points["poisson"][newton] = p.points["restitution"][newton]
    p.P[:] = 0.0
    v[:] = free
    return _both(solved, _two_phases(p, parts, v, goal, most)), int(np.sum(newton))


def _two_phases(p: Problem, parts, v: np.ndarray, goal: float, most: int) -> Solved:
    """Compress and expand; impacts by Newton's law beside them have their rebound in the first phase."""
    add_all(p, parts, v)
    first = solve_contacts(p, parts, v, goal, most)
    if not first.residual <= goal:
        return first
    compressing = p.P.copy()
    # what holds bodies up against the forces of the step is no impulse of an impact: given back, it would keep the last
    # bounces going, v = e (v + g h) with the speed e g h / (1 - e) for ever
    back = np.where(p.active == 2, p.points["poisson"] * p.points["share"] * compressing[:, 0], 0.0)
    p.shift[(p.active == 2) & (p.shift < 0.0)] = 0.0
    p.least[:] = back
    p.P[:] = 0.0
    p.P[:, 0] = back
    add_all(p, parts, v)
    second = solve_contacts(p, parts, v, goal, most)
    p.P[:] += compressing
    p.least[:] = 0.0
    return _both(first, second)


def _both(a: Solved, b: Solved) -> Solved:
    return Solved(b.residual, b.worst, a.sweeps + b.sweeps, a.newton + b.newton, b.pressed)
