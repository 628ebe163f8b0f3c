"""`OneSidedSpring`: a roller on its track, a rope: a force in one sense only."""

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
from flexmb.model.described import is_number
from flexmb.model.table import Table

__all__ = ["OneSidedSpring"]

ROW = np.dtype(
    [
        ("x", COORDINATE),
        ("contact", float),  # m or rad, where the force begins
        ("sense", float),  # +1 pushes the markers apart, -1 pulls them together
        ("stiffness", float),  # N/m^p
        ("exponent", float),
        ("damping", float),  # N s/m
        ("depth", float),  # m
    ],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """F = k d^p + c w(d/depth) d' for an overlap d > 0, eq. (one-sided); zero otherwise."""
    rows = raw.view(ROW)
    gradient = np.empty(12)
    for n in range(rows.shape[0]):
        row = rows[n]
        x, rate = measure(row.x, state, work, gradient)
        p, speed = row.sense * (row.contact - x), -row.sense * rate
        if p <= 0.0:
            continue
        force, slope, damping, energy = one_sided(p, speed, row.stiffness, row.exponent, row.damping, row.depth)
        act(row.x, work, gradient, row.sense * force)
        work.energy[0].potential += energy
        work.energy[0].dissipation += (force - row.stiffness * p**row.exponent) * speed
        if work.weights[0].wanted == 1:
            add_tangent(row.x, work, gradient, row.sense * force, slope, damping)


@switch_kernel
def switch(raw, data, state, work, out):
    """The gap before the overlap begins."""
    rows = raw.view(ROW)
    gradient = np.empty(12)
    for n in range(rows.shape[0]):
        row, gap = rows[n], out[n]
        x, rate = measure(row.x, state, work, gradient)
        gap[:] = 0.0
        kind = TURN_GAP if row.x.kind == TURN else GAP
        gap[0], gap[1], gap[4], gap[9] = kind, row.sense * x, row.sense * rate, 1.0
        gap[7] = row.sense * row.contact


@dataclass(frozen=True, eq=False)
class OneSidedSpring(OnCoordinate):
    """Push with ``F = stiffness d^exponent + damping w d'`` for an overlap d > 0, and not at all otherwise.

    The overlap is ``d = length - backlash - x`` if the spring pushes (a roller between rails), ``d = x - length -
    backlash`` if it pulls (a rope), eq. (one-sided). x is the distance of two markers, their offset along an axis of
    the first, or a freedom of a joint. The force never changes its sign.

    Parameters
    ----------
    name : str
    markers : (str, str), optional
    joint : str, optional
        Instead of markers: the joint on whose freedom the spring acts.
    stiffness : float, N/m^p (N m/rad^p)
    exponent : float, -
        At least 1; 1.5 for Hertzian contact.
    damping : float, N s/m (N m s/rad)
    depth : float, m or rad
        Overlap at which the damping is complete: w(s) = s^2 (3 - 2 s), s = d/depth up to 1.
    length : float, m or rad, optional
        Where the overlap begins; by default x as described.
    backlash : float, m or rad
        Gap in addition.
    pulls : bool
        A rope instead of a roller.
    along : "line", "x", "y" or "z"
        Line between the markers, or an axis of the first marker.
    freedom : str, optional
        "slide", "turn", "slide_x", "slide_y" or "turn_b" of the joint; by default its first turn, else its slide.
    """

    name: str
    _: KW_ONLY
    markers: tuple[str, str] | None = None
    joint: str | None = None
    stiffness: float
    exponent: float = 1.5
    damping: float = 0.0
    depth: float = 1e-4
    length: float | None = None
    backlash: float = 0.0
    pulls: bool = False
    along: str = "line"
    freedom: str | None = None

    table: ClassVar[Table] = Table("OneSidedSpring", ROW, {"apply": apply, "switch": switch}, switches=1)
    strikes: ClassVar[bool] = True

    def __post_init__(self):
        super().__post_init__()
        self.require_place()
        self.require_positive("stiffness", "depth")
        self.require_positive("damping", "backlash", zero=True)
        check_number(self, "exponent", 1.0, "a number >= 1", "1 is a linear spring, 1.5 a Hertzian contact")
        if self.length is not None and not is_number(self.length):
            raise ModelError(
                self.title,
                found=f"length = {self.length!r}",
                expected="a finite number, m or rad",
                remedy="Leave length out: the contact then begins where the markers are",
            )

    def record(self, compiler):
        """Return the row with the place where the force begins."""
        begins = self.described(compiler) if self.length is None else self.length
        sense = -1.0 if self.pulls else 1.0
        return {"x": self.coordinate_row(compiler), "contact": begins - sense * self.backlash, "sense": sense}
