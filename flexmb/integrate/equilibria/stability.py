"""Is an equilibrium at rest stable? Forces in balance say nothing of it: a pendulum stands on its head, too."""

from __future__ import annotations

import numpy as np
from scipy import linalg

__all__ = ["unstable_motion"]

DENSE = 300
"""Velocities of a model up to which this is looked at."""
DIGITS, NEGLIGIBLE = 1e-12, 1e-7
"""Negative stiffness that is rounding: relative to the stiffnesses whose sum it is, and to the one that loads make."""
SYMMETRIC = 1e-6
"""Relative difference of a stiffness and its transpose beyond which loads follow the motion."""


def unstable_motion(tangent, extent: np.ndarray, by_loads: float) -> tuple[int, float] | None:
    """Return the freedom that moves most in the motion which leaves an equilibrium fastest, and the time, s, in which
    that grows by e; None if there is none.

    With K x = w2 M x on the motions that the equations allow, G x = 0, a negative real w2 means divergence, which no
    damping prevents. Flutter under follower loads (complex w2) is not looked for: see `linearize`.

    Parameters
    ----------
    tangent : Tangent
        M, K and G at the equilibrium; without first-order states.
    extent : (nu,)
        Lengths that a unit of each freedom moves: 1 for translations, m for rotations.
    by_loads : N/m
        The largest force over the size of the model: loads make stiffnesses of about this size.
    """
    nu = len(extent)
    if not 0 < nu <= DENSE:
        return None
    scale = 1.0 / np.where(extent > 0.0, extent, 1.0)
    M, K, G = (np.asarray(part.todense()) for part in (tangent.M, tangent.K, tangent.G))
    K, M, size = scale[:, None] * K * scale, scale[:, None] * M * scale, scale[:, None] * np.abs(K) * scale
    G = G * scale
    rows = np.linalg.norm(G, axis=1, keepdims=True)
    N = linalg.null_space(G / np.where(rows > 0.0, rows, 1.0), rcond=1e-9) if len(G) else np.eye(nu)
    if not N.shape[1] or not (np.all(np.isfinite(K)) and np.all(np.isfinite(N))):
        return None
    inner, inertia = N.T @ K @ N, N.T @ (0.5 * (M + M.T)) @ N
    if np.linalg.norm(inner - inner.T) > SYMMETRIC * np.linalg.norm(inner):
        values, vectors = linalg.eig(inner, inertia)
        real = np.isfinite(values) & (np.abs(values.imag) <= SYMMETRIC * np.abs(values.real))
        values, vectors = np.where(real, values.real, np.inf), vectors.real
    else:
        try:
            values, vectors = linalg.eigh(0.5 * (inner + inner.T), inertia)
        except linalg.LinAlgError:  # a motion without inertia
            return None
    k = int(np.argmin(values))
    x = N @ vectors[:, k]
    rounding = max(DIGITS * (np.abs(x) @ size @ np.abs(x)), NEGLIGIBLE * (x @ x) * by_loads)
    if not (x @ K @ x < -rounding and values[k] < 0.0):
        return None
    return int(np.argmax(np.abs(x))), float(1.0 / np.sqrt(-values[k]))
