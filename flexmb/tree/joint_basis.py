"""What the tree joint of a body leaves free, from the gradients of its equations, and its velocity terms."""

from __future__ import annotations

from flexmb.math.kernel import kernel

__all__ = ["joint_basis", "velocity_terms"]


@kernel
def _orthogonalise(Q, n, column, coefficients):
    """Subtract from `column` its parts along the first n columns of Q, adding them to `coefficients`; return its length."""
    before = 0.0
    for m in range(6):
        before += column[m] * column[m]
    for _ in range(2):  # twice is enough (Kahan and Parlett), once if little was cancelled
        for i in range(n):
            s = 0.0
            for m in range(6):
                s += Q[m, i] * column[m]
            if s != 0.0:
                coefficients[i] += s
                for m in range(6):
                    column[m] -= s * Q[m, i]
        length = 0.0
        for m in range(6):
            length += column[m] * column[m]
        if length > 0.5 * before:
            break
    return length**0.5


@kernel
def joint_basis(tables, k, work, store, column, unused):
    """Write directions, triangular factor and free motions N, eq. (tree-joint); False if the equations are dependent."""
    Q, R = store.basis[k], store.triangle[k]
    first, last = tables.start_equation[k], tables.start_equation[k + 1]
    ne = last - first
    for j in range(ne):
        equation = work.equations[tables.equations[first + j]]
        for m in range(6):
            column[m] = 0.0
            unused[m] = 0.0
        for n in range(equation.leg, equation.leg + equation.legs):
            if work.legs[n].marker == tables.outer[k]:
                gradient = work.legs[n].gradient
                for m in range(6):
                    column[m] += gradient[m]
        length = _orthogonalise(Q, j, column, unused)
        if not length > 1e-12:
            return False
        for i in range(j):
            R[i, j] = unused[i]
        R[j, j] = length
        length = 1.0 / length
        for m in range(6):
            Q[m, j] = column[m] * length
    store.free[k] = 6 - ne
    for found in range(ne, 6):
        # the unit vector that the columns so far represent worst keeps at least (6 - found) / 6 of its square
        best, most = 0, -1.0
        for m in range(6):
            rest = 1.0
            for i in range(found):
                rest -= Q[m, i] * Q[m, i]
            if rest > most + 1e-3:
                best, most = m, rest
        for m in range(6):
            column[m] = 0.0
        column[best] = 1.0
        length = 1.0 / _orthogonalise(Q, found, column, unused)
        for m in range(6):
            Q[m, found] = column[m] * length
    return True


@kernel
def velocity_terms(tables, k, work, store, z):
    """Write c = Sh bias_P + sigma - bias_C, eq. (tree-velocity); sigma satisfies the joint's equations alone."""
    first = tables.start_equation[k]
    ne = tables.start_equation[k + 1] - first
    Q, R, c = store.basis[k], store.triangle[k], store.c[k]
    C = work.markers[tables.outer[k]]
    for i in range(6):
        c[i] = -C.bias[i]
    if tables.inner[k] < 0:
        return
    for j in range(ne):
        s = -work.equations[tables.equations[first + j]].drift
        for i in range(j):
            s -= R[i, j] * z[i]
        z[j] = s / R[j, j]
        if z[j] != 0.0:
            for i in range(6):
                c[i] += Q[i, j] * z[j]
    P = work.markers[tables.inner[k]]
    bias = P.bias
    x, y, z_ = C.r[0] - P.r[0], C.r[1] - P.r[1], C.r[2] - P.r[2]
    for i in range(6):
        c[i] += bias[i]
    c[0] += bias[4] * z_ - bias[5] * y
    c[1] += bias[5] * x - bias[3] * z_
    c[2] += bias[3] * y - bias[4] * x
