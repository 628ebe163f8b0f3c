"""What drives that speed up do to a mechanism at rest: an equilibrium takes them at their positions of the moment."""

from __future__ import annotations

import numpy as np
from scipy.sparse.linalg import splu

from flexmb.integrate.linear.steady import saddle
from flexmb.integrate.matrices import equations_at

__all__ = ["driven_accelerations"]

SHARED = 1e-12
"""Softness of equations, relative, that keeps dependent ones solvable."""


def driven_accelerations(system, state, work) -> tuple[np.ndarray, np.ndarray]:
    """Return the accelerations (nu,) and multipliers (ng,) from the second derivatives of prescribed motions alone.

    ``M a - L lam = 0, G a = b``; at rest the right side b holds nothing else.
    """
    rest = state._replace(u=np.zeros(system.nu), a=np.zeros(system.nu), lam=np.zeros(system.ng))
    equations = equations_at(system, rest, work)
    if not np.any(equations.b):
        return np.zeros(system.nu), np.zeros(system.ng)
    right = np.concatenate([np.zeros(system.nu), equations.b])
    found = splu(saddle(equations.M, equations.L, equations.G, SHARED)).solve(right)
    return found[: system.nu], found[system.nu :]
