"""`ModalLink`: what a reduced body is as a link of a tree, by constants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

__all__ = ["ModalLink"]


@dataclass(frozen=True, kw_only=True, eq=False)
class ModalLink:
    """A body with m modes in its own axes, about the origin of its frame; see `InertiaInvariants` for the names.

    Its mass is the same in all directions (``vv`` = mass 1); the mass of a planar mesh is not.

    Parameters
    ----------
    mass : float, kg
    vw0, ww0 : (3, 3), kg m and kg m2
    vw1 : (m, 3, 3), kg
    vn, wn0 : (3, m), kg and kg m
    ww1 : (m, 3, 3), kg m
    ww2 : (m, m, 3, 3), kg
        Symmetric in its modes.
    wn1 : (m, 3, m), kg
    nn, stiffness, damping : (m, m)
    mean : (6, m)
        Rigid motion (v, w) that has the momenta of each mode.
    inertia_stiffening : (12, m, m) or (0, m, m)
        Geometric stiffness of unit acceleration fields A + B x.
    interface_stiffening : (ni, 6, m, m)
        That of unit forces and moments at the first `ni` markers, in body axes.
    load_stiffening : (nl, m, m) or (0, m, m)
        That of unit loads on the load shapes.
    preload_stiffening : (m, m)
    load_shapes : (nl, 6 + m)
    load_turning : (nt, 6 + m, m)
        Change of the load shapes by the modes; one more than load shapes for the preload.
    positions, axes : (k, 3) m, (k, 3, 3)
        Of the undeformed markers.
    translations, rotations : (k, 3, m), - and 1/m
    """

    mass: float
    vw0: np.ndarray
    ww0: np.ndarray
    vw1: np.ndarray
    vn: np.ndarray
    wn0: np.ndarray
    ww1: np.ndarray
    ww2: np.ndarray
    wn1: np.ndarray
    nn: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    mean: np.ndarray
    inertia_stiffening: np.ndarray
    interface_stiffening: np.ndarray
    load_stiffening: np.ndarray
    preload_stiffening: np.ndarray
    load_shapes: np.ndarray
    load_turning: np.ndarray
    positions: np.ndarray
    axes: np.ndarray
    translations: np.ndarray
    rotations: np.ndarray

    @property
    def modes(self) -> int:
        """Number of modes."""
        return len(self.nn)
