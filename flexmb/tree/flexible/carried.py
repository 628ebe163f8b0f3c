"""What links on a flexible body add to its inertia, the way from its frame to its own marker, and its modes eliminated.

Blocks ``[P, B; L, K]`` as in `own_terms`; theory, eq. (bend-out).
"""

from __future__ import annotations

from flexmb.math.eights import WIDTH, keep, less, more, only_after, put, read, same, times
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.tree.flexible.inertia import filled
from flexmb.tree.flexible.six_rows import add_six, keep_six, read_six

__all__ = ["add_links", "eliminate", "hang", "stiffened_columns"]

LEAST, MOST = 1e-4, 2.0
"""A pivot between these parts of what stood in its place at first needs no exchange of rows."""

SINGULAR = 1e-15
"""A pivot below this part of what stood in its place is rounding."""


@kernel
def stiffened_columns(s, m, products, E, loaded):
    """Write E less what a wrench of a place at s (3,) does through the stiffness to `loaded`.

    products : of the unit forces and moments at the place, (6, filled m), in body axes
    """
    x, y, z, size = s[0], s[1], s[2], filled(m)
    for at in range(0, size, WIDTH):
        f, g, h = read(products, at), read(products, size + at), read(products, 2 * size + at)
        p, q, r = read(products, 3 * size + at), read(products, 4 * size + at), read(products, 5 * size + at)
        keep(loaded, (0, at), less(read(E, (0, at)), 1.0, p))
        keep(loaded, (1, at), less(read(E, (1, at)), 1.0, q))
        keep(loaded, (2, at), less(read(E, (2, at)), 1.0, r))
        keep(loaded, (3, at), more(less(less(read(E, (3, at)), 1.0, f), y, r), z, q))
        keep(loaded, (4, at), more(less(less(read(E, (4, at)), 1.0, g), z, p), x, r))
        keep(loaded, (5, at), more(less(less(read(E, (5, at)), 1.0, h), x, q), y, p))


@inner_kernel
def _products(A, i, a, b, c, d, e, f):
    """Return row i of A times six rows of eight."""
    x = more(more(times(A[i, 0], a), A[i, 1], b), A[i, 2], c)
    return more(more(more(x, A[i, 3], d), A[i, 4], e), A[i, 5], f)


@inner_kernel
def _less_columns(x, E, j, a, b, c, d, e, f):
    """Return x less column j of E times six rows of eight."""
    x = less(less(less(x, E[0, j], a), E[1, j], b), E[2, j], c)
    return less(less(less(x, E[3, j], d), E[4, j], e), E[5, j], f)


@inner_kernel
def _more_columns(x, E, j, a, b, c, d, e, f):
    """Return x and column j of E times six rows of eight."""
    x = more(more(more(x, E[0, j], a), E[1, j], b), E[2, j], c)
    return more(more(more(x, E[3, j], d), E[4, j], e), E[5, j], f)


@kernel
def add_links(E, loaded, A, m, P, K, L, B):
    """Add inertia and force A (6, 8) of what a place carries, moved to the frame, to the body's."""
    a, b, c, d, e, f = read_six(A, 0)
    add_six(P, 0, a, b, c, d, e, f)
    for j in range(m):
        keep(L, (j, 0), _more_columns(read(L, (j, 0)), loaded, j, a, b, c, d, e, f))
    for at in range(0, m, WIDTH):
        p, q, r, x, y, z = read_six(E, at)
        a, b = _products(A, 0, p, q, r, x, y, z), _products(A, 1, p, q, r, x, y, z)
        c, d = _products(A, 2, p, q, r, x, y, z), _products(A, 3, p, q, r, x, y, z)
        e, f = _products(A, 4, p, q, r, x, y, z), _products(A, 5, p, q, r, x, y, z)
        add_six(B, at, a, b, c, d, e, f)
        for j in range(m):
            keep(K, (j, at), _more_columns(read(K, (j, at)), loaded, j, a, b, c, d, e, f))


