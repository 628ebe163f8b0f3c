"""Inertia invariants: the coefficients of the body mass matrix, from the FE mass matrix by block products.

With V(eta) = [E | P (X + Phi eta) | Phi] the body mass matrix V^T M V is a quadratic polynomial in eta; its
coefficients are the Gram matrices of the fixed vectors E_k, P_k X, P_k Phi_j, Phi_j, and what nodes with rotations add,
whose inertia turns with them (docs, theory "floating-frame", eq. (rotary-inertia)).
"""

from __future__ import annotations

import numpy as np

from flexmb.fem.fe_model import FEModel
from flexmb.model.modal_arrays import InertiaInvariants
from flexmb.reduction.nodal_inertia import NodalInertia

__all__ = ["inertia_invariants", "rotated"]


def rotated(fe: FEModel, shapes: np.ndarray) -> np.ndarray:
    """Return P_k Phi_j, translations and rotations of the shapes turned about each axis: (3, ndof, m)."""
    row = np.full((len(fe.nodes), 6), -1)
    row[fe.dofs[:, 0], fe.dofs[:, 1]] = np.arange(fe.ndof)
    out = np.zeros((3, *shapes.shape))
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3  # (e_k x u)_b = u_a and (e_k x u)_a = -u_b
        for target, source, sign in ((b, a, 1.0), (a, b, -1.0)):
            for kind in (0, 3):
                both = (row[:, kind + target] >= 0) & (row[:, kind + source] >= 0)
                out[k, row[both, kind + target]] = sign * shapes[row[both, kind + source]]
    return out


def inertia_invariants(fe: FEModel, shapes: np.ndarray) -> InertiaInvariants:
    """Return the ten coefficient arrays for the shapes Phi (ndof, m)."""
    if fe.condensed is not None:
        return inertia_invariants(fe.condensed.whole, fe.condensed.fields @ shapes)
    rigid = fe.rigid_motions()
    E, PX = rigid[:, :3], rigid[:, 3:]
    P = rotated(fe, shapes)
    nodal = NodalInertia.of(fe)
    ME, MPX, MPhi = np.split(fe.M @ np.hstack([rigid, shapes]), [3, 6], axis=1)
    m = shapes.shape[1]
    vw1, ww1, ww2, wn1 = (np.zeros(size) for size in ((m, 3, 3), (m, 3, 3), (m, m, 3, 3), (m, 3, m)))
    for l in range(3):  # one axis at a time: M P_l Phi is as large as the modes
        MP = fe.M @ P[l]
        if nodal is not None:
            arms = nodal.turned_arms(l, shapes)
            MP += arms
            for k in range(
                3
            ):  # the other half of 1/2 w . M_ww w, which arms, no product by M, do not have on both sides
                ww2[:, :, l, k] += arms.T @ P[k]
        vw1[:, :, l], ww1[:, :, l], wn1[:, l] = MP.T @ E, MP.T @ PX, MP.T @ shapes
        for k in range(3):
            ww2[:, :, k, l] += P[k].T @ MP
    if nodal is not None:
        squares, spins = nodal.second_order(shapes)
        ww2, wn1 = ww2 + squares, wn1 + spins
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
