"""Combinations of the flexible coordinates of reduced bodies, as markers with one freedom.

c . eta + k is the place of such a marker along x, its rate the velocity, and c the first row of the Jacobian. Whoever
measures places thus measures deflections, strains and modal coordinates.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.tables import row_kernel
from flexmb.model.table import Table

__all__ = ["combination_rows"]

ROW = np.dtype(
    [
        ("marker", np.int64),
        ("eta", np.int64),  # first flexible coordinate
        ("rate", np.int64),  # its velocity
        ("modes", np.int64),
        ("weights", np.int64),  # where they begin in the bulk data
        ("constant", float),
    ],
    align=True,
)


@row_kernel
def place(raw, data, state, work):
    """Write place, velocity and Jacobian."""
    rows = raw.view(ROW)
    for m in range(rows.shape[0]):
        row = rows[m]
        marker = work.markers[row.marker]
        x, v = row.constant, 0.0
        for k in range(row.modes):
            c = data[row.weights + k]
            x += c * state.q[row.eta + k]
            v += c * state.u[row.rate + k]
            work.J[marker.iJ + marker.nu - row.modes + k] = c
        marker.r[0], marker.v[0] = x, v


@row_kernel
def nothing(raw, data, state, work):
    """They have neither inertia nor energy."""


def combination_rows(compiler, layout) -> list[tuple[Table, tuple]]:
    """Return the rows of all combinations of a model."""
    rows = []
    for combination, marker in compiler.combinations.items():
        body, weights = compiler.marker_body[marker], np.array(combination.weights)
        eta, rate = layout.iq[body + 1] - len(weights), layout.iu[body + 1] - len(weights)
        rows.append((COMBINATIONS, (marker, eta, rate, len(weights), compiler.bulk(weights), combination.constant)))
    return rows


COMBINATIONS = Table("Combinations", ROW, {"place": place, "inertia": nothing, "energy": nothing})
