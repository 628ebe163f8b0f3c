"""`PointLoad`: a given force and moment on a marker."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.constraints import joint_coordinate
from flexmb.constraints.coordinate import COORDINATE, NO_COORDINATE
from flexmb.constraints.coordinate_kernels import measure
from flexmb.forces.on_coordinate import joint_of_tables, signal_and_table
from flexmb.forces.rows import add_follower_stiffness, store_three_signals
from flexmb.math.jets import interpolate
from flexmb.math.kernel import inner_kernel
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import dot
from flexmb.model.kinds import Force
from flexmb.model.table import Table

__all__ = ["PointLoad"]

ROW = np.dtype(
    [
        ("marker", np.int64),
        ("axes", np.int64),
        ("pair", np.int64),
        ("signals", np.int64, 6),
        ("channels", np.int64, 6),  # by which the wrench changes with each signal, or -1
        ("tables", np.int64, 6),  # where the table of each component begins in the bulk data, or -1
        ("x", COORDINATE),  # the argument of the tables
        ("pairs", np.int64, 2),  # (marker, a) and (marker, b) of the coordinate, or -1
    ],
    align=True,
)


@inner_kernel
def _add_slope(row, work, gradient, top, slope):
    """Add -dF/dx dx/d(...) of a force or moment whose derivative by the coordinate is `slope`."""
    for side in range(2):
        K = work.pairs[row.pairs[side]].K
        for i in range(3):
            for j in range(6):
                K[top + i, 6 + j] -= slope[i] * gradient[6 * side + j]


@row_kernel
def apply(raw, data, state, work):
    """W = (F, M), components in W or in the axes of a marker (follower load), of time or of time and a joint."""
    rows = raw.view(ROW)
    gradient = np.empty(12)
    load = np.empty(3)
    slope = np.empty(3)
    for n in range(rows.shape[0]):
        row = rows[n]
        marker = work.markers[row.marker]
        over = row.pairs[0] >= 0
        x = 0.0
        if over:
            x, _ = measure(row.x, state, work, gradient)
        for half in range(2):
            load[:] = 0.0
            slope[:] = 0.0
            for i in range(3):
                amount, change, factor = state.signals[row.signals[3 * half + i], 0], 0.0, 1.0
                channel = row.channels[3 * half + i]
                if row.tables[3 * half + i] >= 0:
                    f, f1, _ = interpolate(x, data[row.tables[3 * half + i] :])
                    change, factor = amount * f1, f
                    amount *= f
                for j in range(3):
                    if row.axes >= 0:
                        share = work.markers[row.axes].R[j, i]
                    else:
                        share = 1.0 if i == j else 0.0
                    load[j] += share * amount
                    slope[j] += share * change
                    if channel >= 0:
                        work.channels[channel, 3 * half + j] = share * factor
            for i in range(3):
                marker.wrench[3 * half + i] += load[i]
            work.energy[0].load_power += dot(load, marker.v) if half == 0 else dot(load, marker.w)
            if work.weights[0].wanted == 0:
                continue
            if over:
                _add_slope(row, work, gradient, 3 * half, slope)
            if row.axes >= 0:
                add_follower_stiffness(work.pairs[row.pair].K, 3 * half, load)


@dataclass(frozen=True, eq=False)
class PointLoad(Force):
    """Apply a force and a moment to a marker: given functions of time, and tables over the coordinate of a joint.

    A component may be a table over a joint, times a signal: ``fmb.table([0, 0.3, 0.6], [2e3, 5e3, 9e3], of="hinge") *
    fmb.step(value=1.0, rise=0.1)`` is an airload that grows with the angle of the joint "hinge". Outside the
    table its first and last values hold.

    Parameters
    ----------
    name : str
    marker : str
        "body.marker" on which the load acts.
    force, moment : three signals, N and N m
        Numbers, signals, tables over a joint, or products of them; all tables of a load are over one joint. Signals may
        follow what is measured: a sensor, a formula, a controller.
    axes : str, optional
        A marker whose axes the components refer to (a follower load turns with it); default: world axes.
    freedom : str, optional
        Coordinate of the joint, where it has several: "turn", "turn_b", "slide", "slide_x" or "slide_y".
    """

    name: str
    _: KW_ONLY
    marker: str
    force: Any = (0.0, 0.0, 0.0)
    moment: Any = (0.0, 0.0, 0.0)
    axes: str | None = None
    freedom: str | None = None

    table: ClassVar[Table] = Table("PointLoad", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        for field in ("force", "moment"):
            store_three_signals(self, field)
        object.__setattr__(self, "_joint", joint_of_tables(self, (*self.force, *self.moment)))

    def check(self, model) -> None:
        """Raise ModelError if a marker or joint does not exist."""
        for marker in (self.marker, self.axes):
            if marker is not None:
                model.marker(marker, self.title)
        joint = self._joint  # type: ignore[attr-defined]
        if joint is not None:
            joint_coordinate(model.joint(joint, self.title), self.title, self.freedom)

    def record(self, compiler):
        """Return the row."""
        marker = compiler.marker(self.marker)
        axes = -1 if self.axes is None else compiler.marker(self.axes)
        pair = -1 if axes < 0 else compiler.pair(marker, axes)
        factors = [signal_and_table(component) for component in (*self.force, *self.moment)]
        followed = [compiler.follow(signal, marker) for signal, _ in factors]
        signals, channels = tuple(number for number, _ in followed), tuple(channel for _, (channel,) in followed)
        tables = tuple(-1 if table is None else compiler.bulk(table.numbers()) for _, table in factors)
        row = {"marker": marker, "axes": axes, "pair": pair, "signals": signals, "channels": channels, "tables": tables}
        if self._joint is None:
            return {**row, "x": NO_COORDINATE, "pairs": (-1, -1)}
        joint = compiler.joint(self._joint)
        x = joint_coordinate(joint, self.title, self.freedom).record(compiler, *map(compiler.marker, joint.markers))
        return {**row, "x": x, "pairs": (compiler.pair(marker, x["a"]), compiler.pair(marker, x["b"]))}
