"""`Deflection`: how far a marker has moved away from its place in the undeformed body."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.constraints import Measured
from flexmb.errors import ModelError
from flexmb.math.rotations import euler_to_matrix
from flexmb.model.kinds import Sensor
from flexmb.sensors.flexible_coordinate import combined, reduced_data

__all__ = ["Deflection"]


@dataclass(frozen=True, eq=False)
class Deflection(Sensor):
    """Elastic displacement of a marker in body axes, (nt, 3), m.

    Without `relative_to` it is the displacement against the body frame, ``R^T (r_m - r) - s``. What that frame does
    depends on the body's data: clamped at an interface, or floating with the mean motion (Buckens). Against another
    marker f of the body, which carries its axes along: ``R_f0 R_f^T (r_m - r_f) - (s_m - s_f)`` with the undeformed
    axes R_f0, which is the same for every frame.

    Parameters
    ----------
    name : str
    marker : str
        "body.marker".
    relative_to : str, optional
        "body.marker" of the same body.
    """

    _: KW_ONLY
    marker: str
    relative_to: str | None = None

    titles: ClassVar[tuple[str, ...]] = ("dx [m]", "dy [m]", "dz [m]")

    def check(self, model) -> None:
        """Raise ModelError if a marker does not exist, is on another body, or the body has no axes of its own."""
        body, _ = model.marker(self.marker, self.title)
        if self.relative_to is not None:
            other, _ = model.marker(self.relative_to, self.title)
            if other.name != body.name:
                raise ModelError(
                    self.title,
                    found=f"'{self.marker}' and '{self.relative_to}' are on two bodies",
                    expected="two markers of one body",
                    remedy="Use Position for distances between bodies: deflection is measured within one",
                )
        elif not body.has_frame:
            raise ModelError(
                self.title,
                found=f"body '{body.name}' ({type(body).__name__}) has no axes of its own",
                expected="a rigid or floating body, or relative_to=",
                remedy=f"Give relative_to='{body.name}.<marker>', or use Position",
            )

    def doubt(self, model) -> str:
        """Return that the axes float, against which it is measured, of a body that a joint holds at the ground."""
        body, _ = model.marker(self.marker, self.title)
        if self.relative_to is not None or getattr(getattr(body, "data", None), "frame", "") != "buckens":
            return ""
        ends = [{m.partition(".")[0] for m in joint.resolved_markers(model)} for joint in model.joints]
        if {"ground", body.name} not in ends:
            return ""
        return (
            f"measured against axes that go with the mean motion of body '{body.name}', so it is not the sag between "
            f"supports, nor the way of an end; relative_to='{body.name}.<marker>' is against a marker, Position is in W"
        )

    def markers_read(self, model) -> tuple[str, ...]:
        """Return the marker, and the one it is compared with."""
        return (self.marker,) if self.relative_to is None else (self.marker, self.relative_to)

    def measured(self, model) -> tuple[Measured, ...]:
        """Return the three components, of a reduced body against its frame."""
        if self.relative_to is not None:
            raise ModelError(
                self.title,
                found="a Deflection relative to another marker, which cannot be measured while the motion is computed",
                expected="the deflection against the body's frame, or a StrainGauge",
                remedy="Leave relative_to out; with a frame clamped at that marker both are the same",
            )
        body, _, marker = self.marker.partition(".")
        data = reduced_data(model, body, self.title)
        return tuple(combined(body, row) for row in data.marker_translations[data.marker_names.index(marker)])

    def values(self, series) -> np.ndarray:
        """Return the displacement (nt, 3), m, in body axes."""
        body, pose = series.model.marker(self.marker)
        r, s = series.marker(self.marker).r, np.array(pose.at)
        if self.relative_to is None:
            q, _ = series.coordinates(body.name)
            R = np.empty((len(q), 3, 3))
            for k in range(len(q)):
                euler_to_matrix(q[k, 3:7], R[k])
            return np.einsum("tji,tj->ti", R, r - q[:, :3]) - s
        _, root = series.model.marker(self.relative_to)
        f = series.marker(self.relative_to)
        local = np.einsum("tji,tj->ti", f.R, r - f.r)
        return local @ root.matrix.T - (s - np.array(root.at))
