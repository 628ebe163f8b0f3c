"""`SignalValue`: the value of a signal, also of one that follows measurements."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.model.input_signal import inputs_of
from flexmb.model.kinds import Sensor
from flexmb.model.signal import as_signal

__all__ = ["SignalValue"]


@dataclass(frozen=True, eq=False)
class SignalValue(Sensor):
    """The value of a signal at every sample, (nt,): what a controller asks for, a given motion.

    By its name other signals can follow it: ``fmb.measured("command")``.

    Parameters
    ----------
    name : str
    of : signal, N or m or what it is
    """

    _: KW_ONLY
    of: Any

    titles: ClassVar[tuple[str, ...]] = ("value",)

    def __post_init__(self):
        super().__post_init__()
        object.__setattr__(self, "of", as_signal(self.of, self.title, "of"))

    def signal(self):
        """Return the signal."""
        return self.of

    def followed(self, compiler):
        """Let the value be computed in every evaluation."""
        compiler.value(self.name, self.of)
        return []

    def values(self, series) -> np.ndarray:
        """Return the value (nt,); FlexmbError if the model was simulated without the sensor."""
        if not self.of.follows and not inputs_of(self.of):  # inputs have the values that they were given in the run
            return self.of.sample(series.t)[:, 0]
        if self.name not in series.system.values:
            raise FlexmbError(
                self.title,
                found="a signal that follows measurements or inputs, of which the run knows nothing",
                expected="a sensor that the model had when it was simulated",
                remedy="Add it to the model, and simulate again",
            )
        return series.signals[:, series.system.values[self.name]]
