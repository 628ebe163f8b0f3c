"""`JointFriction`: Coulomb and Stribeck friction in a joint, regularised."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.constraints.coordinate import COORDINATE, TURN
from flexmb.constraints.coordinate_kernels import act, add_tangent, measure
from flexmb.errors import ModelError
from flexmb.forces.on_coordinate import OnCoordinate
from flexmb.math.kernel import inner_kernel
from flexmb.math.switches import SLIP, switch_kernel
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import dot
from flexmb.model.signal import as_signal
from flexmb.model.table import Table

__all__ = ["JointFriction"]

SLIGHT = 1e-6
"""Of a multiplier, the share across the axis from which on it presses."""
ROW = np.dtype(
    [
        ("x", COORDINATE),
        ("moving", float),  # coefficients of friction
        ("standing", float),
        ("stribeck", float),  # m/s or rad/s
        ("transition", float),  # m/s or rad/s
        ("radius", float),  # m; 1 for a slide
        ("preload", np.int64),  # signal, N
        ("equation", np.int64),  # of the joint
        ("equations", np.int64),
        ("second", np.int64),  # marker b of the joint
    ],
    align=True,
)


@inner_kernel
def _normal_force(row, work, normal, along):
    """Write the joint's force on marker b across the axis `along` to `normal` and return its size."""
    for i in range(3):
        normal[i] = 0.0
    for k in range(row.equations):
        equation = work.equations[row.equation + k]
        for m in range(equation.legs):
            leg = work.legs[equation.leg + m]
            if leg.marker == row.second:
                for i in range(3):
                    normal[i] += leg.gradient[i] * equation.force
    axial = dot(normal, along)
    for i in range(3):
        normal[i] -= axial * along[i]
    return dot(normal, normal) ** 0.5


@inner_kernel
def _add_push(row, work, normal, gradient, slope):
    """Add the derivative of the wrenches by the joint's multipliers; `slope` = dF/dN, `normal` a unit vector."""
    for k in range(row.equations):
        equation = work.equations[row.equation + k]
        change = 0.0
        for m in range(equation.legs):
            leg = work.legs[equation.leg + m]
            if leg.marker == row.second:
                change += slope * dot(leg.gradient[0:3], normal)
        for m in range(equation.legs):
            leg = work.legs[equation.leg + m]
            first = 0 if leg.marker == row.x.a else 6
            for i in range(6):
                leg.push[i] += gradient[first + i] * change


@row_kernel
def apply(raw, data, state, work):
    """F = -mu(v) N r tanh(v / v_t), mu(v) = mu_k + (mu_s - mu_k) exp(-(v / v_s)^2), eq. (friction)."""
    rows = raw.view(ROW)
    gradient = np.empty(12)
    normal = np.empty(3)
    for n in range(rows.shape[0]):
        row = rows[n]
        _, v = measure(row.x, state, work, gradient)
        axis = 2 if row.x.kind == TURN else row.x.axis
        reaction = _normal_force(row, work, normal, work.markers[row.x.a].R[:, axis])
        load = (abs(state.signals[row.preload, 0]) + reaction) * row.radius
        s = v / row.stribeck
        bell = (row.standing - row.moving) * np.exp(-s * s)
        t = np.tanh(v / row.transition)
        mu = row.moving + bell
        act(row.x, work, gradient, -mu * load * t)
        work.energy[0].dissipation += mu * load * t * v
        if work.weights[0].wanted == 1:
            slope = mu * (1.0 - t * t) / row.transition - 2.0 * bell * s / row.stribeck * t
            add_tangent(row.x, work, gradient, -mu * load * t, 0.0, load * slope)
            if reaction > 0.0:
                for i in range(3):
                    normal[i] /= reaction
                _add_push(row, work, normal, gradient, -mu * t * row.radius)


@switch_kernel
def switch(raw, data, state, work, out):
    """The speed of the joint."""
    rows = raw.view(ROW)
    gradient = np.empty(12)
    for n in range(rows.shape[0]):
        row, slip = rows[n], out[n]
        _, v = measure(row.x, state, work, gradient)
        slip[:] = 0.0
        slip[0], slip[4], slip[8] = SLIP, v, row.transition


