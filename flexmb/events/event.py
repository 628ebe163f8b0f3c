"""`Event`: what happens when."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError, did_you_mean, listed
from flexmb.model.described import Described, is_number, whole
from flexmb.model.part import Part
from flexmb.model.sensor_columns import found_in

__all__ = ["Action", "Event"]


class Action(metaclass=Described):
    """A pure function of models: what an event does."""

    strikes: ClassVar[bool] = False
    """Does it change velocities at once? Such an action has `markers`, `along` and `restitution` (see `Impact`)."""

    def check(self, model, asker: str) -> None:
        """Raise ModelError if the action names something that `model` does not have."""

    def apply(self, model, series):
        """Return the model of the next phase, or None to end the run; `series` holds the state at the event."""
        raise TypeError(f"{type(self).__name__} does nothing")


@dataclass(frozen=True, eq=False)
class Event(Part):
    """End a phase at a time, or when a sensor passes a threshold, and change the model.

    Parameters
    ----------
    name : str
    sensor : str, optional
        The sensor to watch, or a column of one: "force fx".
    above, below : float, in the sensor's unit
        The event happens when the value rises above, or falls below this.
    at : float, s
        The event happens at this time (without a sensor).
    column : int, optional
        Number of the column of a sensor with several values, if `sensor` does not say it.
    then : Release, Lock, Unlock, Stop, Change or Impact, or a sequence of them
        What happens, in this order.
    repeats : bool
        False: it happens once. True: whenever the value passes the threshold again.
    """

    name: str
    _: KW_ONLY
    then: Any
    sensor: str | None = None
    above: float | None = None
    below: float | None = None
    at: float | None = None
    column: Any = None  # an int: `check` tells the columns of the sensor
    repeats: bool = False

    family: ClassVar[str] = "Event"

    def __post_init__(self):
        super().__post_init__()
        given = [name for name in ("above", "below", "at") if getattr(self, name) is not None]
        right = given == ["at"] if self.sensor is None else given in (["above"], ["below"])
        if not right or not is_number(getattr(self, given[0])):
            raise ModelError(
                self.title,
                found=f"sensor = {self.sensor!r} with {', '.join(given) or 'no threshold'}",
                expected="at= (a time), or sensor= with one of above= and below=",
                remedy="Write at=0.65, or sensor='force', above=1e4",
            )
        if self.repeats and self.sensor is None:
            raise ModelError(
                self.title,
                found=f"repeats = True with at = {self.at} s",
                expected="a sensor: a time passes only once",
                remedy="Leave repeats out, or write one event per time",
            )
        actions = self.then if isinstance(self.then, tuple | list) else (self.then,)
        if not actions or not all(isinstance(a, Action) for a in actions):
            raise ModelError(
                self.title,
                found=f"then = {self.then!r}",
                expected="Release, Lock, Unlock, Stop, Change or Impact",
                remedy="Write then=flexmb.Release('strut')",
            )
        object.__setattr__(self, "then", tuple(actions))
        object.__setattr__(self, "column", whole(self.column))

    def check(self, model) -> None:
        """Raise ModelError if the sensor, or what the actions name, does not exist."""
        if self.sensor is not None:
            sensors = {s.name: s for s in model.sensors}
            found = found_in(model, self.sensor)
            if found is None:
                raise ModelError(
                    self.title,
                    found=f"sensor '{self.sensor}' does not exist",
                    expected=f"The model has: {listed(self.sensor, sorted(sensors))}",
                    remedy=did_you_mean(self.sensor, sensors) or "Add the sensor to the model",
                )
            sensor, own = found
            columns = len(sensor.columns(model))
            column = own if own is not None else 0 if columns == 1 else None
            column = column if self.column is None else self.column
            counted = isinstance(column, int | np.integer) and not isinstance(column, bool) and 0 <= column < columns
            if not counted or own not in (None, column):
                raise ModelError(
                    self.title,
                    found=f"column = {self.column!r} of sensor '{self.sensor}'",
                    expected=f"0 to {columns - 1}, a whole number: {', '.join(sensor.columns(model))}",
                    remedy="Say which column is watched",
                )
        for action in self.then:
            action.check(model, self.title)

    def distance(self, values: np.ndarray) -> np.ndarray:
        """Return how far sensor values (nt,) or (nt, k) are past the threshold; the event happens above zero."""
        values = np.asarray(values, float)
        one = values if values.ndim == 1 else values[:, self.column or 0]
        return one - self.above if self.above is not None else self.below - one
