"""A force with a state, as a kind of its own: a spring and a damper in a row, along x of W (Maxwell)."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.math.states import add_rate, state_of
from flexmb.math.tables import row_kernel
from flexmb.model.kinds import Force
from flexmb.model.table import Table

ROW = np.dtype(
    [
        ("marker", np.int64),
        ("states", np.int64),
        ("pair", np.int64),  # marker, marker of the state
        ("stiffness", float),
        ("damping", float),
    ],
    align=True,
)


@row_kernel
def apply(raw, data, state, work):
    """F = -k (x - z), z' = k / c (x - z)."""
    rows = raw.view(ROW)
    for n in range(rows.shape[0]):
        row = rows[n]
        marker = work.markers[row.marker]
        stretch = marker.r[0] - state_of(work, row.states, 0)
        marker.wrench[0] -= row.stiffness * stretch
        rate = row.stiffness / row.damping
        add_rate(work, row.states, 0, rate * stretch)
        work.energy[0].potential += 0.5 * row.stiffness * stretch**2
        work.energy[0].dissipation += row.damping * (rate * stretch) ** 2
        if work.weights[0].wanted == 1:
            pair = work.pairs[row.pair]
            pair.K[0, 0] += row.stiffness
            pair.D[0, 6] -= row.stiffness
            pair.K[6, 0] -= rate
            pair.D[6, 6] += rate


@dataclass(frozen=True, eq=False)
class Maxwell(Force):
    """A spring and a damper in a row from the y-z plane of W to a marker.

    Parameters
    ----------
    name : str
    marker : str
    stiffness : float, N/m
    damping : float, N s/m
    start : float, m
        Of the damper.
    """

    name: str
    _: KW_ONLY
    marker: str
    stiffness: float
    damping: float
    start: float = 0.0

    table: ClassVar[Table] = Table("Maxwell", ROW, {"apply": apply})

    def record(self, compiler):
        """Return the row."""
        marker = compiler.marker(self.marker)
        states = compiler.state_marker(self.title, {"damper": self.start})
        return {"marker": marker, "states": states, "pair": compiler.pair(marker, states)}
