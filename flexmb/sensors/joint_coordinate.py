"""`JointCoordinate`: how far a joint has turned or slid."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.kinds import Sensor

__all__ = ["JointCoordinate"]

TURN = 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class JointCoordinate(Sensor):
    """Turn (rad) or slide (m) of a joint's second marker b relative to its first marker a, (nt,).

    The turn is ``theta = atan2(y_a . x_b, x_a . x_b)``, the angle from x of a to x of b about z of a, counted on
    through full turns; it starts in (-pi, pi]. The slide is ``z_a . (r_b - r_a)``.

    Full turns between two samples are counted with the relative angular velocity and acceleration at both,
    ``theta_1 - theta_0 = h (w_0 + w_1)/2 + h^2 (alpha_0 - alpha_1)/12``, so fast joints need no dense samples.

    Parameters
    ----------
    name : str
    joint : str
        Name of the joint.
    kind : "turn", "slide" or None
        None: the turn of joints that can turn, the slide of others.
    """

    _: KW_ONLY
    joint: str
    kind: str | None = None

    def __post_init__(self):
        super().__post_init__()
        if self.kind not in ("turn", "slide", None):
            raise ModelError(self.title, found=f"kind = {self.kind!r}", expected="'turn', 'slide' or nothing",
                             remedy="Leave kind away: it follows from the joint")

    def check(self, model) -> None:
        """Raise ModelError if the joint does not exist or neither turns nor slides."""
        self._kind(model)

    def markers_read(self, model) -> tuple[str, ...]:
        """Return the two markers of the joint."""
        return tuple(model.joint(self.joint, self.title).resolved_markers(model))

    def columns(self, model) -> tuple[str, ...]:
        """Return the title with the unit."""
        return ("angle [rad]",) if self._kind(model) == "turn" else ("displacement [m]",)

    def values(self, series) -> np.ndarray:
        """Return the coordinate (nt,), rad or m."""
        a, b = (series.marker(name) for name in self.markers_read(series.model))
        z = a.R[:, :, 2]
        if self._kind(series.model) == "slide":
            return np.einsum("ti,ti->t", z, b.r - a.r)
        x_b = b.R[:, :, 0]
        angle = np.arctan2(np.einsum("ti,ti->t", a.R[:, :, 1], x_b), np.einsum("ti,ti->t", a.R[:, :, 0], x_b))
        rate = np.einsum("ti,ti->t", z, b.w - a.w)
        second = np.einsum("ti,ti->t", z, b.alpha - a.alpha)
        return _unwrapped(series.t, angle, rate, second)

    def joined(self, pieces) -> np.ndarray:
        """Return the values of consecutive phases; an angle goes on counting from the end of the phase before."""
        pieces = [np.asarray(piece, float) for piece in pieces]
        for k in range(1, len(pieces)):
            before, now = pieces[k - 1][-1], pieces[k][0]
            if self.kind == "slide" or not np.isfinite(before - now):
                continue
            turns = np.round((before - now) / TURN)
            # an event does not move the joint: what is off by whole turns is an angle, anything else a displacement
            if abs(before - now - TURN * turns) < 1e-3 or self.kind == "turn":
                pieces[k] = pieces[k] + TURN * turns
        return np.concatenate(pieces)

    def _kind(self, model) -> str:
        joint = model.joint(self.joint, self.title)
        target = joint if joint.permits or not hasattr(joint, "joint") else model.joint(joint.joint, self.title)
        if self.kind is not None:
            return self.kind
        still, here = np.eye(3), np.zeros(3)
        twists = [freedom.twists(still, still, here) for freedom in target.permits]
        if not twists:
            raise ModelError(self.title,
                             found=f"joint '{self.joint}' ({type(joint).__name__}) neither turns nor slides",
                             expected="a joint that turns or slides",
                             remedy="Name another joint, or say kind='turn' or kind='slide'")
        return "turn" if np.any(np.vstack(twists)[:, 3:]) else "slide"


def _unwrapped(t, angle, rate, second):
    """Add to each step the number of full turns that velocity and acceleration tell."""
    h = np.diff(t)
    told = 0.5 * h * (rate[1:] + rate[:-1]) + h * h * (second[:-1] - second[1:]) / 12.0
    steps = np.diff(angle)
    steps = steps + TURN * np.round((told - steps) / TURN)
    return np.concatenate([angle[:1], angle[0] + np.cumsum(steps)])
