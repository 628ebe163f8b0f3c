"""The wrench of a point of one skin on a face of another, and its tangent, eq. (skin-contact).

The point z = r + R y belongs to a marker, the place p = sum_k b_k v_k on the face to the markers at its corners. All
derivatives are by displacements and turns, then by velocities and spins, of the point's marker and of the three
corners: 24 columns. With w = dz - sum_k b_k dv_k, the tangents a of the face, edge or (none) corner and their inverse
products A^-1,

    d gap = n.w,   dn = -a A^-1 (n.da) + (1 - n n^T - a A^-1 a^T) w / G,   db = B A^-1 (a.w + G n.da)

where G is the distance of z from p. The forces act on both bodies at one place, x = z - gap n.
"""

from __future__ import annotations

import numpy as np

from flexmb.forces.contact_force import CONTACT_FORCE, force_change, press, write_slopes
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import cross, dot, matvec
from flexmb.surfaces.detection import faced

__all__ = ["COLUMNS", "SPOT", "act_on_skins", "place_derivatives"]

COLUMNS = 24

SPOT = np.dtype(
    [
        ("r", float, (4, 3)),  # m, of the marker of the point and of the three corners, in W
        ("v", float, (4, 3)),  # m/s
        ("w", float, (4, 3)),  # rad/s
        ("y", float, 3),  # m, of the point from its marker, in W
        ("m", float, 3),  # outward normal of the skin there
        ("area", float),  # m2
        ("radius", float),  # m, by which the faces are thickened
    ],
    align=True,
)
"""A point of a skin with the markers of the face that it meets."""


@inner_kernel
def _tangents(place, spot, a, ends):
    """Write the edges (2, 3) along which the place may slide, with the corners (2, 2) at their ends; how many."""
    if place.where >= 4:
        return 0
    if place.where >= 1:
        ends[0, 0], ends[0, 1] = place.where - 1, place.where % 3
    else:
        ends[0, 0], ends[0, 1], ends[1, 0], ends[1, 1] = 0, 1, 0, 2
    count = 1 if place.where >= 1 else 2
    for k in range(count):
        for i in range(3):
            a[k, i] = spot.r[1 + ends[k, 1], i] - spot.r[1 + ends[k, 0], i]
    return count


@kernel
def place_derivatives(place, spot, w, dn, dshare):
    """Write how w, the normal (3, 24) and the shares of the corners (3, 24) change with displacements and turns."""
    a = np.zeros((2, 3))
    ends = np.zeros((2, 2), np.int64)
    count = _tangents(place, spot, a, ends)
    inverse = np.zeros((2, 2))
    if count == 1:
        inverse[0, 0] = 1.0 / dot(a[0], a[0])
    elif count == 2:
        d00, d01, d11 = dot(a[0], a[0]), dot(a[0], a[1]), dot(a[1], a[1])
        D = d00 * d11 - d01 * d01
        inverse[0, 0], inverse[1, 1] = d11 / D, d00 / D
        inverse[0, 1], inverse[1, 0] = -d01 / D, -d01 / D
    n, G = place.n, place.distance
    P = np.zeros((3, 3))  # onto what is neither along the normal nor along the face
    if count < 2:
        for i in range(3):
            for j in range(3):
                P[i, j] = (1.0 if i == j else 0.0) - n[i] * n[j] - a[0, i] * inverse[0, 0] * a[0, j]
    turned = np.zeros(2)
    slid = np.zeros(2)
    w[:] = 0.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        w[i, i] = 1.0
        # e_j x y
        w[i, 3 + j] = spot.y[k]
        w[i, 3 + k] = -spot.y[j]
        for c in range(3):
            w[i, 6 + 6 * c + i] = -place.share[c]
    for col in range(COLUMNS):
        corner, axis = (col - 6) // 6, col % 6
        for e in range(count):
            along = 0.0
            for i in range(3):
                along += a[e, i] * w[i, col]
            nda = 0.0
            if col >= 6 and axis < 3:
                nda = n[axis] * ((1.0 if ends[e, 1] == corner else 0.0) - (1.0 if ends[e, 0] == corner else 0.0))
            turned[e], slid[e] = nda, along + G * nda
        for i in range(3):
            dn[i, col], dshare[i, col] = 0.0, 0.0
            for e in range(count):
                for f in range(count):
                    dn[i, col] -= a[e, i] * inverse[e, f] * turned[f]
            if count < 2:
                for j in range(3):
                    dn[i, col] += P[i, j] * w[j, col] / G
        for e in range(count):
            step = 0.0
            for f in range(count):
                step += inverse[e, f] * slid[f]
            dshare[ends[e, 1], col] += step
            dshare[ends[e, 0], col] -= step


@inner_kernel
def _velocity(place, spot, levers, u):
    """Write the velocity of the point relative to the face, at x, to `u`."""
    t = np.empty(3)
    cross(spot.w[0], levers[0], t)
    for i in range(3):
        u[i] = spot.v[0, i] + t[i]
    for c in range(3):
        cross(spot.w[1 + c], levers[1], t)
        for i in range(3):
            u[i] -= place.share[c] * (spot.v[1 + c, i] + t[i])


