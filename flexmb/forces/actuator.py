"""`Actuator`: a given force or torque on a freedom of a joint."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.constraints.coordinates import COORDINATE, act, add_tangent, measure
from flexmb.forces.on_coordinate import OnCoordinate, checked_limits
from flexmb.math.tables import row_kernel
from flexmb.model.kinds import Table
from flexmb.model.signal import as_signal

__all__ = ["Actuator"]

ROW = np.dtype([("x", COORDINATE), ("signal", np.int64), ("lower", float), ("upper", float)], align=True)


@row_kernel
def apply(raw, data, state, work):
    """F = s(t) within its limits, along the freedom."""
    rows = raw.view(ROW)
    gradient = np.empty(12)
    for n in range(rows.shape[0]):
        row = rows[n]
        _, rate = measure(row.x, state, work, gradient)
        force = min(max(state.signals[row.signal, 0], row.lower), row.upper)
        act(row.x, work, gradient, force)
        work.energy[3] += force * rate
        if work.coefficients[3] > 0.0:
            add_tangent(row.x, work, gradient, force, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Actuator(OnCoordinate):
    """Drive a freedom of a joint with a given force or torque, positive in the positive sense of the freedom.

    It acts on the body of the second marker and back on that of the first: a motor with its stator. Where the motion is
    given, not the force, use `Drive`.

    Parameters
    ----------
    name : str
    joint : str
        A joint that turns or slides.
    effort : signal, N or N m
        Force of a slide, torque of a turn.
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
        object.__setattr__(self, "limits", checked_limits(self, "Write limits=(-200.0, 200.0)"))

    def record(self, compiler):
        """Return the row."""
        return (self.coordinate_row(compiler, counts=False), compiler.signal(self.effort),
                *(self.limits or (-np.inf, np.inf)))
