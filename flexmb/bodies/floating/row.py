"""The row and the bulk data of a floating body: modal neutral data, packed for the kernels."""

from __future__ import annotations

import numpy as np

from flexmb.bodies.rows import HEADER
from flexmb.math.kernel import kernel

__all__ = ["ROW", "geometry", "invariants", "mean_motion", "pack", "pack_mass", "stiffness_matrices"]

ROW = np.dtype(
    [
        *HEADER,
        ("modes", np.int64),  # m
        ("interfaces", np.int64),  # markers whose wrench stiffens the body: the first ones
        ("loads", np.int64),  # number of load shapes
        ("first_load", np.int64),  # their first place in work.loads
        ("turning", np.int64),  # number of matrices by which loads turn: 0, one per load, or one more for the preload
        ("stiffening", np.int64),  # number of geometric stiffness matrices, 0: none
        ("mass", np.int64),  # invariants in the bulk data
        ("geometry", np.int64),  # markers in the bulk data
        ("elastic", np.int64),  # stiffness, damping, load shapes, geometric stiffness in the bulk data
        ("gravity", float, 3),  # m/s2, in W
    ],
    align=True,
)

SYMMETRIC = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
"""Order of the six entries of a symmetric (3, 3) matrix."""


def pack(
    data, damping: np.ndarray, groups: tuple[str, ...], poses
) -> tuple[np.ndarray, np.ndarray, np.ndarray, int, int]:
    """Return mass, geometry and elastic bulk data, and how many matrices of geometric stiffness and of turning loads.

    Parameters
    ----------
    data : ModalNeutralData
    damping : (m, m), N s/m
    groups : names among "inertia", "interface", "loads", "preload"
        The geometric stiffness that acts.
    poses : sequence of Pose
        Undeformed markers in body axes.
    """
    m = data.n_modes
    geometry = []
    for k, pose in enumerate(poses):
        geometry += [np.array(pose.at), pose.matrix, data.marker_translations[k], data.marker_rotations[k]]
    turning = data.load_turning if data.load_turning is not None and m else np.zeros((0, 6 + m, m))
    if data.preload_turning is not None and "preload" in groups and m:
        missing = np.zeros((len(data.load_names) - len(turning), 6 + m, m))
        turning = np.concatenate([turning, missing, data.preload_turning[None]])
    elastic = [data.stiffness, damping, data.load_shapes, turning]
    n_stiffening = 0
    g = data.geometric
    if g is not None and groups and m:
        parts = {
            "inertia": g.inertia,
            "interface": g.interface.reshape(-1, m, m),
            "loads": g.loads,
            "preload": g.preload[None],
        }
        matrices = np.concatenate([part if name in groups else np.zeros_like(part) for name, part in parts.items()])
        n_stiffening = len(matrices)
        # row j of all matrices side by side: the product of all with eta is one sum of long rows
        elastic.append(0.5 * (matrices + np.swapaxes(matrices, 1, 2)).transpose(1, 0, 2))
    return pack_mass(data.invariants), _flat(geometry), _flat(elastic), n_stiffening, len(turning)


def _flat(arrays) -> np.ndarray:
    return np.concatenate([np.asarray(a, float).ravel() for a in arrays] or [np.empty(0)])


def pack_mass(i) -> np.ndarray:
    """Return the bulk data of the inertia invariants, as `invariants` and `mean_motion` read them."""
    rows, columns = zip(*SYMMETRIC, strict=True)
    ww2 = 0.5 * (i.ww2 + np.swapaxes(i.ww2, 2, 3))
    ww2 = 0.5 * (ww2 + np.swapaxes(ww2, 0, 1))
    pairs = np.swapaxes(ww2[:, :, rows, columns], 1, 2)  # (m, 6, m): sums over modes run along rows
    return _flat(
        [i.vv, i.vw0, i.vw1, i.vn, i.ww0, i.ww1[:, rows, columns], pairs, i.wn0, i.wn1, i.nn, mean_of_modes(i)]
    )


def mean_of_modes(invariants) -> np.ndarray:
    """Return the rigid motion (v, w) of the frame that has the momenta of each mode, (6, m): zero in the mean frame."""
    i = invariants
    rigid = np.block([[i.vv, i.vw0], [i.vw0.T, i.ww0]])
    scale = 1.0 / np.sqrt(np.where(np.diag(rigid) > 0.0, np.diag(rigid), 1.0))  # a planar model lacks some motions
    momenta = np.vstack([i.vn, i.wn0])
    return scale[:, None] * (
        np.linalg.pinv(rigid * np.outer(scale, scale), hermitian=True) @ (scale[:, None] * momenta)
    )


@kernel
def invariants(data, start, m):
    """Return the views vv, vw0, vw1, vn, ww0, ww1, ww2, wn0, wn1, nn of the inertia invariants (see the model room)."""
    a = start
    vv = data[a : a + 9].reshape((3, 3))
    vw0 = data[a + 9 : a + 18].reshape((3, 3))
    a += 18
    vw1 = data[a : a + 9 * m].reshape((m, 3, 3))
    a += 9 * m
    vn = data[a : a + 3 * m].reshape((3, m))
    a += 3 * m
    ww0 = data[a : a + 9].reshape((3, 3))
    a += 9
    ww1 = data[a : a + 6 * m].reshape((m, 6))
    a += 6 * m
    ww2 = data[a : a + 6 * m * m].reshape((m, 6, m))
    a += 6 * m * m
    wn0 = data[a : a + 3 * m].reshape((3, m))
    a += 3 * m
    wn1 = data[a : a + 3 * m * m].reshape((m, 3, m))
    a += 3 * m * m
    nn = data[a : a + m * m].reshape((m, m))
    return vv, vw0, vw1, vn, ww0, ww1, ww2, wn0, wn1, nn


@kernel
def mean_motion(data, start, m):
    """Return the view (6, m) of `mean_of_modes`, behind the invariants."""
    a = start + 27 + 21 * m + 10 * m * m
    return data[a : a + 6 * m].reshape((6, m))


@kernel
def geometry(data, start, k, m):
    """Return position (3,), axes (3, 3), translation and rotation shapes (3, m) of marker `k`."""
    a = start + k * (12 + 6 * m)
    s = data[a : a + 3]
    axes = data[a + 3 : a + 12].reshape((3, 3))
    translation = data[a + 12 : a + 12 + 3 * m].reshape((3, m))
    rotation = data[a + 12 + 3 * m : a + 12 + 6 * m].reshape((3, m))
    return s, axes, translation, rotation


@kernel
def stiffness_matrices(data, start, m, loads, turning, stiffening):
    """Return the views K, D (m, m), load shapes (nl, 6 + m), how they turn (nt, 6 + m, m) and geometric stiffness
    (m, n, m), row by row."""
    a = start
    K = data[a : a + m * m].reshape((m, m))
    a += m * m
    D = data[a : a + m * m].reshape((m, m))
    a += m * m
    shapes = data[a : a + loads * (6 + m)].reshape((loads, 6 + m))
    a += loads * (6 + m)
    turned = data[a : a + turning * (6 + m) * m].reshape((turning, 6 + m, m))
    a += turning * (6 + m) * m
    G = data[a : a + stiffening * m * m].reshape((m, stiffening, m))
    return K, D, shapes, turned, G
