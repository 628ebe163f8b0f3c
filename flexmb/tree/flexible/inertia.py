"""Inertia of flexible links: their own terms, what links on them add, and the elimination of the modes.

In (angular, linear) of the frame, about its origin, with the modes behind. The six columns of inertias have a seventh,
the force at rate zero, so that both take the same sums; an eighth is zero.
"""

from __future__ import annotations

from flexmb.math.kernel import inner_kernel, kernel

__all__ = ["add_links", "eliminate", "hang", "own_terms", "stiffened_columns"]


@inner_kernel
def _sum_rows(x, at, constants, first, size, n, out):
    """Write sum_j x[at + j] row_j, of n rows of `size` numbers, to `out`; three at a time, element by element."""
    for i in range(size):
        out[i] = 0.0
    j = 0
    while j + 2 < n:
        a, b, c = x[at + j], x[at + j + 1], x[at + j + 2]
        row = constants[first + j * size : first + (j + 1) * size]
        other = constants[first + (j + 1) * size : first + (j + 2) * size]
        third = constants[first + (j + 2) * size : first + (j + 3) * size]
        for i in range(size):
            out[i] += a * row[i] + b * other[i] + c * third[i]
        j += 3
    while j < n:
        a = x[at + j]
        row = constants[first + j * size : first + (j + 1) * size]
        for i in range(size):
            out[i] += a * row[i]
        j += 1


@inner_kernel
def _own_inertia(link, m, ww1, vw0, bent, eta, vw, P):
    """Write the inertia of the frame for the present shape to P (6, 8).

    bent (6 m,) : sum of ww2; vw (9,) : what the modes add to M_vw
    """
    J = link.J
    xx, xy, xz, yy, yz, zz = J[0], J[1], J[2], J[3], J[4], J[5]
    for j in range(m):
        e = eta[j]
        xx += e * (bent[j] + ww1[j])
        yy += e * (bent[m + j] + ww1[m + j])
        zz += e * (bent[2 * m + j] + ww1[2 * m + j])
        xy += e * (bent[3 * m + j] + ww1[3 * m + j])
        yz += e * (bent[4 * m + j] + ww1[4 * m + j])
        xz += e * (bent[5 * m + j] + ww1[5 * m + j])
    P[0, 0], P[0, 1], P[0, 2] = xx, xy, xz
    P[1, 0], P[1, 1], P[1, 2] = xy, yy, yz
    P[2, 0], P[2, 1], P[2, 2] = xz, yz, zz
    for i in range(3):
        for k in range(3):
            P[3 + i, k] = P[k, 3 + i] = vw0[3 * i + k] + vw[3 * i + k]
            P[3 + i, 3 + k] = link.mass if i == k else 0.0
        P[i, 7], P[3 + i, 7] = 0.0, 0.0


