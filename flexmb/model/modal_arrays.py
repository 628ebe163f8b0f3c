"""The arrays of a reduced elastic body, and what they are called; `ModalNeutralData` is what can be done with them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

import numpy as np

from flexmb.model.numbering import Numbering

__all__ = ["GeometricStiffness", "InertiaInvariants", "LeftOutStiffness", "ModalArrays"]


@dataclass(frozen=True, kw_only=True, eq=False)
class InertiaInvariants:
    """Coefficients of the body mass matrix, a quadratic polynomial in eta (theory, "floating frame", M_b).

    With the fixed vectors E_k (unit translation), P_k X (rigid rotation), P_k Phi_j (rotated modes) and
    Phi_j, all scalar products under the FE mass matrix M::

        M_vv                = E^T M E                    vv  (3, 3)     kg
        M_vw = vw0 + sum_j eta_j vw1[j]                  vw0 (3, 3)     kg m     vw1 (m, 3, 3)     kg
        M_vn                = E^T M Phi                  vn  (3, m)     kg
        M_ww = ww0 + sum_j eta_j ww1[j] + sum_jk eta_j eta_k ww2[j, k]
                                                         ww0 (3, 3)     kg m2    ww1 (m, 3, 3)     kg m
                                                         ww2 (m, m, 3, 3)  kg
        M_wn = wn0 + sum_j eta_j wn1[j]                  wn0 (3, m)     kg m     wn1 (m, 3, m)     kg
        M_nn                = Phi^T M Phi                nn  (m, m)     kg
    """

    vv: np.ndarray
    vw0: np.ndarray
    vw1: np.ndarray
    vn: np.ndarray
    ww0: np.ndarray
    ww1: np.ndarray
    ww2: np.ndarray
    wn0: np.ndarray
    wn1: np.ndarray
    nn: np.ndarray

    def selected(self, modes: np.ndarray) -> InertiaInvariants:
        """Return the invariants of a subset of the modes (int indices)."""
        j = np.asarray(modes, int)
        return InertiaInvariants(
            vv=self.vv,
            vw0=self.vw0,
            vw1=self.vw1[j],
            vn=self.vn[:, j],
            ww0=self.ww0,
            ww1=self.ww1[j],
            ww2=self.ww2[np.ix_(j, j)],
            wn0=self.wn0[:, j],
            wn1=self.wn1[j][:, :, j],
            nn=self.nn[np.ix_(j, j)],
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class GeometricStiffness:
    """Modal geometric stiffness matrices of unit loads, N/m each per unit of the load (Banerjee 1993).

    ``inertia`` (12, m, m): index k = 0..2 for the nodal forces -M E_k, scaled by A_k (m/s2); index 3 + 3 k + l
    for -M [x_l e_k], scaled by B_kl (1/s2), of the acceleration field a(x) = A + B x, gravity included in A.
    ``interface`` (ni, 6, m, m): unit force (N) and moment (N m) along the body axes at each interface.
    ``loads`` (nl, m, m): one per load shape. ``preload`` (m, m): constant.
    """

    inertia: np.ndarray
    interface: np.ndarray
    loads: np.ndarray
    preload: np.ndarray

    def selected(self, modes: np.ndarray) -> GeometricStiffness:
        """Return the matrices of a subset of the modes (int indices)."""
        j = np.asarray(modes, int)
        return GeometricStiffness(**{f.name: getattr(self, f.name)[..., j, :][..., j] for f in fields(self)})


@dataclass(frozen=True, kw_only=True, eq=False)
class LeftOutStiffness(GeometricStiffness):
    """Geometric stiffness, left out by a reduction or not, on some soft shapes and the three turns of the body.

    The matrices are those of unit loads, as in `GeometricStiffness`; left out, there is no preload. The first shapes
    have the strain energy 1/2 at a coordinate of 1, in a unit of energy of their own, so that only the units of the
    loads count: the eigenvalues of the sum of the matrices, each times its load, are relative changes of stiffness.

    ``translations`` (ni, 3, k), m, and ``turns`` (ni, 3, k): motion of each interface by the shapes, in body axes, for
    one unit of the last three coordinates. ``compliance`` (6 ni, 6 ni): what the stiffer shapes add to the motions
    (translation, turn) of the interfaces under unit forces and moments on them, in these units.
    """

    translations: np.ndarray
    turns: np.ndarray
    compliance: np.ndarray


@dataclass(frozen=True, kw_only=True, eq=False)
class ModalArrays:
    """The fields of `ModalNeutralData`, which says what they hold."""

    name: str
    nodes: np.ndarray
    cells: tuple[tuple[str, np.ndarray], ...]
    shapes: np.ndarray
    rotation_shapes: np.ndarray | None = None
    marker_names: tuple[str, ...]
    n_interfaces: int
    marker_positions: np.ndarray
    marker_translations: np.ndarray
    marker_rotations: np.ndarray
    stiffness: np.ndarray
    damping_ratios: np.ndarray
    frequencies: np.ndarray
    invariants: InertiaInvariants
    geometric: GeometricStiffness | None = None
    left_out: LeftOutStiffness | None = None
    load_names: tuple[str, ...] = ()
    load_shapes: np.ndarray
    load_turning: np.ndarray | None = None
    preload_turning: np.ndarray | None = None
    stress_modes: np.ndarray | None = None
    frame: str = "buckens"
    quality: dict[str, Any] = field(default_factory=dict)
    recipe: dict[str, Any] = field(default_factory=dict)
    node_sets: Mapping[str, np.ndarray] = field(default_factory=dict)
    numbering: Numbering | None = None

    @property
    def n_modes(self) -> int:
        """Number m of flexible coordinates."""
        return self.stiffness.shape[0]

    @property
    def mass(self) -> float:
        """Mass, kg (a planar FE model has mass only in the directions of its freedoms)."""
        return float(np.diag(self.invariants.vv).max())

    @property
    def center_of_mass(self) -> np.ndarray:
        """Centre of mass of the undeformed body, (3,), m, in body axes."""
        s = self.invariants.vw0 / self.mass  # M_vw = -m c~
        return np.array([s[1, 2], s[2, 0], s[0, 1]])

    @property
    def inertia(self) -> np.ndarray:
        """Inertia of the undeformed body about its centre of mass, (3, 3), kg m2, in body axes."""
        c = self.center_of_mass
        return self.invariants.ww0 - self.mass * (c @ c * np.eye(3) - np.outer(c, c))

    @cached_property
    def stressed(self) -> np.ndarray:
        """At which nodes elements give stress, (n,) bool: not at those of beams, rods, springs and links alone.

        Nothing but zeros in all modes is no stress; what is drawn there must not look like 0 MPa.
        """
        if self.stress_modes is None:
            return np.zeros(len(self.nodes), bool)
        return np.any(self.stress_modes != 0.0, axis=(1, 2))

    @property
    def has_stress(self) -> bool:
        """Does any element give stress?"""
        return bool(self.stressed.any())

    def node_name(self, node: int) -> str:
        """Return words for a node: "node 63241 of the deck" where the file has numbers, else "node 12"."""
        return f"node {int(node)}" if self.numbering is None else self.numbering.node_name(node)
