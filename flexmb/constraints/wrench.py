"""The wrench of a force on a marker, measured before the signals that follow it.

The force's own kernel is called on its own row once more, with all markers and its pairs set aside: what it adds to the
marker is the wrench, what it adds to its pairs are the derivatives. Both go to `work.channels`: the wrench, then for
every pair and component the derivatives by the displacements of its two markers, and by their twists.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel
from flexmb.math.tables import call_row_kernel, row_kernel
from flexmb.model.table import Table

__all__ = ["EACH_PAIR", "WRENCH"]

ROW = np.dtype(
    [
        ("marker", np.int64),
        ("address", np.int64),  # of the kernel of the force
        ("row", np.int64),  # where a copy of its row begins in the bulk data
        ("words", np.int64),
        ("pairs", np.int64),  # which it writes
        ("n_pairs", np.int64),
        ("channel", np.int64),
    ],
    align=True,
)
EACH_PAIR = 24
"""Channels for the derivatives by the markers of a pair."""


@inner_kernel
def _set_aside(pairs, work, K, D):
    """Write stiffness and damping of pairs to K and D, and clear them."""
    for k in range(len(pairs)):
        pair = work.pairs[pairs[k]]
        K[k] = pair.K
        D[k] = pair.D
        pair.K[:] = 0.0
        pair.D[:] = 0.0


@inner_kernel
def _put_back(row, pairs, work, K, D):
    """Write the derivatives to the channels, and give the pairs what they had."""
    out = work.channels
    for k in range(len(pairs)):
        pair = work.pairs[pairs[k]]
        first = row.channel + 1 + EACH_PAIR * k
        for c in range(6):
            at = first + 4 * c
            out[at : at + 4] = 0.0
            for side in range(2):
                if (pair.a if side == 0 else pair.b) != row.marker:
                    continue
                for j in range(6):
                    out[at, j] -= pair.K[6 * side + c, j]
                    out[at + 1, j] -= pair.K[6 * side + c, 6 + j]
                    out[at + 2, j] -= pair.D[6 * side + c, j]
                    out[at + 3, j] -= pair.D[6 * side + c, 6 + j]
        pair.K[:] = K[k]
        pair.D[:] = D[k]


@row_kernel
def apply(raw, data, state, work):
    """Measure the wrenches; nothing else changes."""
    rows = raw.view(ROW)
    kept = np.empty((len(work.markers), 6))
    for m in range(rows.shape[0]):
        row = rows[m]
        energy, loads = work.energy.copy(), work.loads.copy()
        for n in range(len(work.markers)):
            for i in range(6):
                kept[n, i] = work.markers[n].wrench[i]
                work.markers[n].wrench[i] = 0.0
        tangent = work.weights[0].wanted == 1
        pairs = data[row.pairs : row.pairs + row.n_pairs].view(np.int64)
        K, D = np.empty((len(pairs), 12, 12)), np.empty((len(pairs), 12, 12))
        if tangent:
            _set_aside(pairs, work, K, D)
        call_row_kernel(row.address, data[row.row : row.row + row.words].view(np.uint8), data, state, work)
        for i in range(6):
            work.channels[row.channel, i] = work.markers[row.marker].wrench[i]
        if tangent:
            _put_back(row, pairs, work, K, D)
        for n in range(len(work.markers)):
            for i in range(6):
                work.markers[n].wrench[i] = kept[n, i]
        work.energy[0] = energy[0]
        work.loads[:] = loads


WRENCH = Table("MeasuredWrench", ROW, {"apply": apply})
