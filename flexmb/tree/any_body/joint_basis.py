"""What the tree joint of a body leaves free, from the gradients of its equations, and its velocity terms."""

from __future__ import annotations

from flexmb.math.kernel import inner_kernel, kernel

__all__ = ["joint_basis", "velocity_terms"]


@inner_kernel
def _orthogonalise(way, n, factors):
    """Subtract from direction n of `way` (6, 6) its parts along the first n directions; add them to `factors`.

    Returns its length. Twice is enough (Parlett 1980, section 6-9), and once if little was cancelled.
    """
    before = 0.0
    for m in range(6):
        before += way[n, m] * way[n, m]
    for _ in range(2):
        for i in range(n):
            s = 0.0
            for m in range(6):
                s += way[i, m] * way[n, m]
            factors[i] += s
            if s != 0.0:
                for m in range(6):
                    way[n, m] -= s * way[i, m]
        length = 0.0
        for m in range(6):
            length += way[n, m] * way[n, m]
        if length > 0.5 * before:
            break
    return length**0.5


@kernel
def joint_basis(row, equations, first, last, outer, table, legs, factors):
    """Write directions, triangular factor and free motions N, eq. (tree-joint); False if equations are dependent."""
    ne, way = last - first, row.way
    for j in range(ne):
        equation = table[equations[first + j]]
        for m in range(6):
            way[j, m] = 0.0
            factors[m] = 0.0
        for n in range(equation.leg, equation.leg + equation.legs):
            leg = legs[n]
            if leg.marker == outer:
                for m in range(6):
                    way[j, m] += leg.gradient[m]
        length = _orthogonalise(way, j, factors)
        if not length > 1e-12:
            return False
        for i in range(j):
            row.triangle[i, j] = factors[i]
        row.triangle[j, j] = length
        length = 1.0 / length
        for m in range(6):
            way[j, m] *= length
    row.free = 6 - ne
    _free_motions(way, ne, factors)
    return True


@inner_kernel
def _free_motions(way, ne, factors):
    """Complete the directions of ne equations to an orthonormal basis."""
    for found in range(ne, 6):
        # the unit vector that the directions so far represent worst keeps at least (6 - found) / 6 of its square
        best, most = 0, -1.0
        for m in range(6):
            rest = 1.0
            for i in range(found):
                x = way[i, m]
                rest -= x * x
            if rest > most + 1e-3:
                best, most = m, rest
        for m in range(6):
            way[found, m] = 0.0
        way[found, best] = 1.0
        length = 1.0 / _orthogonalise(way, found, factors)
        for m in range(6):
            way[found, m] *= length


@kernel
def velocity_terms(row, equations, first, last, outer, inner, table, markers, factors):
    """Write c = Sh bias_P + sigma - bias_C, eq. (tree-velocity); sigma satisfies the joint's equations alone."""
    C = markers[outer]
    for i in range(6):
        row.bias[i] = -C.bias[i]
    if inner < 0:
        return
    for j in range(last - first):
        s = -table[equations[first + j]].drift
        for i in range(j):
            s -= row.triangle[i, j] * factors[i]
        s /= row.triangle[j, j]
        factors[j] = s
        for i in range(6):
            row.bias[i] += s * row.way[j, i]
    P = markers[inner]
    x, y, z = C.r[0] - P.r[0], C.r[1] - P.r[1], C.r[2] - P.r[2]
    a, b, c = P.bias[3], P.bias[4], P.bias[5]
    row.bias[0] += P.bias[0] + b * z - c * y
    row.bias[1] += P.bias[1] + c * x - a * z
    row.bias[2] += P.bias[2] + a * y - b * x
    row.bias[3] += a
    row.bias[4] += b
    row.bias[5] += c
