"""`Cam`: the profile that moves a follower by a given law, as the envelope of the follower seen from the cam."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import ModelError, did_you_mean
from flexmb.model.described import finite_array, is_number
from flexmb.profiles.pieces import Segments, cubics
from flexmb.profiles.profile import Profile
from flexmb.profiles.segments import LARGEST

__all__ = ["LAWS", "Cam"]


def _cycloidal(x):
    w = 2.0 * np.pi
    return x - np.sin(w * x) / w, 1.0 - np.cos(w * x), w * np.sin(w * x)


def _polynomial(x):
    return (
        x**3 * (10.0 + x * (-15.0 + 6.0 * x)),
        30.0 * x**2 * (1.0 - x) ** 2,
        60.0 * x * (1.0 - x) * (1.0 - 2.0 * x),
    )


def _harmonic(x):
    return 0.5 * (1.0 - np.cos(np.pi * x)), 0.5 * np.pi * np.sin(np.pi * x), 0.5 * np.pi**2 * np.cos(np.pi * x)


LAWS = {"cycloidal": _cycloidal, "polynomial": _polynomial, "harmonic": _harmonic}
"""Normalised laws of a rise: s, s', s'' over 0 <= x <= 1. "polynomial" is 10 x^3 - 15 x^4 + 6 x^5."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Cam(Profile):
    """A plate cam from the motion of its follower, while the cam turns counter-clockwise about the origin.

    The follower comes from above. A translating one moves along y, in a guide at x = `offset`; an oscillating one turns
    about `pivot`, and its lift is an angle, rad, counter-clockwise if the pivot is on the left. The profile is the
    envelope of the roller or the flat face in the axes of the cam at angle zero, as a periodic cubic spline through
    `count` places of it.

    Parameters
    ----------
    base_radius : float, m
        Least radius of the profile, on which the follower rests at lift zero.
    motion : list of (angle, lift, law)
        Up to which cam angle, rad, the follower moves to which lift, m (rad if it oscillates), by which law:
        "cycloidal", "polynomial" (3-4-5) or "harmonic". The last angle is a full turn, and its lift equals the first.
    roller : float, m
        Radius of the roller; 0 for a flat face.
    offset : float, m
        Of the guide of a translating roller from the axis.
    pivot : (2,), m, optional
        Of an oscillating follower.
    arm : float, m
        Of an oscillating follower: from the pivot to the roller.
    start : float, m or rad
        Lift at angle zero.
    count : int
        Number of places of the envelope through which the spline passes.

    Source: Norton, Cam Design and Manufacturing Handbook, 2nd ed., ch. 3 (laws), 13 (profiles).
    """

    base_radius: float
    motion: Any
    roller: float = 0.0
    offset: float = 0.0
    pivot: Any = None
    arm: float = 0.0
    start: float = 0.0
    count: int = 360

    def __post_init__(self):
        self.require_positive("base_radius")
        self.require_positive("roller", "arm", zero=True)
        _check_motion(self)
        if not is_number(self.count) or int(self.count) != self.count or not 16 <= self.count <= 5000:
            raise ModelError(
                self.title,
                found=f"count = {self.count!r}",
                expected="a whole number from 16 to 5000",
                remedy="Leave count out for 360 points",
            )
        for field in ("offset", "start"):
            if not is_number(getattr(self, field)) or abs(getattr(self, field)) > LARGEST:
                raise ModelError(
                    self.title, found=f"{field} = {getattr(self, field)!r}", expected="a number", remedy="Leave it out"
                )
        _check_follower(self)
        super().__post_init__()

    def lift(self, angle: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the lift at cam angles (n,), rad, and its first and second derivative by the angle."""
        angle = np.asarray(angle, float) % (2.0 * np.pi)
        s, d, dd = np.zeros((3, *angle.shape))
        begin, low = 0.0, float(self.start)
        for end, high, law in self.motion:
            inside = (angle >= begin) & (angle <= end)
            x = (angle[inside] - begin) / (end - begin)
            f, f1, f2 = LAWS[law](x)
            s[inside] = low + (high - low) * f
            d[inside] = (high - low) * f1 / (end - begin)
            dd[inside] = (high - low) * f2 / (end - begin) ** 2
            begin, low = end, high
        return s, d, dd

    def segments(self) -> tuple[Segments, bool]:
        """Return the cubics through points of the envelope."""
        angle = np.arange(int(self.count)) * 2.0 * np.pi / int(self.count)
        lift = self.lift(angle)
        points = _roller_envelope(self, angle, lift) if self.roller > 0.0 else _flat_envelope(self, angle, lift)
        back = points[::-1]  # seen from the cam, the follower goes round clockwise
        return cubics(np.vstack([back, back[:1]]), "periodic", self.title), True


def _turned(points: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return points (n, 2) turned by -angle (n,)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([c * points[:, 0] + s * points[:, 1], -s * points[:, 0] + c * points[:, 1]])


def _centers(cam: Cam, lift) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the places (n, 2) of the centre of the roller, their first and second derivatives by the cam angle."""
    s, d, dd = lift
    far, zero = cam.base_radius + cam.roller, np.zeros_like(s)
    if cam.pivot is None:
        high = (far**2 - cam.offset**2) ** 0.5
        return (
            np.column_stack([zero + cam.offset, high + s]),
            np.column_stack([zero, d]),
            np.column_stack([zero, dd]),
        )
    pivot, sense = np.array(cam.pivot), 1.0 if cam.pivot[0] < 0.0 else -1.0
    reach = float(np.hypot(*pivot))
    between = np.arccos((reach**2 + cam.arm**2 - far**2) / (2.0 * reach * cam.arm))
    a = np.arctan2(-pivot[1], -pivot[0]) + sense * (between + s)
    e, t = np.column_stack([np.cos(a), np.sin(a)]), np.column_stack([-np.sin(a), np.cos(a)])
    d, dd = sense * d[:, None], sense * dd[:, None]
    return pivot + cam.arm * e, cam.arm * t * d, cam.arm * (t * dd - e * d**2)


def _roller_envelope(cam: Cam, angle: np.ndarray, lift) -> np.ndarray:
    """Return the points of the profile inside the path of the roller; ModelError if the roller is too large for it."""
    P, P1, P2 = _centers(cam, lift)
    J = lambda x: np.column_stack([-x[:, 1], x[:, 0]])  # noqa: E731
    first = P1 - J(P)
    second = P2 - 2.0 * J(P1) - P
    speed = np.linalg.norm(first, axis=1)
    bend = -(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / speed**3  # positive: convex, walked clockwise
    worst = int(np.argmax(bend))
    if bend[worst] * cam.roller >= 1.0:
        raise ModelError(
            cam.title,
            found=f"a path of the roller with a radius of {1.0 / bend[worst]:.6g} m at {angle[worst]:.4g} rad, "
            f"and a roller of {cam.roller:.6g} m",
            expected="a roller smaller than that: the profile would be undercut",
            remedy="Make the roller smaller, or base_radius larger",
        )
    normal = -J(first) / speed[:, None]  # to the right of a clockwise walk: inwards
    return _turned(P + cam.roller * normal, angle)


def _flat_envelope(cam: Cam, angle: np.ndarray, lift) -> np.ndarray:
    """Return the points of the profile under a flat face; ModelError where it would have to be hollow."""
    s, d, dd = lift
    if cam.pivot is None:
        h, h1, h2 = cam.base_radius + s, d, dd
        n, n1, n2 = np.pi / 2.0 + 0.0 * s, 0.0 * s, 0.0 * s
    else:
        pivot, sense = np.array(cam.pivot), 1.0 if cam.pivot[0] < 0.0 else -1.0
        reach, across = float(np.hypot(*pivot)), float(np.arctan2(pivot[1], pivot[0]))
        # the face passes the pivot at `arm`; at lift zero it touches the base circle
        first = across - sense * np.arccos((cam.base_radius - cam.arm) / reach)
        n, n1, n2 = first + sense * s, sense * d, sense * dd
        h = cam.arm + reach * np.cos(n - across)
        h1 = -reach * np.sin(n - across) * n1
        h2 = -reach * (np.cos(n - across) * n1**2 + np.sin(n - across) * n2)
    # in the axes of the cam the normal is at n - angle, and h a function of it
    a1 = n1 - 1.0
    by, by2 = h1 / a1, (h2 * a1 - h1 * n2) / a1**3
    worst = int(np.argmin(h + by2))
    if np.any(a1 >= 0.0) or h[worst] + by2[worst] <= 0.0:
        raise ModelError(
            cam.title,
            found=f"a radius of curvature of {h[worst] + by2[worst]:.6g} m at {angle[worst]:.4g} rad",
            expected="a convex profile: a flat face does not reach into a hollow",
            remedy="Make base_radius larger, or the rise slower",
        )
    e, t = np.column_stack([np.cos(n), np.sin(n)]), np.column_stack([-np.sin(n), np.cos(n)])
    return _turned(h[:, None] * e + by[:, None] * t, angle)


def _check_motion(cam: Cam) -> None:
    """Raise ModelError unless the motion is a list of angle, lift and law over a full turn."""
    motion = cam.motion
    try:
        entries = tuple((float(angle), float(lift), law) for angle, lift, law in motion)
    except (TypeError, ValueError):
        entries = ()
    angles = [0.0, *(angle for angle, _, _ in entries)]
    if not entries or not np.all(np.isfinite(angles)) or np.any(np.diff(angles) <= 0.0):
        raise ModelError(
            cam.title,
            found=f"motion = {motion!r:.80}",
            expected="a list of (angle, lift, law) with growing angles",
            remedy='Write motion=[(2.0, 0.01, "cycloidal"), (6.2831853, 0.0, "polynomial")]',
        )
    most = max(abs(lift - cam.start) for _, lift, _ in entries)
    if abs(angles[-1] - 2.0 * np.pi) > 1e-6 or abs(entries[-1][1] - cam.start) > 1e-9 * most:
        raise ModelError(
            cam.title,
            found=f"a motion that ends at {angles[-1]:.6g} rad with the lift {entries[-1][1]:.6g}",
            expected=f"a full turn, 2 pi rad, and the lift of the start, {cam.start:.6g}",
            remedy="Add the last part of the turn",
        )
    for _, _, law in entries:
        if law not in LAWS:
            raise ModelError(
                cam.title,
                found=f"the law {law!r}",
                expected=f"One of: {', '.join(LAWS)}",
                remedy=did_you_mean(str(law), LAWS) or "Use 'cycloidal'",
            )
    entries = (*entries[:-1], (2.0 * np.pi, *entries[-1][1:]))
    object.__setattr__(cam, "motion", entries)


def _check_follower(cam: Cam) -> None:
    """Raise ModelError for a follower that does not reach the base circle."""
    far = cam.base_radius + cam.roller
    if cam.pivot is None:
        if abs(cam.offset) >= far or (cam.offset != 0.0 and cam.roller == 0.0) or cam.arm != 0.0:
            raise ModelError(
                cam.title,
                found=f"offset = {cam.offset!r} m, arm = {cam.arm!r} m",
                expected=f"an offset below {far:.6g} m for a roller, none for a flat face; an arm only with a pivot",
                remedy="Leave them out, or give a pivot",
            )
        return
    pivot = finite_array(cam.pivot)
    pivot = pivot if pivot.shape == (2,) else np.zeros(2)
    reach = float(np.hypot(*pivot))
    fits = abs(reach - cam.arm) < far < reach + cam.arm if cam.roller > 0.0 else abs(cam.base_radius - cam.arm) < reach
    if not fits or pivot[0] == 0.0:
        raise ModelError(
            cam.title,
            found=f"pivot = {cam.pivot!r}, arm = {cam.arm!r} m",
            expected=f"a pivot beside the cam whose arm reaches the circle of {far:.6g} m",
            remedy="Give the pivot as (x, y) in m and the arm from it to the roller",
        )
    object.__setattr__(cam, "pivot", tuple(pivot.tolist()))
