"""What the errors of `MoreauJean` add up to: a second motion in steps twice as long, until something touches.

The midpoint rule is of second order, so errors of steps twice as long are four times as large, and a third of the
distance between the two motions is the error (Richardson's extrapolation). It costs one step for two. Contacts make an
error of first order, by the time of an impact, and motions that touch at other times are no neighbours any more: from
there on nothing is known. Source: Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, 2nd ed. 1993,
sec. II.4.
"""

from __future__ import annotations

from copy import copy
from typing import Any

import numpy as np

from flexmb.integrate.extent import extents
from flexmb.integrate.nonsmooth.closing import Closing
from flexmb.integrate.nonsmooth.points import POINT
from flexmb.integrate.runs.gap import begin_again, measure, new_gap

__all__ = ["Doubled"]

FINER = 3.0
"""The distance over the error: four times less one."""
ALIKE = 0.5
"""Size of the shorter of two steps, relative to the longer, from which on they count as two of one size."""
MOSTLY = 0.5
"""Part of the time in steps that had to be taken alone, from which on the second motion says nothing of the first."""


class _Nothing:
    """Contacts of the second motion: none."""

    forces = ()

    @staticmethod
    def found(*_: Any) -> np.ndarray:
        """Return no points."""
        return np.zeros(0, POINT)


class Doubled:
    """The second motion beside a run.

    Parameters
    ----------
    stepper : Stepper
        The run, at its start.
    followed : bool
        Whether there is a second motion.
    """

    def __init__(self, stepper: Any, followed: bool):
        system = stepper.system
        self.system = system
        self.gap = new_gap(system, bool(followed and system.nu))
        self.failed, self.waiting = False, 0.0  # s, of a step that the second motion has not taken yet
        self.inputs = np.zeros(0)  # with which it was taken
        self.taken, self.alone = 0.0, 0.0  # s
        if not self.gap["followed"][0]:
            return
        self.start = stepper.q.copy()
        work = system.workspace()
        self.extent = extents(system, stepper.present(), work)[0]
        self.motion = copy(stepper)
        self.motion.touching, self.motion.switches, self.motion.refused = _Nothing(), False, None
        self.motion.closing = Closing(system, work, stepper.parts, stepper.world, self.motion.touching)
        self.motion.work, self.motion.counts = work, dict(stepper.counts)
        self.motion.works, self.motion.made_by_impacts = stepper.works.copy(), stepper.made_by_impacts.copy()
        self.motion.q, self.motion.u, self.motion.lam = stepper.q.copy(), stepper.u.copy(), stepper.lam.copy()

    def add(self, stepper: Any, h: float, touched: bool) -> None:
        """Take a step of the run, of size h, that has just been taken."""
        if not self.gap["followed"][0]:
            return
        if touched:
            self.gap["blind"], self.gap["followed"] = 1, 0
        elif not self.waiting:
            self._wait(h)
        elif ALIKE * self.waiting <= h <= self.waiting / ALIKE:
            h, self.waiting = h + self.waiting, 0.0
            if self._step(h):
                self._compare(stepper)
        else:
            self.catch_up()
            self._wait(h)

    @property
    def known(self) -> bool:
        """Were steps of twice the size taken, and could they be?"""
        return not self.failed and not self.alone > MOSTLY * self.taken

    def catch_up(self) -> None:
        """Take the step that waits for another one by itself: the next one is of another size, or a load jumps."""
        if self.waiting and self.gap["followed"][0]:
            inputs = self.system.program.signals.args
            now = inputs.copy()
            inputs[:] = self.inputs
            self._step(self.waiting)
            inputs[:] = now
            self.alone += self.waiting
        self.waiting = 0.0

    def _wait(self, h: float) -> None:
        self.waiting, self.inputs = h, self.system.program.signals.args.copy()

    def _step(self, h: float) -> bool:
        self.taken += h
        if not self.motion._step(h):
            self.failed, self.gap["followed"] = True, 0
        return not self.failed

    def _compare(self, stepper: Any) -> None:
        """Keep the largest distance that errors have made."""
        own, far = stepper.q, self.motion.q
        near = own + (far - own) / FINER
        for iq, _ in self.system.program.frames[:, :2]:
            turn = slice(iq + 3, iq + 7)
            if own[turn] @ far[turn] < 0.0:
                near[turn] = own[turn] - (far[turn] + own[turn]) / FINER
        measure(self.system.program, own, near, self.extent, self.gap, self.start, stepper.t)

    def goes_on_from(self, before: Doubled, was: Any, stepper: Any) -> None:
        """Go on with the distance that the second motion had from a run that `was`; where the coordinates are others,
        with its size.
        """
        if not self.gap["followed"][0]:
            return
        before.catch_up()
        self.failed, self.taken, self.alone = before.failed, before.taken, before.alone
        self.gap[:] = before.gap
        if was.q.shape != stepper.q.shape or was.u.shape != stepper.u.shape:
            begin_again(self.gap)
            return
        self.start = before.start
        if self.gap["followed"][0]:
            self.motion.q += before.motion.q - was.q
            self.motion.u += before.motion.u - was.u
