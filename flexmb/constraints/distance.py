"""`Distance`: two markers keep their distance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints.rows import HEADER, add_block, apply_multiplier, set_gradient
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import dot
from flexmb.model.primitives import Equation
from flexmb.model.table import Table

__all__ = ["Distance"]

ROW = np.dtype([*HEADER, ("length", float)], align=True)


@row_kernel
def evaluate(raw, data, state, work):
    """g = (d . d - L^2) / (2 L), d = r_b - r_a; g'' = d . (a_b - a_a) / L + d' . d' / L.

    The square avoids the root; divided by 2 L the residual is a length and the multiplier the force in the rod.
    """
    rows = raw.view(ROW)
    d = np.empty(3)
    rate = np.empty(3)
    zero = np.zeros(3)
    for n in range(rows.shape[0]):
        row = rows[n]
        a = work.markers[row.a]
        b = work.markers[row.b]
        equation = work.equations[row.equation]
        leg_a = work.legs[row.leg]
        leg_b = work.legs[row.leg + 1]
        for i in range(3):
            d[i] = b.r[i] - a.r[i]
            rate[i] = b.v[i] - a.v[i]
        set_gradient(leg_a, -1.0 / row.length, d, zero)
        set_gradient(leg_b, 1.0 / row.length, d, zero)
        equation.g = (dot(d, d) - row.length**2) / (2.0 * row.length)
        equation.rate = 0.0
        equation.drift = dot(rate, rate) / row.length
        lam = state.lam[row.equation]
        apply_multiplier(equation, leg_a, leg_b, a, b, lam)
        if work.weights[0].stiffness != 0.0:
            K = work.pairs[row.pair].K
            k = lam / row.length
            add_block(K, 0, 0, -k, zero, zero, 1.0)
            add_block(K, 6, 6, -k, zero, zero, 1.0)
            add_block(K, 0, 6, k, zero, zero, 1.0)
            add_block(K, 6, 0, k, zero, zero, 1.0)


@dataclass(frozen=True)
class Distance(Equation):
    """The distance between the markers is given.

    Parameters
    ----------
    length : float, m
    """

    length: float

    table: ClassVar[Table] = Table("Distance", ROW, {"evaluate": evaluate})
    stiffens: ClassVar[bool] = True
