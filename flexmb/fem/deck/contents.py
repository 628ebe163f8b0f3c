"""`Deck`: what a finite element program's input describes, in words that belong to no program.

Nodes are numbered 0 .. n-1 in the order of `Deck.labels`, which keeps the numbers of the file (ascending in Nastran).
Lengths, forces and masses are still in units of the file. Everything is in the basic (global) axes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from flexmb.fem.frames.section import Section
from flexmb.fem.solids.elements import SolidElement
from flexmb.model.material import Material

__all__ = [
    "Beams",
    "Deck",
    "Inventory",
    "Lumped",
    "MissingNode",
    "Reference",
    "Rods",
    "ScalarPoint",
    "Shells",
    "Solids",
]

PORTION = 20_000
"""Rows whose node numbers are looked up together."""


@dataclass(kw_only=True, eq=False)
class Solids:
    """Solid cells of one type and material.

    nodes (ne, c) int in meshio's order, labels (ne,), elasticity (6, 6) for xx, yy, zz, xy, yz, zx, density.
    element: the element that the program of the deck has there, None for the usual one of the cell type.
    """

    cell_type: str
    nodes: np.ndarray
    labels: np.ndarray
    elasticity: np.ndarray
    density: float
    group: str
    element: SolidElement | None = None


@dataclass(kw_only=True, eq=False)
class Shells:
    """Flat triangles (ne, 3) or quadrilaterals (ne, 4) of one layup.

    Parameters
    ----------
    membrane, coupling, bending : (3, 3)
        Force per length N = A e + B k and moment per length M = B e + D k, k = -(w_xx, w_yy, 2 w_xy), in material
        axes about the reference plane.
    material_x : (ne, 3)
        Direction whose part in the element's plane is the first material axis.
    offset : (ne,)
        Of the reference plane from the plane of the nodes, along the normal of the cell.
    thickness, mass : (ne,)
        Thickness and mass per area.
    faces : (2, 3, 3)
        Plane stress elasticity of the bottom and of the top layer, in material axes, for the stress there.
    depths : (2,)
        Height of the bottom and of the top face over the reference plane.
    shear : (2, 2)
        Transverse shear compliance in material axes, length over force; zero for thin shells.
    stretch : (ne,)
        Thickness of the element over the layup's: scales A, B and D by its first, second and third power.
    poisson : float
        Of the in-plane bending modes of triangles.
    spring : float or None
        Share of the in-plane shear stiffness that holds the rotation about the normal, in programs whose shells do not
        turn in their plane; None: the membrane turns with its corners.
    point_masses : bool
        Whether lumped masses have no rotary inertia.
    """

    nodes: np.ndarray
    labels: np.ndarray
    membrane: np.ndarray
    coupling: np.ndarray
    bending: np.ndarray
    material_x: np.ndarray
    offset: np.ndarray
    thickness: np.ndarray
    mass: np.ndarray
    faces: np.ndarray
    depths: np.ndarray
    stretch: np.ndarray
    shear: np.ndarray
    poisson: float
    group: str
    spring: float | None = None
    point_masses: bool = False

    def only(self, chosen: np.ndarray) -> Shells:
        """Return the chosen elements (mask or numbers)."""
        rows = ("nodes", "labels", "material_x", "offset", "thickness", "mass", "stretch")
        return replace(self, **{name: getattr(self, name)[chosen] for name in rows})

    def split(self, points: np.ndarray) -> Shells:
        """Return quadrilaterals as two triangles each, along the shorter diagonal."""
        corners = points[self.nodes]
        first = np.linalg.norm(corners[:, 2] - corners[:, 0], axis=1)
        second = np.linalg.norm(corners[:, 3] - corners[:, 1], axis=1)
        along = (first <= second)[:, None]
        one = np.where(along, self.nodes[:, [0, 1, 2]], self.nodes[:, [0, 1, 3]])
        two = np.where(along, self.nodes[:, [0, 2, 3]], self.nodes[:, [1, 2, 3]])
        twice = self.only(np.tile(np.arange(len(self.nodes)), 2))
        return replace(twice, nodes=np.vstack([one, two]))


@dataclass(kw_only=True, eq=False)
class Beams:
    """Beams of one material: nodes (ne, 2), a pair of sections each, y-axis (ne, 3), offsets of the ends (ne, 2, 3).

    released holds, per beam, two sets of local directions (0..5) that its ends do not pass on; point_masses says which
    rotary inertia lumped masses lack (`beam_block`).
    """

    nodes: np.ndarray
    labels: np.ndarray
    sections: list[tuple[Section, Section]]
    material: Material
    y_axis: np.ndarray
    offsets: np.ndarray
    released: list[tuple[frozenset[int], frozenset[int]]]
    group: str
    point_masses: str = ""


@dataclass(kw_only=True, eq=False)
class Rods:
    """Bars that carry axial force and torque only: nodes (ne, 2); EA, GJ, mass per length, polar inertia (ne,).

    point_masses: lumped masses have no rotary inertia.
    """

    nodes: np.ndarray
    labels: np.ndarray
    axial: np.ndarray
    torsion: np.ndarray
    mass: np.ndarray
    polar: np.ndarray
    group: str
    point_masses: bool = False


@dataclass(kw_only=True, eq=False)
class Lumped:
    """A mass, spring or damper: a symmetric matrix (6 k, 6 k) on the six directions of k nodes.

    kind is "mass", "stiffness" or "damping".
    """

    kind: str
    nodes: tuple[int, ...]
    matrix: np.ndarray
    name: str


@dataclass(kw_only=True, eq=False)
class Reference:
    """A point by which a deck attaches its surroundings: a node, or the weighted mean of others."""

    node: int
    averaged: np.ndarray | None = None
    weights: np.ndarray | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class ScalarPoint:
    """A freedom of its own (SPOINT): its value is ``row`` (6,) times the basic freedoms of a node; `free` is the one
    freedom ``6 node + direction`` of that node that follows nothing.
    """

    node: int
    row: np.ndarray
    free: int


@dataclass(kw_only=True, eq=False)
class Inventory:
    """What became of a deck: counts by card, what was approximated or left out, materials without density."""

    read: Counter[str] = field(default_factory=Counter)
    approximated: Counter[str] = field(default_factory=Counter)
    left_out: Counter[str] = field(default_factory=Counter)
    unused: Counter[str] = field(default_factory=Counter)
    weightless: set[str] = field(default_factory=set)


@dataclass(kw_only=True, eq=False)
class Deck:
    """Everything that a deck says of a structure.

    Parameters
    ----------
    labels, points : (n,), (n, 3)
        Node numbers of the file and positions. Midside and base nodes that were added have no number.
    instances, instance_of : tuple of str, (n,) int or None
        Part instances, and which of them a node belongs to, where the file numbers the nodes of each by themselves.
    links : LinkRows
        Freedoms that depend on others.
    supports : mapping of name to (k, 2)
        Node and direction of every held freedom.
    slanted : mapping of name to (node, row (6,)) pairs
        Directions across the basic axes that supports hold, over the basic freedoms of their nodes.
    mass_factor : float
        By which all masses are to be multiplied (PARAM, WTMASS).
    lumped : bool
        Whether the program lumps masses at nodes by default.
    stress_side : float or None
        Side of shells at which their stress is taken: -1, 0 or +1; None where nobody chose.
    node_sets, facet_sets : mappings of name to node numbers 0 .. n-1, and to corners of facets (nf, 3 or 4)
    scalar_points : mapping of int to ScalarPoint or None
        Points without a place (SPOINT) by number; None where no node moves them: what hangs on them is left out.
    """

    name: str
    source: str
    labels: np.ndarray
    points: np.ndarray
    instances: tuple[str, ...] = ()
    instance_of: np.ndarray | None = None
    solids: list[Solids] = field(default_factory=list)
    shells: list[Shells] = field(default_factory=list)
    beams: list[Beams] = field(default_factory=list)
    rods: list[Rods] = field(default_factory=list)
    lumped_parts: list[Lumped] = field(default_factory=list)
    links: list = field(default_factory=list)
    supports: dict[str, np.ndarray] = field(default_factory=dict)
    slanted: dict[str, list[tuple[int, np.ndarray]]] = field(default_factory=dict)
    node_sets: dict[str, np.ndarray] = field(default_factory=dict)
    facet_sets: dict[str, np.ndarray] = field(default_factory=dict)
    references: dict[str, Reference] = field(default_factory=dict)
    scalar_points: dict[int, ScalarPoint | None] = field(default_factory=dict)
    mass_factor: float = 1.0
    lumped: bool = False
    stress_side: float | None = None
    units: str = ""
    inventory: Inventory = field(default_factory=Inventory)

    def groups(self) -> list[Solids | Shells | Beams | Rods]:
        """Return all groups of elements."""
        return [*self.solids, *self.shells, *self.beams, *self.rods]

    def numbers(self, labels: Iterable[int] | np.ndarray, what: str, out: np.ndarray | None = None) -> np.ndarray:
        """Return the node numbers 0 .. n-1 of numbers of the file; MissingNode names one that does not exist.

        They are written to `out` if it is given, which may be the labels themselves.
        """
        given = labels if isinstance(labels, np.ndarray) else list(labels)
        try:
            wanted = np.asarray(given, np.int64)
        except OverflowError:
            raise MissingNode(what, max(given, key=abs)) from None
        if not len(self.labels):
            raise MissingNode(what, int(wanted.flat[0]))
        at = np.empty(wanted.shape, np.int64) if out is None else out
        for begin in range(0, len(wanted), PORTION):  # in portions: a table of cells is large
            part = wanted[begin : begin + PORTION]
            found = np.minimum(np.searchsorted(self.labels, part), len(self.labels) - 1)
            missing = self.labels[found] != part
            if missing.any():
                raise MissingNode(what, int(part[missing].flat[0]))
            at[begin : begin + PORTION] = found
        return at


class MissingNode(Exception):
    """Something names a node that the deck does not have."""

    def __init__(self, what: str, node: int):
        super().__init__(f"{what} names the node {node}, which does not exist")
