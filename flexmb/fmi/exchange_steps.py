"""`SteppedExchange`: a unit for model exchange that is integrated from one communication time to the next."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from flexmb.errors import IntegrationError
from flexmb.fmi.exchange_unit import ExchangeUnit
from flexmb.fmi.unit_variables import failed_reading

__all__ = ["SteppedExchange"]

RTOL = 1e-9
"""Tolerance of the steps, relative; absolute: times the nominal values."""
SHARP = 1e-13
"""How close events are found, over the time and the step."""
MOST_EVENTS = 100_000
"""Events in one communication step."""


class SteppedExchange:
    """Takes the steps of a unit by LSODA of scipy, its inputs held, its events found where indicators change sign.

    Source: FMI 3.0.1, section 3; Hindmarsh 1983, ODEPACK.
    """

    def __init__(self, described: Any, folder: str, t: float, end: float):
        self.described, title = described, f"Fmu '{described.path}'"
        self.unit = ExchangeUnit(described.path, title, folder, described.parameters, t, end)
        self.title, self.variable = title, self.unit.variable
        self.x = self.unit.start
        self._given: dict[str, float] = {}

    def get_all(self, names: Collection[str]) -> list[float]:
        """Return the values of variables."""
        with self.unit.speaking(failed_reading(names)):
            return self.unit.values(names)

    def set_all(self, given: Mapping[str, float]) -> None:
        """Set inputs, from the begin of the next step on: discrete ones change in an event only."""
        self._given.update(given)

    def step(self, t: float, h: float) -> bool:
        """Go from t to t + h; return if the unit goes on."""
        with self.unit.speaking(f"failed at t = {t:.9g} s"):
            end = t + h
            if self._given:  # they have jumped
                self.unit.place(t, self.x)
                self.x = self.unit.happen(self._given)
            for _ in range(MOST_EVENTS):
                t, happens = self._run(t, min(end, max(self.unit.next_event, t)))
                self.unit.place(t, self.x)
                if happens or t >= self.unit.next_event:
                    self.x = self.unit.happen()
                if self.unit.ended or t >= end:
                    return not self.unit.ended
        raise IntegrationError(
            self.title,
            found=f"{MOST_EVENTS} events up to t = {t:.9g} s",
            expected="events that do not follow each other ever faster",
            remedy="Look at the event indicators of the unit",
        )

    def _rates(self, t: float, x: np.ndarray) -> np.ndarray:
        self.unit.place(t, x)
        return self.unit.rates()

    def _run(self, t: float, end: float) -> tuple[float, bool]:
        """Integrate up to the next event or the end; return the time, and if there is an event."""
        if end - t <= SHARP * max(abs(t), abs(end)):
            return end, False
        unit = self.unit
        unit.place(t, self.x)
        signs = unit.signs()
        if not len(self.x):
            unit.place(end, self.x)
            return end, unit.completed() or bool(np.any(unit.signs() != signs))
        from scipy.integrate import LSODA

        solver = LSODA(self._rates, t, self.x, end, rtol=RTOL, atol=RTOL * unit.sizes)
        while solver.status == "running":
            before = solver.t
            message = solver.step()
            if solver.status == "failed":
                raise IntegrationError(
                    self.title,
                    found=f"its states cannot be integrated beyond t = {before:.9g} s: {message}",
                    expected="finite rates",
                    remedy="Look at the inputs of the unit, and at its log",
                )
            dense = solver.dense_output()
            unit.place(solver.t, solver.y)
            if np.any(unit.signs() != signs):
                return self._first(dense, before, solver.t, signs), True
            self.x = solver.y.copy()
            if unit.completed():
                return solver.t, True
        return end, False

    def _first(self, dense: Any, low: float, high: float, signs: np.ndarray) -> float:
        """Return where the first indicator has just changed its sign in a step, and stand there."""
        width = SHARP * max(abs(high), high - low)
        while high - low > width:
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            self.unit.place(middle, dense(middle))
            if np.any(self.unit.signs() != signs):
                high = middle
            else:
                low = middle
        self.x = np.array(dense(high))
        return high

    def close(self) -> None:
        """End the unit."""
        self.unit.close()
