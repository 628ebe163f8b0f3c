"""The second motion beside a run: its begin, and its continuation over a new start."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.alpha.variables import Apart, Motions, Variables
from flexmb.integrate.runs.gap import begin_again, new_gap

__all__ = ["beside", "taken_over"]

SHARED = ("extent", "reach", "signals", "pace", "world", "switching", "axes")
"""What both motions have in common."""


def beside(system, own: Variables, followed: bool) -> Motions:
    """Return the motion of a run at its start, and the one without local errors, which still is the same.

    It stays as it is where it shall not be followed.
    """
    copied = {name: getattr(own, name).copy() for name in own._fields if name not in SHARED}
    return Motions(
        own=own,
        corrected=own._replace(**copied),
        apart=Apart(
            dx=np.zeros(system.nu),
            du=np.zeros(system.nu),
            q=np.zeros(system.nq),
            u=np.zeros(system.nu),
            a=np.zeros(system.nu),
            q_start=own.q.copy(),
            run=new_gap(system, followed),
        ),
    )


def taken_over(system, before: Motions, now: Motions) -> Motions:
    """Return a new start with the distance that the motions had; in a model with other coordinates its size alone is
    known.
    """
    now.apart.run[:] = before.apart.run
    now.corrected.run["steps"] = before.corrected.run["steps"]
    if before.own.q.shape != now.own.q.shape or before.own.u.shape != now.own.u.shape:
        begin_again(now.apart.run)
        return now
    for name in ("q", "u"):
        getattr(now.corrected, name)[:] += getattr(before.corrected, name) - getattr(before.own, name)
    now.apart.q_start[:] = before.apart.q_start
    return now
