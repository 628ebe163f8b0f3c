"""`InPlane`: marker b stays in a plane of marker a, or moves along its normal as prescribed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.constraints.rows import HEADER, add_block, apply_multiplier, centripetal, set_gradient
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import add_skew, cross, dot
from flexmb.model.primitives import Equation
from flexmb.model.table import Table

__all__ = ["InPlane"]

ROW = np.dtype([*HEADER, ("axis", np.int64), ("signal", np.int64)], align=True)


@row_kernel
def evaluate(raw, data, state, work):
    """g = n . d - s(t), n an axis of a, d = r_b - r_a.

    dg = n . (dr_b - dr_a) + (n x d) . dtheta_a;  g'' = G a + (w x (w x n)) . d + 2 (w x n) . d' - s''.
    """
    rows = raw.view(ROW)
    d = np.empty(3)
    rate = np.empty(3)
    moment = np.empty(3)
    swing = np.empty(3)
    zero = np.zeros(3)
    for n in range(rows.shape[0]):
        row = rows[n]
        a = work.markers[row.a]
        b = work.markers[row.b]
        equation = work.equations[row.equation]
        leg_a = work.legs[row.leg]
        leg_b = work.legs[row.leg + 1]
        normal = a.R[:, row.axis]
        for i in range(3):
            d[i] = b.r[i] - a.r[i]
            rate[i] = b.v[i] - a.v[i]
        cross(d, normal, moment)
        set_gradient(leg_a, -1.0, normal, moment)
        set_gradient(leg_b, 1.0, normal, zero)
        equation.g = dot(normal, d)
        equation.rate = 0.0
        centripetal(a.w, normal, swing)
        equation.drift = dot(swing, d)
        cross(a.w, normal, swing)
        equation.drift += 2.0 * dot(swing, rate)
        if row.signal >= 0:
            equation.g -= state.signals[row.signal, 0]
            equation.rate -= state.signals[row.signal, 1]
            equation.drift -= state.signals[row.signal, 2]
        lam = state.lam[row.equation]
        apply_multiplier(equation, leg_a, leg_b, a, b, lam)
        if work.weights[0].stiffness != 0.0:
            K = work.pairs[row.pair].K
            add_skew(K, 0, 3, -lam, normal)
            add_skew(K, 6, 3, lam, normal)
            add_skew(K, 3, 0, lam, normal)
            add_skew(K, 3, 6, -lam, normal)
            add_block(K, 3, 3, -lam, normal, d, -dot(normal, d))


@dataclass(frozen=True)
class InPlane(Equation):
    """Marker b lies in the plane through a whose normal is the named axis of a; a signal moves the plane along it.

    Parameters
    ----------
    axis : "x", "y" or "z"
        Axis of marker a.
    displacement : signal, m, optional
        Prescribed distance from the plane (default: zero).
    """

    axis: str
    displacement: Any = None

    table: ClassVar[Table] = Table("InPlane", ROW, {"evaluate": evaluate})
    stiffens: ClassVar[bool] = True

    def record(self, compiler, markers):
        signal = -1 if self.displacement is None else compiler.signal(self.displacement)
        return {"axis": "xyz".index(self.axis), "signal": signal}
