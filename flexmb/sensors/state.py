"""`State`: a first-order state of a force or a block."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np

from flexmb.constraints import Measured
from flexmb.model.kinds import Sensor

__all__ = ["State"]


@dataclass(frozen=True, eq=False)
class State(Sensor):
    """A state x of a part with x' = f(t, x, what is measured): a force with memory, a block of a controller, (nt,).

    Parameters
    ----------
    name : str
    of : str
        Name of the force or block.
    state : str, optional
        Name of the state, where there are several.
    """

    _: KW_ONLY
    of: str
    state: str | None = None

    def columns(self, model) -> tuple[str, ...]:
        """Return the title; the unit is the part's."""
        return (f"{self.of} {self.state}" if self.state else self.of,)

    def followed(self, compiler):
        """Return nothing to follow; ModelError if there is no such state."""
        compiler.state_place(self.of, self.state)
        return []

    def measured(self, model) -> tuple[Measured, ...]:
        """Return the state."""
        return (Measured("state", state=(self.of, self.state)),)

    def values(self, series) -> np.ndarray:
        """Return the state (nt,); ModelError if there is none of this name."""
        owner, column = series.system.place_of_state(self.of, self.state, self.title)
        return series.phase.u[:, series.system.state_slices[owner][1]][:, column]
