"""The way of a string over cylinders that follow each other, whose axes may be skew: places between them by Newton.

Between two cylinders the way is a straight line that touches both. A place X on it divides the way into pieces over
one cylinder each, whose lengths are closed. The way is the shortest over all X: the sum is convex, because the space
around cylinders, seen along one kind of way, is curved nowhere inwards, eq. (cylinders-in-a-row). X is free along the
line; it is put in the middle between the places where the line is nearest to the two axes, so that each piece sees its
cylinder whole.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import matvec, matvec_t, norm

__all__ = ["around_cylinder", "contact_angle", "eliminate", "passes_behind", "places_between", "turn_about"]

_STEPS = 100  # of Newton, with those after a change of place along the lines
_MEET = 1e-10  # by which unit vectors at a place between cylinders may differ before the last step


@kernel
def contact_angle(radius, P, S, angle):
    """Return the angle over which the way lies on a cylinder, rad; where it is negative the way does not touch."""
    r = abs(radius)
    return angle - np.arccos(r / (P[0] ** 2 + P[1] ** 2) ** 0.5) - np.arccos(r / (S[0] ** 2 + S[1] ** 2) ** 0.5)


@kernel
def passes_behind(radius, P, S, angle):
    """Does the straight line from P to S cut the cylinder on the side around which the way does not go?"""
    x, y = S[0] - P[0], S[1] - P[1]
    share = -(P[0] * x + P[1] * y) / max(x * x + y * y, 1e-300)
    across = (P[0] * y - P[1] * x) ** 2
    return -np.pi < angle < 0.0 and 0.0 < share < 1.0 and across < radius * radius * (x * x + y * y)


@kernel
def around_cylinder(radius, P, S, contact, g, H):
    """Return the length of the way from P to S around the cylinder, write gradient (2, 3) and second derivative (6, 6).

    In the plane across the axis the length s is that of two tangents a and an arc; ds is the unit vector u along the
    tangent, and moving P across it turns the tangent: d2s = n n^T / a. With the height z, L = sqrt(s^2 + z^2).
    """
    r, sense = abs(radius), (1.0 if radius > 0.0 else -1.0)
    H[:] = 0.0
    ds = np.zeros(6)
    s = r * contact
    for side in range(2):
        x = P if side == 0 else S
        rho = (x[0] * x[0] + x[1] * x[1]) ** 0.5
        a = (rho * rho - r * r) ** 0.5
        s += a
        # towards the other end, from P with the sense of the way and from S against it
        way = sense if side == 0 else -sense
        cosine, sine = a / rho, way * r / rho
        u = (cosine * x[0] + sine * x[1]) / rho, (cosine * x[1] - sine * x[0]) / rho
        n = (-u[1], u[0])
        for i in range(2):
            ds[3 * side + i] = u[i]
            for j in range(2):
                H[3 * side + i, 3 * side + j] = n[i] * n[j] / a
    z = S[2] - P[2]
    length = (s * s + z * z) ** 0.5
    for i in range(6):
        rise = (1.0 if i == 5 else -1.0 if i == 2 else 0.0) * z
        g[i // 3, i % 3] = (s * ds[i] + rise) / length
    for i in range(6):
        for j in range(6):
            rises = (1.0 if i == j else -1.0) if i % 3 == 2 and j % 3 == 2 else 0.0
            own = ds[i] * ds[j] + s * H[i, j] + rises - g[i // 3, i % 3] * g[j // 3, j % 3]
            H[i, j] = own / length
    return length


@kernel
def turn_about(radius, P, S, near):
    """Return by how much the way turns from P to S about the axis of a cylinder, the one that is nearest to `near`."""
    x = (1.0 if radius > 0.0 else -1.0) * np.arctan2(P[0] * S[1] - P[1] * S[0], P[0] * S[0] + P[1] * S[1])
    return x + 2.0 * np.pi * np.round((near - x) / (2.0 * np.pi))


@kernel
def eliminate(A, B):
    """Solve A X = B in place by elimination with pivots; B (n, m). Return if no pivot is zero."""
    n, m = B.shape
    for j in range(n):
        best = j
        for i in range(j + 1, n):
            if abs(A[i, j]) > abs(A[best, j]):
                best = i
        if not abs(A[best, j]) > 0.0:
            return False
        for k in range(n):
            A[j, k], A[best, k] = A[best, k], A[j, k]
        for k in range(m):
            B[j, k], B[best, k] = B[best, k], B[j, k]
        for i in range(j + 1, n):
            factor = A[i, j] / A[j, j]
            if factor != 0.0:
                for k in range(j, n):
                    A[i, k] -= factor * A[j, k]
                for k in range(m):
                    B[i, k] -= factor * B[j, k]
    for j in range(n - 1, -1, -1):
        for k in range(m):
            for i in range(j + 1, n):
                B[j, k] -= A[j, i] * B[i, k]
            B[j, k] /= A[j, j]
    return True


@inner_kernel
def _piece(radius, center, R, near, one, two, g, H):
    """Return the length of the way between two places over a cylinder, NaN where there is none.

    Writes gradient (2, 3) and second derivative (6, 6) by the two places, in W.
    """
    P, S, d = np.empty(3), np.empty(3), np.empty(3)
    for i in range(3):
        d[i] = one[i] - center[i]
    matvec_t(R, d, P)
    for i in range(3):
        d[i] = two[i] - center[i]
    matvec_t(R, d, S)
    angle = turn_about(radius, P, S, near)
    contact = contact_angle(radius, P, S, angle)
    if contact != contact or passes_behind(radius, P, S, angle):
        return np.nan
    if contact <= 0.0:
        for i in range(3):
            d[i] = two[i] - one[i]
        length = max(norm(d), 1e-150)
        for i in range(3):
            g[1, i] = d[i] / length
            g[0, i] = -g[1, i]
        for i in range(3):
            for j in range(3):
                x = ((1.0 if i == j else 0.0) - g[1, i] * g[1, j]) / length
                H[i, j] = H[3 + i, 3 + j] = x
                H[3 + i, j] = H[i, 3 + j] = -x
        return length
    own, turned = np.empty((2, 3)), np.empty((6, 6))
    length = around_cylinder(radius, P, S, contact, own, turned)
    for side in range(2):
        matvec(R, own[side], g[side])
    for a in range(0, 6, 3):
        for b in range(0, 6, 3):
            for i in range(3):
                for j in range(3):
                    x = 0.0
                    for k in range(3):
                        for m in range(3):
                            x += R[i, k] * turned[a + k, b + m] * R[j, m]
                    H[a + i, b + j] = x
    return length


@inner_kernel
def _whole(radii, centers, frames, near, P, S, X, gradient, A, along):
    """Return the length of the way over all cylinders, and write its gradient and second derivative by all X.

    `along` (m - 1, 3) are the directions of the straight lines, along which nothing changes; A is stiff there.
    """
    m = len(radii)
    g, H = np.empty((2, 3)), np.empty((6, 6))
    gradient[:] = 0.0
    A[:] = 0.0
    along[:] = 0.0
    total = 0.0
    for j in range(m):
        length = _piece(
            radii[j], centers[j], frames[j], near[j], P if j == 0 else X[j - 1], S if j == m - 1 else X[j], g, H
        )
        if length != length:
            return np.nan
        total += length
        for a in range(2):
            if not 0 <= j - 1 + a < m - 1:
                continue
            for i in range(3):
                gradient[3 * (j - 1 + a) + i] += g[a, i]
                along[j - 1 + a, i] += g[a, i] if a == 1 else -g[a, i]
                for b in range(2):
                    if 0 <= j - 1 + b < m - 1:
                        for k in range(3):
                            A[3 * (j - 1 + a) + i, 3 * (j - 1 + b) + k] += H[3 * a + i, 3 * b + k]
    for j in range(m - 1):
        size = max(norm(along[j]), 1e-150)
        for i in range(3):
            along[j, i] /= size
        stiff = A[3 * j, 3 * j] + A[3 * j + 1, 3 * j + 1] + A[3 * j + 2, 3 * j + 2]
        for i in range(3):
            for k in range(3):
                A[3 * j + i, 3 * j + k] += stiff * along[j, i] * along[j, k]
    return total


@inner_kernel
def _nearest(center, R, x, e):
    """Return how far along x + t e the line is nearest to the axis of a cylinder."""
    d, w, u = np.empty(3), np.empty(3), np.empty(3)
    for i in range(3):
        d[i] = x[i] - center[i]
    matvec_t(R, d, w)
    matvec_t(R, e, u)
    return -(w[0] * u[0] + w[1] * u[1]) / max(u[0] * u[0] + u[1] * u[1], 1e-300)


@inner_kernel
def _to_the_middle(centers, frames, X, along):
    """Move the places along their lines to the middle between those nearest to the two axes; return twice by how far
    the one that moves most, m."""
    moved = 0.0
    for j in range(len(X)):
        before = _nearest(centers[j], frames[j], X[j], along[j])
        behind = _nearest(centers[j + 1], frames[j + 1], X[j], along[j])
        moved = max(moved, abs(before + behind))
        for i in range(3):
            X[j, i] += 0.5 * (before + behind) * along[j, i]
    return moved


@inner_kernel
def _in_order(centers, frames, X, along):
    """Does the way come to the cylinders in the order in which they are described?"""
    for j in range(len(X)):
        if _nearest(centers[j], frames[j], X[j], along[j]) > _nearest(centers[j + 1], frames[j + 1], X[j], along[j]):
            return False
    return True


@kernel
def places_between(radii, centers, frames, near, P, S, X):
    """Move the places X (m - 1, 3) between m cylinders to where the way is shortest; return if there is such a way.

    Parameters
    ----------
    radii : (m,), m
        Negative: around the z-axis the other way.
    centers, frames : (m, 3), m, and (m, 3, 3)
        Markers of the cylinders, in W.
    near : (m,), rad
        About by how much the way turns around each.
    P, S : (3,), m
        Ends of the way.
    X : (m - 1, 3), m
        Where to begin; overwritten.
    """
    m = len(radii)
    n = 3 * (m - 1)
    gradient, A, along, step = np.empty(n), np.empty((n, n)), np.empty((m - 1, 3)), np.empty((n, 1))
    tried, new_gradient, new_A, new_along = np.empty((m - 1, 3)), np.empty(n), np.empty((n, n)), np.empty((m - 1, 3))
    length = _whole(radii, centers, frames, near, P, S, X, gradient, A, along)
    placed = last = False
    for _ in range(_STEPS):
        if length != length:
            return False
        apart = 0.0
        for i in range(n):
            apart = max(apart, abs(gradient[i]))
        if apart < _MEET and not placed:
            moved, placed = _to_the_middle(centers, frames, X, along), True
            length = _whole(radii, centers, frames, near, P, S, X, gradient, A, along)
            if moved > 1e-9 * length:
                continue
        last = apart < _MEET and placed
        for i in range(n):
            step[i, 0] = -gradient[i]
        if not eliminate(A, step):
            return False
        share, slope = 1.0, 0.0
        for i in range(n):
            slope += gradient[i] * step[i, 0]
        while True:
            for i in range(n):
                tried[i // 3, i % 3] = X[i // 3, i % 3] + share * step[i, 0]
            new = _whole(radii, centers, frames, near, P, S, tried, new_gradient, new_A, new_along)
            if last or new <= length + 1e-4 * share * slope:
                break
            closer = 0.0
            for i in range(n):
                closer = max(closer, abs(new_gradient[i]))
            if new == new and closer < 0.5 * apart:
                break
            share *= 0.5
            if share < 1e-9:
                return False
        X[:], gradient[:], A[:], along[:] = tried, new_gradient, new_A, new_along
        length = new
        if last:
            break
        placed = placed and apart < _MEET
    return last and length == length and _in_order(centers, frames, X, along)
