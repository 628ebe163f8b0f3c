"""Start values of bodies that have a frame: pose and twist in world axes, checked and turned into coordinates."""

from __future__ import annotations

import numpy as np

from flexmb.errors import ModelError
from flexmb.math.rotations import matrix_to_euler
from flexmb.model.described import is_number
from flexmb.model.pose import rotation3, vector3

__all__ = ["check_frame", "check_initial_strain", "frame_state"]

UNTURNED = np.eye(3)


def check_frame(body) -> None:
    """Check `at`, `rotation`, `velocity` and `angular_velocity` of a description; store vectors as tuples of floats."""
    for field in ("at", "velocity", "angular_velocity"):
        object.__setattr__(body, field, vector3(getattr(body, field), body.title, field))
    object.__setattr__(body, "rotation", rotation3(body.rotation, body.title, "rotation"))


def check_initial_strain(body) -> None:
    """Raise ModelError unless `initial_strain` of a description leaves lengths positive."""
    if not is_number(body.initial_strain) or not -1.0 < body.initial_strain < 1.0:
        raise ModelError(
            body.title,
            found=f"initial_strain = {body.initial_strain!r}",
            expected="a number between -1 and 1",
            remedy="Write initial_strain=1e-3 for 0.1 % stretch",
        )


def frame_state(body) -> tuple[np.ndarray, np.ndarray]:
    """Return (r, p) (7,) and (v, w) (6,) in body axes."""
    R = np.asarray(body.rotation)
    p = np.array([1.0, 0.0, 0.0, 0.0])
    if np.any(R != UNTURNED):  # a model drawn in the axes of W does not wait for this kernel
        matrix_to_euler(R, p)
    q = np.concatenate([body.at, p])
    u = np.concatenate([R.T @ np.array(body.velocity), R.T @ np.array(body.angular_velocity)])
    return q, u
