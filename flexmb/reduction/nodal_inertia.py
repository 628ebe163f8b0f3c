"""Inertia that turns with nodes: rotary inertia and mass on arms, from the rows of the mass matrix at rotations.

A node with rotations theta has the angular velocity w + theta' + w x theta + (theta x (theta x w) - theta x theta') / 2
in its own, turned axes, in which its inertia is constant (docs, theory "floating-frame", eq. (nodal-spin)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from flexmb.fem.fe_model import FEModel

__all__ = ["NodalInertia"]


@dataclass(frozen=True, eq=False)
class NodalInertia:
    """Blocks of the mass matrix at rotational freedoms.

    Parameters
    ----------
    translations, rotations : (3 n, ndof) csr
        What picks the translations and the rotations of all nodes out of the freedoms.
    coupling : (3 n, 3 n) csr, kg m
        Momentum of the translations per rotation.
    arms : (3 n, 3 n) csr, kg m
        Its antisymmetric blocks: ``arms @ theta`` is theta x S, the first moment S of the mass that turns with a node.
    rotary : (n, 3, 3), kg m2
        Angular momentum at all nodes per angular velocity of each: column sums of the rotational block.
    """

    translations: sparse.csr_matrix
    rotations: sparse.csr_matrix
    coupling: sparse.csr_matrix
    arms: sparse.csr_matrix
    rotary: np.ndarray

    @classmethod
    def of(cls, fe: FEModel) -> NodalInertia | None:
        """Return the blocks of an FE model, or None if no node has rotations with inertia."""
        if not np.any(fe.dofs[:, 1] >= 3):
            return None
        n = len(fe.nodes)
        translations, rotations = (_picked(fe, first) for first in (0, 3))
        by_rotation = fe.M @ rotations.T
        if not by_rotation.nnz:
            return None
        coupling, spin = (translations @ by_rotation).tocoo(), rotations @ by_rotation
        total = sparse.csr_matrix(np.tile(np.eye(3), n)) @ spin  # (3, 3 n)
        return cls(
            translations=translations,
            rotations=rotations,
            coupling=coupling.tocsr(),
            arms=_antisymmetric(coupling, np.diff(translations.indptr) > 0, np.diff(rotations.indptr) > 0),
            rotary=total.toarray().reshape(3, n, 3).transpose(1, 0, 2),
        )

    def turned_arms(self, axis: int, shapes: np.ndarray) -> np.ndarray:
        """Return the momentum (ndof, m) of ``e_k x (theta x S)`` less ``(e_k x theta) x S``, which M P_k Phi has."""
        theta = self.rotations @ shapes
        momentum = _turned(axis, self.arms @ theta) - self.coupling @ _turned(axis, theta)
        return self.translations.T @ momentum

    def second_order(self, shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return what the second-order spin adds to ww2 (m, m, 3, 3) and wn1 (m, 3, m).

        w . J (theta_i x (theta_j x w)) / 2 and -w . J (theta_j x theta_k') / 2, summed over the nodes.
        """
        m = shapes.shape[1]
        if m == 0:
            return np.zeros((0, 0, 3, 3)), np.zeros((0, 3, 0))
        theta = (self.rotations @ shapes).reshape(len(self.rotary), 3, m)
        ww2, wn1 = np.zeros((m, m, 3, 3)), np.zeros((m, 3, m))
        flat = theta.reshape(-1, m)
        for k in range(3):
            row = self.rotary[:, k, :]  # (n, 3)
            along = np.einsum("bp,bpi->bi", row, theta)
            crossed = np.cross(row[:, :, None], theta, axis=1).reshape(-1, m)
            wn1[:, k, :] = -0.5 * crossed.T @ flat
            for l in range(3):
                weighted = (row[:, l, None, None] * theta).reshape(-1, m)
                ww2[:, :, k, l] = along.T @ theta[:, l] - weighted.T @ flat
        ww2 = 0.25 * (ww2 + ww2.transpose(1, 0, 2, 3))
        return ww2 + ww2.transpose(0, 1, 3, 2), wn1

    def moments(self, field: np.ndarray) -> np.ndarray:
        """Return the moments (ndof,) of the inertia at the nodes in an acceleration field ``field @ x``, (3, 3), 1/s2.

        ``int y x (B y) dm`` of the mass around a node, whose second moments are (tr J) / 2 I - J.
        """
        second = 0.5 * np.trace(self.rotary, axis1=1, axis2=2)[:, None, None] * np.eye(3) - self.rotary
        tensor = np.einsum("kl,nlj->nkj", field, second)
        moment = np.stack([tensor[:, (i + 2) % 3, (i + 1) % 3] - tensor[:, (i + 1) % 3, (i + 2) % 3] for i in range(3)])
        return self.rotations.T @ moment.T.ravel()


def _picked(fe: FEModel, first: int) -> sparse.csr_matrix:
    column = np.flatnonzero((fe.dofs[:, 1] >= first) & (fe.dofs[:, 1] < first + 3))
    row = 3 * fe.dofs[column, 0] + fe.dofs[column, 1] - first
    return sparse.csr_matrix((np.ones(len(column)), (row, column)), shape=(3 * len(fe.nodes), fe.ndof))


def _antisymmetric(blocks: sparse.coo_matrix, translates: np.ndarray, turns: np.ndarray) -> sparse.csr_matrix:
    """Return the antisymmetric part of all (3, 3) blocks; an entry whose mirror image has no freedoms stays."""
    i, j = blocks.row % 3, blocks.col % 3
    off = i != j
    row, column, value, i, j = blocks.row[off], blocks.col[off], blocks.data[off], i[off], j[off]
    mirrored = row - i + j, column - j + i
    both = translates[mirrored[0]] & turns[mirrored[1]]
    half = np.where(both, 0.5, 1.0) * value
    return sparse.csr_matrix(
        (
            np.concatenate([half, -half[both]]),
            (np.concatenate([row, mirrored[0][both]]), np.concatenate([column, mirrored[1][both]])),
        ),
        shape=blocks.shape,
    )


def _turned(axis: int, vectors: np.ndarray) -> np.ndarray:
    """Return e_k x of nodal vectors stacked as (3 n, m)."""
    a, b = (axis + 1) % 3, (axis + 2) % 3
    out = np.zeros_like(vectors)
    out[b::3], out[a::3] = vectors[a::3], -vectors[b::3]
    return out
