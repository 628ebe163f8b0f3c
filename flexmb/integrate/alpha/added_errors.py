"""The motion beside that of a run: its begin, its continuation over a new start, and what it tells."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.alpha.variables import Apart, Gap, Motions, Variables
from flexmb.integrate.runs.added_error import AddedError

__all__ = ["added_error", "beside", "taken_over"]

LEAST, SHORT = 1e-3, 1e-2
"""Lengths of the largest assembly: the least displacement with which errors are compared, and below which nothing is
lost."""
TURN = 1e-2
"""rad, the least rotation with which errors are compared."""
SHARED = ("extent", "reach", "signals", "pace", "world", "switching")
"""What both motions have in common."""


def beside(system, own: Variables, followed: bool) -> Motions:
    """Return the motion of a run at its start, and the one without local errors, which still is the same.

    It stays as it is where it shall not be followed.
    """
    copied = {name: getattr(own, name).copy() for name in own._fields if name not in SHARED}
    length = float(system.lengths.whole)
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
            run=Gap.table(followed=int(followed), moved=LEAST * length, turned=TURN, short=SHORT * length),
        ),
    )


def taken_over(system, before: Motions, now: Motions) -> Motions:
    """Return a new start with the distance that the motions had; of a model with other coordinates it is not known."""
    if before.own.q.shape != now.own.q.shape or before.own.u.shape != now.own.u.shape:
        return now
    for name in ("q", "u"):
        getattr(now.corrected, name)[:] += getattr(before.corrected, name) - getattr(before.own, name)
    now.apart.q_start[:] = before.apart.q_start
    now.apart.run[:] = before.apart.run
    return now


def added_error(system, gap) -> AddedError:
    """Return the larger of the errors of places and of rotations, relative to the motion."""
    far, wide = float(gap["far"] / gap["moved"]), float(gap["wide"] / gap["turned"])
    kind, unit, motion = ("far", "m", "moved") if far >= wide else ("wide", "rad", "turned")
    return AddedError(
        share=max(far, wide),
        error=float(gap[kind]),
        motion=float(gap[motion]),
        unit=unit,
        t=float(gap[f"{kind}_t"]),
        owner=system.owner(int(gap[f"{kind}_place"])) if system.nu else "",
        lost=not gap["followed"],
        blind=int(gap["blind"]),
    )