@kernel
def hang(E, loaded, m, P, K, L, B):
    """Go from the rate of the frame to the rate of the own marker, moved to the frame: V_frame = V - E eta''."""
    for at in range(0, m, WIDTH):
        p, q, r, x, y, z = read_six(E, at)
        a = less(read(B, (0, at)), 1.0, _products(P, 0, p, q, r, x, y, z))
        b = less(read(B, (1, at)), 1.0, _products(P, 1, p, q, r, x, y, z))
        c = less(read(B, (2, at)), 1.0, _products(P, 2, p, q, r, x, y, z))
        d = less(read(B, (3, at)), 1.0, _products(P, 3, p, q, r, x, y, z))
        e = less(read(B, (4, at)), 1.0, _products(P, 4, p, q, r, x, y, z))
        f = less(read(B, (5, at)), 1.0, _products(P, 5, p, q, r, x, y, z))
        keep_six(B, at, a, b, c, d, e, f)
        for j in range(m):
            own = less(read(K, (j, at)), 1.0, _products(L, j, p, q, r, x, y, z))
            keep(K, (j, at), _less_columns(own, loaded, j, a, b, c, d, e, f))
    a, b, c, d, e, f = read_six(P, 0)
    for j in range(m):
        keep(L, (j, 0), _less_columns(read(L, (j, 0)), loaded, j, a, b, c, d, e, f))


@inner_kernel
def _exchange(k, m, K, L, pivots):
    """Bring the largest entry of column k on or below the diagonal to the diagonal; 0.0 if there is none, else it.

    pivots : (m,) the row that came to each place, -1 first: no row has been exchanged yet
    """
    if pivots[0] < 0:
        for i in range(m):
            pivots[i] = i
    p = k
    for i in range(k + 1, m):
        if abs(K[i, k]) > abs(K[p, k]):
            p = i
    pivots[k] = p
    if p != k:
        for at in range(0, m, WIDTH):
            x = read(K, (k, at))
            keep(K, (k, at), read(K, (p, at)))
            keep(K, (p, at), x)
        x = read(L, (k, 0))
        keep(L, (k, 0), read(L, (p, 0)))
        keep(L, (p, 0), x)
    return K[k, k]


@kernel
def eliminate(m, P, K, L, B, usual, pivots):
    """Replace K by its factors, L by K^-1 L, P by P - B K^-1 L; False if a motion of the modes has no inertia.

    K is a mass matrix, but for what accelerations do to bent bodies. A mass matrix needs no exchange of rows: its
    pivots are positive, and none exceeds what stood in its place. Where that does not hold, rows are exchanged from
    there on. The factors are those of Crout: the upper one has a unit diagonal, and of the lower one's diagonal the
    inverse numbers are kept.

    usual : (m,) scratch
    pivots : (m,) rows that were exchanged, one by one; -1 first if none was
    """
    zero = same(0.0)
    pivots[0] = -1
    for k in range(m):
        usual[k] = K[k, k]
    for k in range(m):
        pivot = K[k, k]
        if pivots[0] >= 0 or not (LEAST * usual[k] < pivot < MOST * usual[k]):
            pivot = _exchange(k, m, K, L, pivots)
            if not abs(pivot) > max(SINGULAR * abs(usual[k]), 1e-300):
                return False
        f, begin = 1.0 / pivot, k // WIDTH * WIDTH
        lane, own = k - begin, read(K, (k, begin))
        row, of_k = only_after(times(f, own), zero, lane), times(f, read(L, (k, 0)))
        keep(K, (k, begin), put(only_after(row, own, lane), lane, f))
        keep(L, (k, 0), of_k)
        for at in range(begin + WIDTH, m, WIDTH):
            keep(K, (k, at), times(f, read(K, (k, at))))
        for i in range(k + 1, m):
            x = K[i, k]
            keep(K, (i, begin), less(read(K, (i, begin)), x, row))
            keep(L, (i, 0), less(read(L, (i, 0)), x, of_k))
            for at in range(begin + WIDTH, m, WIDTH):
                keep(K, (i, at), less(read(K, (i, at)), x, read(K, (k, at))))
    a, b, c, d, e, f = read_six(P, 0)
    for k in range(m - 1, -1, -1):
        of_k = read(L, (k, 0))
        a, b, c = less(a, B[0, k], of_k), less(b, B[1, k], of_k), less(c, B[2, k], of_k)
        d, e, f = less(d, B[3, k], of_k), less(e, B[4, k], of_k), less(f, B[5, k], of_k)
        for i in range(k):
            keep(L, (i, 0), less(read(L, (i, 0)), K[i, k], of_k))
    keep_six(P, 0, a, b, c, d, e, f)
    return True
