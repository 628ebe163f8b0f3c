"""`Pose`: a position and an orientation relative to a parent."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.math.rotations import rotation_matrix
from flexmb.model.described import Described, finite_array

__all__ = ["Pose", "as_pose", "rotation3", "vector3"]

ORTHOGONAL = 1e-9 + 1e-5 * np.eye(3)
"""How far R R^T may be from one: axes of the length of rounded numbers, perpendicular to the last digits."""


def vector3(value: Any, part: str, field: str, example: str = "(0.0, 0.0, 0.0)") -> tuple[float, float, float]:
    """Return `value` as three floats; ModelError naming part and field, with an example, otherwise."""
    if type(value) in (tuple, list) and len(value) == 3 and all(type(x) is float and isfinite(x) for x in value):
        return tuple(value)  # as most are: a large model has thousands, and an array of each takes ten times as long
    array = finite_array(value)
    if array.shape != (3,):
        raise ModelError(
            part,
            found=f"{field} = {value!r}",
            expected="three finite numbers (x, y, z)",
            remedy=f"Write {field} = {example}",
        )
    return float(array[0]), float(array[1]), float(array[2])


def rotation3(value: Any, part: str, field: str) -> np.ndarray:
    """Return a rotation as a matrix (3, 3); ModelError naming part and field if it is not a rotation."""
    if value is None:
        return np.eye(3)
    known = hasattr(value, "as_matrix") or finite_array(value).shape in ((3,), (3, 3))
    R = rotation_matrix(value) if known else np.zeros(0)
    if R.shape != (3, 3) or np.any(np.abs(R @ R.T - np.eye(3)) > ORTHOGONAL) or np.linalg.det(R) < 0.0:
        raise ModelError(
            part,
            found=f"{field} = {value!r} is not a right-handed orthogonal rotation",
            expected="a rotation vector (3,), a rotation matrix (3, 3) or a scipy Rotation",
            remedy="Use Pose.axes(at, x=..., z=...) to give two directions",
        )
    return R


@dataclass(frozen=True, eq=False)
class Pose(metaclass=Described):
    """Position and orientation of a marker or body in its parent's axes.

    Parameters
    ----------
    at : (3,), m
        Position in the parent's axes.
    rotation : (3,) rotation vector in rad, (3, 3) matrix, or scipy Rotation, optional
        Maps the marker's axes to the parent's axes. The z-axis is the axis of revolute, prismatic, cylindrical and
        screw joints and the normal of planar ones.

    Examples
    --------
    >>> hinge = Pose.axes((0.3, 0.0, 0.0), z=(0.0, 1.0, 0.0))
    >>> hinge.matrix[:, 2].tolist()
    [0.0, 1.0, 0.0]
    """

    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation: Any = None

    def __post_init__(self):
        object.__setattr__(self, "at", vector3(self.at, "Pose", "at"))
        rotation3(self.rotation, "Pose", "rotation")

    @property
    def matrix(self) -> np.ndarray:
        """Rotation matrix (3, 3), marker axes in the parent's axes."""
        return rotation_matrix(self.rotation)

    @staticmethod
    def axes(at=(0.0, 0.0, 0.0), *, x=None, y=None, z=None) -> Pose:
        """Make a pose from one or two directions of its axes in the parent's axes.

        The first given of z, x, y is kept exactly, the other is made perpendicular to it; with one direction only, the
        others are chosen.
        """
        given = [(k, np.array(vector3(d, "Pose", "xyz"[k]))) for k, d in ((2, z), (0, x), (1, y)) if d is not None]
        if not 1 <= len(given) <= 2:
            raise ModelError(
                "Pose.axes",
                found=f"{len(given)} directions",
                expected="one or two of x=, y=, z=",
                remedy="Give the main direction and one to fix the rotation about it",
            )
        (i, a), *rest = given
        if rest:
            j, b = rest[0]
        else:
            j, b = (i + 1) % 3, np.eye(3)[int(np.argmin(np.abs(a)))]
        if np.linalg.norm(a) == 0.0 or np.linalg.norm(np.cross(a, b)) < 1e-9 * np.linalg.norm(a) * np.linalg.norm(b):
            raise ModelError(
                "Pose.axes",
                found="directions that are zero or parallel",
                expected="two different directions",
                remedy="Give another second direction",
            )
        a = a / np.linalg.norm(a)
        b = b - a * (a @ b)
        R = np.empty((3, 3))
        R[:, i], R[:, j] = a, b / np.linalg.norm(b)
        k = 3 - i - j
        R[:, k] = np.cross(R[:, (k + 1) % 3], R[:, (k + 2) % 3])
        return Pose(at, R)


def as_pose(value: Any, part: str, field: str) -> Pose:
    """Return a Pose from a Pose, a bare 3-vector, or a mapping of its fields (at, rotation | x, y, z)."""
    if isinstance(value, Pose):
        return value
    if isinstance(value, dict):
        entries = dict(value)
        at = vector3(entries.pop("at", (0.0, 0.0, 0.0)), part, f"{field}.at")
        if set(entries) <= {"x", "y", "z"} and entries:
            return Pose.axes(at, **entries)
        if set(entries) <= {"rotation"}:
            return Pose(at, entries.get("rotation"))
        raise ModelError(
            part,
            found=f"{field} has the entries {', '.join(value)}",
            expected="at, and rotation or one or two of x, y, z",
            remedy="Remove the others",
        )
    return Pose(vector3(value, part, field))
