"""`Perpendicular`: an axis of marker a stays perpendicular to an axis of marker b."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints.rows import HEADER, add_block, apply_multiplier, rotating_product, set_gradient
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import cross, dot
from flexmb.model.primitives import Equation
from flexmb.model.table import Table

__all__ = ["Perpendicular"]

ROW = np.dtype([*HEADER, ("axis_a", np.int64), ("axis_b", np.int64)], align=True)


@row_kernel
def evaluate(raw, data, state, work):
    """g = a . b, axes of the two markers; dg = (a x b) . (dtheta_a - dtheta_b).

    g'' = G a + (w_a x (w_a x a)) . b + 2 (w_a x a) . (w_b x b) + a . (w_b x (w_b x b)).
    """
    rows = raw.view(ROW)
    normal = np.empty(3)
    zero = np.zeros(3)
    scratch = np.empty((2, 3))
    for n in range(rows.shape[0]):
        row = rows[n]
        marker_a = work.markers[row.a]
        marker_b = work.markers[row.b]
        equation = work.equations[row.equation]
        leg_a = work.legs[row.leg]
        leg_b = work.legs[row.leg + 1]
        a = marker_a.R[:, row.axis_a]
        b = marker_b.R[:, row.axis_b]
        cross(a, b, normal)
        set_gradient(leg_a, 1.0, zero, normal)
        set_gradient(leg_b, -1.0, zero, normal)
        equation.g = dot(a, b)
        equation.rate = 0.0
        _, equation.drift = rotating_product(a, marker_a.w, b, marker_b.w, scratch)
        lam = state.lam[row.equation]
        apply_multiplier(equation, leg_a, leg_b, marker_a, marker_b, lam)
        if work.weights[0].stiffness != 0.0:
            K = work.pairs[row.pair].K
            add_block(K, 3, 3, -lam, a, b, -dot(a, b))
            add_block(K, 9, 3, lam, a, b, -dot(a, b))
            add_block(K, 3, 9, lam, b, a, -dot(a, b))
            add_block(K, 9, 9, -lam, b, a, -dot(a, b))


@dataclass(frozen=True)
class Perpendicular(Equation):
    """The named axis of marker a is perpendicular to the named axis of marker b.

    Parameters
    ----------
    axis_a, axis_b : "x", "y" or "z"
    """

    axis_a: str
    axis_b: str

    table: ClassVar[Table] = Table("Perpendicular", ROW, {"evaluate": evaluate})
    stiffens: ClassVar[bool] = True

    def idle(self, a: str, b: str) -> tuple[str, str, str]:
        """Say that the axes are parallel: no direction is better than another."""
        return (
            f"the {self.axis_a}-axis of '{a}' and the {self.axis_b}-axis of '{b}' are parallel",
            "axes that are perpendicular, or nearly so",
            f"Turn one of the two markers, for example '{b}': Pose.axes(at=..., z=...), in a model file "
            "{ at = [...], z = [...] }",
        )

    def record(self, compiler, markers):
        return {"axis_a": "xyz".index(self.axis_a), "axis_b": "xyz".index(self.axis_b)}
