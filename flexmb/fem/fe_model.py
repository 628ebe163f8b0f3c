"""`FEModel`: what every way of making a finite element model ends in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from scipy import sparse

from flexmb.errors import MeshError, did_you_mean
from flexmb.model.numbering import Numbering, named_numbers

__all__ = ["Condensed", "ElementBlock", "FEModel", "ReferencePoint"]

LARGEST = 1e60
"""Of the entries of K and M, N/m and kg: products of larger ones exceed the range of numbers."""


class ElementBlock(Protocol):
    """Elements of one kind: what reduction, recovery and drawing need of them beyond K and M.

    Nodal fields have the shape (n, 6, k): three translations, three rotations (zero where a node has none),
    k columns (modes or load cases).
    """

    @property
    def cell_type(self) -> str:
        """Cell name in meshio's spelling ("tetra10", "hexahedron", "line", "triangle")."""

    @property
    def connectivity(self) -> np.ndarray:
        """(ne, nodes per cell), int, node numbers of the FE model in meshio's order."""

    @property
    def modulus(self) -> float:
        """Largest elastic stiffness of the material, Pa: tells materials apart where they meet;
        0 without nodal stress.
        """

    def geometric_stiffness(self, displacement: np.ndarray, dofs: np.ndarray) -> sparse.csr_matrix:
        """Initial-stress stiffness (ndof, ndof), N/m, of the stress that `displacement` (n, 6), m, causes."""

    def projected_geometric_stiffness(self, displacements: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """``modes^T K_g(displacements[..., l]) modes`` per load case l: (loads, m, m), nothing assembled."""

    def nodal_stress(self, displacements: np.ndarray) -> np.ndarray:
        """Stress xx, yy, zz, xy, yz, zx averaged to nodes, (n, 6, k), Pa; NaN at nodes of other blocks."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ReferencePoint:
    """A point by which a deck attaches its surroundings; an interface in waiting.

    Parameters
    ----------
    node : int
        The reference node.
    averaged, weights : (k,) int and (k,), or None
        Nodes whose weighted mean motion it follows (RBE3, distributing coupling); None: it moves by its own freedoms.
    """

    node: int
    averaged: np.ndarray | None = None
    weights: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class Condensed:
    """The finite elements behind an `FEModel` that has the freedoms of reduced parts.

    Products of the mass with fields that the freedoms do not hold, such as a spin, are taken in the whole.

    Parameters
    ----------
    whole : FEModel
        All elements with all freedoms, parts beside each other; with the nodes and sets of the condensed model.
    fields : (ndof of the whole, ndof)
        Its displacements per freedom.
    couplings : tuple of (Coupling, int)
        Where parts are held within, in freedoms of the whole, and the node with their motion.
    places : (k,)
        Nodes that move with interfaces of parts, and of parts of parts: no element has them.
    reach : mapping of name to float, Hz, or None
        Up to which frequency the basis of each part holds; None where it is not known.
    errors : tuple
        What the data of parts tell of the errors of their responses; None for a part that does not.
    """

    whole: Any
    fields: np.ndarray
    couplings: tuple[Any, ...] = ()
    places: np.ndarray = field(default_factory=lambda: np.zeros(0, int))
    reach: Mapping[str, float | None] = field(default_factory=dict)
    errors: tuple[Any, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class FEModel:
    """Stiffness, mass and everything that must be known of the mesh.

    Parameters
    ----------
    nodes : (n, 3), m
        Node positions in body axes.
    dofs : (ndof, 2), int
        Node number and direction (0..2 translation x y z, 3..5 rotation x y z) of every row of K and M.
    K, M : (ndof, ndof) csr, N/m and kg
        Symmetric stiffness and mass matrices (consistent or lumped).
    node_sets : mapping of name to node numbers
        Named groups of nodes (from the mesh's physical groups, Nastran SETs, Abaqus NSETs).
    facet_sets : mapping of name to (nf, nodes per facet)
        Named groups of surface facets, as node numbers, corner nodes first, outward normal by the
        right-hand rule.
    blocks : tuple of ElementBlock
        The elements, for stress, geometric stiffness and drawing; empty for foreign matrices.
    name : str
        Used in messages and reports.
    expansion : (6 n, ndof) csr or None
        Motion of every node (row 6 node + direction) from the freedoms, where rigid or averaging links make some
        nodes depend on others; None: every node moves by its own freedoms only.
    C : (ndof, ndof) csr, N s/m, or None
        Viscous damping of discrete dampers.
    numbering : Numbering or None
        Numbers of nodes and cells in the file they come from; its cells follow `blocks`, block by block.
    reference_points : mapping of name to ReferencePoint
        Interfaces that the file offers: reference nodes of RBE2, RBE3 and couplings, ASET nodes.
    supports : mapping of name to (k, 2)
        Node and direction (0..5) of the freedoms that the file holds; they are not applied unless asked for, by
        ``fem.eigenmodes(fe, "spc_1")``.
    slanted : mapping of name to (r, 6 n) csr
        What supports of that name hold besides: directions across the axes, ``row @ motion of all nodes = 0``.
    warnings : tuple of str
        Warnings on the way from the file; the report of a reduction repeats them.
    source : mapping
        Of a deck: program, file, units and inventory, as JSON can hold them.
    condensed : Condensed or None
        The finite elements behind freedoms of reduced parts.
    """

    nodes: np.ndarray
    dofs: np.ndarray
    K: sparse.csr_matrix
    M: sparse.csr_matrix
    node_sets: Mapping[str, np.ndarray] = field(default_factory=dict)
    facet_sets: Mapping[str, np.ndarray] = field(default_factory=dict)
    blocks: tuple[ElementBlock, ...] = ()
    name: str = "part"
    expansion: sparse.csr_matrix | None = None
    C: sparse.csr_matrix | None = None
    numbering: Numbering | None = None
    reference_points: Mapping[str, ReferencePoint] = field(default_factory=dict)
    supports: Mapping[str, np.ndarray] = field(default_factory=dict)
    slanted: Mapping[str, sparse.csr_matrix] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    source: Mapping[str, Any] = field(default_factory=dict)
    condensed: Condensed | None = None

    def __post_init__(self):
        part, size = f"FE model '{self.name}'", len(self.dofs)
        for symbol, matrix in (("K", self.K), ("M", self.M)):
            if matrix.shape != (size, size):
                raise MeshError(
                    part,
                    found=f"{symbol} has the shape {matrix.shape}",
                    expected=f"({size}, {size}), one row per freedom in dofs",
                    remedy="Give one (node, direction) pair per matrix row",
                )
            if not (sparse.issparse(matrix) and matrix.format == "csr"):
                object.__setattr__(self, symbol, sparse.csr_matrix(matrix))
        for what, matrix in (("stiffness", self.K), ("mass", self.M)):
            if not np.all(np.abs(matrix.data) <= LARGEST):  # nan too
                self._refuse_entry(what, matrix.tocoo())
        if self.nodes.ndim != 2 or self.nodes.shape[1] != 3:
            raise MeshError(
                part,
                found=f"nodes have the shape {self.nodes.shape}",
                expected="(n, 3)",
                remedy="Give one row x, y, z per node; planar meshes need z = 0",
            )
        if self.condensed is not None and self.condensed.fields.shape[1] != size:
            raise MeshError(
                part,
                found=f"{size} freedoms of a model of {self.condensed.fields.shape[1]} freedoms of reduced parts",
                expected="all of them: such a model takes springs, but no links, nodes or supports",
                remedy="Link or hold the parts before they are reduced",
            )
        if self.expansion is not None and self.expansion.shape != (6 * len(self.nodes), size):
            raise MeshError(
                part,
                found=f"expansion has the shape {self.expansion.shape}",
                expected=f"({6 * len(self.nodes)}, {size}), six rows per node",
                remedy="Make links with fem.with_rigid_link or fem.with_averaging_link",
            )

    def _refuse_entry(self, what: str, matrix: sparse.coo_matrix) -> None:
        entry = int(np.argmin(np.abs(matrix.data) <= LARGEST))
        node = int(self.dofs[matrix.row[entry], 0])
        at = ", ".join(f"{x:.4g}" for x in self.nodes[node])
        raise MeshError(
            f"FE model '{self.name}'",
            found=f"a {what} of {matrix.data[entry]:.3g} at {self.node_name(node)}, ({at}) m",
            expected=f"numbers up to {LARGEST:g} in SI units, whose products are finite",
            remedy="Correct the material, thickness, section, mass or spring there",
        )

    def node_name(self, node: int) -> str:
        """Return words for a node: "node 63241 of the deck" where the file has numbers, else "node 12"."""
        return f"node {int(node)}" if self.numbering is None else self.numbering.node_name(node)

    @property
    def labels(self) -> np.ndarray | None:
        """Numbers of the nodes in the file, (n,) int, 0 for nodes that are not in it; None without a file."""
        return None if self.numbering is None else self.numbering.nodes

    def numbered(self, text: str, part: str, error: type = MeshError) -> np.ndarray | None:
        """Return the nodes (k,) of "node 63241" or "element 812", numbers of the deck; None for other text."""
        if self.numbering is None or named_numbers(text) is None:
            return None
        cells = [np.asarray(block.connectivity) for block in self.blocks]
        whole = self.numbering.padded(len(self.nodes), [len(rows) for rows in cells])
        return whole.nodes_of(text, tuple(cells), part, error)

    def node_set(self, name: str) -> np.ndarray:
        """Return the node numbers of a named set, or of "node 63241" of a deck; MeshError with the known names."""
        if name not in self.node_sets and (found := self.numbered(name, f"FE model '{self.name}'")) is not None:
            return found
        if name not in self.node_sets:
            known = ", ".join(sorted(self.node_sets)) or "none"
            raise MeshError(
                f"FE model '{self.name}'",
                found=f"the node set '{name}' does not exist",
                expected=f"One of: {known}",
                remedy=did_you_mean(name, self.node_sets),
            )
        return self.node_sets[name]

    def __repr__(self):
        counts = ", ".join(
            f"{len(block.connectivity)} {block.cell_type}" for block in self.blocks if len(block.connectivity)
        )
        counts = counts or "matrices only"
        sets = ", ".join(sorted({*self.node_sets, *self.facet_sets})) or "none"
        return f"FEModel('{self.name}': {len(self.nodes)} nodes, {len(self.dofs)} freedoms, {counts}, sets: {sets})"

    @property
    def ndof(self) -> int:
        """Number of freedoms."""
        return len(self.dofs)

    def field(self, vectors: np.ndarray) -> np.ndarray:
        """Return freedom vectors (ndof, k) as a nodal field (n, 6, k); absent freedoms are zero."""
        vectors = np.asarray(vectors, float).reshape(self.ndof, -1)
        if self.expansion is not None:
            return (self.expansion @ vectors).reshape(len(self.nodes), 6, -1)
        out = np.zeros((len(self.nodes), 6, vectors.shape[1]))
        out[self.dofs[:, 0], self.dofs[:, 1]] = vectors
        return out

    def vectors(self, field: np.ndarray) -> np.ndarray:
        """Return a nodal field (n, 6, k) as freedom vectors (ndof, k); the inverse of `field`."""
        return np.asarray(field, float)[self.dofs[:, 0], self.dofs[:, 1]]

    def forces(self, field: np.ndarray) -> np.ndarray:
        """Return nodal forces and moments (n, 6, k), N and N m, as freedom vectors (ndof, k): links pass them on."""
        if self.expansion is None:
            return self.vectors(field)
        field = np.asarray(field, float)
        return self.expansion.T @ field.reshape(6 * len(self.nodes), -1)

    def rigid_motions(self) -> np.ndarray:
        """Return the six unit rigid motions about the origin: (ndof, 6), translations then rotations."""
        motions = np.zeros((len(self.nodes), 6, 6))
        for k in range(3):
            axis = np.eye(3)[k]
            motions[:, k, k] = 1.0
            motions[:, :3, 3 + k] = np.cross(axis, self.nodes)
            motions[:, 3 + k, 3 + k] = 1.0
        return self.vectors(motions)
