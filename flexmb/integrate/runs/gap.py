"""How far a motion without the known local errors of the steps has gone away from the run."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.runs.added_error import AddedError
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.structures import Record

__all__ = ["EVERY", "Gap", "added_error", "begin_again", "measure", "new_gap"]

LEAST, SHORT = 1e-3, 1e-2
"""Lengths of the largest assembly: the least displacement with which errors are compared, and below which nothing is
lost."""
TURN = 1e-2
"""rad, the least rotation with which errors are compared."""
EVERY = 4
"""Steps from one look at the distance to the next."""
LOST, ANGLE = 0.1, 0.1
"""Share of the largest motion so far, of an angle of so many rad at least, from which on the second motion is too far
away to follow."""


class Gap(Record):
    """How far the motion without known local errors has been from the run, and how far the run has moved."""

    followed: int
    """1 while it is followed"""
    blind: int
    """1: something has touched, and what errors add up to from there on is not known"""
    far: float
    """m, largest distance of places and deflections"""
    far_t: float
    """s, when"""
    far_place: int
    """its velocity; -1: one of a model before"""
    wide: float
    """rad, largest angle"""
    wide_t: float
    wide_place: int
    was_far: float
    """m, distance at the last look"""
    was_wide: float
    """rad, likewise"""
    from_far: float
    """m, distance before the unknowns became others: all of later ones come on top of it"""
    from_wide: float
    """rad, likewise"""
    moved: float
    """m, largest displacement, or the least with which distances are compared"""
    turned: float
    """rad, largest rotation, or the least"""
    short: float
    """m, displacement below which it is too early to say that the motions are lost to each other"""


def new_gap(system, followed: bool) -> np.ndarray:
    """Return the table of a run that begins."""
    length = float(system.lengths.whole)
    return Gap.table(followed=int(followed), moved=LEAST * length, turned=TURN, short=SHORT * length)


def begin_again(run: np.ndarray) -> None:
    """Go on with other unknowns: of the distance its size is kept, to which that of the new ones is added."""
    run["from_far"], run["from_wide"] = run["was_far"], run["was_wide"]
    run["far_place"] = run["wide_place"] = -1


def added_error(system, gap, uncertainty: float = 1.0) -> AddedError:
    """Return the larger of the errors of places and of rotations, relative to the motion: it may be by `uncertainty`
    larger than what was found."""
    far, wide = float(gap["far"] / gap["moved"]), float(gap["wide"] / gap["turned"])
    kind, unit, motion = ("far", "m", "moved") if far >= wide else ("wide", "rad", "turned")
    return AddedError(
        share=uncertainty * max(far, wide),
        error=uncertainty * float(gap[kind]),
        motion=float(gap[motion]),
        unit=unit,
        t=float(gap[f"{kind}_t"]),
        owner=system.owner(int(gap[f"{kind}_place"])) if gap[f"{kind}_place"] >= 0 else "its parts",
        lost=not gap["followed"] and not gap["blind"],
        blind=bool(gap["blind"]),
        unsure=uncertainty > 1.0,
    )


@inner_kernel
def _turn_between(q, p, iq):
    """Return the angle (rad) between two orientations."""
    same, other = 0.0, 0.0
    for i in range(4):
        same += (q[iq + i] - p[iq + i]) ** 2
        other += (q[iq + i] + p[iq + i]) ** 2
    return 4.0 * np.arcsin(min(0.5 * min(same, other) ** 0.5, 1.0))


@kernel
def measure(program, own, near, extent, run, start, t):
    """Keep the largest displacement and rotation of the run, and the largest distance and angle between the motions.

    `own` and `near` (nq,) are the configurations of both, `start` (nq,) that from which motion is counted; `extent`
    (nu,) are displacements by coordinates.
    """
    far, at, wide, about = 0.0, 0, 0.0, 0
    for n in range(len(program.frames)):
        iq, iu = program.frames[n, 0], program.frames[n, 1]
        for i in range(3):
            run[0].moved = max(run[0].moved, abs(own[iq + i] - start[iq + i]))
            distance = abs(own[iq + i] - near[iq + i])
            if distance > far:
                far, at = distance, iu + i
        run[0].turned = max(run[0].turned, _turn_between(own, start, iq + 3))
        angle = _turn_between(own, near, iq + 3)
        if angle > wide:
            wide, about = angle, iu + 3
    for n in range(len(program.vectors)):
        iq, iu, size, kind = program.vectors[n]
        if kind > 1:  # integrals of states
            continue
        for i in range(size):
            run[0].moved = max(run[0].moved, abs(own[iq + i] - start[iq + i]) * extent[iu + i])
            distance = abs(own[iq + i] - near[iq + i]) * extent[iu + i]
            if distance > far:
                far, at = distance, iu + i
    far, wide = far + run[0].from_far, wide + run[0].from_wide
    run[0].was_far, run[0].was_wide = far, wide
    if far > run[0].far:
        run[0].far, run[0].far_t, run[0].far_place = far, t, at
    if wide > run[0].wide:
        run[0].wide, run[0].wide_t, run[0].wide_place = wide, t, about
    if not (far < LOST * max(run[0].moved, run[0].short) and wide < LOST * max(run[0].turned, ANGLE)):
        run[0].followed = 0
