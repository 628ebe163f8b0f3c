"""The rows of a run on their way to the file: what is wrong in them ends the run behind the last good sample.

They come in blocks, whose lengths depend on the clock. What is looked at in a few rows of many, or told of all rows
together, is looked at in parts of the phase that do not.
"""

from __future__ import annotations

import numpy as np

from flexmb.errors import IntegrationError
from flexmb.integrate.runs import contradiction
from flexmb.integrate.runs.energy_watch import EnergyWatch
from flexmb.integrate.runs.inversion import EXPECTED, REMEDY, first_inversion
from flexmb.integrate.runs.record import Recorder, joined_rows
from flexmb.integrate.runs.sunk_surfaces import SunkSurfaces
from flexmb.integrate.runs.validity import Validity
from flexmb.integrate.runs.vanishing import Gradients

__all__ = ["KeptRows"]

PARTS, SHORTEST = 16, 256
"""Parts of a phase, and the fewest samples of one."""


class KeptRows:
    """What looks at the rows of a phase and records them; `t`, s, is the time that has been reached."""

    def __init__(self, recorder: Recorder, validity: Validity, times: np.ndarray):
        self.recorder, self.validity = recorder, validity
        self.t, self.duration = float(times[0]), float(np.ptp(times))
        self.energy: EnergyWatch | None = None
        self.gradients: Gradients | None = None
        self.sunk = SunkSurfaces()
        self._ends = np.empty(0)
        self._waiting: list[dict[str, np.ndarray]] = []

    def begin(self, system) -> None:
        """Begin with the rows of a phase."""
        self.energy = EnergyWatch(system, system.workspace())
        self.gradients = Gradients(system)

    def divide(self, times: np.ndarray) -> None:
        """Divide the samples of the phase, s, into parts."""
        count = max(SHORTEST, -(-len(times) // PARTS))
        self._ends = times[count::count]

    def block_end(self, marks: np.ndarray, first: int) -> int:
        """Return the number of the mark behind the part in which `marks[first]` is, which a block must not pass."""
        k = int(np.searchsorted(self._ends, marks[first]))
        return int(np.searchsorted(marks, self._ends[k])) + 1 if k < len(self._ends) else len(marks)

    def look(self, switching) -> None:
        """Look at what waits for the end of the part."""
        rows, self._waiting = self._waiting, []
        if rows:
            self.validity.look(self.recorder.system, joined_rows(rows))
        self.validity.tell(self.sunk.look(self.recorder.system, switching))
        if self.energy is not None:
            self.energy.lay_blame()

    def keep(self, rows, times, switching) -> None:
        """Record the rows whose times are samples (others were only looked at for events).

        Raises
        ------
        IntegrationError
            If an element has turned inside out, equations contradict each other, or a gradient vanishes.
        """
        # both increase: a search per row, where isin would sort all times of the run once per block
        places = np.minimum(np.searchsorted(times, rows["t"]), len(times) - 1)
        keep = times[places] == rows["t"]
        kept = {name: x[keep] for name, x in rows.items()}
        self._require_agreement(kept)
        wrong = first_inversion(self.recorder.system, kept["q"])
        if wrong is not None:
            kept = {name: x[: wrong.sample + 1] for name, x in kept.items()}
        if self.gradients is not None:
            try:
                self.gradients.look(rows)
            except IntegrationError:
                good = kept["t"] <= self.gradients.reached
                self.recorder.add({name: x[good] for name, x in kept.items()})
                self.t = self.gradients.reached
                raise
        self.recorder.add(kept)
        if len(kept["t"]):
            self._waiting.append(kept)
            if self.energy is not None:
                self.energy.look(kept, switching)
            if kept["t"][-1] in self._ends:
                self.look(switching)
        if wrong is not None:
            self.t = float(kept["t"][-1])
            raise IntegrationError(wrong.title, found=wrong.found, expected=EXPECTED, remedy=REMEDY)

    def require_half_turns(self, rows, switching) -> None:
        """Raise IntegrationError if a bushing has turned by half a turn, where its moment jumps to the other side."""
        if switching is not None and switching.limits[0].turned:
            self.t = float(rows["t"][-1]) if len(rows["t"]) else self.t
            raise IntegrationError(
                self.recorder.system.switch_owners[switching.limits[0].turned - 1],
                found="its markers have turned against each other by half a turn",
                expected="less than half a turn, where its moment would jump to the opposite sign",
                remedy="Use a TorsionSpring on a joint, which counts full turns, or no stiffness about this axis",
            )

    def _require_agreement(self, kept) -> None:
        """Record what comes before equations contradict each other, and raise IntegrationError, if they do."""
        apart = contradiction.first_contradiction(self.recorder.system, kept, self.duration)
        if apart is not None:
            self.t = float(kept["t"][apart.sample])
            self.recorder.add({name: x[: apart.sample] for name, x in kept.items()})
            raise IntegrationError(
                apart.title, found=apart.found, expected=contradiction.EXPECTED, remedy=contradiction.REMEDY
            )
