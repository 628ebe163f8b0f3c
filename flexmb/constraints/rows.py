"""What the kernels of all primitive equations share: the row header, a leg's gradient, the work of the multiplier.

Variations of a marker are its displacement dr (m) and its rotation dtheta (rad), both in W: dR = dtheta~ R.
Theory: constraints, "primitive equations".
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel
from flexmb.math.tables import DAMPED
from flexmb.math.vectors import cross, dot

__all__ = [
    "HEADER",
    "add_block",
    "add_to_pairs",
    "apply_multiplier",
    "centripetal",
    "pair_blocks",
    "rotating_product",
    "set_gradient",
]

HEADER = [
    ("equation", np.int64),  # first equation
    ("leg", np.int64),  # first leg: markers a, b alternate
    ("a", np.int64),  # marker a
    ("b", np.int64),  # marker b
    ("pair", np.int64),  # pair (a, b)
]
"""The first fields of every row of equations."""


@kernel
def set_gradient(leg, sign, translation, rotation):
    """Write the derivative with respect to displacement and rotation of the leg's marker, times `sign`."""
    for i in range(3):
        leg.gradient[i] = sign * translation[i]
        leg.gradient[3 + i] = sign * rotation[i]


@kernel
def apply_multiplier(equation, leg_a, leg_b, marker_a, marker_b, lam):
    """Let the multiplier act: wrench += G^T lam on both markers."""
    equation.force = lam
    for i in range(6):
        marker_a.wrench[i] += leg_a.gradient[i] * lam
        marker_b.wrench[i] += leg_b.gradient[i] * lam


@kernel
def centripetal(w, a, out):
    """Write w x (w x a) to `out`."""
    wa = dot(w, a)
    ww = dot(w, w)
    for i in range(3):
        out[i] = w[i] * wa - a[i] * ww


@kernel
def add_block(K, row, column, scale, a, b, diagonal):
    """Add scale * (a b^T + diagonal I) to the block of `K` (12, 12) at `row`, `column`."""
    for i in range(3):
        for j in range(3):
            K[row + i, column + j] += scale * a[i] * b[j]
        K[row + i, column + i] += scale * diagonal


@kernel
def rotating_product(a, wa, b, wb, scratch):
    """Return the rate of a . b and the part of its second rate without angular accelerations.

    a turns with wa, b with wb; `scratch` (2, 3).
    """
    cross(wa, a, scratch[0])
    cross(wb, b, scratch[1])
    rate = dot(scratch[0], b) + dot(a, scratch[1])
    second = 2.0 * dot(scratch[0], scratch[1])
    centripetal(wa, a, scratch[0])
    centripetal(wb, b, scratch[1])
    return rate, second + dot(scratch[0], b) + dot(a, scratch[1])


@kernel
def add_to_pairs(work, data, blocks, n_legs, K, D):
    """Add K and D (6 n_legs, 6 n_legs) of many markers to their pairs; `blocks`: where `pair_blocks` begin."""
    for one in range(n_legs):
        for two in range(n_legs):
            at = blocks + 3 * (one * n_legs + two)
            pair, x, y = work.pairs[int(data[at])], int(data[at + 1]), int(data[at + 2])
            for i in range(6):
                for j in range(6):
                    pair.K[x + i, y + j] += K[6 * one + i, 6 * two + j]
                    if pair.active == DAMPED:
                        pair.D[x + i, y + j] += D[6 * one + i, 6 * two + j]


def pair_blocks(compiler, legs: tuple[int, ...], writes: int) -> list[tuple[int, int, int]]:
    """Return for every two legs the pair of markers, and the row and column in it, where their block stands."""
    found = []
    for i in range(len(legs)):
        for j in range(len(legs)):
            first, second = (min(i, j), max(i, j)) if i != j else (0, i or min(1, len(legs) - 1))
            pair = compiler.pair(legs[first], legs[second], writes)
            found.append((pair, 0 if i == first else 6, 0 if j == first else 6))
    return found
