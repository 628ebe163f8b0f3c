"""`Spots`: the points of surfaces that touch at an instant."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

__all__ = ["Spots"]


class Spots(NamedTuple):
    """What touches, point by point; n points of those that the force lists by its method `points`."""

    point: np.ndarray
    """(n,), numbers of the points"""
    depth: np.ndarray
    """(n,), m, of the penetration"""
    pressure: np.ndarray
    """(n,), Pa, with damping"""
    slip: np.ndarray
    """(n,), m/s"""
    area: np.ndarray
    """(n,), m2, as far as the surfaces face each other"""
