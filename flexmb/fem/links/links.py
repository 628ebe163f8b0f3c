"""Rigid links (RBE2) and averaging links (RBE3) by elimination of the dependent freedoms.

With ``U = T U_r`` the linked model has ``K_r = T^T K T`` and ``M_r = T^T M T`` (docs/theory/frames.md, eq.
(link-elimination)).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from flexmb.errors import MeshError
from flexmb.fem.chosen_nodes import NodeName, as_array, node_number, node_numbers
from flexmb.fem.fe_model import ElementBlock, FEModel
from flexmb.fem.links.connectors import expansion_of, rigid_arm
from flexmb.fem.links.stiffness import RigidLinkBlock
from flexmb.fem.nodal_assembly import all_freedoms
from flexmb.model.described import finite_array

__all__ = ["LinkedBlock", "with_averaging_link", "with_node", "with_rigid_link"]


def with_node(fe: FEModel, position, name: str | None = None) -> FEModel:
    """Return the model with one more node, six freedoms without stiffness and mass, at (3,), m; a set of
    that name."""
    number = len(fe.nodes)
    point = finite_array(position)
    if point.shape != (3,):
        raise MeshError(
            f"FE model '{fe.name}'",
            found=f"a new node at {position!r:.80}",
            expected="its coordinates x, y, z, m",
            remedy="Write (0.0, 0.0, 0.1)",
        )
    nodes = np.vstack([fe.nodes, point])
    dofs = np.vstack([fe.dofs, np.stack([np.full(6, number), np.arange(6)], axis=1)])
    empty = sparse.csr_matrix((6, 6))
    sets = dict(fe.node_sets) if name is None else {**fe.node_sets, name: np.array([number])}
    grown = replace(
        fe,
        nodes=nodes,
        dofs=dofs,
        node_sets=sets,
        K=sparse.block_diag([fe.K, empty], format="csr"),
        M=sparse.block_diag([fe.M, empty], format="csr"),
        expansion=sparse.block_diag([expansion_of(fe), sparse.identity(6)], format="csr"),
        blocks=(),
    )
    return replace(grown, blocks=_linked_blocks(fe.blocks, grown, len(fe.nodes)))


def with_rigid_link(
    fe: FEModel, reference: NodeName, dependent: NodeName | Iterable[int], name: str | None = None
) -> FEModel:
    """Return the model in which nodes follow a reference node rigidly (RBE2).

    Parameters
    ----------
    reference : node number, name of a set of one node, or coordinates (3,), m, of a new node: floats, or a tuple
        Keeps its six freedoms.
    dependent : name of a node set or node numbers
        Lose their freedoms; loads on them act on the reference node (`FEModel.forces`).
    name : str
        Name of a node set that is made of the reference node.

    Raises
    ------
    MeshError
        The reference has no rotations or depends on another link; a dependent node is in another link
        already.
    """
    fe, node = _reference(fe, reference, name)
    numbers = np.setdiff1d(node_numbers(fe, dependent), [node])
    part = f"Rigid link at {fe.node_name(node)} of '{fe.name}'"
    rows = _rows(fe)
    if (rows[node] < 0).any():
        raise MeshError(
            part,
            found=f"the reference node has {int((rows[node] >= 0).sum())} independent freedoms",
            expected="six: neither a node of solids, nor held, nor dependent on another link",
            remedy="Give coordinates (x, y, z) as reference: a new node is made there",
        )
    _check_free(fe, part, numbers, rows)
    columns = np.arange(fe.ndof)
    entries = []
    for number in numbers:
        arm = rigid_arm(fe.nodes[number] - fe.nodes[node])
        for direction in np.flatnonzero(rows[number] >= 0):
            entries += [
                (rows[number, direction], rows[node, k], arm[direction, k]) for k in np.flatnonzero(arm[direction])
            ]
    eliminated = rows[numbers][rows[numbers] >= 0]
    if fe.blocks:  # foreign matrices have no geometric stiffness to add to
        fe = replace(fe, blocks=(*fe.blocks, _link_block(fe, node, numbers, rows)))
    return _eliminated(fe, columns, eliminated, entries)


def with_averaging_link(
    fe: FEModel, reference: NodeName, nodes: NodeName | Iterable[int], weights=None, name: str | None = None
) -> FEModel:
    """Return the model in which a reference node follows the weighted mean motion of others (RBE3).

    The others are not stiffened: a force on the reference node is distributed over them, mass on it as well. The
    geometric stiffness does not see the lever between their mean and the reference; `reduction.Averaging` does.

    Parameters
    ----------
    reference : node number, name of a set of one node, or coordinates (3,), m, of a new node: floats, or a tuple
        Its freedoms become dependent, so it cannot be an interface; `reduction` has averaging interfaces.
    nodes : name of a node set or node numbers
        At least three that do not lie on one line; only their translations count.
    weights : (number of nodes,), -
        Default: all equal.
    """
    fe, node = _reference(fe, reference, name)
    numbers = np.setdiff1d(node_numbers(fe, nodes), [node])
    part = f"Averaging link at {fe.node_name(node)} of '{fe.name}'"
    rows = _rows(fe)
    _check_free(fe, part, numbers, rows, translations_only=True)
    weights = np.ones(len(numbers)) if weights is None else finite_array(weights)
    if weights.shape != numbers.shape or (weights < 0.0).any() or not weights.sum() > 0.0:
        raise MeshError(
            part,
            found=f"weights of shape {weights.shape}",
            expected=f"({len(numbers)},) numbers >= 0, one per node in ascending order of node numbers",
            remedy="Leave weights out for equal ones",
        )
    _check_free(fe, part, np.array([node]), rows)
    mean = average_motion(fe.nodes[numbers], weights, fe.nodes[node], part)
    entries = [
        (rows[node, direction], rows[number, k], mean[direction, j, k])
        for direction in np.flatnonzero(rows[node] >= 0)
        for j, number in enumerate(numbers)
        for k in range(3)
    ]
    return _eliminated(fe, np.arange(fe.ndof), rows[node][rows[node] >= 0], entries)


def average_motion(points: np.ndarray, weights: np.ndarray, at: np.ndarray, part: str) -> np.ndarray:
    """Return (6, n, 3): weighted least-squares rigid motion at a point (3,), m, of the displacements of
    points (n, 3).

    ``theta = J^-1 sum w r x u``, ``u = sum w u / sum w + theta x (at - c)`` (eq. (link-average)).
    """
    share = weights / weights.sum()
    centre = share @ points
    arms = points - centre
    inertia = np.einsum("i,ij,ij->", share, arms, arms) * np.eye(3) - np.einsum("i,ij,ik->jk", share, arms, arms)
    principal = np.linalg.eigvalsh(inertia)
    if len(points) < 3 or principal[0] <= 1e-10 * principal[-1]:
        raise MeshError(
            part,
            found=f"{len(points)} node(s) on one line",
            expected="at least three nodes that do not lie on one line",
            remedy="Add nodes, or use fem.with_rigid_link",
        )
    cross = np.cross(arms[:, None, :], np.eye(3)[None])  # r x e_k, (n, k, 3)
    turn = np.linalg.solve(inertia, np.einsum("i,ikj->jik", share, cross).reshape(3, -1)).reshape(3, -1, 3)
    out = np.zeros((6, len(points), 3))
    out[3:] = turn
    out[:3] = np.cross(turn, (at - centre)[:, None, None], axis=0)
    out[np.arange(3), :, np.arange(3)] += share
    return out


@dataclass(frozen=True, kw_only=True, eq=False)
class LinkedBlock:
    """Elements of a model whose nodes depend on each other: an `ElementBlock` around another one."""

    block: ElementBlock
    own_nodes: int
    dofs: np.ndarray
    expansion: sparse.csr_matrix

    @property
    def cell_type(self) -> str:
        """Cell name in meshio's spelling."""
        return self.block.cell_type

    @property
    def connectivity(self) -> np.ndarray:
        """(ne, nodes per cell), int."""
        return self.block.connectivity

    @property
    def modulus(self) -> float:
        """Largest elastic stiffness of the material, Pa."""
        return self.block.modulus

    def geometric_stiffness(self, displacement: np.ndarray, dofs: np.ndarray) -> sparse.csr_matrix:
        """Initial-stress stiffness (ndof, ndof), N/m, of the stress that `displacement` (n, 6), m, causes."""
        number = {(int(n), int(d)): row for row, (n, d) in enumerate(self.dofs)}
        columns = [number[int(n), int(d)] for n, d in dofs]
        moved = self.expansion[: 6 * self.own_nodes][:, columns].tocsr()
        rows = np.flatnonzero(np.diff(moved.indptr))
        full = self.block.geometric_stiffness(displacement[: self.own_nodes], all_freedoms(self.own_nodes)[rows])
        moved = moved[rows]
        matrix = (moved.T @ full @ moved).tocsr()
        return (0.5 * (matrix + matrix.T)).tocsr()

    def projected_geometric_stiffness(self, displacements: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """``modes^T K_g modes`` for each load case: (l, m, m), N/m; the nodal fields contain the dependent
        nodes."""
        return self.block.projected_geometric_stiffness(displacements[: self.own_nodes], modes[: self.own_nodes])

    def nodal_stress(self, displacements: np.ndarray) -> np.ndarray:
        """Stress xx, yy, zz, xy, yz, zx at nodes, (n, 6, k), Pa; NaN at nodes of other blocks."""
        stress = np.full(displacements.shape, np.nan)
        stress[: self.own_nodes] = self.block.nodal_stress(displacements[: self.own_nodes])
        return stress

    def element_stress(self, displacements: np.ndarray, cells: np.ndarray | None = None) -> np.ndarray:
        """Stress (ne, nodes of a cell, 6, k), Pa, at the nodes of chosen cells, each cell by itself."""
        return self.block.element_stress(displacements[: self.own_nodes], cells)  # type: ignore[attr-defined]


def _link_block(fe: FEModel, node: int, numbers: np.ndarray, rows: np.ndarray) -> RigidLinkBlock:
    """Return the geometric stiffness of a rigid link about to be made."""
    which, directions = np.nonzero(rows[numbers, :3] >= 0)
    return RigidLinkBlock(
        nodes=np.full(len(which), node),
        number_of_nodes=len(fe.nodes),
        dofs=fe.dofs,
        stiffness=fe.K[rows[numbers[which], directions]],
        directions=directions,
        arms=fe.nodes[numbers[which]] - fe.nodes[node],
    )


def _linked_blocks(blocks, fe: FEModel, own_nodes: int) -> tuple:
    expansion = expansion_of(fe)
    return tuple(
        LinkedBlock(
            block=block.block if isinstance(block, LinkedBlock) else block,
            own_nodes=block.own_nodes if isinstance(block, LinkedBlock) else own_nodes,
            dofs=fe.dofs,
            expansion=expansion,
        )
        for block in blocks
    )


def _reference(fe: FEModel, reference: NodeName, name: str | None) -> tuple[FEModel, int]:
    """Return the model and the number of the reference node, made if coordinates are given.

    A tuple of three whole numbers is a place as well: a new node is meant where three numbers cannot be one node.
    """
    given = as_array(reference)
    if given.ndim == 1 and (given.dtype.kind == "f" or (isinstance(reference, tuple) and given.dtype.kind in "iu")):
        return with_node(fe, reference, name), len(fe.nodes)
    number = node_number(fe, reference)
    sets = dict(fe.node_sets) if name is None else {**fe.node_sets, name: np.array([number])}
    return replace(fe, node_sets=sets), number


def _rows(fe: FEModel) -> np.ndarray:
    rows = np.full((len(fe.nodes), 6), -1)
    rows[fe.dofs[:, 0], fe.dofs[:, 1]] = np.arange(fe.ndof)
    return rows


def _check_free(fe: FEModel, part: str, numbers: np.ndarray, rows: np.ndarray, translations_only=False) -> None:
    """Raise MeshError where a node is held or depends on another link."""
    if len(numbers) == 0:
        raise MeshError(
            part,
            found="no nodes",
            expected="at least one node besides the reference node",
            remedy="Name a set of the mesh or give node numbers",
        )
    lacking = [int(n) for n in numbers if (rows[n, :3] < 0).any()]
    if lacking and fe.expansion is not None:
        moved = np.diff(fe.expansion.indptr).reshape(-1, 6)
        dependent = [n for n in lacking if ((moved[n] > 0) & (rows[n] < 0)).any()]
        if dependent:
            raise MeshError(
                part,
                found=f"{fe.node_name(dependent[0])} depends on another link already",
                expected="nodes with independent freedoms",
                remedy="Remove the node from one of the two links, or link their reference nodes",
            )
    if lacking:
        raise MeshError(
            part,
            found=f"{fe.node_name(lacking[0])} is held in a translation",
            expected="nodes free in x, y, z" if translations_only else "free nodes: links come before supports",
            remedy="Make the link first and hold its reference node",
        )


def _eliminated(fe: FEModel, columns: np.ndarray, dependent: np.ndarray, entries: list) -> FEModel:
    """Return the model without the dependent freedoms; entries (dependent row, independent row, factor)."""
    kept = np.setdiff1d(columns, dependent)
    new = np.full(fe.ndof, -1)
    new[kept] = np.arange(len(kept))
    i = np.concatenate([kept, [e[0] for e in entries]]).astype(int)
    j = np.concatenate([kept, [e[1] for e in entries]]).astype(int)
    factors = np.concatenate([np.ones(len(kept)), [e[2] for e in entries]])
    transfer = sparse.csr_matrix((factors, (i, new[j])), shape=(fe.ndof, len(kept)))
    stiffness, mass = ((transfer.T @ matrix @ transfer).tocsr() for matrix in (fe.K, fe.M))
    linked = replace(
        fe,
        dofs=fe.dofs[kept],
        K=(0.5 * (stiffness + stiffness.T)).tocsr(),
        M=(0.5 * (mass + mass.T)).tocsr(),
        expansion=(expansion_of(fe) @ transfer).tocsr(),
    )
    return replace(linked, blocks=_linked_blocks(fe.blocks, linked, len(fe.nodes)))
