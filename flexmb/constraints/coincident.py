"""`Coincident`: two markers share their position."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints.rows import HEADER
from flexmb.math.tables import row_kernel
from flexmb.model.primitives import Equation
from flexmb.model.table import Table

__all__ = ["Coincident"]

ROW = np.dtype(HEADER, align=True)


@row_kernel
def evaluate(raw, data, state, work):
    """g = r_b - r_a (three equations, in W); g'' = a_b - a_a; no second derivative."""
    rows = raw.view(ROW)
    for n in range(rows.shape[0]):
        row = rows[n]
        a = work.markers[row.a]
        b = work.markers[row.b]
        for k in range(3):
            equation = work.equations[row.equation + k]
            leg_a = work.legs[row.leg + 2 * k]
            leg_b = work.legs[row.leg + 2 * k + 1]
            for i in range(6):
                leg_a.gradient[i] = 0.0
                leg_b.gradient[i] = 0.0
            leg_a.gradient[k] = -1.0
            leg_b.gradient[k] = 1.0
            equation.g = b.r[k] - a.r[k]
            equation.rate = 0.0
            equation.drift = 0.0
            lam = state.lam[row.equation + k]
            equation.force = lam
            a.wrench[k] -= lam
            b.wrench[k] += lam


@dataclass(frozen=True)
class Coincident(Equation):
    """The origins of both markers coincide: r_b - r_a = 0, in world axes."""

    table: ClassVar[Table] = Table("Coincident", ROW, {"evaluate": evaluate})
    count: ClassVar[int] = 3
    stiffens: ClassVar[bool] = False
