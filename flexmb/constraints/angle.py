"""`Angle`: a turn of marker b relative to marker a is prescribed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.constraints.coordinate import COORDINATE, Coordinate
from flexmb.constraints.coordinate_kernels import act, add_curvature, measure, second_rate
from flexmb.constraints.rows import HEADER
from flexmb.math.tables import STIFF, row_kernel
from flexmb.model.primitives import Equation
from flexmb.model.table import Table

__all__ = ["Angle"]

ROW = np.dtype([*HEADER, ("x", COORDINATE), ("signal", np.int64)], align=True)


@row_kernel
def evaluate(raw, data, state, work):
    """g = theta - s(t), the difference wrapped to (-pi, pi]; theta as in eq. (coordinate-turn)."""
    rows = raw.view(ROW)
    gradient = np.empty(12)
    for n in range(rows.shape[0]):
        row = rows[n]
        equation = work.equations[row.equation]
        x, _ = measure(row.x, state, work, gradient)
        for i in range(6):
            work.legs[row.leg].gradient[i] = gradient[i]
            work.legs[row.leg + 1].gradient[i] = gradient[6 + i]
        difference = x - state.signals[row.signal, 0]
        equation.g = difference - 2.0 * np.pi * np.round(difference / (2.0 * np.pi))
        equation.rate = -state.signals[row.signal, 1]
        equation.drift = second_rate(row.x, work) - state.signals[row.signal, 2]
        lam = state.lam[row.equation]
        equation.force = lam
        act(row.x, work, gradient, lam)
        if work.weights[0].wanted == 1:
            add_curvature(row.x, work, -lam, work.pairs[row.x.pair].K)


TURN = Coordinate("turn")


@dataclass(frozen=True)
class Angle(Equation):
    """An angle between the two markers follows a signal (rad).

    Parameters
    ----------
    angle : signal, rad
    coordinate : Coordinate
        Which angle: by default from x of a to x of b about z of a.
    """

    angle: Any
    coordinate: Coordinate = TURN

    table: ClassVar[Table] = Table("Angle", ROW, {"evaluate": evaluate})
    stiffens: ClassVar[bool] = True

    def involved(self, markers):
        """Return the markers in the order in which the angle is measured."""
        return (markers[1], markers[0]) if self.coordinate.swapped else (markers[0], markers[1])

    def record(self, compiler, markers):
        x = self.coordinate.record(compiler, *markers, counts=False, writes=STIFF)
        return {"x": x, "signal": compiler.signal(self.angle)}
