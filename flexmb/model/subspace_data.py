"""A reduced body in a subspace of its flexible coordinates, without a new reduction."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TypeVar

import numpy as np
from scipy.linalg import eigh

from flexmb.model.modal_arrays import GeometricStiffness, InertiaInvariants, ModalArrays

__all__ = ["in_subspace", "own_shapes"]

Data = TypeVar("Data", bound=ModalArrays)


def own_shapes(data: ModalArrays, directions: np.ndarray) -> np.ndarray:
    """Return the shapes of a body that deforms in a subspace only, as flexible coordinates of `data`, (m, p).

    They are M-orthonormal, and the stiffness is diagonal.

    Parameters
    ----------
    directions : (m, p)
        Independent flexible coordinates.
    """
    K, M = (directions.T @ A @ directions for A in (data.stiffness, data.invariants.nn))
    _, y = eigh(0.5 * (K + K.T), 0.5 * (M + M.T))
    return directions @ y


def in_subspace(data: Data, T: np.ndarray) -> Data:
    """Return the body that deforms in a subspace only: eta = T y.

    Damping ratios are those that give the same work of damping in each shape. The quality report, which is of other
    shapes, is left out.

    Parameters
    ----------
    T : (m, p)
        The shapes, from `own_shapes`.
    """
    w2 = np.einsum("mp,mp->p", T, data.stiffness @ T)
    m, p = T.shape
    whole = np.block([[np.eye(6), np.zeros((6, p))], [np.zeros((m, 6)), T]])
    rates = 2.0 * np.pi * data.frequencies * data.damping_ratios * np.diag(data.invariants.nn)

    def turned(turning):
        return None if turning is None else np.swapaxes(whole, 0, 1) @ turning @ T

    return replace(
        data,
        shapes=data.shapes @ T,
        rotation_shapes=None if data.rotation_shapes is None else data.rotation_shapes @ T,
        marker_translations=data.marker_translations @ T,
        marker_rotations=data.marker_rotations @ T,
        stiffness=np.diag(w2),
        damping_ratios=(rates @ T**2) / np.sqrt(w2),
        frequencies=np.sqrt(w2) / (2.0 * np.pi),
        invariants=_invariants(data.invariants, T),
        geometric=None if data.geometric is None else _geometric(data.geometric, T),
        load_shapes=data.load_shapes @ whole,
        load_turning=turned(data.load_turning),
        preload_turning=turned(data.preload_turning),
        stress_modes=None if data.stress_modes is None else data.stress_modes @ T,
        quality={},
    )


def _invariants(i: InertiaInvariants, T: np.ndarray) -> InertiaInvariants:
    return InertiaInvariants(
        vv=i.vv,
        vw0=i.vw0,
        vw1=np.einsum("jab,jp->pab", i.vw1, T),
        vn=i.vn @ T,
        ww0=i.ww0,
        ww1=np.einsum("jab,jp->pab", i.ww1, T),
        ww2=np.einsum("jkab,jp,kq->pqab", i.ww2, T, T, optimize=True),
        wn0=i.wn0 @ T,
        wn1=np.einsum("jak,jp,kq->paq", i.wn1, T, T, optimize=True),
        nn=T.T @ i.nn @ T,
    )


def _geometric(geometric: GeometricStiffness, T: np.ndarray) -> GeometricStiffness:
    return GeometricStiffness(**{f.name: T.T @ getattr(geometric, f.name) @ T for f in fields(geometric)})
