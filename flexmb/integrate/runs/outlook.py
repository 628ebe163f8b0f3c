"""What is to be expected of a run: whether it gets to its end, and why not."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

from flexmb.errors import SlowRunWarning
from flexmb.integrate.runs.fastest import fastest
from flexmb.integrate.runs.pace import REMEDY as REMEDY_OF_PACE
from flexmb.integrate.runs.pace import Pace
from flexmb.integrate.runs.runaway import REMEDY as REMEDY_OF_RUNAWAY
from flexmb.integrate.runs.runaway import Runaway
from flexmb.results import Status

__all__ = ["Outlook"]


class Outlook:
    """The pace of a run, and the growth of its motion where it is slow.

    Parameters
    ----------
    begin, end : float, s
        Of the simulated time.
    """

    def __init__(self, begin: float, end: float):
        self._pace, self._runaway = Pace(begin, end), Runaway(begin)
        self.new_phase = self._pace.new_phase
        self.far_gone = self._runaway.far_gone

    def look(self, integrator, system, work, variables, now: float, validity) -> Status | None:
        """Return a failure if the run would take years, as of an end time in milliseconds or a stiffness in N/mm, or
        its motion grows without bound; tell if it takes long.
        """
        pace, here = self._pace, (integrator, system, work, variables, now)
        counts = integrator.statistics(variables)
        pace.look(now, counts)
        gone = self.far_gone(*here) if pace.hopeless else self._runaway.look(*here) if pace.slow else None
        if gone:
            return Status.failed(f"{gone}; {pace.sentence()}", REMEDY_OF_RUNAWAY)
        if pace.hopeless:
            return Status.failed(f"{pace.sentence()}{fastest(*here)}", REMEDY_OF_PACE)
        if pace.long():
            where = f"Model '{system.model.name}', {type(integrator).__name__}"
            sentence = (
                f"{where}: {pace.sentence()}{fastest(*here)}{_slow_recursion(counts)}. Ctrl-C keeps what is computed."
            )
            warnings.warn(sentence, SlowRunWarning, stacklevel=2)
            validity.note([sentence])
        return None


def _slow_recursion(counts: Mapping[str, Any]) -> str:
    """Return why the steps of a run in joint coordinates are not compiled, and what is faster, if that is so."""
    told = counts.get("recursion", "links")
    return "" if told == "links" else f"; the recursion is over {told}"