@inner_kernel
def _velocity_terms(V, m, ww1, bent, rates, wn, vn, by_rate, P, L):
    """Write velocity terms of the frame to P[:, 6], those of -1/2 w . M_ww w to L[:, 6]; P has the inertia.

    wn, vn (3 m,) : momenta of the modes
    """
    a, b, c = V[0], V[1], V[2]
    u, v, w = V[3], V[4], V[5]
    xx, yy, zz, xy, yz, xz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    p, q, r = P[3, 3] * u, P[4, 4] * v, P[5, 5] * w
    f, g, k = 0.0, 0.0, 0.0
    x, y, z = 0.0, 0.0, 0.0
    for j in range(m):
        e = rates[j]
        xx += e * (2.0 * bent[j] + ww1[j])
        yy += e * (2.0 * bent[m + j] + ww1[m + j])
        zz += e * (2.0 * bent[2 * m + j] + ww1[2 * m + j])
        xy += e * (2.0 * bent[3 * m + j] + ww1[3 * m + j])
        yz += e * (2.0 * bent[4 * m + j] + ww1[4 * m + j])
        xz += e * (2.0 * bent[5 * m + j] + ww1[5 * m + j])
        p += vn[j] * e
        q += vn[m + j] * e
        r += vn[2 * m + j] * e
        f += wn[j] * e
        g += wn[m + j] * e
        k += wn[2 * m + j] * e
        x += by_rate[j] * e
        y += by_rate[m + j] * e
        z += by_rate[2 * m + j] * e
    # momentum (p, q, r), spin (f, g, k)
    p += P[3, 0] * a + P[3, 1] * b + P[3, 2] * c
    q += P[4, 0] * a + P[4, 1] * b + P[4, 2] * c
    r += P[5, 0] * a + P[5, 1] * b + P[5, 2] * c
    f += P[0, 0] * a + P[0, 1] * b + P[0, 2] * c + P[3, 0] * u + P[4, 0] * v + P[5, 0] * w
    g += P[1, 0] * a + P[1, 1] * b + P[1, 2] * c + P[3, 1] * u + P[4, 1] * v + P[5, 1] * w
    k += P[2, 0] * a + P[2, 1] * b + P[2, 2] * c + P[3, 2] * u + P[4, 2] * v + P[5, 2] * w
    d = by_rate[6 * m : 6 * m + 9]
    x += d[0] * u + d[3] * v + d[6] * w + xx * a + xy * b + xz * c
    y += d[1] * u + d[4] * v + d[7] * w + xy * a + yy * b + yz * c
    z += d[2] * u + d[5] * v + d[8] * w + xz * a + yz * b + zz * c
    P[0, 6] = x + b * k - c * g + v * r - w * q
    P[1, 6] = y + c * f - a * k + w * p - u * r
    P[2, 6] = z + a * g - b * f + u * q - v * p
    P[3, 6] = d[0] * a + d[1] * b + d[2] * c + b * r - c * q
    P[4, 6] = d[3] * a + d[4] * b + d[5] * c + c * p - a * r
    P[5, 6] = d[6] * a + d[7] * b + d[8] * c + a * q - b * p
    xx, yy, zz, xy, yz, xz = a * a, b * b, c * c, 2.0 * a * b, 2.0 * b * c, 2.0 * a * c
    for j in range(m):
        L[j, 6] = -(
            xx * (bent[j] + 0.5 * ww1[j])
            + yy * (bent[m + j] + 0.5 * ww1[m + j])
            + zz * (bent[2 * m + j] + 0.5 * ww1[2 * m + j])
            + xy * (bent[3 * m + j] + 0.5 * ww1[3 * m + j])
            + yz * (bent[4 * m + j] + 0.5 * ww1[4 * m + j])
            + xz * (bent[5 * m + j] + 0.5 * ww1[5 * m + j])
        )


@inner_kernel
def _stiffen_by_inertia(V, m, g, mean, K, L):
    """Add what accelerations and spin make of the modal rows; g (12 m,) are the products of the unit fields."""
    a, b, c = V[0], V[1], V[2]
    u, v, w = V[3], V[4], V[5]
    x, y, z = b * w - c * v, c * u - a * w, a * v - b * u
    square = a * a + b * b + c * c
    for j in range(m):
        s = x * g[j] + y * g[m + j] + z * g[2 * m + j]
        s += (a * a - square) * g[3 * m + j] + (b * b - square) * g[7 * m + j] + (c * c - square) * g[11 * m + j]
        s += a * b * (g[4 * m + j] + g[6 * m + j]) + a * c * (g[5 * m + j] + g[9 * m + j])
        L[j, 6] += s + b * c * (g[8 * m + j] + g[10 * m + j])
        d, e, f = g[10 * m + j] - g[8 * m + j], g[5 * m + j] - g[9 * m + j], g[6 * m + j] - g[4 * m + j]
        p, q, r = g[j], g[m + j], g[2 * m + j]
        L[j, 0] += d
        L[j, 1] += e
        L[j, 2] += f
        L[j, 3] += p
        L[j, 4] += q
        L[j, 5] += r
        row = K[j]
        for k in range(m):
            row[k] += p * mean[k] + q * mean[m + k] + r * mean[2 * m + k]
            row[k] += d * mean[3 * m + k] + e * mean[4 * m + k] + f * mean[5 * m + k]


@inner_kernel
def _add_loads(body, row, c, at, x, v, loads, energy, g, P, L):
    """Subtract the load shapes times their amounts, add their stiffening; g (n m,) are its products by loads."""
    m, size = body.m, 6 + body.m
    eta, rate, V = x[body.coordinate :], v[body.rate :], row.twist
    for n in range(max(body.shapes, body.turning)):
        amount = loads[body.first_load + n] if n < body.shapes else 1.0
        if amount == 0.0:
            continue
        for i in range(size):
            force = c[at + n * size + i] if n < body.shapes else 0.0
            if n < body.turning:
                first = at + body.shapes * size + (n * size + i) * m
                for j in range(m):
                    force += c[first + j] * eta[j]
            force *= amount
            if i < 6:
                P[(i + 3) % 6, 6] -= force
                power = force * V[(i + 3) % 6]
            else:
                L[i - 6, 6] -= force
                power = force * rate[i - 6]
            if n < body.shapes:
                energy[0].load_power += power
    if body.stiffened > 0:
        for n in range(body.by_loads + 1):
            amount = loads[body.first_load + n] if n < body.by_loads else 1.0
            for j in range(m):
                L[j, 6] += amount * g[n * m + j]


