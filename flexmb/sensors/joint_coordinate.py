"""`JointCoordinate`: how far a joint has turned or slid."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np

from flexmb.constraints import Measured
from flexmb.constraints.coordinate import Coordinate
from flexmb.constraints.coordinate_kernels import FOLLOWED, joint_coordinate
from flexmb.errors import FlexmbError, ModelError
from flexmb.model.kinds import Sensor

__all__ = ["JointCoordinate"]

TURN = 2.0 * np.pi
DOUBTFUL = 0.25 * TURN
"""Difference between a turn and what velocities and accelerations tell of it, from which its full turns are a guess."""


@dataclass(frozen=True, eq=False)
class JointCoordinate(Sensor):
    """Turn (rad) or slide (m) of a joint's second marker b relative to its first marker a, (nt,).

    The turn is ``theta = atan2(y_a . x_b, x_a . x_b)``, the angle from x of a to x of b about z of a, counted on
    through full turns; it starts in (-pi, pi]. The slide is ``z_a . (r_b - r_a)``.

    Full turns are counted in every step of the integration (by the drive itself, where one prescribes the turn), so any
    samples will do. A sensor that the model did not have when it was simulated counts them from sample to sample, with
    the relative angular velocity and acceleration at both,
    ``theta_1 - theta_0 = h (w_0 + w_1)/2 + h^2 (alpha_0 - alpha_1)/12``. If that misses by a quarter of a turn or more,
    the samples are too far apart, which is an error.

    Parameters
    ----------
    name : str
    joint : str
        Name of the joint.
    kind : "turn", "slide" or None
        None: the turn of joints that can turn, the slide of others.
    freedom : "turn", "turn_b", "slide", "slide_x", "slide_y" or None
        Which one, for joints with several turns or slides, as in `Drive`; None: the first.
    """

    _: KW_ONLY
    joint: str
    kind: str | None = None
    freedom: str | None = None

    def __post_init__(self):
        super().__post_init__()
        if self.freedom is not None and self.kind is not None:
            raise ModelError(
                self.title,
                found=f"both kind = {self.kind!r} and freedom = {self.freedom!r}",
                expected="one of them",
                remedy="Omit kind: it follows from the freedom",
            )
        if self.kind not in ("turn", "slide", None):
            raise ModelError(
                self.title,
                found=f"kind = {self.kind!r}",
                expected="'turn', 'slide' or nothing",
                remedy="Omit kind: it follows from the joint",
            )

    def check(self, model) -> None:
        """Raise ModelError if the joint does not exist or neither turns nor slides."""
        self._kind(model)

    def markers_read(self, model) -> tuple[str, ...]:
        """Return the two markers of the joint."""
        return tuple(model.joint(self.joint, self.title).resolved_markers(model))

    def columns(self, model) -> tuple[str, ...]:
        """Return the title with the unit."""
        return ("angle [rad]",) if self._kind(model) == "turn" else ("displacement [m]",)

    def followed(self, compiler):
        """Return the row that counts the turns, unless the joint slides or a drive knows them."""
        coordinate, names = self._coordinate(compiler.model), self.markers_read(compiler.model)
        if coordinate.kind != "turn" or self._drive(compiler.model, coordinate, names) is not None:
            return []
        return [(FOLLOWED, coordinate.record(compiler, *map(compiler.marker, names), writes=0))]

    def measured(self, model) -> tuple[Measured, ...]:
        """Return the coordinate; turns are counted in every step."""
        return (Measured("coordinate", self.markers_read(model), coordinate=self._coordinate(model)),)

    def values(self, series) -> np.ndarray:
        """Return the coordinate (nt,), rad or m; FlexmbError if turns cannot be counted from sample to sample."""
        names = self.markers_read(series.model)
        coordinate = self._coordinate(series.model)
        a, b = (series.marker(name) for name in (names[::-1] if coordinate.swapped else names))
        axis = "xyz".index(coordinate.axis)
        if coordinate.kind == "slide":
            return np.einsum("ti,ti->t", a.R[:, :, axis], b.r - a.r)
        sign, z, e = -1.0 if coordinate.swapped else 1.0, a.R[:, :, 2], b.R[:, :, axis]
        angle = sign * np.arctan2(np.einsum("ti,ti->t", a.R[:, :, 1], e), np.einsum("ti,ti->t", a.R[:, :, 0], e))
        counted = self._counted(series, coordinate, names)
        if counted is not None:
            return angle + TURN * np.round((counted - angle) / TURN)
        rate = sign * np.einsum("ti,ti->t", z, b.w - a.w)
        second = sign * np.einsum("ti,ti->t", z, b.alpha - a.alpha)
        return self._unwrapped(series.t, angle, rate, second)

    def joined(self, pieces) -> np.ndarray:
        """Return the values of consecutive phases; an angle continues from the end of the phase before."""
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

    def _counted(self, series, coordinate, names):
        """Return the turn as a drive prescribes it, or as the integrator has counted it for a coupler or a
        force (nt,).
        """
        drive = self._drive(series.model, coordinate, names)
        if drive is not None:
            return drive.angle.sample(series.t)[:, 0]
        known, branch = series.system.branch_names, coordinate.branch(*names)
        if branch in known:
            # it belongs to the last iteration of a step, so only its turns are exact
            counted = series.phase.q[:, series.system.program.branches + known.index(branch) :][:, :1].ravel()
            return counted if len(counted) else None  # a stored run of a model without this sensor
        return None

    @staticmethod
    def _drive(model, coordinate, names):
        """Return the drive that prescribes the turn, or None."""
        for drive in model.turn_drives.get(names, ()):
            if joint_coordinate(model.joint(drive.joint), "", drive.freedom or "turn", "turn") == coordinate:
                return drive
        return None

    def _unwrapped(self, t, angle, rate, second):
        """Add to each step the number of full turns that velocity and acceleration tell."""
        h = np.diff(t)
        told = 0.5 * h * (rate[1:] + rate[:-1]) + h * h * (second[:-1] - second[1:]) / 12.0
        steps = np.diff(angle)
        steps = steps + TURN * np.round((told - steps) / TURN)
        doubtful = np.flatnonzero(np.abs(told - steps) > DOUBTFUL)
        if len(doubtful):
            k = doubtful[0]
            raise FlexmbError(
                self.title,
                found=f"samples at {t[k]:.6g} and {t[k + 1]:.6g} s, too far apart to count the turns between "
                f"them: {steps[k]:.3g} rad by the angles, {told[k]:.3g} rad by velocities and accelerations",
                expected="a count in every step, or closer samples",
                remedy="Add the sensor to the model before it is simulated, or take more samples",
            )
        return np.concatenate([angle[:1], angle[0] + np.cumsum(steps)])

    def _kind(self, model) -> str:
        return self._coordinate(model).kind

    def _coordinate(self, model) -> Coordinate:
        joint = model.joint(self.joint, self.title)
        target = joint if joint.permits or not hasattr(joint, "joint") else model.joint(joint.joint, self.title)
        if self.freedom is not None:
            return joint_coordinate(target, self.title, self.freedom)
        if self.kind is None and not target.permits:
            raise ModelError(
                self.title,
                found=f"joint '{self.joint}' ({type(joint).__name__}) neither turns nor slides",
                expected="a joint that turns or slides",
                remedy="Name another joint, or say kind='turn' or kind='slide'",
            )
        kind = self.kind or ("turn" if any(freedom.turns for freedom in target.permits) else "slide")
        first = [f for f in target.coordinates if f.word.startswith(kind)]
        # a joint may also be watched where it is stiff: about and along z of its first marker
        return first[0].coordinate if first else Coordinate(kind, "x" if kind == "turn" else "z")
