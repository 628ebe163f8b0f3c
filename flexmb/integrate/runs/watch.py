"""Watching events: which happens first, and exactly when."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from flexmb.errors import IntegrationError
from flexmb.integrate.runs.breaks import beside
from flexmb.integrate.runs.held import Switching
from flexmb.integrate.runs.record import joined_rows
from flexmb.model.sensor_columns import found_in
from flexmb.results import Phase, Series
from flexmb.system.assembly import consistent_start

__all__ = ["Watch", "carried", "next_phase"]

LOOKS = 1000
"""Sensors of events are looked at in every sample, and at least so many times over the run."""
PATIENCE = 0.3
"""s: how long the way to a time that may be that of an event is computed without a look at the user's wishes."""


class Watch:
    """The events of one phase.

    Parameters
    ----------
    model, system
        Of the phase.
    integrator
        Used again to locate the time of an event inside an interval.
    passed : dict of event name to float
        How far past its threshold a repeating event must be to happen again before its sensor has come back. (Updated.)
    look : callable, optional
        Called now and then while an event is located: it may raise KeyboardInterrupt.
    """

    def __init__(
        self, model, system, integrator, work, passed: dict[str, float], look: Callable[[], None] = lambda: None
    ):
        self.model, self.system, self.integrator, self.work, self._look = model, system, integrator, work, look
        self.events: list[Any] = [e for e in model.events if e.sensor is not None]
        watched = {e.sensor: found_in(model, e.sensor) for e in self.events}
        self.sensors: dict[str, Any] = {name: found[0] for name, found in watched.items() if found is not None}
        self.columns = {name: found[1] for name, found in watched.items() if found is not None}
        switching = [Switching(hold.title, hold.crossing) for hold in system.holds if hold.crossing >= 0]
        self.events += switching
        self.sensors.update({one.name: one for one in switching})
        self.last: dict[str, np.ndarray] = {}
        self.passed = passed

    def recall(self, phase: Phase) -> None:
        """Take the last values of the watched sensors from a phase that continues: angles are counted from there."""
        seen = Series(phase)
        for event in self.events:
            values = np.asarray(self.sensors[event.sensor].values(seen), float)
            self.last[event.name] = values[-1]
            past = float(self._beyond(event, values[-1:])[0])
            if event.repeats and past > 0.0:
                self.passed[event.name] = past if _strikes(event) else np.inf

    def _beyond(self, event, values: np.ndarray) -> np.ndarray:
        """Return how far values are past the threshold, of the column that the event's name of a sensor says."""
        column = self.columns.get(event.sensor)
        return event.distance(values if column is None or np.ndim(values) == 1 else np.asarray(values)[:, column])

    def distance(self, event, values) -> np.ndarray:
        """Return how far values are past the place where the event happens (again)."""
        return self._beyond(event, values) - self.passed.get(event.name, 0.0)

    def series(self, rows: dict[str, Any]) -> Series:
        """Return what sensors read in a block of rows."""
        return Series(Phase(model=self.model, system=self.system, **rows))

    def _values(self, event, rows) -> np.ndarray:
        """Return the watched sensor's values; angles count on from the row before."""
        sensor = self.sensors[event.sensor]
        values = np.asarray(sensor.values(self.series(rows)), float)
        if event.name in self.last:
            values = sensor.joined([self.last[event.name][None], values])[1:]
        return values

    def first(self, rows: dict[str, np.ndarray], begins: bool) -> tuple[list[Any], int] | None:
        """Return the events that happen first in a block of rows, and the number of the row; None if none does.

        The first row of a block is the last of the block before, unless the phase `begins` with it.
        """
        values = {event.name: self._values(event, rows) for event in self.events}
        found: list[Any] = []
        at = len(rows["t"])
        for event in self.events:
            past = self._past(event, values[event.name], begins)
            if past is not None and past <= at:
                found = [*(found if past == at else []), event]
                at = past
        keep = len(rows["t"]) - 1 if not found else max(at - 1, 0)
        self.last = {name: array[keep] for name, array in values.items()}
        return (found, at) if found else None

    def _past(self, event, values, begins: bool) -> int | None:
        """Return the first row past the place of an event; coming back makes a repeating one happen at its
        threshold.
        """
        level = self.passed.get(event.name, 0.0)
        distances = self._beyond(event, values)
        back = np.flatnonzero(distances < 0.0)
        past = distances > level
        if level > 0.0 and len(back):
            self.passed[event.name] = 0.0
            past[back[0] :] = distances[back[0] :] > 0.0
        past[: 0 if begins else 1] = False
        return int(np.argmax(past)) if np.any(past) else None

    def locate(self, events, before: dict[str, np.ndarray], after: dict[str, np.ndarray]):
        """Return which of the events between two neighbouring rows is the first, and the row just past it."""
        places = [self._place(event, before, after) for event in events]
        k = int(np.argmin([row["t"][-1] for row in places]))
        return events[k], places[k]

    def happened(self, event, row) -> None:
        """Keep a repeating event from happening again until its sensor comes back; but bodies that another impact
        drives together where they touch must bounce again."""
        if event.repeats:
            past = float(self._beyond(event, self._values(event, row))[-1])
            # a little further, so that rounding does not make it happen again in the same place
            self.passed[event.name] = max(past, 0.0) * (1.0 + 1e-9) + 1e-14 if _strikes(event) else np.inf

    def _place(self, event, before: dict[str, np.ndarray], after: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Return the row just past an event between two neighbouring rows: the step is computed again to its time."""
        from scipy.optimize import brentq

        t0, t1 = float(before["t"][-1]), float(after["t"][-1])
        rows: dict[float, dict[str, np.ndarray]] = {t0: before, t1: after}

        def distance(t: float) -> float:
            if t not in rows:
                rows[t] = self._again(before, t)
            pair = joined_rows([before, rows[t]]) if t > t0 else before
            return float(self.distance(event, self._values(event, pair))[-1])

        if distance(t0) >= 0.0:
            return before
        if t1 - t0 <= 2.0 * float(beside(t1)):  # at a jump of a load
            return after
        close = 1e-12 * max(abs(t0), abs(t1))
        t = brentq(distance, t0, t1, xtol=close, rtol=1e-14)
        while distance(t) < 0.0 and t < t1:
            t = min(t1, t + close)
        return rows[t]

    def _again(self, before, t: float) -> dict[str, np.ndarray]:
        """Integrate from a row to time t."""
        system = self.system
        state = consistent_start(system, system.state(before["t"][-1], before["q"][-1], before["u"][-1]), self.work)
        variables = self.integrator.start(system, state, self.work, t)
        marks = np.array([state.t, t])
        while True:
            outcome = self.integrator.run(system, self.work, variables, marks, 1, 2, PATIENCE)
            if outcome.failure or len(outcome.rows["t"]):
                break
            self._look()
        if outcome.failure:
            raise IntegrationError(
                f"Model '{self.model.name}'",
                found=outcome.failure,
                expected="a step to an event",
                remedy=outcome.remedy,
            )
        return {**outcome.rows, "works": outcome.rows["works"] + before["works"][-1]}


def _strikes(event) -> bool:
    return any(action.strikes for action in event.then)


def next_phase(model, event, series):
    """Return the model after the event (None: stop), without the event itself unless it repeats."""
    if not event.repeats:
        model = replace(model, events=tuple(e for e in model.events if e.name != event.name))
    for action in event.then:
        action.check(model, event.title)
        model = action.apply(model, series)
        if model is None:
            return None
    return model


def carried(system, model, q: np.ndarray, u: np.ndarray):
    """Return the start (q, u) of the next phase by body name; parts keep their states, joints their number of turns."""
    bodies = {body.name for body in model.bodies}
    state = {
        name: (q[iq], u[iu])
        for name, (iq, iu) in system.slices.items()
        if name in system.state_slices or name in bodies
    }
    branches = q[system.program.branches :]
    return {**state, **{("branch", name): value for name, value in zip(system.branch_names, branches, strict=True)}}
