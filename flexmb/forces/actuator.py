"""`Actuator`: a given force or torque on a freedom of a joint."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.constraints.coordinate import COORDINATE
from flexmb.constraints.coordinate_kernels import act, add_tangent, measure
from flexmb.errors import ModelError
from flexmb.forces.on_coordinate import OnCoordinate, checked_limits, signal_and_table
from flexmb.math.jets import interpolate
from flexmb.math.tables import row_kernel
from flexmb.model.signal import as_signal
from flexmb.model.table import Table

__all__ = ["Actuator"]

ROW = np.dtype(
    [
        ("x", COORDINATE),
        ("signal", np.int64),
        ("channels", np.int64, 2),  # by which the wrenches on both markers change with the signal, or -1
        ("table", np.int64),  # where it begins in the bulk data, or -1
        ("lower", float),
        ("upper", float),
    ],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """F = s(t), or s(t) f(x), within its limits, along the freedom."""
    rows = raw.view(ROW)
    gradient = np.empty(12)
    for n in range(rows.shape[0]):
        row = rows[n]
        x, rate = measure(row.x, state, work, gradient)
        effort, slope, share = state.signals[row.signal, 0], 0.0, 1.0
        if row.table >= 0:
            f, f1, _ = interpolate(x, data[row.table :])
            slope, share = effort * f1, f
            effort *= f
        force = min(max(effort, row.lower), row.upper)
        if force != effort:
            slope = share = 0.0
        act(row.x, work, gradient, force)
        work.energy[0].load_power += force * rate
        if work.weights[0].wanted == 1:
            add_tangent(row.x, work, gradient, force, -slope, 0.0)
            for side in range(2):
                if row.channels[side] >= 0:
                    for i in range(6):
                        work.channels[row.channels[side], i] = share * gradient[6 * side + i]


@dataclass(frozen=True, eq=False)
class Actuator(OnCoordinate):
    """Drive a freedom of a joint with a given force or torque, positive in the positive sense of the freedom.

    The effort may be a table over the freedom itself, times a signal:
    ``fmb.table([0, 0.1, 0.3], [0, -200, -900], of="strut")`` is a spring with a bent characteristic. Outside the table
    its first and last values hold. It acts on the body of the second marker and reacts on the body of the first: a
    motor with its stator. Where the motion is given, not the force, use `Drive`.

    Parameters
    ----------
    name : str
    joint : str
        A joint that turns or slides.
    effort : signal, table over the joint, or a product of them; N or N m
        Force of a slide, torque of a turn. It may follow what is measured: a sensor, a formula, a controller.
    limits : (float, float), N or N m, optional
        Smallest and largest effort that the actuator can give.
    freedom : str, optional
        "turn", "turn_b", "slide", "slide_x" or "slide_y", for joints with several; by default the first turn, else the
        slide.
    """

    name: str
    _: KW_ONLY
    joint: str
    effort: Any
    limits: tuple[float, float] | None = None
    freedom: str | None = None

    table: ClassVar[Table] = Table("Actuator", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        object.__setattr__(self, "effort", as_signal(self.effort, self.title, "effort"))
        over = signal_and_table(self.effort)[1]
        if over is not None and getattr(over, "joint", None) != self.joint:
            raise ModelError(
                self.title,
                found=f"effort = {self.effort!r}",
                expected=f"a function of time, or one table over its own joint '{self.joint}'",
                remedy="A PointLoad may depend on another joint",
            )
        object.__setattr__(self, "limits", checked_limits(self, "Write limits=(-200.0, 200.0)"))

    def record(self, compiler):
        """Return the row."""
        signal, over = signal_and_table(self.effort)
        table = -1 if over is None else compiler.bulk(over.numbers())
        lower, upper = self.limits or (-np.inf, np.inf)
        x = self.coordinate_row(compiler, counts=over is not None)
        number, channels = compiler.follow(signal, x["a"], x["b"])
        return {"x": x, "signal": number, "channels": channels, "table": table, "lower": lower, "upper": upper}
