"""Momentum of bodies with a frame, from what it is in their own axes."""

from __future__ import annotations

import numpy as np

from flexmb.math.rotations import euler_to_matrix

__all__ = ["floating_momentum", "rigid_momentum"]


def _in_world(q: np.ndarray, P: np.ndarray, h: np.ndarray) -> np.ndarray:
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
    return _in_world(q, P, w @ np.asarray(J).T + np.cross(c, P))


def floating_momentum(I, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Return the momenta of a reduced body with the invariants I: rows 1 to 6 of M_b(eta) (v, w, eta')."""
    eta, v, w, rate = q[:, 7:], u[:, :3], u[:, 3:6], u[:, 6:]
    vw = I.vw0 + np.einsum("tj,jkl->tkl", eta, I.vw1)
    ww = I.ww0 + np.einsum("tj,jkl->tkl", eta, I.ww1)
    ww += np.einsum("ti,tj,ijkl->tkl", eta, eta, I.ww2, optimize=True)
    wn = I.wn0 + np.einsum("tj,jkl->tkl", eta, I.wn1)
    P = v @ I.vv.T + np.einsum("tkl,tl->tk", vw, w) + rate @ I.vn.T
    h = np.einsum("tlk,tl->tk", vw, v) + np.einsum("tkl,tl->tk", ww, w) + np.einsum("tkl,tl->tk", wn, rate)
    return _in_world(q, P, h)