@kernel
def own_terms(tree, body, work, scratch, P, K, L, B):
    """Write inertia and force of a body alone at the tree's coordinates and rates; its stiffening products remain.

    Those of the interfaces stand in scratch[0], from the place on that is returned.

    P (6, 8), K (m, m), L (m, 8), B (6, m) : blocks ``[P, B; L, K]``
    """
    c, m = tree.flexible.constants, body.m
    link, row = tree.links[body.link], tree.rows[body.link]
    size, at = m * (10 + body.stiffened) + 9, body.constants
    by_shape, by_rate, wn = scratch[0], scratch[1], scratch[2]
    _sum_rows(tree.x, body.coordinate, c, at, size, m, by_shape)
    at += m * size
    size = 7 * m + 9
    _sum_rows(tree.v, body.rate, c, at, size, m, by_rate)
    at += m * size
    eta, rate, V = tree.x[body.coordinate :], tree.v[body.rate :], row.twist
    ww1, vn = c[at:], c[at + 9 * m :]
    for i in range(3 * m):
        wn[i] = c[at + 6 * m + i] + by_shape[6 * m + i]
    vw1, at = c[at + 12 * m :], at + 21 * m
    _own_inertia(link, m, ww1, c[at : at + 9], by_shape, eta, by_shape[9 * m : 9 * m + 9], P)
    _velocity_terms(V, m, ww1, by_shape, rate, wn, vn, by_rate, P, L)
    at += 9
    a, b, e = V[0], V[1], V[2]
    u, v, w = V[3], V[4], V[5]
    elastic, damping, odd = 9 * m + 9, 6 * m + 9, 3 * m
    dissipation = 0.0
    for j in range(m):
        p, q, r = vn[j], vn[m + j], vn[2 * m + j]
        f, g, k = wn[j], wn[m + j], wn[2 * m + j]
        B[0, j], B[1, j], B[2, j], B[3, j], B[4, j], B[5, j] = f, g, k, p, q, r
        L[j, 0], L[j, 1], L[j, 2], L[j, 3], L[j, 4], L[j, 5], L[j, 7] = f, g, k, p, q, r, 0.0
        damped = by_rate[damping + j]
        dissipation += damped * rate[j]
        x = a * by_rate[odd + j] + b * by_rate[odd + m + j] + e * by_rate[odd + 2 * m + j]
        x -= u * (vw1[j] * a + vw1[m + j] * b + vw1[2 * m + j] * e)
        x -= v * (vw1[3 * m + j] * a + vw1[4 * m + j] * b + vw1[5 * m + j] * e)
        x -= w * (vw1[6 * m + j] * a + vw1[7 * m + j] * b + vw1[8 * m + j] * e)
        L[j, 6] += x + by_shape[elastic + j] + damped
        for i in range(m):
            K[j, i] = c[at + j * m + i]
    at += m * m
    work.energy[0].dissipation += dissipation
    stiffness = 10 * m + 9
    if body.by_inertia > 0:
        _stiffen_by_inertia(V, m, by_shape[stiffness:], c[at:], K, L)
    interfaces = stiffness + body.by_inertia * m
    if body.shapes > 0 or body.turning > 0 or body.stiffened > 0:
        last = by_shape[interfaces + 6 * body.by_interfaces * m :]
        _add_loads(body, row, c, at + 6 * m, tree.x, tree.v, work.loads, work.energy, last, P, L)
    if len(tree.program.forces) > 0:
        for i in range(3):
            P[3 + i, 6] += work.residual[body.u + i]
            P[i, 6] += work.residual[body.u + 3 + i]
        for j in range(m):
            L[j, 6] += work.residual[body.u + 6 + j]
    return interfaces


