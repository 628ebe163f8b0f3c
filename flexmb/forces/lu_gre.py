"""`LuGre`: friction with the deflection of bristles as a state, on a freedom of a joint."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints.coordinate import COORDINATE
from flexmb.constraints.coordinate_kernels import act, add_tangent, measure
from flexmb.errors import ModelError
from flexmb.forces.on_coordinate import OnCoordinate
from flexmb.forces.with_states import add_state_tangent, state_pairs
from flexmb.math.states import add_rate, state_of
from flexmb.math.tables import row_kernel
from flexmb.model.described import is_number
from flexmb.model.table import Table

__all__ = ["LuGre"]

ROW = np.dtype(
    [
        ("x", COORDINATE),
        ("states", np.int64),
        ("pairs", np.int64, 2),  # of the joint's markers with the marker of the state
        ("stiffness", float),  # N/m or N m/rad
        ("damping", float),  # N s/m or N m s/rad
        ("viscous", float),  # N s/m or N m s/rad
        ("moving", float),  # N or N m
        ("standing", float),
        ("stribeck", float),  # m/s or rad/s
    ],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """F = -(s0 z + s1 z' + s2 v), z' = v - s0 |v| z / g(v), eq. (lugre)."""
    rows = raw.view(ROW)
    gradient = np.empty(12)
    for n in range(rows.shape[0]):
        row = rows[n]
        _, v = measure(row.x, state, work, gradient)
        z = state_of(work, row.states, 0)
        s = v / row.stribeck
        bell = (row.standing - row.moving) * np.exp(-s * s)
        level = row.moving + bell
        slip = row.stiffness * abs(v) / level
        rate = v - slip * z
        force = row.stiffness * z + row.damping * rate + row.viscous * v
        act(row.x, work, gradient, -force)
        add_rate(work, row.states, 0, rate)
        work.energy[0].potential += 0.5 * row.stiffness * z * z
        work.energy[0].dissipation += force * v - row.stiffness * z * rate
        if work.weights[0].wanted == 1:
            # d(rate)/dv: |v| has the slope sign(v), the level falls by 2 s / v_s of the bell
            by_v = 1.0 - row.stiffness * z / level * (np.sign(v) + abs(v) * 2.0 * s / row.stribeck * bell / level)
            add_tangent(row.x, work, gradient, -force, 0.0, row.damping * by_v + row.viscous)
            by_z = -(row.stiffness - row.damping * slip)
            add_state_tangent(row.pairs, work, gradient, 0, by_z, 0.0, by_v, -slip)


@dataclass(frozen=True, eq=False)
class LuGre(OnCoordinate):
    """Resist the motion of a joint by bristles that bend before they slip, eq. (lugre).

    ``F = stiffness z + damping z' + viscous v`` with the deflection z of the bristles, ``z' = v - stiffness |v| z /
    g(v)`` and ``g(v) = moving + (standing - moving) exp(-(v/stribeck)^2)``. Below the force of break-away the joint
    deflects as on a spring, holds without creeping, and comes back; `JointFriction` has no states and follows the
    joint's reaction, but creeps. In statics the deflection stays as it begins: at rest every one is in equilibrium.

    Parameters
    ----------
    name : str
    joint : str
        A joint that turns or slides.
    stiffness : float, N/m or N m/rad
        Of the bristles, sigma_0.
    damping : float, N s/m or N m s/rad
        Of the bristles, sigma_1. About sqrt(stiffness * mass) lets the presliding motion settle.
    viscous : float, N s/m or N m s/rad
        Friction that grows with the speed, sigma_2.
    moving : float, N or N m
        Friction at speed (Coulomb).
    standing : float, N or N m, optional
        Friction at rest; by default that at speed.
    stribeck : float, m/s or rad/s
        Speed at which the friction has fallen by 63 % of the difference.
    deflection : float, m or rad
        Of the bristles at the start. It is the state "deflection".
    freedom : str, optional
        "turn", "turn_b", "slide", "slide_x" or "slide_y", for joints with several; by default the first turn, else the
        slide.

    Source: Canudas de Wit, Olsson, Astrom & Lischinsky 1995, A new model for control of systems with friction, IEEE
    Transactions on Automatic Control 40, eq. 1 to 5.
    """

    name: str
    _: KW_ONLY
    joint: str
    stiffness: float
    damping: float = 0.0
    viscous: float = 0.0
    moving: float
    standing: float | None = None
    stribeck: float = 1e-3
    deflection: float = 0.0
    freedom: str | None = None

    table: ClassVar[Table] = Table("LuGre", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("stiffness", "moving", "stribeck")
        self.require_positive("damping", "viscous", zero=True)
        if self.standing is not None:
            self.require_positive("standing")
            if self.standing < self.moving:
                raise ModelError(
                    self.title,
                    found=f"standing = {self.standing} below moving = {self.moving}",
                    expected="friction at rest not below that at speed",
                    remedy="Exchange them",
                )
        longest = self.rest / self.stiffness
        if not is_number(self.deflection) or abs(self.deflection) > longest:
            raise ModelError(
                self.title,
                found=f"deflection = {self.deflection!r}",
                expected=f"a number up to standing / stiffness = {longest:.4g}: bristles slip beyond",
                remedy="Leave deflection out for 0",
            )

    @property
    def rest(self) -> float:
        """Return the friction at rest, N or N m."""
        return self.moving if self.standing is None else self.standing

    def record(self, compiler):
        """Return the row."""
        x = self.coordinate_row(compiler, counts=False)
        size = {"deflection": self.rest / self.stiffness}
        states = compiler.state_marker(self.title, {"deflection": self.deflection}, size)
        return {"x": x, "states": states, "pairs": state_pairs(compiler, x, states), "standing": self.rest}
