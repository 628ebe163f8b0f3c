"""The change of a held value, looked for as events are: the run goes on with the same model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import IntegrationError
from flexmb.integrate.runs.breaks import jumps_at
from flexmb.integrate.runs.switching import read_switches
from flexmb.math.weights import no_matrix
from flexmb.system.holds import held_from
from flexmb.system.program import evaluate

__all__ = ["Switching", "require_seen", "sampled_on", "with_held"]


@dataclass(frozen=True)
class Switching:
    """Event and sensor in one: a relay or quantiser changes when a signal of the system passes zero upwards."""

    title: str
    number: int
    repeats: bool = False
    then: tuple[Any, ...] = ()

    @property
    def name(self) -> str:
        """Its name among events, which no part has."""
        return f"held: {self.title}"

    sensor = name

    @staticmethod
    def distance(values: np.ndarray) -> np.ndarray:
        """Return how far values are past the place of the change."""
        return np.asarray(values, float)

    def values(self, series) -> np.ndarray:
        """Return the signal (nt,)."""
        return series.signals[:, self.number]

    @staticmethod
    def joined(pieces) -> np.ndarray:
        """Return the values of consecutive phases."""
        return np.concatenate(pieces)


def with_held(system, work, t: float, row: dict[str, Any], passed: str = "") -> dict[str, Any]:
    """Return a row of one sample with what blocks hold from time t on; see `held_from`."""
    if not system.holds:
        return row
    q = held_from(system, work, t, row["q"][-1], row["u"][-1], passed)
    return {**row, "q": q[None]}


def sampled_on(integrator, system, work, variables, t: float, before: dict[str, Any]) -> dict[str, Any] | None:
    """Let blocks sample at a time, and the integrator go on with its step size and memory; return the row with what is
    held from then on. None if it has to begin anew: it cannot do that, or signals of time jump there too.
    """
    again = getattr(integrator, "held", None)
    if again is None or not system.holds or not system.signal_times.sampled_at(t) or jumps_at(system, t):
        return None
    row = with_held(system, work, t, before)
    q, u = row["q"][-1], row["u"][-1]
    if not again(system, work, variables, t, q):
        return None
    if len(variables.switching.now):  # signals of relays and limits may jump with what is held
        state = system.state(t, q, u)
        no_matrix(work.weights)
        evaluate(system.program, state, work)
        read_switches(system.program, variables.switching, state, work)
        variables.switching.now[:] = variables.switching.then
    return row


def require_seen(system, variables) -> None:
    """Raise IntegrationError if a signal passed the threshold of a relay and came back between two looks at it."""
    switching = getattr(variables, "switching", None)
    if switching is None or not system.holds:
        return
    titles = {hold.title for hold in system.holds if hold.crossing >= 0}
    for number, owner in enumerate(system.switch_owners):
        # one that is past it now has not been looked at yet: the integrator has come back between two looks
        if owner in titles and switching.touched[number] > 0.0 and switching.now[number, 1] >= 0.0:
            raise IntegrationError(
                owner,
                found="its signal passed a threshold and came back between two looks at it",
                expected="at most one change between two samples, and within a thousandth of the run",
                remedy="Take more samples, so that it is looked at more often",
            )
