"""Sensors of a run that stands: their scalars are measured by compiled kernels, which costs little."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from flexmb.constraints.measured_kernels import MEASURED, measure_scalar
from flexmb.errors import ModelError
from flexmb.math.direct import direct
from flexmb.math.kernel import kernel
from flexmb.math.tables import State
from flexmb.model.kinds import Sensor
from flexmb.model.table import in_order
from flexmb.system.program import run_kernels

__all__ = ["Readings"]

KNOWN = ("coordinate", "cosine", "place", "velocity", "spin")
"""What depends on the motion of markers alone."""


@kernel
def read_scalars(program, work, storage, t, placed, scalars, out):
    """Place the markers of a state at a time, unless they are `placed`, and write the values of scalars."""
    state = State(t, storage.q, storage.u, storage.a, storage.lam, storage.signals)
    if not placed:
        run_kernels(program.place, 0, program, state, work)
    jet, push, slope = np.empty(3), np.empty(12), np.empty(12)
    for k in range(len(out)):
        measure_scalar(scalars[k], state, work, jet, push, slope)
        out[k] = jet[0]


class _Numbers:
    """Numbers of markers and turns of a compiled system, as `Measured.record` asks for them."""

    def __init__(self, system):
        self.system, self.names = system, {k: name for name, k in system.marker_index.items()}

    def marker(self, name: str) -> int:
        return self.system.marker_index[name]

    def marker_name(self, marker: int) -> str:
        return self.names[marker]

    @staticmethod
    def pose(marker: int) -> tuple[np.ndarray, np.ndarray]:
        return np.zeros(3), np.eye(3)

    def branch(self, name: str, value: float) -> int:
        return self.system.branch_names.index(name)  # ValueError if the turn is counted elsewhere


class Readings:
    """Reads the sensors of one system at states that are given."""

    def __init__(self, system):
        self.system, self.work = system, system.workspace()
        self.numbers = _Numbers(system)
        self.state = system.state()
        self._placed: Any = None
        """The row whose markers stand in the workspace: many sensors are read at one."""

    def reader(self, sensor: Sensor) -> Callable[[Any], Any] | None:
        """Return the function that reads a sensor at a row of one sample; None if it needs more than places and
        velocities.
        """
        try:
            scalars = () if sensor.signal() is not None else sensor.measured(self.system.model)
            if any(one.alone or one.what not in KNOWN for one in scalars):
                return None
            rows = [in_order(MEASURED, one.record(self.numbers, lambda marker: marker)) for one in scalars]
        except (ModelError, ValueError):
            return None
        if not rows:
            return None
        table, out, system = np.array(rows, MEASURED), np.empty(len(rows)), self.system
        call, state = direct(system, read_scalars), self.state

        def read(row: Any) -> Any:
            placed = row is self._placed
            if not placed:
                state.q[:], state.u[:] = row["q"][-1], row["u"][-1]
            call(system.program, self.work, state, float(row["t"][-1]), placed, table, out)
            self._placed = row
            return float(out[0]) if len(out) == 1 else out.copy()

        return read
