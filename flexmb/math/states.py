"""What kernels of forces do with first-order states: read them, and write their rates.

The states of a part are the twists of markers, six each (see `Compiler.state_marker`). Derivatives go to the pairs of
these markers with others: D, rows of the state, columns of twists and states; K, columns of displacements.
"""

from __future__ import annotations

from flexmb.math.kernel import kernel

__all__ = ["add_rate", "state_of"]


@kernel
def state_of(work, first, k):
    """Return state k of the part whose first marker of states is `first`."""
    marker = work.markers[first + k // 6]
    i = k % 6
    return marker.v[i] if i < 3 else marker.w[i - 3]


@kernel
def add_rate(work, first, k, rate):
    """Add to the rate of state k."""
    work.markers[first + k // 6].wrench[k % 6] += rate
