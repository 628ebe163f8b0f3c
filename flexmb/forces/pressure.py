"""`Pressure`: a distributed load on an elastic body."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.constraints import joint_coordinate
from flexmb.constraints.coordinate import COORDINATE, NO_COORDINATE
from flexmb.constraints.coordinate_kernels import measure
from flexmb.errors import ModelError, did_you_mean
from flexmb.forces.on_coordinate import joint_of_tables, signal_and_table
from flexmb.forces.travelling import travelling
from flexmb.math.jets import interpolate
from flexmb.math.tables import STIFF, row_kernel
from flexmb.model.kinds import Force
from flexmb.model.signal import as_signal
from flexmb.model.table import Table

__all__ = ["Pressure"]

ROW = np.dtype(
    [
        ("load", np.int64),
        ("signal", np.int64),
        ("channel", np.int64),  # by which the amount changes with the signal, or -1: a function of time
        ("table", np.int64),  # where the table over the coordinate begins in the bulk data, or -1
        ("shape", np.int64),  # where the load shape begins there
        ("modes", np.int64),  # flexible coordinates of the body by which the shape turns, or 0
        ("eta", np.int64),  # the first of them
        ("turning", np.int64),  # where the change of the load shape per coordinate begins in the bulk data
        ("own", np.int64),  # the marker whose one freedom is the amount of the load shape
        ("x", COORDINATE),  # the argument of the table
        ("pairs", np.int64, 2),  # (own, a) and (own, b) of the coordinate
    ],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """Add the amount to the load shape's; the body turns it into forces, eq. (load-shape)."""
    rows = raw.view(ROW)
    gradient = np.empty(12)
    for n in range(rows.shape[0]):
        row = rows[n]
        amount = state.signals[row.signal, 0]
        tangent = work.weights[0].wanted == 1
        if tangent and row.own >= 0:
            own = work.markers[row.own]
            for j in range(own.nu):
                force = data[row.shape + j]
                for k in range(row.modes):
                    force += data[row.turning + j * row.modes + k] * state.q[row.eta + k]
                work.J[own.iJ + j] = force
        share = 1.0
        if row.table >= 0:
            x, _ = measure(row.x, state, work, gradient)
            f, f1, _ = interpolate(x, data[row.table :])
            share = f
            if tangent:
                for side in range(2):
                    K = work.pairs[row.pairs[side]].K
                    for j in range(6):
                        K[0, 6 + j] -= amount * f1 * gradient[6 * side + j]
            amount *= f
        work.loads[row.load] += amount
        if tangent and row.channel >= 0:
            work.channels[row.channel, :] = 0.0
            work.channels[row.channel, 0] = share


@dataclass(frozen=True, eq=False)
class Pressure(Force):
    """Apply a load shape of an elastic body times a function of time or of a joint; it turns with the body's material.

    A load shape is named where the body is reduced: ``reduction.reduce(fe, loads={"air": "upper_skin"})``. Its amount
    may be a table over the coordinate of a joint, times a signal: ``fmb.table([0, 0.3, 0.6], [2e3, 5e3, 9e3],
    of="hinge") * fmb.step(value=1.0, rise=0.1)`` is an airload that grows with the angle of the joint "hinge".
    Outside the table its first and last values hold.

    A positive pressure on a surface of a reduced body pushes onto it, against the outward normal; suction is negative.
    An `AncfPlate`, which has two sides, has "pressure" along its normal, and the dead loads "load_x", "load_y",
    "load_z" per area as drawn, in W; they depend on time only.

    Parameters
    ----------
    name : str
    load : str
        "body.load".
    amount : signal, Pa (or -)
        Pressure for a load made of a surface, factor for one made of forces: a number, a signal, a table over a
        joint, or a product of them. On a reduced body it may follow what is measured.
    freedom : str, optional
        Coordinate of the joint, where it has several: "turn", "turn_b", "slide", "slide_x" or "slide_y".
    """

    name: str
    _: KW_ONLY
    load: str
    amount: Any
    freedom: str | None = None

    table: ClassVar[Table] = Table("Pressure", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        if not isinstance(self.load, str) or "." not in self.load:
            raise ModelError(
                self.title, found=f"load = {self.load!r}", expected="'body.load'", remedy="Write load='flap.air'"
            )
        object.__setattr__(self, "amount", as_signal(self.amount, self.title, "amount"))
        object.__setattr__(self, "_joint", joint_of_tables(self, (self.amount,)))

    def check(self, model) -> None:
        """Raise ModelError if the body has no such load, or a joint does not exist."""
        name, _, load = self.load.partition(".")
        body = model.body(name, self.title)
        known = tuple(getattr(getattr(body, "data", body), "load_names", ()))
        if load not in known:
            raise ModelError(
                self.title,
                found=f"body '{name}' has no load '{load}'",
                expected=f"One of: {', '.join(known)}" if known else "a FloatingBody with load shapes, or an AncfPlate",
                remedy=did_you_mean(load, known) or "Name loads in reduction.reduce(..., loads={...})",
            )
        joint = self._joint  # type: ignore[attr-defined]
        if (joint is not None or self.amount.follows) and not hasattr(body, "data"):
            what = "that follows measurements" if joint is None else f"over joint '{joint}'"
            raise ModelError(
                self.title,
                found=f"an amount {what} on body '{name}' ({type(body).__name__})",
                expected="a signal of time: its load moves with the surface",
                remedy="Give a number, fmb.ramp(...) or fmb.table(..., of=fmb.ramp(...))",
            )
        if joint is not None:
            joint_coordinate(model.joint(joint, self.title), self.title, self.freedom)

    def travels(self, model):
        """Return the share that it has in a load that travels over a track of the body."""
        return travelling(self, model)

    def record(self, compiler):
        """Return the row."""
        body, _, load = self.load.partition(".")
        signal, table = signal_and_table(self.amount)
        row = {"load": compiler.load(body, load), "x": NO_COORDINATE, "table": -1, "pairs": (-1, -1), "channel": -1}
        if table is None and not signal.follows:
            none = dict.fromkeys(("shape", "eta", "turning", "own"), -1)
            return {**row, **none, "signal": compiler.signal(signal), "modes": 0}
        data = compiler.model.body(body).reduced
        number = data.load_names.index(load)
        turning = np.zeros((0, 0)) if data.load_turning is None else data.load_turning[number]
        own = compiler.load_marker(body, load)
        if table is not None:
            joint = compiler.joint(self._joint)
            x = joint_coordinate(joint, self.title, self.freedom).record(compiler, *map(compiler.marker, joint.markers))
            row["x"], row["table"] = x, compiler.bulk(table.numbers())
            row["pairs"] = compiler.pair(own, x["a"], STIFF), compiler.pair(own, x["b"], STIFF)
        row["signal"], (row["channel"],) = compiler.follow(signal, own)
        return {
            **row,
            "shape": compiler.bulk(data.load_shapes[number]),
            "modes": turning.shape[1],
            "eta": compiler.coordinate(body) + 7,
            "turning": compiler.bulk(turning),
            "own": own,
        }
