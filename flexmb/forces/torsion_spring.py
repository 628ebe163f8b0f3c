"""`TorsionSpring`: a linear spring and damper on the turn of a joint."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints.coordinate import COORDINATE
from flexmb.constraints.coordinate_kernels import act, add_tangent, measure
from flexmb.errors import ModelError
from flexmb.forces.on_coordinate import OnCoordinate
from flexmb.math.tables import row_kernel
from flexmb.model.described import is_number
from flexmb.model.table import Table

__all__ = ["TorsionSpring"]

ROW = np.dtype([("x", COORDINATE), ("stiffness", float), ("damping", float), ("free", float)], align=True)


@row_kernel
def apply(raw, data, state, work):
    """M = -k (theta - theta_0) - c theta', eq. (torsion-spring)."""
    rows = raw.view(ROW)
    gradient = np.empty(12)
    for n in range(rows.shape[0]):
        row = rows[n]
        x, rate = measure(row.x, state, work, gradient)
        moment = -row.stiffness * (x - row.free) - row.damping * rate
        act(row.x, work, gradient, moment)
        work.energy[0].potential += 0.5 * row.stiffness * (x - row.free) ** 2
        work.energy[0].dissipation += row.damping * rate**2
        if work.weights[0].wanted == 1:
            add_tangent(row.x, work, gradient, moment, row.stiffness, row.damping)


@dataclass(frozen=True, eq=False)
class TorsionSpring(OnCoordinate):
    """Turn a joint back with the moment ``stiffness (theta - free_angle) + damping theta'``, eq. (torsion-spring).

    theta is the turn of the joint about z, from the x-axis of its first marker to the x-axis of its second. It is
    counted through full turns: a spring that is wound three times pulls three times as far back. At the start theta
    lies in (-pi, pi].

    Parameters
    ----------
    name : str
    joint : str
        A joint that turns.
    stiffness : float, N m/rad
    damping : float, N m s/rad
    free_angle : float, rad
        Where the spring is at rest.
    freedom : str, optional
        "turn", or "turn_b" (about z of the second marker), for joints with several.
    """

    name: str
    _: KW_ONLY
    joint: str
    stiffness: float
    damping: float = 0.0
    free_angle: float = 0.0
    freedom: str | None = None

    motion: ClassVar[str] = "turn"
    table: ClassVar[Table] = Table("TorsionSpring", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("stiffness", "damping", zero=True)
        if not is_number(self.free_angle):
            raise ModelError(
                self.title,
                found=f"free_angle = {self.free_angle!r}",
                expected="a finite angle, rad",
                remedy="Leave free_angle out for 0 rad",
            )

    def record(self, compiler):
        """Return the row."""
        return {"x": self.coordinate_row(compiler), "free": self.free_angle}
