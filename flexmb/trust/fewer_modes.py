"""A reduced body with fewer of its dynamic shapes: what its highest fixed-interface modes add to a run.

The shapes of a reduced body are orthonormal, so the highest of them hold most of the static deformation between its
interfaces: leaving them out is a coarser statics, not a coarser dynamics. Here the highest modes with all interfaces
held are left out. What remains is the K-orthogonal complement: all static deformation, and the response to the loads.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh, null_space

from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.model.subspace_data import in_subspace, own_shapes

__all__ = ["without_highest"]

SHARE = 4
"""One of so many of the modes with all interfaces held is left out, at least one."""
HELD = 1e-8
"""Singular values of the motion of the interfaces below this, relative to the largest, are zero."""


def without_highest(data: ModalNeutralData) -> tuple[ModalNeutralData, np.ndarray] | None:
    """Return the body without its highest modes with held interfaces, and its shapes (m, p); None if it has none.

    The shapes are flexible coordinates of the given body. It has none where there are static shapes only.
    """
    held, w2 = _held_modes(data)
    if not len(w2):
        return None
    drop = max(1, len(w2) // SHARE)
    # in the metric of K; what is left out must not answer to the loads
    responses = held.T @ data.load_shapes[:, 6:].T / np.sqrt(w2)[:, None]
    sizes = np.linalg.norm(responses, axis=0)
    kept = np.hstack([np.eye(len(w2))[:, : len(w2) - drop], responses[:, sizes > 0.0] / sizes[sizes > 0.0]])
    left_out = null_space(kept.T, rcond=HELD)
    if not left_out.shape[1]:
        return None
    dropped = held @ (left_out / np.sqrt(w2)[:, None])
    scale = 1.0 / np.sqrt(np.diag(data.stiffness))
    rest = scale[:, None] * null_space((data.stiffness @ dropped).T * scale, rcond=HELD)
    if not rest.shape[1]:
        return None
    T = own_shapes(data, rest)
    return in_subspace(data, T), T


def _held_modes(data: ModalNeutralData) -> tuple[np.ndarray, np.ndarray]:
    """Return the modes with all interfaces held, as flexible coordinates (m, k), and their w2 (k,), 1/s2, ascending."""
    i, n = data.invariants, data.n_interfaces
    mass = np.block([[i.vv, i.vw0, i.vn], [i.vw0.T, i.ww0, i.wn0], [i.vn.T, i.wn0.T, i.nn]])
    length = np.ptp(data.nodes, axis=0).max() or 1.0
    rows = [np.zeros((0, 6 + data.n_modes))]
    for r, u, turn in zip(
        data.marker_positions[:n], data.marker_translations[:n], data.marker_rotations[:n], strict=True
    ):
        lever = np.array([[0.0, r[2], -r[1]], [-r[2], 0.0, r[0]], [r[1], -r[0], 0.0]])  # w x r
        rows.append(np.hstack([np.eye(3), lever, u]))
        rows.append(length * np.hstack([np.zeros((3, 3)), np.eye(3), turn]))
    motion = np.vstack(rows)
    # of comparable size: a rigid motion by a length or a radian, and shapes of the same kinetic energy
    size = np.concatenate([np.ones(3), np.full(3, 1.0 / length), np.sqrt(data.mass / np.diag(i.nn))])
    free = size[:, None] * null_space(motion * size, rcond=HELD) if n else np.eye(6 + data.n_modes)[:, 6:]
    if not free.shape[1]:
        return np.zeros((data.n_modes, 0)), np.zeros(0)
    K, M = free[6:].T @ data.stiffness @ free[6:], free.T @ mass @ free
    mu, y = eigh(0.5 * (M + M.T), 0.5 * (K + K.T))  # the inverse problem keeps the digits of the low ones
    order = np.argsort(mu)[::-1]
    order = order[mu[order] > 0.0]
    return (free @ (y[:, order] / np.sqrt(mu[order])))[6:], 1.0 / mu[order]
