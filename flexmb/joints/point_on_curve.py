"""`PointOnCurve`: a point follows a track."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import Any

import numpy as np

from flexmb.constraints import OnCurve, OnTrace
from flexmb.errors import ModelError, did_you_mean
from flexmb.math.splines import pack_spline
from flexmb.model.kinds import Joint

__all__ = ["PointOnCurve"]

LARGEST = 1e30
"""Coordinate, m, beyond which the spline leaves the range of numbers."""


@dataclass(frozen=True, eq=False)
class PointOnCurve(Joint):
    """Keep marker b on a cubic spline that is fixed to the axes of marker a, eq. (on-curve).

    Two equations without a further unknown: the place on the curve is the one nearest to the point. It is found from
    where the point was before, so a track may cross itself. The body of marker a may be of any kind; a curve that
    deforms with it is `PointOnPath`.

    With `along`, the track is the surface that the curve sweeps along this axis of marker a: one equation, the point is
    free along the axis. The curve is then plane, across the axis.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a, in whose axes the curve is given; marker b, the point. Reactions are those on the body of marker b.
    curve : (n, 3), m
        Points of the curve, in axes of marker a.
    closed : bool
        The curve returns to its first point, which is given once.
    ends : "extend" or "error"
        Beyond the ends of an open curve: continue straight, or stop the simulation with an error.
    along : "x", "y" or "z", optional
        Sweep the curve along this axis.
    """

    _: KW_ONLY
    curve: Any
    closed: bool = False
    ends: str = "extend"
    along: str | None = None

    def __post_init__(self):
        super().__post_init__()
        try:
            points = np.asarray(self.curve, float)
        except (TypeError, ValueError, OverflowError):
            points = np.empty(0)
        if points.ndim != 2 or points.shape[1:] != (3,) or len(points) < 3 or not np.all(np.isfinite(points)):
            raise ModelError(
                self.title,
                found=f"a curve with the shape {points.shape}",
                expected="three or more points (n, 3), m",
                remedy="Give x, y, z of each point",
            )
        if np.abs(points).max() > LARGEST:
            raise ModelError(
                self.title,
                found=f"a curve with the coordinate {points.flat[np.abs(points).argmax()]:.3g} m",
                expected=f"coordinates up to {LARGEST:g} m",
                remedy="Correct the number",
            )
        if np.min(np.linalg.norm(np.diff(points, axis=0), axis=1)) == 0.0 or (
            self.closed and np.array_equal(points[0], points[-1])
        ):
            raise ModelError(
                self.title,
                found="two neighbouring points of the curve coincide",
                expected="points that differ",
                remedy="Leave repeated points out, also the last of a closed one",
            )
        if self.ends not in ("extend", "error"):
            raise ModelError(
                self.title,
                found=f"ends = {self.ends!r}",
                expected="'extend' or 'error'",
                remedy=did_you_mean(str(self.ends), ("extend", "error")) or "Leave ends out for 'extend'",
            )
        if self.along not in (None, "x", "y", "z"):
            raise ModelError(
                self.title,
                found=f"along = {self.along!r}",
                expected="'x', 'y' or 'z'",
                remedy="Name the axis of the first marker along which the track is free",
            )
        if self.along is not None and np.ptp(points[:, "xyz".index(self.along)]) > 1e-9 * np.ptp(points, axis=0).max():
            raise ModelError(
                self.title,
                found=f"a curve whose {self.along} varies",
                expected="a plane curve",
                remedy=f"Give all points the same {self.along}: the surface does not depend on it",
            )
        object.__setattr__(self, "curve", tuple(tuple(point) for point in points.tolist()))

    @cached_property
    def spline(self) -> np.ndarray:
        """Numbers of the curve, as kernels read them."""
        points = np.array(self.curve)
        if self.closed:
            points = np.vstack([points, points[0]])
        return pack_spline(points, self.closed, None if self.along is None else np.eye(3)["xyz".index(self.along)])

    def equations(self):
        """Return two equations, or the one of a swept curve."""
        axis = -1 if self.along is None else "xyz".index(self.along)
        kind = OnCurve if self.along is None else OnTrace
        return (kind(self.spline, self.closed, self.ends == "error", self.name, axis),)
