"""Momentum of a floating body: the first six rows of its mass matrix, times its velocities."""

from __future__ import annotations

import numpy as np

from flexmb.bodies.floating.inertia import mass_matrix
from flexmb.bodies.floating.row import invariants, pack_mass
from flexmb.bodies.frame_momentum import momentum_in_world
from flexmb.math.kernel import kernel

__all__ = ["floating_momentum"]


@kernel
def frame_momenta(mass, eta, u, out):
    """Write momentum and angular momentum (nt, 6) in the frame and about its origin; bulk data `mass`, eta (nt, m)."""
    m = eta.shape[1]
    terms = invariants(mass, 0, m)
    M, W = np.empty((6 + m, 6 + m)), np.empty((m, 6))
    for t in range(len(eta)):
        mass_matrix(terms, eta[t], M, W)
        for i in range(6):
            out[t, i] = 0.0
            for j in range(6 + m):
                out[t, i] += M[i, j] * u[t, j]


def floating_momentum(data, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Return momentum and angular momentum about the origin of W (nt, 6) for q (nt, 7 + m), u (nt, 6 + m)."""
    P = np.empty((len(q), 6))
    eta, u = (np.ascontiguousarray(values, float) for values in (q[:, 7:], u))
    frame_momenta(pack_mass(data.invariants), eta, u, P)
    return momentum_in_world(q, P[:, :3], P[:, 3:])