@kernel
def stiffened_columns(s, m, products, E, loaded):
    """Write E less what a wrench of a place at s (3,) does through the stiffness to `loaded`.

    products : of the unit forces and moments at the place, (6 m,), in body axes
    """
    x, y, z = s[0], s[1], s[2]
    for j in range(m):
        f, g, h = products[j], products[m + j], products[2 * m + j]
        p, q, r = products[3 * m + j], products[4 * m + j], products[5 * m + j]
        loaded[0, j], loaded[1, j], loaded[2, j] = E[0, j] - p, E[1, j] - q, E[2, j] - r
        loaded[3, j] = E[3, j] - f - (y * r - z * q)
        loaded[4, j] = E[4, j] - g - (z * p - x * r)
        loaded[5, j] = E[5, j] - h - (x * q - y * p)


@inner_kernel
def _add_products(sign, E, A, m, out):
    """Add sign E^T A, E (6, m), A (6, 8), to `out` (m, 8)."""
    for j in range(m):
        a, b, c = sign * E[0, j], sign * E[1, j], sign * E[2, j]
        d, e, f = sign * E[3, j], sign * E[4, j], sign * E[5, j]
        for i in range(8):
            out[j, i] += a * A[0, i] + b * A[1, i] + c * A[2, i] + d * A[3, i] + e * A[4, i] + f * A[5, i]


@inner_kernel
def _times(A, E, m, out):
    """Write A E, A (6, 8) without its last columns, E (6, m), to `out` (6, m)."""
    for i in range(6):
        a, b, c, d, e, f = A[i, 0], A[i, 1], A[i, 2], A[i, 3], A[i, 4], A[i, 5]
        for j in range(m):
            out[i, j] = a * E[0, j] + b * E[1, j] + c * E[2, j] + d * E[3, j] + e * E[4, j] + f * E[5, j]


@kernel
def add_links(E, loaded, A, m, P, K, L, B, product):
    """Add inertia and force A (6, 8) of what a place carries, moved to the frame, to the body's."""
    for i in range(6):
        for j in range(8):
            P[i, j] += A[i, j]
    _add_products(1.0, loaded, A, m, L)
    _times(A, E, m, product)
    for i in range(6):
        for j in range(m):
            B[i, j] += product[i, j]
    _add_modal(1.0, loaded, product, m, K)


@inner_kernel
def _add_modal(sign, loaded, product, m, K):
    """Add sign E_L^T X, X (6, m), to K."""
    for j in range(m):
        a, b, c = sign * loaded[0, j], sign * loaded[1, j], sign * loaded[2, j]
        d, e, f = sign * loaded[3, j], sign * loaded[4, j], sign * loaded[5, j]
        for i in range(m):
            K[j, i] += a * product[0, i] + b * product[1, i] + c * product[2, i]
            K[j, i] += d * product[3, i] + e * product[4, i] + f * product[5, i]


@kernel
def hang(E, loaded, m, P, K, L, B, product):
    """Go from the rate of the frame to the rate of the own marker, moved to the frame: V_frame = V - E eta''."""
    _times(P, E, m, product)
    for i in range(6):
        for j in range(m):
            B[i, j] -= product[i, j]
    for j in range(m):
        a, b, c, d, e, f = L[j, 0], L[j, 1], L[j, 2], L[j, 3], L[j, 4], L[j, 5]
        for i in range(m):
            K[j, i] -= a * E[0, i] + b * E[1, i] + c * E[2, i] + d * E[3, i] + e * E[4, i] + f * E[5, i]
    _add_modal(-1.0, loaded, B, m, K)
    _add_products(-1.0, loaded, P, m, L)


@kernel
def eliminate(m, P, K, L, B):
    """Replace K by its factors, L by K^-1 L, P by P - B K^-1 L; False if a motion of the modes has no inertia.

    Without exchange of rows: K is a mass matrix, but for what accelerations do to bent bodies.
    """
    for k in range(m):
        if not K[k, k] > 1e-300:
            return False
        f = 1.0 / K[k, k]
        for i in range(k + 1, m):
            x = K[i, k] * f
            K[i, k] = x
            for j in range(k + 1, m):
                K[i, j] -= x * K[k, j]
            for j in range(8):
                L[i, j] -= x * L[k, j]
    for k in range(m - 1, -1, -1):
        f = 1.0 / K[k, k]
        for j in range(8):
            L[k, j] *= f
        for i in range(k):
            x = K[i, k]
            for j in range(8):
                L[i, j] -= x * L[k, j]
    for i in range(6):
        for k in range(m):
            x = B[i, k]
            for j in range(8):
                P[i, j] -= x * L[k, j]
    return True
