"""Signed distance from an extruded profile: that of the plane profile and of its flat ends together.

In the bulk data: half the length, the size of the profile's table, the table (`flexmb.profiles.segments`).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel
from flexmb.profiles.feet import FOOT, find_feet

__all__ = ["profile_distance"]


@kernel
def profile_distance(data, own, z, n, H):
    """Return the distance of z (3,), negative inside, with gradient and second derivative, see `signed_distance`.

    Beyond a rim it is the distance from the rim; inside that of the nearer of side and end.
    """
    half, size = data[own], int(data[own + 1])
    feet = np.empty((1, FOOT))
    find_feet(data[own + 2 : own + 2 + size], z[0], z[1], 0.0, feet)
    beside, above, bend = feet[0, 4], abs(z[2]) - half, feet[0, 5]
    up = 1.0 if z[2] > 0.0 else -1.0
    e = (feet[0, 2], feet[0, 3], 0.0)
    t = (-feet[0, 3], feet[0, 2], 0.0)
    n[:] = 0.0
    H[:] = 0.0
    if above <= 0.0 or beside <= 0.0:
        if beside <= above:
            n[2] = up
            return above
        for i in range(2):
            n[i] = e[i]
            for j in range(2):
                H[i, j] = bend * t[i] * t[j]
        return beside
    gap = (beside * beside + above * above) ** 0.5
    c, s = beside / gap, up * above / gap
    for i in range(3):
        n[i] = c * e[i] + (s if i == 2 else 0.0)
    for i in range(3):
        for j in range(3):
            a = -s * e[i] + (c if i == 2 else 0.0)
            b = -s * e[j] + (c if j == 2 else 0.0)
            H[i, j] = a * b / gap + c * bend * t[i] * t[j]
    return gap
