"""`BiStop`: free travel between two dissipative end stops."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints.coordinate import COORDINATE, TURN
from flexmb.constraints.coordinate_kernels import act, add_tangent, measure
from flexmb.errors import ModelError
from flexmb.forces.on_coordinate import OnCoordinate, check_number
from flexmb.forces.rows import one_sided
from flexmb.math.switches import GAP, TURN_GAP, switch_kernel
from flexmb.math.tables import row_kernel
from flexmb.model.described import finite_array
from flexmb.model.table import Table

__all__ = ["BiStop"]

ROW = np.dtype(
    [
        ("x", COORDINATE),
        ("lower", float),  # m or rad, where the stops are
        ("upper", float),
        ("stiffness", float),  # N/m^e
        ("exponent", float),
        ("damping", float),  # N s/m
        ("depth", float),  # m, penetration at which the damping is complete
    ],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """Nothing between the stops; beyond one, the force of eq. (one-sided) back."""
    rows = raw.view(ROW)
    gradient = np.empty(12)
    for n in range(rows.shape[0]):
        row = rows[n]
        x, rate = measure(row.x, state, work, gradient)
        sense, p = -1.0, x - row.upper
        if x < row.lower:
            sense, p = 1.0, row.lower - x
        if p <= 0.0:
            continue
        speed = -sense * rate
        force, slope, damping, energy = one_sided(p, speed, row.stiffness, row.exponent, row.damping, row.depth)
        act(row.x, work, gradient, sense * force)
        work.energy[0].potential += energy
        work.energy[0].dissipation += (force - row.stiffness * p**row.exponent) * speed
        if work.weights[0].wanted == 1:
            add_tangent(row.x, work, gradient, sense * force, slope, damping)


@switch_kernel
def switch(raw, data, state, work, out):
    """The way to the upper and to the lower stop."""
    rows = raw.view(ROW)
    gradient = np.empty(12)
    for n in range(rows.shape[0]):
        row = rows[n]
        x, rate = measure(row.x, state, work, gradient)
        for k in range(2):
            gap, sense = out[2 * n + k], (-1.0 if k == 0 else 1.0)
            gap[:] = 0.0
            kind = TURN_GAP if row.x.kind == TURN else GAP
            gap[0], gap[1], gap[4], gap[9] = kind, sense * x, sense * rate, 1.0
            gap[7] = -row.upper if k == 0 else row.lower


@dataclass(frozen=True, eq=False)
class BiStop(OnCoordinate):
    """Leave a travel free between two end stops; beyond each of them ``F = k p^e + c w(p/d) p'``, eq. (one-sided).

    p is the penetration. The damping grows with it by w(s) = s^2 (3 - 2 s), complete at the depth d; no stop pulls.
    The coordinate is the distance of two markers (less `length`), their offset along an axis of the first, or a freedom
    of a joint.

    Parameters
    ----------
    name : str
    markers : (str, str), optional
    joint : str, optional
        Instead of markers: the joint on whose freedom the stops act.
    travel : (float, float), m or rad
        Where the stops are, relative to `length`.
    stiffness : float, N/m^e (N m/rad^e)
    exponent : float, -
        At least 1.
    damping : float, N s/m (N m s/rad)
    depth : float, m or rad
        Penetration at which the damping is complete.
    length : float, m, optional
        Reference of the travel; by default the distance of the markers as described, 0 for axes and joints.
    along : "line", "x", "y" or "z"
        Line between the markers, or an axis of the first marker.
    freedom : str, optional
        "slide", "turn", "slide_x", "slide_y" or "turn_b" of the joint; by default its first turn, else its slide.

    Source: the impact law of MSC Adams (IMPACT, BISTOP functions).
    """

    name: str
    _: KW_ONLY
    markers: tuple[str, str] | None = None
    joint: str | None = None
    travel: tuple[float, float]
    stiffness: float
    exponent: float = 1.0
    damping: float = 0.0
    depth: float = 1e-4
    length: float | None = None
    along: str = "line"
    freedom: str | None = None

    table: ClassVar[Table] = Table("BiStop", ROW, {"apply": apply, "switch": switch}, switches=2)
    strikes: ClassVar[bool] = True

    def __post_init__(self):
        super().__post_init__()
        self.require_place()
        self.require_positive("stiffness", "depth")
        self.require_positive("damping", zero=True)
        check_number(self, "exponent", 1.0, "a number >= 1", "1 is a linear stop, 1.5 a Hertzian contact")
        if self.length is not None:
            self.require_positive("length", zero=True)
        travel = finite_array(self.travel)
        if travel.shape != (2,) or travel[0] > travel[1]:
            raise ModelError(
                self.title,
                found=f"travel = {self.travel!r}",
                expected="(lower, upper), m or rad",
                remedy="Write travel=(-0.028, 0.012)",
            )
        object.__setattr__(self, "travel", (float(travel[0]), float(travel[1])))

    def record(self, compiler):
        """Return the row with the places of the stops."""
        line = self.joint is None and self.along == "line"
        zero = self.length if self.length is not None else self.described(compiler) if line else 0.0
        lower, upper = (zero + end for end in self.travel)
        return {"x": self.coordinate_row(compiler), "lower": lower, "upper": upper}
