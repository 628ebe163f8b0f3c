"""`arm_lines`: rigid arms on elastic beams, which are no elements but carry joints and loads."""

from __future__ import annotations

import numpy as np

from flexmb.io.drawn_parts import DrawnPart

__all__ = ["arm_lines"]


def arm_lines(part: DrawnPart) -> tuple[tuple[str, np.ndarray], ...]:
    """Return a line from every node of a beam body that no element has to the nearest node that one has.

    A reduced body does not keep what its links hang on: the nearest node is where an arm across the beam stands. Bodies
    with shells or solids get none, as their free nodes are centres of bores and the like.
    """
    if part.data is None or part.nodes is not None or not part.cells:
        return ()
    if not all(kind.startswith("line") for kind, _ in part.cells):
        return ()
    held = np.unique(np.concatenate([np.ravel(rows) for _, rows in part.cells]))
    free = np.setdiff1d(np.arange(len(part.points)), held)
    if not len(free):
        return ()
    from scipy.spatial import cKDTree

    distance, foot = cKDTree(part.points[held]).query(part.points[free])
    apart = distance > 0.0
    return (("line", np.column_stack([held[foot], free])[apart]),) if apart.any() else ()
