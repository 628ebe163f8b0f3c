"""Errors that turn the axis of a spinning body, and add up: the precession of a gyroscope at any rate of its spin.

The axis of a fast gyroscope moves slowly, and no step sees more of it than its tolerance. But the errors of that
motion point the same way in space in every step, while those of nutation and vibration turn, and cancel. So where they
add up they are compared with the motion of the axis itself in the step. With the spin w, the part a of the angular
acceleration across it and the error e of the rotation across it, the axis turns by ``a h / w`` in a step, of which
e must be a small part.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel
from flexmb.math.rotations import euler_to_matrix

__all__ = ["AXIS", "error_of_axes", "keep_axes", "new_axes"]

AXIS = 9
"""Numbers of a body: errors in W that have added up (3), the sum of their sizes, the rate of the axis, and of the last
step the error in W (3) and its rate."""
TURNS = 3.0
"""Turns of the spin after which an error is forgotten: one turn would leave what a vibration adds up to half of it."""
CANCEL = 4
"""Power by which the tolerance grows as errors cancel: a sum of a tenth of their sizes lets it be what it is anyway."""
WHOLE = 2.0
"""Tolerances of a step that errors of an axis may add up to over a run, however little it moves."""


def new_axes(program) -> np.ndarray:
    """Return the table of a run that begins: (frames, AXIS)."""
    return np.zeros((len(program.frames), AXIS))


@inner_kernel
def error_of_axes(frames, axes, q, u, a, d, extent, reach, tolerance, share, h, span):
    """Return the largest error of an axis in a step, relative to what it may be; it stands in `axes` for `keep_axes`.

    Parameters
    ----------
    frames : (n, 2 or more), places of the bodies' frames in q and u
    q, u, a : (nq,), (nu,), (nu,), at the end of the step, in body axes
    d : (nu,), error of the increment
    extent, reach : (nu,), see `flexmb.integrate.extent`
    tolerance : float, of a step
    share : float, of the motion of an axis that an error may be
    h, span : float, s, the step and the run
    """
    R, across = np.empty((3, 3)), np.empty((2, 3))
    worst = 0.0
    for n in range(len(frames)):
        k, x = frames[n, 1] + 3, axes[n]
        speed = (u[k] * u[k] + u[k + 1] * u[k + 1] + u[k + 2] * u[k + 2]) ** 0.5
        x[5], x[6], x[7], x[8] = 0.0, 0.0, 0.0, x[4]
        if speed == 0.0:
            continue
        error, acceleration = 0.0, 0.0
        for i in range(3):
            error += u[k + i] * d[k + i] / (speed * speed)
            acceleration += u[k + i] * a[k + i] / (speed * speed)
        size, rate, length = 0.0, 0.0, 0.0
        for i in range(3):
            across[0, i] = d[k + i] - error * u[k + i]
            across[1, i] = (a[k + i] - acceleration * u[k + i]) / speed
            size += across[0, i] * across[0, i]
            rate += across[1, i] * across[1, i]
            length = max(length, extent[k + i] / reach[k + i])
        size, rate = size**0.5, rate**0.5
        x[8] = rate
        euler_to_matrix(q[frames[n, 0] + 3 : frames[n, 0] + 7], R)
        added = 0.0
        for i in range(3):
            x[5 + i] = R[i, 0] * across[0, 0] + R[i, 1] * across[0, 1] + R[i, 2] * across[0, 2]
            added += (x[i] + x[5 + i]) ** 2
        added = added**0.5 / (x[3] + size) if x[3] + size > 0.0 else 0.0
        least = WHOLE * tolerance / length * h / span
        may = max(share * max(rate, x[4]) * h, least)
        if added > 0.0:
            worst = max(worst, size / may * added**CANCEL)
    return worst


@inner_kernel
def keep_axes(frames, axes, u, h):
    """Add the errors of a step that is accepted, which `error_of_axes` has left in `axes`."""
    for n in range(len(frames)):
        k, x = frames[n, 1] + 3, axes[n]
        speed = (u[k] * u[k] + u[k + 1] * u[k + 1] + u[k + 2] * u[k + 2]) ** 0.5
        kept = np.exp(-speed * h / (2.0 * np.pi * TURNS))
        size = (x[5] * x[5] + x[6] * x[6] + x[7] * x[7]) ** 0.5
        for i in range(3):
            x[i] = kept * x[i] + x[5 + i]
        x[3] = kept * x[3] + size
        x[4] = kept * x[4] + (1.0 - kept) * x[8] if x[4] > 0.0 else x[8]
