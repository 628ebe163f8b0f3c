"""Translation of frames in world axes within a step: the group R^3 x SO(3) (Brüls, Cardona & Arnold 2012, section 2).

A frame that travels while it spins has a velocity that changes slowly in W and rotates in its own axes. A frame that
turns about a fixed pin has a constant velocity in its own axes, which rotates in W. A step resolves what changes.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.kernel_on_demand import kernel_on_demand
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.structures import array_type
from flexmb.math.tables import FLOATS, INTEGERS, void
from flexmb.model.model import GROUND

__all__ = ["frames_in_world_axes", "move", "to_body_axes", "to_increment", "to_world_axes", "turn"]


def frames_in_world_axes(system) -> np.ndarray:
    """Return the frames (n, 2) whose translation is integrated in world axes: of bodies that no joints hold to the
    ground.

    A joint that rolls holds nothing: its wheel travels.
    """
    level, frames = system.program.equation_level, system.program.frames
    joins: dict[str, list[str]] = {}
    for joint in system.joints:
        levels = level[system.joint_equations[joint.name]]
        if len(levels) and not np.any(levels == 1):
            a, b = (marker.split(".")[0] for marker in joint.markers)
            joins.setdefault(a, []).append(b)
            joins.setdefault(b, []).append(a)
    held, waiting = {GROUND}, [GROUND]
    while waiting:
        for body in joins.get(waiting.pop(), ()):
            if body not in held:
                held.add(body)
                waiting.append(body)
    travelling = {slices[1].start for name, slices in system.body_slices.items() if name not in held}
    return frames[[int(iu) in travelling for iu in frames[:, 1]]]


@kernel
def turn(frames, q, x):
    """Turn the translations of `x` (nu,) from body axes to W, in place."""
    if len(frames) > 0:
        _turn_some(frames, q, x)


@kernel_on_demand(void, array_type(INTEGERS, 2), array_type(FLOATS), array_type(FLOATS))
def _turn_some(frames, q, x):
    """Do what `turn` does for the frames (n, 2)."""
    R = np.empty((3, 3))
    for n in range(len(frames)):
        iq, iu = frames[n, 0], frames[n, 1]
        euler_to_matrix(q[iq + 3 : iq + 7], R)
        x0, x1, x2 = x[iu], x[iu + 1], x[iu + 2]
        for i in range(3):
            x[iu + i] = R[i, 0] * x0 + R[i, 1] * x1 + R[i, 2] * x2


@kernel
def to_world_axes(frames, q, u, a):
    """Turn velocities and accelerations (nu,) from body axes to W, in place: v_W = R v, v_W' = R (v' + w x v)."""
    for n in range(len(frames)):
        iu = frames[n, 1]
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            a[iu + i] += u[iu + 3 + j] * u[iu + k] - u[iu + 3 + k] * u[iu + j]
    turn(frames, q, u)
    turn(frames, q, a)


@kernel
def to_body_axes(frames, q, u, a, body_u, body_a):
    """Write velocities and accelerations in body axes: v = R^T v_W, v' = R^T v_W' - w x v."""
    for i in range(len(u)):
        body_u[i] = u[i]
        body_a[i] = a[i]
    if len(frames) > 0:
        _turn_back(frames, q, u, a, body_u, body_a)


@kernel_on_demand(void, array_type(INTEGERS, 2), *[array_type(FLOATS)] * 5)
def _turn_back(frames, q, u, a, body_u, body_a):
    """Write what `to_body_axes` writes of the frames (n, 2)."""
    R = np.empty((3, 3))
    for n in range(len(frames)):
        iq, iu = frames[n, 0], frames[n, 1]
        euler_to_matrix(q[iq + 3 : iq + 7], R)
        for i in range(3):
            body_u[iu + i] = R[0, i] * u[iu] + R[1, i] * u[iu + 1] + R[2, i] * u[iu + 2]
            body_a[iu + i] = R[0, i] * a[iu] + R[1, i] * a[iu + 1] + R[2, i] * a[iu + 2]
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            body_a[iu + i] -= u[iu + 3 + j] * body_u[iu + k] - u[iu + 3 + k] * body_u[iu + j]


@kernel
def move(frames, q, dx, out):
    """Write the translations of the configuration after the increment `dx` (nu,)."""
    for n in range(len(frames)):
        iq, iu = frames[n, 0], frames[n, 1]
        for i in range(3):
            out[iq + i] = q[iq + i] + dx[iu + i]


@inner_kernel
def to_increment(frames, world, q, dx, x):
    """Turn the correction `x` from a variation at the end of the step, in body axes, to one of the increment `dx`."""
    known = 0
    for n in range(len(frames)):
        # inverse tangent of the exponential, second order
        k = frames[n, 1]
        x0, x1, x2, y0, y1, y2 = x[k], x[k + 1], x[k + 2], x[k + 3], x[k + 4], x[k + 5]
        d = dx[k : k + 6]
        if known < len(world) and world[known, 1] == k:
            known += 1
        else:
            x[k] += 0.5 * (d[4] * x2 - d[5] * x1 + d[1] * y2 - d[2] * y1)
            x[k + 1] += 0.5 * (d[5] * x0 - d[3] * x2 + d[2] * y0 - d[0] * y2)
            x[k + 2] += 0.5 * (d[3] * x1 - d[4] * x0 + d[0] * y1 - d[1] * y0)
        x[k + 3] += 0.5 * (d[4] * y2 - d[5] * y1)
        x[k + 4] += 0.5 * (d[5] * y0 - d[3] * y2)
        x[k + 5] += 0.5 * (d[3] * y1 - d[4] * y0)
    turn(world, q, x)
