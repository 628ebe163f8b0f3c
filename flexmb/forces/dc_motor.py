"""`DcMotor`: a motor with brushes behind a gear, its current a state, on a freedom of a joint."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.constraints.coordinate import COORDINATE
from flexmb.constraints.coordinate_kernels import act, add_tangent, measure
from flexmb.errors import ModelError
from flexmb.forces.on_coordinate import OnCoordinate
from flexmb.forces.with_states import add_state_tangent, state_pairs
from flexmb.math.states import add_rate, state_of
from flexmb.math.tables import row_kernel
from flexmb.model.described import is_number
from flexmb.model.signal import as_signal
from flexmb.model.table import Table

__all__ = ["DcMotor"]

ROW = np.dtype(
    [
        ("x", COORDINATE),
        ("states", np.int64),
        ("pairs", np.int64, 2),  # of the joint's markers with the marker of the state
        ("voltage", np.int64),  # signal, V
        ("channel", np.int64),  # by which the rate of the current changes with the voltage, or -1
        ("resistance", float),  # ohm
        ("inductance", float),  # H
        ("effort", float),  # N m/A or N/A at the joint, and V s/rad or V s/m
    ],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """F = n k i, L i' = V - R i - n k x', eq. (dc-motor)."""
    rows = raw.view(ROW)
    gradient = np.empty(12)
    for n in range(rows.shape[0]):
        row = rows[n]
        _, rate = measure(row.x, state, work, gradient)
        current, voltage = state_of(work, row.states, 0), state.signals[row.voltage, 0]
        force = row.effort * current
        act(row.x, work, gradient, force)
        add_rate(work, row.states, 0, (voltage - row.resistance * current - row.effort * rate) / row.inductance)
        work.energy[0].load_power += voltage * current
        work.energy[0].potential += 0.5 * row.inductance * current * current
        work.energy[0].dissipation += row.resistance * current * current
        if work.weights[0].wanted == 1:
            add_tangent(row.x, work, gradient, force, 0.0, 0.0)
            by_speed, by_current = -row.effort / row.inductance, -row.resistance / row.inductance
            add_state_tangent(row.pairs, work, gradient, 0, row.effort, 0.0, by_speed, by_current)
            if row.channel >= 0:
                work.channels[row.channel, 0] = 1.0 / row.inductance


@dataclass(frozen=True, eq=False)
class DcMotor(OnCoordinate):
    """Drive a freedom of a joint by a motor with winding and gear that a voltage feeds, eq. (dc-motor).

    The winding has L i' = V - R i - k w, the motor turns ``ratio`` times as fast as the joint, w = ratio x', and the
    joint feels ratio k i. The current i is the state "current". The magnetic energy counts as potential energy, V i as
    the power of loads. Gear and bearings are without friction (`JointFriction`, `LuGre`); the inertia of the rotor is
    that of a body: add ``ratio**2`` times it to the inertia of the driven body about the axis, or describe the rotor
    with a `GearPair`.

    Parameters
    ----------
    name : str
    joint : str
        A joint that turns or slides.
    voltage : signal, V
        It may follow what is measured: a sensor, a formula, a controller.
    resistance : float, ohm
    inductance : float, H
    constant : float, N m/A (V s/rad)
        Of the motor, k: torque per current and voltage per speed, which are the same number.
    ratio : float, -; rad/m where the joint slides
        Of the gear, turns of the motor per turn of the joint; negative where the gear changes the sense.
    current : float, A
        At the start.
    freedom : str, optional
        "turn", "turn_b", "slide", "slide_x" or "slide_y", for joints with several; by default the first turn, else the
        slide.

    Source: Franklin, Powell & Emami-Naeini 2019, Feedback control of dynamic systems, section 2.3.
    """

    name: str
    _: KW_ONLY
    joint: str
    voltage: Any
    resistance: float
    inductance: float
    constant: float
    ratio: float = 1.0
    current: float = 0.0
    freedom: str | None = None

    table: ClassVar[Table] = Table("DcMotor", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("resistance", "inductance", "constant")
        for field in ("ratio", "current"):
            value = getattr(self, field)
            if not is_number(value) or (field == "ratio" and value == 0.0):
                raise ModelError(
                    self.title,
                    found=f"{field} = {value!r}",
                    expected="a finite number" + (" that is not 0" if field == "ratio" else ", A"),
                    remedy=f"Leave {field} out for " + ("a motor without a gear" if field == "ratio" else "0 A"),
                )
        object.__setattr__(self, "voltage", as_signal(self.voltage, self.title, "voltage"))

    def record(self, compiler):
        """Return the row."""
        x = self.coordinate_row(compiler, counts=False)
        states = compiler.state_marker(self.title, {"current": self.current})
        number, (channel,) = compiler.follow(self.voltage, states)
        return {
            "x": x,
            "states": states,
            "pairs": state_pairs(compiler, x, states),
            "voltage": number,
            "channel": channel,
            "effort": self.ratio * self.constant,
        }
