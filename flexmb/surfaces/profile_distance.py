"""Signed distance from extruded and from revolved profiles, by the distance in the plane of the profile.

In the bulk data: half the length (if extruded), the size of the profile's table, the table
(`flexmb.profiles.segments`).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel
from flexmb.profiles.feet import FOOT, find_feet

__all__ = ["profile_distance", "revolved_distance"]

TINY = 1e-150


@kernel
def profile_distance(data, own, z, n, H):
    """Return the distance of z (3,), negative inside, with gradient and second derivative, see `signed_distance`.

    Beyond a rim it is the distance from the rim; inside from the nearer of side and end.
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


@kernel
def revolved_distance(data, own, z, n, H):
    """Return the distance of z (3,), negative inside, with gradient and second derivative, see `signed_distance`.

    A point at the distance rho from the axis is as far as (rho, z) from the profile, which is symmetric to the axis or
    beside it. Around the axis the normal turns with 1 / rho of its radial part.
    """
    rho = max((z[0] * z[0] + z[1] * z[1]) ** 0.5, TINY)
    feet = np.empty((1, FOOT))
    find_feet(data[own + 1 : own + 1 + int(data[own])], rho, z[2], 0.0, feet)
    radial, along, bend = feet[0, 2], feet[0, 3], feet[0, 5]
    around = bend if rho < 1e-9 * (abs(feet[0, 4]) + abs(z[2])) and abs(radial) < 1e-6 else radial / rho
    e = (z[0] / rho, z[1] / rho, 0.0)
    t = (-along * e[0], -along * e[1], radial)
    for i in range(3):
        n[i] = radial * e[i] + (along if i == 2 else 0.0)
        for j in range(3):
            across = ((1.0 if i == j else 0.0) - e[i] * e[j]) if i < 2 and j < 2 else 0.0
            H[i, j] = bend * t[i] * t[j] + around * across
    return feet[0, 4]
