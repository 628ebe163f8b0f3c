"""Inertia invariants: the coefficients of the body mass matrix, from the FE mass matrix by block products.

With V(eta) = [E | P (X + Phi eta) | Phi] the body mass matrix V^T M V is a quadratic polynomial in eta; its
coefficients are the Gram matrices of the fixed vectors E_k, P_k X, P_k Phi_j, Phi_j (docs, theory "reduction").
"""

from __future__ import annotations

import numpy as np

from flexmb.fem.fe_model import FEModel
from flexmb.model.modal_neutral_data import InertiaInvariants

__all__ = ["inertia_invariants", "rotated"]


def rotated(fe: FEModel, shapes: np.ndarray) -> np.ndarray:
    """Return P_k Phi_j, the shapes turned about each axis, translation rows only: (3, ndof, m)."""
    translation = fe.dofs[:, 1] < 3
    node, direction = fe.dofs[translation, 0], fe.dofs[translation, 1]
    row = np.full((len(fe.nodes), 3), -1)
    row[node, direction] = np.flatnonzero(translation)
    out = np.zeros((3, *shapes.shape))
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3  # (e_k x u)_b = u_a and (e_k x u)_a = -u_b
        for target, source, sign in ((b, a, 1.0), (a, b, -1.0)):
            both = (row[:, target] >= 0) & (row[:, source] >= 0)
            out[k, row[both, target]] = sign * shapes[row[both, source]]
    return out


def inertia_invariants(fe: FEModel, shapes: np.ndarray) -> InertiaInvariants:
    """Return the ten coefficient arrays for the shapes Phi (ndof, m)."""
    rigid = fe.rigid_motions()
    E, PX = rigid[:, :3], rigid[:, 3:]
    P = rotated(fe, shapes)
    ME, MPX, MPhi = np.split(fe.M @ np.hstack([rigid, shapes]), [3, 6], axis=1)
    m = shapes.shape[1]
    vw1, ww1, ww2, wn1 = (np.zeros(size) for size in ((m, 3, 3), (m, 3, 3), (m, m, 3, 3), (m, 3, m)))
    for l in range(3):  # one axis at a time: M P_l Phi is as large as the modes
        MP = fe.M @ P[l]
        vw1[:, :, l], ww1[:, :, l], wn1[:, l] = MP.T @ E, MP.T @ PX, MP.T @ shapes
        for k in range(3):
            ww2[:, :, k, l] = P[k].T @ MP
    return InertiaInvariants(
        vv=_symmetric(E.T @ ME),
        vw0=E.T @ MPX,
        vw1=vw1,
        vn=ME.T @ shapes,
        ww0=_symmetric(PX.T @ MPX),
        ww1=ww1 + ww1.transpose(0, 2, 1),
        ww2=ww2,
        wn0=MPX.T @ shapes,
        wn1=wn1,
        nn=_symmetric(shapes.T @ MPhi),
    )


def _symmetric(a: np.ndarray) -> np.ndarray:
    return 0.5 * (a + a.T)
