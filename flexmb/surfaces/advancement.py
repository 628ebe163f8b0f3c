"""Continuous detection: when two surfaces first touch on the way from one pose to another.

Between the ends of a step d follows the cubic through its values and rates, and b turns about one axis at one rate. A
gap closes no faster than the fastest point moves, so from a gap g the step is free for g / L of its length, L being the
way of the fastest point: conservative advancement. Source: Mirtich 1996, Impulse-based Dynamic Simulation, section 3.3;
Ericson, Real-Time Collision Detection, section 5.5.5 (intervals of motion).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import dot
from flexmb.surfaces.detection import bound_gap, find_closest, nearest_sample
from flexmb.surfaces.records import FAR, REACH, THICKNESS

__all__ = ["POSE", "first_touch", "part_within"]

POSE = 10
"""Where in a row of switches d, d', w (3 each) and Q (9) stand."""
FINEST = 1e-3
"""Way, in radii of the smaller surface, that is not resolved further."""
MOST = 20_000
"""Gaps that are computed in a step; what is left is for the next one."""
NEVER = 2.0
ROOM = 0.25
"""Way of what touches, in thicknesses of the thinner surface, that a step may lead on: the forces in it see both sides
of a plate otherwise, or none."""


@inner_kernel
def _turn_between(before, after, axis):
    """Write the rotation vector, in the axes of a, that turns Q before into Q after."""
    M = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            for k in range(3):
                M[i, j] += after[3 * i + k] * before[3 * j + k]
    axis[0], axis[1], axis[2] = M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1]
    sine = 0.5 * dot(axis, axis) ** 0.5
    angle = np.arctan2(sine, 0.5 * (M[0, 0] + M[1, 1] + M[2, 2] - 1.0))
    for i in range(3):
        axis[i] *= 0.5 * angle / sine if sine > 1e-12 else 0.5


@inner_kernel
def _pose(a, b, h, s, turn, d, Q):
    """Write the pose at the part s of a step."""
    s2, s3 = s * s, s * s * s
    p, q = 1.0 - 3.0 * s2 + 2.0 * s3, 3.0 * s2 - 2.0 * s3
    m, n = s - 2.0 * s2 + s3, s3 - s2
    for i in range(3):
        d[i] = p * a[POSE + i] + q * b[POSE + i] + h * (m * a[POSE + 3 + i] + n * b[POSE + 3 + i])
    angle = dot(turn, turn) ** 0.5
    e = np.empty(3)
    for i in range(3):
        e[i] = turn[i] / angle if angle > 0.0 else 0.0
    c, sine = np.cos(s * angle), np.sin(s * angle)
    for j in range(3):
        along = 0.0
        for i in range(3):
            along += e[i] * a[POSE + 9 + 3 * i + j]
        for i in range(3):
            k, r = (i + 1) % 3, (i + 2) % 3
            x = a[POSE + 9 + 3 * i + j]
            crossed = e[k] * a[POSE + 9 + 3 * r + j] - e[r] * a[POSE + 9 + 3 * k + j]
            Q[i, j] = c * x + sine * crossed + (1.0 - c) * along * e[i]


@inner_kernel
def _ways(a, b, h, turn, reach_a, reach_b, way):
    """Write the control points of d' h (3, 3); return how far a point of one surface turns relative to the other."""
    far = 0.0
    for i in range(3):
        between = 3.0 * (b[POSE + i] - a[POSE + i]) - h * (a[POSE + 3 + i] + b[POSE + 3 + i])
        way[0, i], way[1, i], way[2, i] = h * a[POSE + 3 + i], between, h * b[POSE + 3 + i]
    for k in range(3):
        far = max(far, dot(way[k], way[k]) ** 0.5)
    arm = max(dot(a[POSE : POSE + 3], a[POSE : POSE + 3]), dot(b[POSE : POSE + 3], b[POSE : POSE + 3])) ** 0.5
    return dot(turn, turn) ** 0.5 * min(reach_b, reach_a + arm + far)


@kernel
def first_touch(data, by_samples, at_a, at_b, a, b, h, floor, contacts):
    """Return the part of a step at which two surfaces that are apart at both of its ends have just touched, or 2.0.

    `a` and `b` are the rows of their gap at the ends (see `flexmb.math.switches`), `floor` a way, m, that does not
    matter, `contacts` (2,) is written.
    """
    turn = np.empty(3)
    way = np.empty((3, 3))
    d = np.empty(3)
    Q = np.empty((3, 3))
    _turn_between(a[POSE + 9 : POSE + 18], b[POSE + 9 : POSE + 18], turn)
    reach_a, reach_b = data[at_a + REACH], data[at_b + REACH]
    turning = _ways(a, b, h, turn, reach_a, reach_b, way)
    fastest = 0.0
    for k in range(3):
        fastest = max(fastest, dot(way[k], way[k]) ** 0.5)
    fastest += turning
    gap, end = a[1], b[1]
    if gap + end > fastest:
        return NEVER
    finest = max(floor, FINEST * min(reach_a, reach_b))
    flat = not by_samples or data[at_a + REACH] >= FAR or data[at_b + REACH] >= FAR
    s, known = 0.0, False
    for _ in range(MOST):
        most = fastest
        if flat and known:
            # a plane parts the surfaces, and only the way along its normal counts
            nearing = 0.0
            for k in range(3):
                nearing = max(nearing, -dot(contacts[0].n, way[k]))
            most = min(fastest, nearing + turning)
        if gap >= most * (1.0 - s) or gap + end > fastest * (1.0 - s):
            return NEVER
        s += max(gap, finest) / most
        if s >= 1.0:
            return NEVER
        _pose(a, b, h, s, turn, d, Q)
        gap = bound_gap(data, at_a, at_b, d, Q)
        known = gap < 0.1 * min(reach_a, reach_b)
        if known:
            if by_samples:
                nearest_sample(data, at_a, at_b, np.inf, d, Q, contacts)
            else:
                find_closest(data, at_a, at_b, np.inf, d, Q, contacts)
            gap = contacts[0].gap
        if gap <= 1e-3 * floor:
            return s
    return s


@kernel
def part_within(data, by_samples, at_a, at_b, a, b, rate, h, floor, contacts):
    """Return the part of a step, one that begins or ends where two surfaces touch, that leads no further than `ROOM`
    beyond the first touch; 2.0 if all of it does. `rate`, m/s, is that of the gap at its begin.
    """
    thickness = min(data[at_a + THICKNESS], data[at_b + THICKNESS])
    room = ROOM * thickness
    if not -rate * h > room or a[1] < -thickness:  # deeper than it is thick: nothing is left to pass through
        return NEVER
    touch = 0.0
    if a[1] > 0.0:
        if not -rate * h > a[1] + room:
            return NEVER
        touch = first_touch(data, by_samples, at_a, at_b, a, b, h, floor, contacts)
    return touch + room / (-rate * h)
