"""Signed distance of a point from a shape, with gradient and second derivative: all that contacts know of a shape.

Source: the distance of a point from a convex set is that from its projection, n = grad g, and H n = 0; its other
principal values are 1 / (distance from the centres of curvature), those of parallel surfaces (do Carmo, Differential
Geometry of Curves and Surfaces, section 3-5).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.surfaces.mesh_distance import mesh_distance
from flexmb.surfaces.profile_distance import profile_distance, revolved_distance
from flexmb.surfaces.records import CODE, FAR, HEADER, PATCH

__all__ = ["signed_distance"]

TINY = 1e-150


@inner_kernel
def _from_point(z, radius, n, H):
    """Distance from a ball around the origin."""
    size = max((z[0] * z[0] + z[1] * z[1] + z[2] * z[2]) ** 0.5, TINY)
    for i in range(3):
        n[i] = z[i] / size
    for i in range(3):
        for j in range(3):
            H[i, j] = ((1.0 if i == j else 0.0) - n[i] * n[j]) / size
    return size - radius


@inner_kernel
def _from_line(z, radius, n, H):
    """Distance from an endless bar around the z-axis."""
    size = max((z[0] * z[0] + z[1] * z[1]) ** 0.5, TINY)
    n[0], n[1], n[2] = z[0] / size, z[1] / size, 0.0
    H[:] = 0.0
    for i in range(2):
        for j in range(2):
            H[i, j] = ((1.0 if i == j else 0.0) - n[i] * n[j]) / size
    return size - radius


@inner_kernel
def _from_segment(z, radius, half, n, H):
    """Distance from a bar around the z-axis with round ends at +-half."""
    if abs(z[2]) <= half:
        return _from_line(z, radius, n, H)
    end = np.empty(3)
    end[0], end[1], end[2] = z[0], z[1], z[2] - (half if z[2] > 0.0 else -half)
    return _from_point(end, radius, n, H)


@inner_kernel
def _from_box(z, half, n, H):
    """Distance from a box with the half edges; inside from the nearest face."""
    n[:] = 0.0
    H[:] = 0.0
    square, nearest, axis = 0.0, -np.inf, 0
    for i in range(3):
        beyond = abs(z[i]) - half[i]
        if beyond > nearest:
            nearest, axis = beyond, i
        if beyond > 0.0:
            square += beyond * beyond
            n[i] = beyond if z[i] > 0.0 else -beyond
    if nearest <= 0.0:
        n[:] = 0.0
        n[axis] = 1.0 if z[axis] > 0.0 else -1.0
        return nearest
    gap = square**0.5
    for i in range(3):
        n[i] /= gap
    for i in range(3):
        for j in range(3):
            if n[i] != 0.0 and n[j] != 0.0:
                H[i, j] = ((1.0 if i == j else 0.0) - n[i] * n[j]) / gap
    return gap


@inner_kernel
def _from_rod(z, radius, half, n, H):
    """Distance from a round bar with flat ends; inside from the nearer of side and end."""
    rho = max((z[0] * z[0] + z[1] * z[1]) ** 0.5, TINY)
    beside, above = rho - radius, abs(z[2]) - half
    up = 1.0 if z[2] > 0.0 else -1.0
    if above <= 0.0 or beside <= 0.0:
        if beside > above:
            return _from_line(z, radius, n, H)
        n[0], n[1], n[2] = 0.0, 0.0, up
        H[:] = 0.0
        return above
    gap = (beside * beside + above * above) ** 0.5
    e = np.empty(3)  # radial
    e[0], e[1], e[2] = z[0] / rho, z[1] / rho, 0.0
    c, s = beside / gap, up * above / gap
    for i in range(3):
        n[i] = c * e[i]
    n[2] = s
    for i in range(3):
        for j in range(3):
            t = (-s * e[i] + (c if i == 2 else 0.0)) * (-s * e[j] + (c if j == 2 else 0.0)) / gap
            if i < 2 and j < 2:
                t += c / rho * ((1.0 if i == j else 0.0) - e[i] * e[j])
            H[i, j] = t
    return gap


@kernel
def signed_distance(data, at, z, within, n, H):
    """Return the distance, m, of the point z (3,) from the surface at `at` in the bulk data, negative inside.

    `within` is an upper bound of its absolute value, infinite if unknown: it shortens the search in meshes. All in the
    axes of the surface's marker; writes the gradient to `n` (3,) and the second derivative to `H` (3, 3).
    """
    code, own = int(data[at + CODE]), at + HEADER
    if code == 0:
        n[0], n[1], n[2] = 0.0, 0.0, 1.0
        H[:] = 0.0
        return z[2]
    if code == 1:
        return _from_point(z, data[own], n, H)
    if code == 2:
        return _from_rod(z, data[own], data[own + 1], n, H)
    if code == 3:
        return _from_segment(z, data[own], data[own + 1], n, H)
    if code == 4:
        return _from_box(z, data[own : own + 3], n, H)
    if code == PATCH:
        n[:] = 0.0
        H[:] = 0.0
        return FAR
    if code == 20:
        return profile_distance(data, own, z, n, H)
    if code == 21:
        return revolved_distance(data, own, z, n, H)
    return mesh_distance(data, own, z, within, n, H)
