"""Effective mass of the fixed-interface modes: the share of the body that each of them moves, by direction."""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["effective_mass_table"]

DIRECTIONS = ("x", "y", "z", "rotation x", "rotation y", "rotation z")
_NOTHING = 1e-12  # of the largest mass or inertia: the model has no mass in this direction


def effective_mass_table(participation: np.ndarray, rigid_mass: np.ndarray) -> dict[str, Any]:
    """Return the table of the quality report, as JSON can hold it.

    Parameters
    ----------
    participation : (k, 6), sqrt(kg) and sqrt(kg) m
        phi_k^T M R of the mass-normalised modes, for rigid translations and rotations R about the centroid.
    rigid_mass : (6, 6), kg, kg m, kg m2
        R^T M R.

    Returns
    -------
    dict
        ``directions``; ``per_mode`` (k, d), the shares participation^2 / rigid mass; their ``sum`` (d,), short of one
        by what moves with the interfaces; ``participation`` and ``rigid_mass`` as given.
    """
    size = np.diag(rigid_mass)
    there = [d for d in range(6) if size[d] > _NOTHING * size[3 * (d // 3) : 3 * (d // 3) + 3].max(initial=0.0)]
    share = participation[:, there] ** 2 / size[there]
    return {
        "directions": [DIRECTIONS[d] for d in there],
        "per_mode": share.tolist(),
        "sum": share.sum(axis=0).tolist(),
        "participation": participation.tolist(),
        "rigid_mass": rigid_mass.tolist(),
    }
