"""`Coupled`: two coordinates keep a ratio."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints.coordinate import COORDINATE, Coordinate
from flexmb.constraints.coordinate_kernels import act, add_curvature, measure, second_rate
from flexmb.constraints.rows import HEADER
from flexmb.math.tables import STIFF, row_kernel
from flexmb.model.primitives import Equation
from flexmb.model.table import Table

__all__ = ["Coupled"]

ROW = np.dtype(
    [
        *HEADER,
        ("x", COORDINATE),
        ("y", COORDINATE),
        ("legs", np.int64, 4),  # of the markers a, b of x and of y, counted from the first leg
        ("n_legs", np.int64),
        ("ratio", float),
        ("offset", float),
    ],
    align=True,
)


@row_kernel
def evaluate(raw, data, state, work):
    """g = x - ratio y - offset, eq. (coupled); markers that both coordinates share have one leg."""
    rows = raw.view(ROW)
    gx = np.empty(12)
    gy = np.empty(12)
    for n in range(rows.shape[0]):
        row = rows[n]
        equation = work.equations[row.equation]
        x, _ = measure(row.x, state, work, gx)
        y, _ = measure(row.y, state, work, gy)
        for k in range(row.n_legs):
            for i in range(6):
                work.legs[row.leg + k].gradient[i] = 0.0
        for k in range(2):
            for i in range(6):
                work.legs[row.leg + row.legs[k]].gradient[i] += gx[6 * k + i]
                work.legs[row.leg + row.legs[2 + k]].gradient[i] -= row.ratio * gy[6 * k + i]
        equation.g = x - row.ratio * y - row.offset
        equation.rate = 0.0
        equation.drift = second_rate(row.x, work) - row.ratio * second_rate(row.y, work)
        lam = state.lam[row.equation]
        equation.force = lam
        act(row.x, work, gx, lam)
        act(row.y, work, gy, -row.ratio * lam)
        if work.weights[0].wanted == 1:
            add_curvature(row.x, work, -lam, work.pairs[row.x.pair].K)
            add_curvature(row.y, work, row.ratio * lam, work.pairs[row.y.pair].K)


@dataclass(frozen=True)
class Coupled(Equation):
    """A coordinate x of the first two markers and a coordinate y of the last two keep x = ratio y + offset.

    Parameters
    ----------
    x, y : Coordinate
    ratio : float, - (m/rad, rad/m)
    offset : float, m or rad, optional
        By default taken from the configuration as described.
    """

    x: Coordinate
    y: Coordinate
    ratio: float
    offset: float | None = None

    table: ClassVar[Table] = Table("Coupled", ROW, {"evaluate": evaluate})
    stiffens: ClassVar[bool] = True

    def involved(self, markers):
        """Return each marker once."""
        return tuple(dict.fromkeys(markers))

    def record(self, compiler, markers):
        """Return the own fields of the row; `markers` belong to x and to y, or are the two of both."""
        a, b, c, d = markers if len(markers) == 4 else (*markers, *markers)
        offset = self.offset
        if offset is None:
            offset = self.x.value(compiler, a, b) - self.ratio * self.y.value(compiler, c, d)
        legs = self.involved(markers)
        ordered = [*((b, a) if self.x.swapped else (a, b)), *((d, c) if self.y.swapped else (c, d))]
        return {
            "x": self.x.record(compiler, a, b, writes=STIFF),
            "y": self.y.record(compiler, c, d, writes=STIFF),
            "legs": [legs.index(m) for m in ordered],
            "n_legs": len(legs),
            "offset": offset,
        }
