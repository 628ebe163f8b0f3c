"""`Motor`: a controlled drive of limited force or torque."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.constraints.coordinate import COORDINATE
from flexmb.constraints.coordinate_kernels import act, add_tangent, measure
from flexmb.errors import ModelError
from flexmb.forces.on_coordinate import OnCoordinate, checked_limits
from flexmb.math.tables import row_kernel
from flexmb.model.signal import as_signal
from flexmb.model.table import Table

__all__ = ["Motor"]

ROW = np.dtype(
    [
        ("x", COORDINATE),
        ("target", np.int64),  # signal
        ("rate", np.int64),  # signal of its rate, or -1: it is a function of time
        ("channels", np.int64, 4),  # by which the wrenches on both markers change with the target, and with its rate
        ("stiffness", float),  # N/m or N m/rad
        ("damping", float),  # N s/m or N m s/rad
        ("lower", float),  # N or N m
        ("upper", float),
    ],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """F = k (s - x) + c (s' - x') within its limits, eq. (motor)."""
    rows = raw.view(ROW)
    gradient = np.empty(12)
    for n in range(rows.shape[0]):
        row = rows[n]
        x, rate = measure(row.x, state, work, gradient)
        speed = state.signals[row.target, 1] if row.rate < 0 else state.signals[row.rate, 0]
        wanted = row.stiffness * (state.signals[row.target, 0] - x) + row.damping * (speed - rate)
        force = min(max(wanted, row.lower), row.upper)
        act(row.x, work, gradient, force)
        work.energy[0].load_power += force * rate
        if work.weights[0].wanted == 1:
            free = 1.0 if force == wanted else 0.0
            add_tangent(row.x, work, gradient, force, free * row.stiffness, free * row.damping)
            for k in range(4):
                if row.channels[k] >= 0:
                    share = free * (row.stiffness if k < 2 else row.damping)
                    for i in range(6):
                        work.channels[row.channels[k], i] = share * gradient[6 * (k % 2) + i]


@dataclass(frozen=True, eq=False)
class Motor(OnCoordinate):
    """Drive a freedom of a joint towards a given motion with a limited effort: a controlled motor, and its stalling.

    F = stiffness (s - x) + damping (s' - x') within the limits, with the given motion s(t), eq. (motor). Turns are
    counted through full turns. Where the motion is met exactly, whatever effort it takes, use `Drive`; where the effort
    is given, `Actuator`.

    Parameters
    ----------
    name : str
    joint : str
        A joint that turns or slides.
    target : signal, rad or m
        The wanted motion of the freedom. It may follow what is measured: a sensor, a formula, a controller.
    stiffness : float, N m/rad or N/m
        Effort per error of position.
    damping : float, N m s/rad or N s/m
        Effort per error of speed.
    rate : signal, rad/s or m/s
        Rate of the target, where this follows measurements and there is damping; 0.0 damps the motion itself.
    limits : (float, float), N m or N, optional
        Smallest and largest effort: the stall torque.
    freedom : str, optional
        "turn", "turn_b", "slide", "slide_x" or "slide_y", for joints with several; by default the first turn, else the
        slide.
    """

    name: str
    _: KW_ONLY
    joint: str
    target: Any
    stiffness: float
    damping: float = 0.0
    rate: Any = None
    limits: tuple[float, float] | None = None
    freedom: str | None = None

    table: ClassVar[Table] = Table("Motor", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("stiffness", "damping", zero=True)
        object.__setattr__(self, "target", as_signal(self.target, self.title, "target"))
        if self.rate is not None:
            object.__setattr__(self, "rate", as_signal(self.rate, self.title, "rate"))
        if (self.rate is None) == bool(self.target.follows and self.damping):
            raise ModelError(
                self.title,
                found=f"rate = {self.rate!r}, damping = {self.damping:g}, a target that "
                f"{'follows measurements' if self.target.follows else 'is a function of time'}",
                expected="the rate of a target that follows measurements, where there is damping; no other",
                remedy="Write rate=0.0 to damp the motion itself, or the rate of the target (measured(..., rate=True))",
            )
        object.__setattr__(self, "limits", checked_limits(self, "Write limits=(-250.0, 250.0)"))

    def record(self, compiler):
        """Return the row."""
        lower, upper = self.limits or (-np.inf, np.inf)
        x = self.coordinate_row(compiler)
        row = {"x": x, "lower": lower, "upper": upper, "rate": -1, "channels": (-1, -1, -1, -1)}
        if not self.target.follows:
            return {**row, "target": compiler.signal(self.target, rate=self.damping != 0.0)}
        target, channels = compiler.follow(self.target, x["a"], x["b"])
        if self.rate is None:
            return {**row, "target": target, "channels": (*channels, -1, -1)}
        rate, of_rate = compiler.follow(self.rate, x["a"], x["b"])
        return {**row, "target": target, "rate": rate, "channels": (*channels, *of_rate)}