@kernel
def act_on_skins(law, place, spot, wanted, wrench, K, D, energy):
    """Write wrenches (4, 6) on the markers of a spot, and with `wanted` K, D (24, 24), minus their derivatives.

    `law` has stiffness, exponent, damping, friction and transition. Returns penetration, pressure and slip.
    """
    at = np.empty(1, CONTACT_FORCE)[0]
    levers = np.empty((2, 3))  # of x about the marker of the point, and about the place on the face
    t = np.empty(3)
    gap = place.distance - spot.radius
    for i in range(3):
        at.n[i] = place.n[i]
        levers[0, i] = spot.y[i] - gap * place.n[i]
        levers[1, i] = spot.radius * place.n[i]
    _velocity(place, spot, levers, at.u)
    share, share_slope = faced(-dot(spot.m, place.n))
    press(law, gap, spot.area * share, at, energy)
    F = at.F
    cross(levers[0], F, t)
    for i in range(3):
        wrench[0, i], wrench[0, 3 + i] = F[i], t[i]
    cross(levers[1], F, t)
    for c in range(3):
        for i in range(3):
            wrench[1 + c, i], wrench[1 + c, 3 + i] = -place.share[c] * F[i], -place.share[c] * t[i]
    if wanted:
        write_slopes(law, at)
        _tangent(place, spot, levers, at, spot.area * share_slope, K, D)
    return -gap, at.f, dot(at.s, at.s) ** 0.5


@inner_kernel
def _tangent(place, spot, levers, at, area_slope, K, D):
    """Write minus the derivatives of the wrenches; `area_slope` is the area's by how much the skins face each other."""
    w = np.empty((3, COLUMNS))
    dn = np.empty((3, COLUMNS))
    dshare = np.empty((3, COLUMNS))
    place_derivatives(place, spot, w, dn, dshare)
    F = at.F
    rF = np.empty(3)
    cross(levers[1], F, rF)
    dl = np.empty((2, 3))
    du = np.empty(3)
    dF = np.empty(3)
    t = np.empty(3)
    e = np.empty(3)
    turn = np.empty(3)
    turned = np.empty(3)
    cross(spot.m, place.n, turn)
    for col in range(COLUMNS):
        marker, axis = col // 6, col % 6
        dgap, facing = 0.0, 0.0
        for i in range(3):
            dgap += place.n[i] * w[i, col]
            facing -= spot.m[i] * dn[i, col]
            turned[i] = dn[i, col]
        if marker == 0 and axis >= 3:
            facing -= turn[axis - 3]
        _moved(place, spot, levers, (col, dgap), (dn, dshare), dl, du)
        force_change(at, dgap, area_slope * facing, turned, du, dF)
        cross(levers[0], dF, t)
        cross(dl[0], F, e)
        for i in range(3):
            K[i, col], K[3 + i, col] = -dF[i], -(t[i] + e[i])
        cross(levers[1], dF, t)
        cross(dl[1], F, e)
        for c in range(3):
            b, db = place.share[c], dshare[c, col]
            for i in range(3):
                K[6 + 6 * c + i, col] = b * dF[i] + db * F[i]
                K[9 + 6 * c + i, col] = b * (t[i] + e[i]) + db * rF[i]
        # by velocities and spins
        e[:] = 0.0
        e[axis % 3] = 1.0
        if axis < 3:
            du[:] = e
        else:
            cross(e, levers[0 if marker == 0 else 1], du)
        if marker > 0:
            for i in range(3):
                du[i] *= -place.share[marker - 1]
        matvec(at.by_u, du, dF)
        cross(levers[0], dF, t)
        for i in range(3):
            D[i, col], D[3 + i, col] = -dF[i], -t[i]
        cross(levers[1], dF, t)
        for c in range(3):
            for i in range(3):
                D[6 + 6 * c + i, col] = place.share[c] * dF[i]
                D[9 + 6 * c + i, col] = place.share[c] * t[i]


@inner_kernel
def _moved(place, spot, levers, moved, changes, dl, du):
    """Write how levers (2, 3) and relative velocity (3,) change with a column of displacements and turns.

    `moved` is the number of the column and the change of the gap, `changes` are those of normal and shares.
    """
    col, dgap = moved
    dn, dshare = changes
    gap = place.distance - spot.radius
    t = np.empty(3)
    for i in range(3):
        dl[0, i] = -dgap * place.n[i] - gap * dn[i, col]
        dl[1, i] = spot.radius * dn[i, col]
    if 3 <= col < 6:  # the point turns with its marker: e x y
        j, k = (col - 2) % 3, (col - 1) % 3
        dl[0, j] -= spot.y[k]
        dl[0, k] += spot.y[j]
    cross(spot.w[0], dl[0], du)
    for c in range(3):
        cross(spot.w[1 + c], dl[1], t)
        for i in range(3):
            du[i] -= place.share[c] * t[i]
        cross(spot.w[1 + c], levers[1], t)
        for i in range(3):
            du[i] -= dshare[c, col] * (spot.v[1 + c, i] + t[i])
