"""What drives that speed up do to a mechanism at rest: an equilibrium takes them at their positions of the moment."""

from __future__ import annotations

import numpy as np
from scipy.sparse.linalg import splu

from flexmb.integrate.linear.steady import saddle
from flexmb.integrate.matrices import equations_at

__all__ = ["driven_accelerations", "prescribed"]

SHARED = 1e-12
"""Softness of equations, relative, that keeps dependent ones solvable."""


def prescribed(system, state, work) -> np.ndarray:
    """Return the second derivatives (ng,) of prescribed motions, the right side b of the equations at rest."""
    return equations_at(system, state._replace(u=np.zeros(system.nu)), work).b


def driven_accelerations(system, state, work, b: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Return the accelerations (nu,) and multipliers (ng,) from the second derivatives of prescribed motions alone.

    ``M a - L lam = 0, G a = b`` at the places of `state`; `b` (ng,) may come from another state.
    """
    equations = equations_at(system, state._replace(u=np.zeros(system.nu)), work)
    b = equations.b if b is None else b
    if not np.any(b):
        return np.zeros(system.nu), np.zeros(system.ng)
    right = np.concatenate([np.zeros(system.nu), b])
    are_lengths, least = system.lengths.are_lengths, equations.least_inertia
    found = splu(saddle(equations.M, equations.L, equations.G, SHARED, are_lengths, least)).solve(right)
    return found[: system.nu], found[system.nu :]
