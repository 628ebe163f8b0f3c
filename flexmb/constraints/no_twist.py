"""`NoTwist`: marker b bends against marker a without turning about the axis between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints.rows import HEADER, add_block, apply_multiplier, rotating_product, set_gradient
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import cross, dot
from flexmb.model.primitives import Equation
from flexmb.model.table import Table

__all__ = ["NoTwist"]

ROW = np.dtype(HEADER, align=True)


@row_kernel
def evaluate(raw, data, state, work):
    """g = (y_a . x_b - x_a . y_b) / 2, eq. (no-twist): two products of turning vectors, as in `Perpendicular`."""
    rows = raw.view(ROW)
    normal = np.empty(3)
    t = np.empty(3)
    zero = np.zeros(3)
    scratch = np.empty((2, 3))
    for n in range(rows.shape[0]):
        row = rows[n]
        a, b = work.markers[row.a], work.markers[row.b]
        equation = work.equations[row.equation]
        leg_a, leg_b = work.legs[row.leg], work.legs[row.leg + 1]
        lam = state.lam[row.equation]
        equation.g, equation.rate, equation.drift = 0.0, 0.0, 0.0
        normal[:] = 0.0
        for k in range(2):
            share = 0.5 if k == 0 else -0.5
            p, q = a.R[:, 1 - k], b.R[:, k]
            cross(p, q, t)
            for i in range(3):
                normal[i] += share * t[i]
            equation.g += share * dot(p, q)
            equation.drift += share * rotating_product(p, a.w, q, b.w, scratch)[1]
            if work.weights[0].wanted == 1:
                K = work.pairs[row.pair].K
                force = share * lam
                add_block(K, 3, 3, -force, p, q, -dot(p, q))
                add_block(K, 9, 3, force, p, q, -dot(p, q))
                add_block(K, 3, 9, force, q, p, -dot(p, q))
                add_block(K, 9, 9, -force, q, p, -dot(p, q))
        set_gradient(leg_a, 1.0, zero, normal)
        set_gradient(leg_b, -1.0, zero, normal)
        apply_multiplier(equation, leg_a, leg_b, a, b, lam)


@dataclass(frozen=True)
class NoTwist(Equation):
    """The rotation from the axes of a to the axes of b is about an axis in the x-y plane of both."""

    table: ClassVar[Table] = Table("NoTwist", ROW, {"evaluate": evaluate})
    stiffens: ClassVar[bool] = True
