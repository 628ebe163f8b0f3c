"""Start values of bodies that have a frame: pose and twist in world axes, checked and turned into coordinates."""

from __future__ import annotations

import numpy as np

from flexmb.math.rotations import matrix_to_euler
from flexmb.model.pose import Pose, vector3

__all__ = ["check_frame", "frame_state"]


def check_frame(body) -> None:
    """Check `at`, `rotation`, `velocity` and `angular_velocity` of a description; store vectors as tuples of floats."""
    for field in ("at", "velocity", "angular_velocity"):
        object.__setattr__(body, field, vector3(getattr(body, field), body.title, field))
    object.__setattr__(body, "rotation", Pose(body.at, body.rotation).matrix)


def frame_state(body) -> tuple[np.ndarray, np.ndarray]:
    """Return (r, p) (7,) and (v, w) (6,) in body axes."""
    R = np.asarray(body.rotation)
    p = np.empty(4)
    matrix_to_euler(R, p)
    q = np.concatenate([body.at, p])
    u = np.concatenate([R.T @ np.array(body.velocity), R.T @ np.array(body.angular_velocity)])
    return q, u
