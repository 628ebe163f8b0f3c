"""`Spots`: the points of surfaces that touch at an instant."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

__all__ = ["ALONE", "Spots"]

ALONE = -1
"""Number of a point that no list has: where bodies touch by a law that acts at one point."""


class Spots(NamedTuple):
    """What touches, point by point; n points of those that the force lists by its method `points`."""

    point: np.ndarray
    """(n,), numbers of the points; `ALONE` by a law that acts at one point"""
    depth: np.ndarray
    """(n,), m, of the penetration"""
    pressure: np.ndarray
    """(n,), Pa, with damping; N by a law that acts at one point"""
    slip: np.ndarray
    """(n,), m/s"""
    area: np.ndarray
    """(n,), m2, as far as the surfaces face each other; 1 by a law that acts at one point"""
