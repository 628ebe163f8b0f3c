"""Inertia of flexible links: the terms of a body alone; what links on it add is in `carried`.

In (angular, linear) of the frame, about its origin, with the modes behind. The six columns of inertias have a seventh,
the force at rate zero, so that both take the same sums; an eighth is zero. Rows over the modes are filled up to eights.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.eights import (
    WIDTH,
    keep,
    keep_columns,
    less,
    more,
    part,
    plus,
    read,
    same,
    times,
    totals,
)
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.tree.flexible.six_rows import keep_six
from flexmb.tree.flexible.tables import FOUR

__all__ = ["filled", "own_terms"]


@kernel
def filled(m):
    """Return the length of a row over m modes, filled up to eights."""
    return (m + WIDTH - 1) // WIDTH * WIDTH


@inner_kernel
def _sum_rows(x, c, first, count, out):
    """Write sum_j x_j row_j, of rows of up to `count` numbers that stand by fours of eights, to `out`; return where in
    c they end.
    """
    at = first
    for k in range(0, count, FOUR):
        a, b, d, e = same(0.0), same(0.0), same(0.0), same(0.0)
        for j in range(len(x)):
            f = same(x[j])
            a = more(a, f, read(c, at))
            b = more(b, f, read(c, at + WIDTH))
            d = more(d, f, read(c, at + 2 * WIDTH))
            e = more(e, f, read(c, at + 3 * WIDTH))
            at += FOUR
        keep(out, k, a)
        keep(out, k + WIDTH, b)
        keep(out, k + 2 * WIDTH, d)
        keep(out, k + 3 * WIDTH, e)
    return at


@inner_kernel
def _inertia_and_rate(x, y, eta, rate, bent, own):
    """Return x and y with what eight modes add to a number of the inertia and to its rate."""
    both = plus(bent, own)
    return more(x, eta, both), more(y, rate, plus(bent, both))


@inner_kernel
def _totals(x, v, body, c, ww1, vn, by_shape, by_rate, sums):
    """Write what the modes add to inertia, its rate, momentum and spin of the frame to sums (24,).

    Six of M_ww by the shape, six of what the rates make of it, momentum, spin, moment of the rates, and dissipation.
    """
    m = body.m
    size = filled(m)
    zero = same(0.0)
    a, b, d, e, f, g = zero, zero, zero, zero, zero, zero
    h, i, j, k, n, o = zero, zero, zero, zero, zero, zero
    p, q, r, s, t, u = zero, zero, zero, zero, zero, zero
    w, y, z, loss = zero, zero, zero, zero
    for at in range(0, size, WIDTH):
        eta, rate = part(x, body.coordinate + at, m - at), part(v, body.rate + at, m - at)
        a, h = _inertia_and_rate(a, h, eta, rate, read(by_shape, at), read(c, ww1 + at))
        b, i = _inertia_and_rate(b, i, eta, rate, read(by_shape, size + at), read(c, ww1 + size + at))
        d, j = _inertia_and_rate(d, j, eta, rate, read(by_shape, 2 * size + at), read(c, ww1 + 2 * size + at))
        e, k = _inertia_and_rate(e, k, eta, rate, read(by_shape, 3 * size + at), read(c, ww1 + 3 * size + at))
        f, n = _inertia_and_rate(f, n, eta, rate, read(by_shape, 4 * size + at), read(c, ww1 + 4 * size + at))
        g, o = _inertia_and_rate(g, o, eta, rate, read(by_shape, 5 * size + at), read(c, ww1 + 5 * size + at))
        p = more(p, rate, read(c, vn + at))
        q = more(q, rate, read(c, vn + size + at))
        r = more(r, rate, read(c, vn + 2 * size + at))
        s = more(s, rate, read(by_shape, 6 * size + at))
        t = more(t, rate, read(by_shape, 7 * size + at))
        u = more(u, rate, read(by_shape, 8 * size + at))
        w = more(w, rate, read(by_rate, at))
        y = more(y, rate, read(by_rate, size + at))
        z = more(z, rate, read(by_rate, 2 * size + at))
        loss = more(loss, rate, read(by_rate, 6 * size + at))
    keep(sums, 0, totals(a, b, d, e, f, g, h, i))
    keep(sums, WIDTH, totals(j, k, n, o, p, q, r, s))
    keep(sums, 2 * WIDTH, totals(t, u, w, y, z, loss, zero, zero))


@inner_kernel
def _own_inertia(rest, sums, vw, P):
    """Write the inertia of the frame for the present shape to P (6, 8).

    rest : mass, M_ww (6,) and M_vw (9,) without deformation; sums : of `_totals`; vw (9,) : what the modes add to M_vw
    """
    mass = rest[0]
    xx, yy, zz = rest[1] + sums[0], rest[4] + sums[1], rest[6] + sums[2]
    xy, yz, xz = rest[2] + sums[3], rest[5] + sums[4], rest[3] + sums[5]
    P[0, 0], P[0, 1], P[0, 2] = xx, xy, xz
    P[1, 0], P[1, 1], P[1, 2] = xy, yy, yz
    P[2, 0], P[2, 1], P[2, 2] = xz, yz, zz
    for i in range(3):
        for k in range(3):
            P[3 + i, k] = P[k, 3 + i] = rest[7 + 3 * i + k] + vw[3 * i + k]
            P[3 + i, 3 + k] = mass if i == k else 0.0
        P[i, 7], P[3 + i, 7] = 0.0, 0.0


@inner_kernel
def _velocity_terms(V, sums, d, P):
    """Write velocity terms of the frame to P[:, 6]; P has the inertia.

    sums : of `_totals`; d (9,) : the rate of M_vw
    """
    a, b, c = V[0], V[1], V[2]
    u, v, w = V[3], V[4], V[5]
    xx, yy, zz, xy, yz, xz = sums[6], sums[7], sums[8], sums[9], sums[10], sums[11]
    p, q, r = sums[12] + P[3, 3] * u, sums[13] + P[4, 4] * v, sums[14] + P[5, 5] * w
    f, g, k = sums[15], sums[16], sums[17]
    x, y, z = sums[18], sums[19], sums[20]
    # momentum (p, q, r), spin (f, g, k)
    p += P[3, 0] * a + P[3, 1] * b + P[3, 2] * c
    q += P[4, 0] * a + P[4, 1] * b + P[4, 2] * c
    r += P[5, 0] * a + P[5, 1] * b + P[5, 2] * c
    f += P[0, 0] * a + P[0, 1] * b + P[0, 2] * c + P[3, 0] * u + P[4, 0] * v + P[5, 0] * w
    g += P[1, 0] * a + P[1, 1] * b + P[1, 2] * c + P[3, 1] * u + P[4, 1] * v + P[5, 1] * w
    k += P[2, 0] * a + P[2, 1] * b + P[2, 2] * c + P[3, 2] * u + P[4, 2] * v + P[5, 2] * w
    x += d[0] * u + d[3] * v + d[6] * w + xx * a + xy * b + xz * c
    y += d[1] * u + d[4] * v + d[7] * w + xy * a + yy * b + yz * c
    z += d[2] * u + d[5] * v + d[8] * w + xz * a + yz * b + zz * c
    P[0, 6] = x + b * k - c * g + v * r - w * q
    P[1, 6] = y + c * f - a * k + w * p - u * r
    P[2, 6] = z + a * g - b * f + u * q - v * p
    P[3, 6] = d[0] * a + d[1] * b + d[2] * c + b * r - c * q
    P[4, 6] = d[3] * a + d[4] * b + d[5] * c + c * p - a * r
    P[5, 6] = d[6] * a + d[7] * b + d[8] * c + a * q - b * p


@inner_kernel
def _modal_force(V, size, at, c, ww1, vw1, by_shape, by_rate):
    """Return the velocity terms, elastic and damping forces of eight modes from `at` on."""
    a, b, e = V[0], V[1], V[2]
    u, v, w = V[3], V[4], V[5]
    h = plus(read(by_shape, 9 * size + at), read(by_rate, 6 * size + at))
    h = less(h, a * a, more(read(by_shape, at), 0.5, read(c, ww1 + at)))
    h = less(h, b * b, more(read(by_shape, size + at), 0.5, read(c, ww1 + size + at)))
    h = less(h, e * e, more(read(by_shape, 2 * size + at), 0.5, read(c, ww1 + 2 * size + at)))
    h = less(h, 2.0 * a * b, more(read(by_shape, 3 * size + at), 0.5, read(c, ww1 + 3 * size + at)))
    h = less(h, 2.0 * b * e, more(read(by_shape, 4 * size + at), 0.5, read(c, ww1 + 4 * size + at)))
    h = less(h, 2.0 * a * e, more(read(by_shape, 5 * size + at), 0.5, read(c, ww1 + 5 * size + at)))
    h = more(h, a, read(by_rate, 3 * size + at))
    h = more(h, b, read(by_rate, 4 * size + at))
    h = more(h, e, read(by_rate, 5 * size + at))
    first = vw1 + at
    h = less(h, u * a, read(c, first))
    h = less(h, u * b, read(c, first + size))
    h = less(h, u * e, read(c, first + 2 * size))
    h = less(h, v * a, read(c, first + 3 * size))
    h = less(h, v * b, read(c, first + 4 * size))
    h = less(h, v * e, read(c, first + 5 * size))
    h = less(h, w * a, read(c, first + 6 * size))
    h = less(h, w * b, read(c, first + 7 * size))
    return less(h, w * e, read(c, first + 8 * size))


@inner_kernel
def _stiffened_force(V, size, g, at):
    """Return what speeds make of eight modes from `at` on; from g on stand the products of the unit fields."""
    a, b, c = V[0], V[1], V[2]
    u, v, w = V[3], V[4], V[5]
    square = a * a + b * b + c * c
    h = times(b * w - c * v, read(g, at))
    h = more(h, c * u - a * w, read(g, size + at))
    h = more(h, a * v - b * u, read(g, 2 * size + at))
    h = more(h, a * a - square, read(g, 3 * size + at))
    h = more(h, b * b - square, read(g, 7 * size + at))
    h = more(h, c * c - square, read(g, 11 * size + at))
    h = more(h, a * b, plus(read(g, 4 * size + at), read(g, 6 * size + at)))
    h = more(h, a * c, plus(read(g, 5 * size + at), read(g, 9 * size + at)))
    return more(h, b * c, plus(read(g, 8 * size + at), read(g, 10 * size + at)))


@inner_kernel
def _modal_rows(V, body, c, fixed, g, by_shape, by_rate, L, B):
    """Write the rows of the modes, what stiffens them by inertia added; from g on stand the products of unit fields."""
    m = body.m
    size = filled(m)
    zero = same(0.0)
    ww1, vn, vw1 = fixed, fixed + 9 * size, fixed + 12 * size
    for at in range(0, size, WIDTH):
        h = _modal_force(V, size, at, c, ww1, vw1, by_shape, by_rate)
        d, e, f = read(by_shape, 6 * size + at), read(by_shape, 7 * size + at), read(by_shape, 8 * size + at)
        p, q, r = read(c, vn + at), read(c, vn + size + at), read(c, vn + 2 * size + at)
        keep_six(B, at, d, e, f, p, q, r)
        if body.by_inertia > 0:
            h = plus(h, _stiffened_force(V, size, g, at))
            d = plus(d, less(read(g, 10 * size + at), 1.0, read(g, 8 * size + at)))
            e = plus(e, less(read(g, 5 * size + at), 1.0, read(g, 9 * size + at)))
            f = plus(f, less(read(g, 6 * size + at), 1.0, read(g, 4 * size + at)))
            p, q, r = plus(p, read(g, at)), plus(q, read(g, size + at)), plus(r, read(g, 2 * size + at))
        keep_columns(L, at, d, e, f, p, q, r, h, zero)


@inner_kernel
def _modal_inertia(body, c, nn, g, K):
    """Write the modal inertia, what stiffens it by inertia added; from g on stand the products of the unit fields."""
    m = body.m
    size = filled(m)
    mean = nn + m * size
    for at in range(0, size, WIDTH):
        if body.by_inertia == 0:
            for j in range(m):
                keep(K, (j, at), read(c, nn + j * size + at))
            continue
        a, b, d = read(c, mean + at), read(c, mean + size + at), read(c, mean + 2 * size + at)
        e, f, h = read(c, mean + 3 * size + at), read(c, mean + 4 * size + at), read(c, mean + 5 * size + at)
        for j in range(m):
            x = more(read(c, nn + j * size + at), g[j], a)
            x = more(more(x, g[size + j], b), g[2 * size + j], d)
            x = more(x, g[10 * size + j] - g[8 * size + j], e)
            x = more(x, g[5 * size + j] - g[9 * size + j], f)
            keep(K, (j, at), more(x, g[6 * size + j] - g[4 * size + j], h))


@inner_kernel
def _add_loads(body, row, c, at, x, v, loads, energy, g, P, L):
    """Subtract the load shapes times their amounts, add their stiffening; g (n, filled m) are its products by loads."""
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
    for n in range(body.by_loads + body.preloaded):
        amount = loads[body.first_load + n] if n < body.by_loads else 1.0
        for j in range(m):
            L[j, 6] += amount * g[n * filled(m) + j]


@kernel
def own_terms(tree, n, work):
    """Write inertia and force of body n alone at the tree's coordinates and rates; its stiffening products remain.

    Those of the interfaces stand in scratch[0], from the place on that is returned. The inertia is ``[P, B; L, K]``.
    """
    flexible = tree.flexible
    body, c = flexible.bodies[n], flexible.constants
    P, L, K, B = flexible.P, flexible.L[n], flexible.K[body.kept], flexible.B[body.kept]
    m = body.m
    size = filled(m)
    row = tree.rows[body.link]
    by_shape, by_rate, sums = flexible.scratch[0], flexible.scratch[1], np.empty(3 * WIDTH)
    turned = (10 + body.stiffened) * size
    eta, rate = tree.x[body.coordinate : body.coordinate + m], tree.v[body.rate : body.rate + m]
    at = _sum_rows(eta, c, body.constants, turned + 2 * WIDTH, by_shape)
    fixed = _sum_rows(rate, c, at, 7 * size + 2 * WIDTH, by_rate)
    for k in range(6 * size, 9 * size, WIDTH):  # momenta of the modes about the origin
        keep(by_shape, k, plus(read(by_shape, k), read(c, fixed + k)))
    V, g = row.twist, by_shape[10 * size :]
    _totals(tree.x, tree.v, body, c, fixed, fixed + 9 * size, by_shape, by_rate, sums)
    nn = fixed + 21 * size
    at = nn + (m + 6) * size
    _own_inertia(c[at : at + 16], sums, by_shape[turned:], P)
    _velocity_terms(V, sums, by_rate[7 * size :], P)
    _modal_rows(V, body, c, fixed, g, by_shape, by_rate, L, B)
    _modal_inertia(body, c, nn, g, K)
    work.energy[0].dissipation += sums[21]
    interfaces = (10 + body.by_inertia) * size
    if body.shapes + body.turning + body.by_loads + body.preloaded > 0:
        last = by_shape[interfaces + 6 * body.by_interfaces * size :]
        _add_loads(body, row, c, at + 16, tree.x, tree.v, work.loads, work.energy, last, P, L)
    if len(tree.program.forces) > 0:
        for i in range(3):
            P[3 + i, 6] += work.residual[body.u + i]
            P[i, 6] += work.residual[body.u + 3 + i]
        for j in range(m):
            L[j, 6] += work.residual[body.u + 6 + j]
    return interfaces
