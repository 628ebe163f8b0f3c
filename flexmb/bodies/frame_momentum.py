"""Momentum of bodies with a frame, from what it is in their own axes."""

from __future__ import annotations

import numpy as np

from flexmb.math.rotations import euler_to_matrix

__all__ = ["momentum_in_world", "rigid_momentum"]


def momentum_in_world(q: np.ndarray, P: np.ndarray, h: np.ndarray) -> np.ndarray:
    """Return momentum and angular momentum about the origin of W (nt, 6), from those (nt, 3) in the frame, about it."""
    R = np.empty((len(q), 3, 3))
    for k in range(len(q)):
        euler_to_matrix(q[k, 3:7], R[k])
    P_W, h_W = np.einsum("tij,tj->ti", R, P), np.einsum("tij,tj->ti", R, h)
    return np.hstack([P_W, np.cross(q[:, :3], P_W) + h_W])


def rigid_momentum(mass: float, c, J, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Return the momenta of a rigid body: m (v + w x c) and J w + c x m (v + w x c), J about the centre of mass c."""
    v, w = u[:, :3], u[:, 3:6]
    P = mass * (v + np.cross(w, c))
    return momentum_in_world(q, P, w @ np.asarray(J).T + np.cross(c, P))
