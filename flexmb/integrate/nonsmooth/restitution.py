"""The impulses of a step by the laws of restitution: Newton's in one problem, Poisson's in phases.

Poisson's law: the impulses of compression stop all approaches as without restitution; in the expansion that follows
every contact gives back e times its own, or more where something else presses, eq. (poisson-law). Contacts that rest
when others strike store what is pressed into them, and give it back as well; what the forces of the step press into a
contact is not of an impact, and stays. All problems have a solution whatever is behind a body, at least without
friction: the velocities that contacts permit are a cone that holds rest, and on it there is a point nearest to those
that a problem begins with. Newton's law demands a velocity, and where bodies hold each other there may be none: its
impulses then grow without end.

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
    acting = p.active > 0
    if np.any(acting & (p.points["poisson"] > 0.0)) and np.any(acting & (p.points["strikes"] == 1)):
        return _in_phases(p, parts, v, goal, most), 0
    newton = (p.active == 2) & (p.shift < 0.0)
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
    return _both(solved, _in_phases(p, parts, v, goal, most)), int(np.sum(newton))


def _in_phases(p: Problem, parts, v: np.ndarray, goal: float, most: int) -> Solved:
    """Compress and expand; impacts by Newton's law beside them have their rebound in the compression."""
    stored = _compression_of_impacts(p, parts, goal, most)
    if not stored.residual <= goal:
        return stored
    shift = p.shift.copy()
    add_all(p, parts, v)
    first = solve_contacts(p, parts, v, goal, most)
    if not first.residual <= goal:
        return _both(stored, first)
    compressing = p.P.copy()
    p.least[:] = p.points["poisson"] * p.struck[:, 0]  # only now: nothing is demanded of the compression
    p.shift[p.active == 2] = np.maximum(shift[p.active == 2], 0.0)
    p.P[:] = 0.0
    p.P[:, 0] = p.least
    add_all(p, parts, v)
    second = solve_contacts(p, parts, v, goal, most)
    p.P[:] += compressing
    p.least[:], p.shift[:] = 0.0, shift
    return _both(_both(stored, first), second)


def _compression_of_impacts(p: Problem, parts, goal: float, most: int) -> Solved:
    """Write to `struck` the impulses that stop the approaches before the step: e times these contacts give back.

    The impulse that holds a weight against the forces of the step is none of an impact. Given back, it would keep the
    last bounces going, v = e (v + g h) with the speed e g h / (1 - e), for ever. So the forces are left out here, and
    approaches that are slow; without an impact there is nothing to give back.
    """
    start, shift, along = p.P.copy(), p.shift.copy(), p.before.copy()
    p.shift[:] += np.where(p.points["strikes"] == 1, 0.0, np.maximum(-p.points["was"], 0.0))
    p.P[:] = p.struck
    add_all(p, parts, along)
    solved = solve_contacts(p, parts, along, goal, most)
    p.struck[:] = p.P
    p.P[:], p.shift[:] = start, shift
    return solved


def _both(a: Solved, b: Solved) -> Solved:
    return Solved(b.residual, b.worst, a.sweeps + b.sweeps, a.newton + b.newton, b.pressed)