@dataclass(frozen=True, eq=False)
class JointFriction(OnCoordinate):
    """Resist the motion of a joint with ``mu(v) N r tanh(v / transition)``, eq. (friction).

    The normal force N is `preload` plus, unless `from_reaction` is off, the size of the joint's reaction force across
    its axis. The coefficient falls from `standing` to `moving` with growing speed (Stribeck). The regularisation lets
    the joint creep with a fraction of `transition` where it should stick: choose it below the speeds of interest.

    Parameters
    ----------
    name : str
    joint : str
        A joint that turns or slides.
    moving : float, -
        Coefficient of friction at speed.
    standing : float, -, optional
        Coefficient of friction at rest; by default that at speed.
    stribeck : float, m/s or rad/s
        Speed at which the coefficient has fallen by 63 % of the difference.
    transition : float, m/s or rad/s
        Speed at which the friction has reached 76 % of its full size.
    preload : signal, N
        Normal force in addition to the reaction (a seal, a clamp).
    radius : float, m, optional
        Lever of the friction force: needed where the joint turns.
    from_reaction : bool
        Count the reaction of the joint.
    freedom : str, optional
        "turn", "turn_b", "slide", "slide_x" or "slide_y", for joints with several; by default the first turn, else the
        slide.

    Source: Armstrong-Helouvry, Dupont & Canudas de Wit 1994, eq. 4 (Gaussian model), with tanh for the sign.
    """

    name: str
    _: KW_ONLY
    joint: str
    moving: float
    standing: float | None = None
    stribeck: float = 0.01
    transition: float = 1e-3
    preload: Any = 0.0
    radius: float | None = None
    from_reaction: bool = True
    freedom: str | None = None

    reads_reactions: ClassVar[bool] = True
    table: ClassVar[Table] = Table("JointFriction", ROW, {"apply": apply, "switch": switch}, switches=1)

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("moving", zero=True)
        self.require_positive("stribeck", "transition")
        for field in ("standing", "radius"):
            if getattr(self, field) is not None:
                self.require_positive(field)
        if self.standing is not None and self.standing < self.moving:
            raise ModelError(
                self.title,
                found=f"standing = {self.standing} below moving = {self.moving}",
                expected="friction at rest not below that at speed",
                remedy="Exchange them",
            )
        object.__setattr__(self, "preload", as_signal(self.preload, self.title, "preload"))

    def check(self, model) -> None:
        """Raise ModelError if the joint has no such freedom, or turns and the radius is missing."""
        super().check(model)
        coordinate, _ = self.place(model)
        if coordinate.kind == "turn" and self.radius is None:
            raise ModelError(
                self.title,
                found=f"no radius, but joint '{self.joint}' turns",
                expected="the radius of the bearing, m",
                remedy="Write radius=0.02",
            )

    def slip_unit(self, model) -> str:
        """Return the unit of the joint's coordinate."""
        return "rad" if self.place(model)[0].kind == "turn" else "m"

    def feels(self, system, work, equation: int) -> bool:
        """Is it an equation that presses across the axis? Moments and forces along it do not count."""
        coordinate, (first, second) = self.place(system.model)
        axis = work.markers[system.marker_index[first]]["R"][:, 2 if coordinate.kind == "turn" else coordinate.axis]
        row, number = work.equations[equation], system.marker_index[second]
        legs = work.legs[row["leg"] : row["leg"] + row["legs"]]
        presses = [leg["gradient"][:3] for leg in legs if leg["marker"] == number]
        across = [np.linalg.norm(force - axis * (axis @ force)) > SLIGHT * np.linalg.norm(force) for force in presses]
        return self.from_reaction and any(across)

    def record(self, compiler):
        """Return the row."""
        coordinate, markers = self.place(compiler.model)
        x = coordinate.record(compiler, *(compiler.marker(m) for m in markers), counts=False)
        span = compiler.equations[self.joint] if self.from_reaction else slice(0, 0)
        radius = self.radius if coordinate.kind == "turn" else 1.0
        standing = self.moving if self.standing is None else self.standing
        return {
            "x": x,
            "standing": standing,
            "radius": radius,
            "preload": compiler.signal(self.preload),
            "equation": span.start,
            "equations": span.stop - span.start,
            "second": compiler.marker(markers[1]),
        }
