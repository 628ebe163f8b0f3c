"""`PointLoad`: a given force and moment on a marker."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import dot
from flexmb.model.kinds import Force, Table
from flexmb.model.signal import as_signal

__all__ = ["PointLoad"]

ROW = np.dtype(
    [("marker", np.int64), ("axes", np.int64), ("pair", np.int64), ("signals", np.int64, 6)],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """W = (F(t), M(t)), components in W or in the axes of a marker (follower load)."""
    rows = raw.view(ROW)
    for n in range(rows.shape[0]):
        row = rows[n]
        marker = work.markers[row.marker]
        for half in range(2):
            load = np.zeros(3)
            for i in range(3):
                amount = state.signals[row.signals[3 * half + i], 0]
                if row.axes < 0:
                    load[i] += amount
                else:
                    for j in range(3):
                        load[j] += work.markers[row.axes].R[j, i] * amount
            for i in range(3):
                marker.wrench[3 * half + i] += load[i]
            if half == 0:
                work.energy[3] += dot(load, marker.v)
            else:
                work.energy[3] += dot(load, marker.w)
            if row.axes >= 0 and work.coefficients[3] > 0.0:
                # a follower load turns with the axes of marker b of the pair: dF = dtheta x F, K = -dW/d(...)
                K = work.pairs[row.pair].K
                top = 3 * half
                K[top, 10] -= load[2]
                K[top, 11] += load[1]
                K[top + 1, 9] += load[2]
                K[top + 1, 11] -= load[0]
                K[top + 2, 9] -= load[1]
                K[top + 2, 10] += load[0]


@dataclass(frozen=True, eq=False)
class PointLoad(Force):
    """Apply a force and a moment, given functions of time, to a marker.

    Parameters
    ----------
    name : str
    marker : str
        "body.marker" on which the load acts.
    force, moment : three signals, N and N m
    axes : str, optional
        A marker whose axes the components refer to (a follower load turns with it); default: world axes.
    """

    name: str
    _: KW_ONLY
    marker: str
    force: Any = (0.0, 0.0, 0.0)
    moment: Any = (0.0, 0.0, 0.0)
    axes: str | None = None

    table: ClassVar[Table] = Table("PointLoad", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        for field in ("force", "moment"):
            value = getattr(self, field)
            if not hasattr(value, "__len__") or isinstance(value, str) or len(value) != 3:
                raise ModelError(self.title, found=f"{field} = {value!r}",
                                 expected="three numbers or signals (x, y, z)",
                                 remedy=f"Write {field}=(0, 0, -100.0)")
            signals = tuple(as_signal(v, self.title, f"{field}[{i}]") for i, v in enumerate(value))
            object.__setattr__(self, field, signals)

    def check(self, model) -> None:
        """Raise ModelError if a marker does not exist."""
        for marker in (self.marker, self.axes):
            if marker is not None:
                model.marker(marker, self.title)

    def record(self, compiler):
        """Return the row."""
        marker = compiler.marker(self.marker)
        axes = -1 if self.axes is None else compiler.marker(self.axes)
        pair = -1 if axes < 0 else compiler.pair(marker, axes)
        return (marker, axes, pair, tuple(compiler.signal(s) for s in (*self.force, *self.moment)))
