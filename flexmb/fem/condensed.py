"""`Condensed`: what a model of few freedoms stands for, where its matrices alone do not say it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

__all__ = ["Condensed"]


@dataclass(frozen=True, eq=False)
class Condensed:
    """The finite elements behind an `FEModel` whose freedoms are those of reduced parts.

    Products of the mass with fields that the freedoms do not hold, such as that of a spin, are taken in the whole.

    Parameters
    ----------
    whole : FEModel
        All elements with all freedoms, parts beside each other; its nodes and sets are those of the condensed model.
    fields : (ndof of the whole, ndof)
        Its displacements per freedom.
    couplings : tuple of (Coupling, int)
        Where parts are held within, in freedoms of the whole, and the node with their motion.
    """

    whole: Any
    fields: np.ndarray
    couplings: tuple[Any, ...] = ()
