"""Where a round bar with flat ends touches a plane: with its rims.

The lowest point of a rim is known in closed form whatever the bar does: it wanders round a disc that rolls on its edge.
A bar that stands needs three points: the lowest of the rim, and those a third of a turn away. One that lies touches
with the lowest points of both rims.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.surfaces.records import CODE, HEADER

__all__ = ["find_rod_on_plane", "is_rod_on_plane"]

PLANE, ROD = 0, 2
"""Codes of a half-space and of a cylinder."""
COS, SIN = -0.5, 0.75**0.5
"""Of a third of a turn."""


@kernel
def is_rod_on_plane(data, at_a, at_b):
    """Is one surface a half-space and the other one a cylinder?"""
    a, b = int(data[at_a + CODE]), int(data[at_b + CODE])
    return (a == PLANE and b == ROD) or (a == ROD and b == PLANE)


@inner_kernel
def _rims(radius, half, n, points):
    """Write the three points of each rim (6, 3), in the axes of the bar; n (3,) is the normal of the plane there."""
    size = (n[0] * n[0] + n[1] * n[1]) ** 0.5
    # upright, every point of the rim is as low as the others
    c, s = (-n[0] / size, -n[1] / size) if size > 0.0 else (1.0, 0.0)
    for end in range(2):
        for k in range(3):
            x, y = 1.0, 0.0
            if k > 0:
                x, y = COS, SIN if k == 1 else -SIN
            points[3 * end + k, 0] = radius * (c * x - s * y)
            points[3 * end + k, 1] = radius * (s * x + c * y)
            points[3 * end + k, 2] = half if end == 0 else -half


@kernel
def find_rod_on_plane(data, at_a, at_b, margin, d, Q, contacts):
    """Write the points of the rims that are nearer to the plane than the margin, m; return how many: places, normals
    and gaps, as between points and surfaces.
    """
    points, n, found = np.empty((6, 3)), np.empty(3), 0
    if int(data[at_a + CODE]) == PLANE:
        for i in range(3):
            n[i] = Q[2, i]
        _rims(data[at_b + HEADER], data[at_b + HEADER + 1], n, points)
        for k in range(6):
            gap = d[2] + Q[2, 0] * points[k, 0] + Q[2, 1] * points[k, 1] + Q[2, 2] * points[k, 2]
            if gap < margin:
                contact = contacts[found]
                for i in range(3):
                    contact.x[i] = d[i] + Q[i, 0] * points[k, 0] + Q[i, 1] * points[k, 1] + Q[i, 2] * points[k, 2]
                    contact.n[i] = 1.0 if i == 2 else 0.0
                contact.gap, contact.area = gap, 1.0
                found += 1
        return found
    for i in range(3):
        n[i] = Q[i, 2]
    _rims(data[at_a + HEADER], data[at_a + HEADER + 1], n, points)
    for k in range(6):
        gap = n[0] * (points[k, 0] - d[0]) + n[1] * (points[k, 1] - d[1]) + n[2] * (points[k, 2] - d[2])
        if gap < margin:
            contact = contacts[found]
            for i in range(3):
                contact.x[i] = points[k, i] - gap * n[i]
                contact.n[i] = -n[i]
            contact.gap, contact.area = gap, 1.0
            found += 1
    return found
