"""`Angle`: the turn of marker b about the z-axis of marker a is prescribed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.constraints.rows import HEADER, add_skew, apply_multiplier, rotating_product, set_gradient
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import cross, dot
from flexmb.model.kinds import Equation, Table

__all__ = ["Angle"]

ROW = np.dtype([*HEADER, ("signal", np.int64)], align=True)


@row_kernel
def evaluate(raw, data, state, work):
    """g = theta - s(t), theta = atan2(y_a . x_b, x_a . x_b), the difference wrapped to (-pi, pi].

    With sine s = y_a . x_b and cosine c = x_a . x_b: dtheta = (c ds - s dc) / (s^2 + c^2); s and c are products of
    turning vectors. The second derivative is that of parallel z-axes, exact for all motions which the joint permits.
    """
    rows = raw.view(ROW)
    sine = np.empty(3)
    cosine = np.empty(3)
    normal = np.empty(3)
    zero = np.zeros(3)
    scratch = np.empty((2, 3))
    for n in range(rows.shape[0]):
        row = rows[n]
        a = work.markers[row.a]
        b = work.markers[row.b]
        equation = work.equations[row.equation]
        leg_a = work.legs[row.leg]
        leg_b = work.legs[row.leg + 1]
        x_a, y_a, x_b = a.R[:, 0], a.R[:, 1], b.R[:, 0]
        s = dot(y_a, x_b)
        c = dot(x_a, x_b)
        r2 = s * s + c * c
        cross(y_a, x_b, sine)
        cross(x_a, x_b, cosine)
        for i in range(3):
            normal[i] = (c * sine[i] - s * cosine[i]) / r2
        set_gradient(leg_a, 1.0, zero, normal)
        set_gradient(leg_b, -1.0, zero, normal)
        ds, dds = rotating_product(y_a, a.w, x_b, b.w, scratch)
        dc, ddc = rotating_product(x_a, a.w, x_b, b.w, scratch)
        turn = (c * ds - s * dc) / r2
        difference = np.arctan2(s, c) - state.signals[row.signal, 0]
        equation.g = difference - 2.0 * np.pi * np.round(difference / (2.0 * np.pi))
        equation.rate = -state.signals[row.signal, 1]
        equation.drift = (c * dds - s * ddc - 2.0 * turn * (s * ds + c * dc)) / r2 - state.signals[row.signal, 2]
        lam = state.lam[row.equation]
        apply_multiplier(equation, leg_a, leg_b, a, b, lam)
        if work.coefficients[3] > 0.0:
            K = work.pairs[row.pair].K
            z_a = a.R[:, 2]
            add_skew(K, 9, 3, lam, z_a)
            add_skew(K, 3, 3, -lam, z_a)


@dataclass(frozen=True)
class Angle(Equation):
    """The angle from x of a to x of b about z of a follows a signal (rad)."""

    angle: Any

    table: ClassVar[Table] = Table("Angle", ROW, {"evaluate": evaluate})
    stiffens: ClassVar[bool] = True

    def record(self, compiler, markers):
        return (compiler.signal(self.angle),)
