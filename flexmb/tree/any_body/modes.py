"""Bodies with modes in the recursion: their own blocks, elimination, and what joints put on the modes of a parent.

With geometric stiffness by interface loads, wrenches also act on the modal rows: the modal columns of J differ between
rows and columns (by work.H), and inertias are not symmetric.
"""

from __future__ import annotations

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.tree.any_body.blocks import factor_block, solve_block
from flexmb.tree.any_body.store import modal_views

__all__ = ["add_to_modes", "eliminate_modes", "own_modes"]


@kernel
def own_modes(row, m, i_modal, iu, outer, work, store):
    """Write modal block and couplings in the coordinates (V, eta''), eq. (tree-own)."""
    K, right, left, Jc, Jr = modal_views(store.modal, i_modal, m)
    C = work.markers[outer]
    x, y, z = row.lever[0], row.lever[1], row.lever[2]
    for j in range(m):
        for i in range(6):
            v = work.J[C.iJ + i * C.nu + 6 + j]
            Jc[i, j] = v
            Jr[i, j] = v - (work.H[C.iH + i * C.nu + 6 + j] if C.iH >= 0 else 0.0)
        at = work.rows[iu + 6 + j]
        for i in range(m):
            K[j, i] = work.S[at + 6 + i]
        for i in range(6):
            first = 3 * (i // 3)
            v, w = 0.0, 0.0
            for a in range(3):
                r = row.R[i % 3, a]
                v += r * work.S[work.rows[iu + first + a] + 6 + j]
                w += r * work.S[at + first + a]
            right[i, j] = v
            left[j, i] = w
        a, b, c = right[0, j], right[1, j], right[2, j]
        right[3, j] -= y * c - z * b
        right[4, j] -= z * a - x * c
        right[5, j] -= x * b - y * a
        a, b, c = left[j, 0], left[j, 1], left[j, 2]
        left[j, 3] -= y * c - z * b
        left[j, 4] -= z * a - x * c
        left[j, 5] -= x * b - y * a
    _hang_on_marker(row, K, right, left, Jc, Jr)


@inner_kernel
def _hang_on_marker(row, K, right, left, Jc, Jr):
    """Change coordinates from the frame to the marker: V_frame = V - Jc eta''."""
    m = K.shape[0]
    for j in range(m):
        for a in range(6):
            x = left[j, a]
            for i in range(m):
                K[j, i] -= x * Jc[a, i]
    for i in range(6):
        for a in range(6):
            x = row.P[i, a]
            for j in range(m):
                right[i, j] -= x * Jc[a, j]
    for j in range(m):
        for a in range(6):
            x = Jr[a, j]
            for i in range(m):
                K[j, i] -= x * right[a, i]
            for i in range(6):
                left[j, i] -= x * row.P[a, i]


@kernel
def eliminate_modes(row, m, i_modal, i_eta, store, column):
    """Eliminate the modes, eq. (tree-modes-out): factors of K, K^-1 times the coupling (m, 6), and the rest in P."""
    K, right, left, _, _ = modal_views(store.modal, i_modal, m)
    pivots = store.pivots[i_eta : i_eta + m]
    if not factor_block(K, m, pivots, 1e-300):
        return False
    for j in range(6):
        for i in range(m):
            column[i] = left[i, j]
        solve_block(K, m, pivots, column)
        for i in range(m):
            left[i, j] = column[i]
    for i in range(6):
        for a in range(m):
            x = right[i, a]
            for j in range(6):
                row.P[i, j] -= x * left[a, j]
    return True


@inner_kernel
def _shifted(A, j, x, y, z):
    """Move the twist in column j of A (6, n) by (x, y, z)."""
    a, b, c = A[3, j], A[4, j], A[5, j]
    A[0, j] += b * z - c * y
    A[1, j] += c * x - a * z
    A[2, j] += a * y - b * x


@kernel
def add_to_modes(row, through, m, i_modal, i_parent, outer, inner, work, store, product, moved):
    """Add the transmitted inertia (36,) of a body to the modes of its parent, eq. (tree-modes).

    The columns E = Sh J_P - Sh J_C, J_C of the parent's own marker, are stored for the passes.
    """
    K, right, left, Jc, Jr = modal_views(store.modal, i_modal, m)
    E = store.parent[i_parent : i_parent + 6 * m].reshape((6, m))
    Er = store.parent[i_parent + 6 * m : i_parent + 12 * m].reshape((6, m))
    C, Q = work.markers[outer], work.markers[inner]
    x, y, z = row.step[0], row.step[1], row.step[2]
    # first by the way from the parent's own marker to P, backwards, then by the whole step
    u, v, w = C.r[0] - Q.r[0] - x, C.r[1] - Q.r[1] - y, C.r[2] - Q.r[2] - z
    for j in range(m):
        for i in range(6):
            E[i, j] = work.J[Q.iJ + i * Q.nu + 6 + j]
            Er[i, j] = E[i, j] - (work.H[Q.iH + i * Q.nu + 6 + j] if Q.iH >= 0 else 0.0)
        _shifted(E, j, u, v, w)
        _shifted(Er, j, u, v, w)
        for i in range(6):
            E[i, j] -= Jc[i, j]
            Er[i, j] -= Jr[i, j]
        _shifted(E, j, x, y, z)
        _shifted(Er, j, x, y, z)
    for i in range(6):
        for j in range(m):
            product[i, j] = 0.0
        for a in range(6):
            moved[6 * i + a] = through[6 * i + a]
            for j in range(m):
                product[i, j] += through[6 * i + a] * E[a, j]
        a, b, c = through[6 * i], through[6 * i + 1], through[6 * i + 2]
        moved[6 * i + 3] += y * c - z * b
        moved[6 * i + 4] += z * a - x * c
        moved[6 * i + 5] += x * b - y * a
    for j in range(m):
        for a in range(6):
            r = Er[a, j]
            for i in range(m):
                K[j, i] += r * product[a, i]
            for i in range(6):
                left[j, i] += r * moved[6 * a + i]
    for j in range(m):
        a, b, c = product[0, j], product[1, j], product[2, j]
        for i in range(6):
            right[i, j] += product[i, j]
        right[3, j] += y * c - z * b
        right[4, j] += z * a - x * c
        right[5, j] += x * b - y * a
