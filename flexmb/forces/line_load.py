"""`LineLoad`: force and moment per length on a stretch of a cable or beam."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.forces.on_stretch import check_stretch, require_stretch_name, stretch_points
from flexmb.forces.rows import add_follower_stiffness, store_three_signals
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import dot
from flexmb.model.kinds import Force
from flexmb.model.table import Table

__all__ = ["LineLoad"]

ROW = np.dtype(
    [
        ("points", np.int64),  # where the stretch begins in the bulk data: marker, pair, length of each
        ("count", np.int64),
        ("section", np.int64),  # 1: components along the axes of the section, 0: of W
        ("signals", np.int64, 6),
    ],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """W_k = weight_k (f, m) at the Gauss points of the stretch: eq. (line-load)."""
    rows = raw.view(ROW)
    load = np.empty(3)
    for n in range(rows.shape[0]):
        row = rows[n]
        for k in range(row.count):
            at = row.points + 3 * k
            marker, weight = work.markers[int(data[at])], data[at + 2]
            for half in range(2):
                for i in range(3):
                    if row.section == 0:
                        load[i] = weight * state.signals[row.signals[3 * half + i], 0]
                    else:
                        load[i] = 0.0
                        for j in range(3):
                            load[i] += weight * marker.R[i, j] * state.signals[row.signals[3 * half + j], 0]
                    marker.wrench[3 * half + i] += load[i]
                work.energy[0].load_power += dot(load, marker.v) if half == 0 else dot(load, marker.w)
                if row.section == 1 and work.weights[0].wanted == 1:
                    add_follower_stiffness(work.pairs[int(data[at + 1])].K, 3 * half, load)


@dataclass(frozen=True, eq=False)
class LineLoad(Force):
    """Apply a force and a moment per length to a stretch of a cable or beam: wind, snow, buoyancy, pressure on a strip.

    Lengths refer to the line as drawn, so the load of a stretch does not change when it is stretched. Pressure p on a
    strip of width b is a force -p b along the section's z-axis, with ``section_axes=True``.

    Parameters
    ----------
    name : str
    stretch : str
        "body.stretch", named in the body's `stretches`.
    force, moment : three signals, N/m and N m/m
    section_axes : bool
        Components along the axes of the section (x along the line) and turning with it; otherwise along the axes of W.
    """

    name: str
    _: KW_ONLY
    stretch: str
    force: Any = (0.0, 0.0, 0.0)
    moment: Any = (0.0, 0.0, 0.0)
    section_axes: bool = False

    table: ClassVar[Table] = Table("LineLoad", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        require_stretch_name(self)
        for field in ("force", "moment"):
            store_three_signals(self, field)

    def check(self, model) -> None:
        """Raise ModelError if the body has no such stretch."""
        check_stretch(self, model)

    def record(self, compiler):
        """Return the row."""
        points, count = stretch_points(self, compiler, lambda b: compiler.pair(b, b) if self.section_axes else -1)
        return {
            "points": points,
            "count": count,
            "section": int(self.section_axes),
            "signals": tuple(compiler.signal(signal) for signal in (*self.force, *self.moment)),
        }
