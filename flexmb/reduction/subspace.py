"""Any displacements as a basis: in coordinates of constraint modes and of fixed-interface shapes.

A displacement that the couplings allow is ``u = Psi q + N c``: its interface coordinates q move the constraint modes,
and what is left vanishes at the interfaces. In these coordinates every basis is a subspace of one Craig-Bampton basis.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh

from flexmb.errors import ReductionError
from flexmb.reduction.basis import NormalModes
from flexmb.reduction.framed_body import FramedBody

__all__ = ["in_coordinates", "orthonormal_blocks"]

_DEPENDENT = 1e-8  # mass norm of what is new in a direction, relative to the direction, below which it is rounding
_SMALL = 1e-10  # the same for what moves with the interfaces held: it need only be known beside the whole


def orthonormal_blocks(M, blocks: list[np.ndarray], tolerance: float = _DEPENDENT, unit: bool = True) -> np.ndarray:
    """Return an M-orthonormal basis (ndof, p) of all columns of the blocks, earlier ones first.

    Directions that earlier columns hold already, and those without mass, are left out (deflation). `unit` says whether
    columns count by their direction, or by their size.
    """
    kept = np.zeros((blocks[0].shape[0] if blocks else 0, 0))
    for block in blocks:
        size = np.sqrt(np.maximum(np.einsum("ij,ij->j", block, M @ block), 0.0))
        new = block[:, size > 0.0] / size[size > 0.0] if unit else block
        floor = tolerance
        while new.shape[1]:
            for _ in range(2):
                new = new - kept @ (kept.T @ (M @ new))
            gram = new.T @ (M @ new)
            length, turn = eigh(0.5 * (gram + gram.T))
            keep = length > max(floor**2, 1e-14 * length[-1])
            clean = bool(len(length)) and bool(np.all(np.abs(length - 1.0) < 1e-6))
            new = new @ (turn[:, keep] / np.sqrt(length[keep]))
            floor = 0.5  # from here on every column has the length of one; what falls below is rounding
            if clean:
                break
        kept = np.hstack([kept, new])
    return kept


def in_coordinates(framed: FramedBody, vectors: np.ndarray) -> tuple[NormalModes, np.ndarray]:
    """Return fixed-interface shapes N and the coordinates (nq + k, p) of displacements in constraint modes and N.

    `vectors` (ndof, p) become M-orthonormal and lose the rigid motion of the frame.
    """
    body, fe = framed.body, framed.body.fe
    if vectors.shape[1] == 0:
        raise ReductionError(
            f"FE model '{fe.name}'",
            found="a basis without shapes",
            expected="at least one elastic displacement",
            remedy="Name interfaces or loads that deform the body, or give more snapshots or modes",
        )
    vectors = orthonormal_blocks(fe.M, [framed.elastic(vectors)])
    q = body.coordinates(vectors)
    rest = vectors - body.constraint_modes @ q
    shapes = orthonormal_blocks(fe.M, [rest], _SMALL, unit=False)
    K, M = shapes.T @ (fe.K @ shapes), shapes.T @ (fe.M @ shapes)
    if shapes.shape[1]:
        mu, turn = eigh(0.5 * (M + M.T), 0.5 * (K + K.T))
        order = np.argsort(mu)[::-1]
        normal = NormalModes(shapes @ (turn[:, order] / np.sqrt(mu[order])), 1.0 / mu[order])
    else:
        normal = NormalModes(shapes, np.zeros(0))
    return normal, np.vstack([q, normal.vectors.T @ (fe.M @ rest)])
