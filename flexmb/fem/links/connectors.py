"""Masses, springs and supports at nodes of an FE model: functions `FEModel` -> `FEModel`.

Links between nodes are in `links`. The theory of all connectors is docs/theory/frames.md, section
"Connectors".
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy import sparse

from flexmb.errors import MeshError
from flexmb.fem.chosen_nodes import NodeName, node_number
from flexmb.fem.fe_model import FEModel
from flexmb.fem.held import held_places
from flexmb.math.definiteness import semidefinite, symmetric
from flexmb.model.described import finite_array, is_number
from flexmb.model.plausibility import inertia_doubts
from flexmb.told import tell

__all__ = ["expansion_of", "with_mass", "with_spring", "with_supports"]

DIRECTIONS = ("x", "y", "z", "rotation x", "rotation y", "rotation z")


def with_mass(fe: FEModel, node: NodeName, mass: float, inertia=None, offset=(0.0, 0.0, 0.0)) -> FEModel:
    """Return the model with a rigid mass at a node.

    Parameters
    ----------
    node : number, name of a set of one node, or coordinates (3,), m, of a node, with a decimal point
    mass : float, kg
    inertia : (3,) or (3, 3), kg m2
        About the centre of the mass, body axes.
    offset : (3,), m
        From the node to the centre of the mass, which follows the rotation of the node.

    Raises
    ------
    MeshError
        Negative mass or inertia; a node without freedoms, or without rotations where they are needed.
    """
    number = node_number(fe, node)
    part = f"Mass at {fe.node_name(number)} of '{fe.name}'"
    own = np.zeros((3, 3)) if inertia is None else finite_array(inertia)
    own = np.diag(own) if own.ndim == 1 else own
    if not is_number(mass) or mass < 0.0 or own.shape != (3, 3) or not symmetric(own) or not semidefinite(own):
        raise MeshError(
            part,
            found=f"mass = {mass!r} kg, inertia = {inertia!r:.100} kg m2",
            expected="a mass >= 0 and a symmetric inertia without negative principal values",
            remedy="Give inertia as (3,) or (3, 3) about the centre of the mass",
        )
    if fe.condensed is not None:
        raise MeshError(
            part,
            found="a model of reduced parts, whose inertia belongs to their elements",
            expected="masses that belong to a part",
            remedy="Give the mass to the part before it is reduced, or to the mechanism as a rigid body",
        )
    for doubt in inertia_doubts(own):
        tell(f"{part}: {doubt}.")
    place = finite_array(offset)
    if place.shape != (3,):
        raise MeshError(
            part,
            found=f"offset = {offset!r:.80}",
            expected="three numbers, m",
            remedy="Give the place of the centre of the mass, seen from the node",
        )
    x, y, z = place.tolist()
    arm = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    matrix = np.zeros((6, 6))
    matrix[:3, :3], matrix[:3, 3:], matrix[3:, :3] = mass * np.eye(3), -mass * arm, -mass * arm.T
    matrix[3:, 3:] = mass * arm.T @ arm + own
    motion = _motion(fe, number, part, needs=np.flatnonzero(np.abs(matrix).sum(axis=1) > 0.0))
    return replace(fe, M=_symmetric(fe.M + motion.T @ sparse.csr_matrix(matrix) @ motion))


def with_spring(fe: FEModel, node: NodeName, stiffness, to: NodeName | None = None) -> FEModel:
    """Return the model with a linear spring from a node to the ground or to another node.

    Parameters
    ----------
    stiffness : (6,) or (6, 6), N/m and N m/rad
        Along and about the body axes.
    to : node or None
        The other node; it is seen from `node` through a rigid arm, so rigid motions stay free of force.
    """
    number = node_number(fe, node)
    part = f"Spring at {fe.node_name(number)} of '{fe.name}'"
    given = finite_array(stiffness)
    matrix = np.diag(given) if given.ndim == 1 else given
    if matrix.shape != (6, 6) or not symmetric(matrix) or not semidefinite(matrix):
        raise MeshError(
            part,
            found=f"a stiffness of shape {given.shape}" if given.size else f"stiffness = {stiffness!r:.80}",
            expected="(6,) or symmetric (6, 6) without negative principal values, N/m and N m/rad",
            remedy="Give three translational and three rotational stiffnesses; zero leaves a direction free",
        )
    needs = np.flatnonzero(np.abs(matrix).sum(axis=1) > 0.0)
    motion = _motion(fe, number, part, needs)
    if to is not None:
        other = node_number(fe, to)
        arm = rigid_arm(fe.nodes[other] - fe.nodes[number])
        seen = _motion(fe, number, part, np.flatnonzero(np.abs(arm[needs]).sum(axis=0) > 0.0))
        motion = sparse.csr_matrix(arm) @ seen - _motion(fe, other, part, needs)
    return replace(fe, K=_symmetric(fe.K + motion.T @ sparse.csr_matrix(matrix) @ motion))


def with_supports(
    fe: FEModel,
    nodes: NodeName | Iterable[int] | Mapping[NodeName, Any] | None = None,
    directions: str | Iterable[int] | None = None,
) -> FEModel:
    """Return the model with directions of some nodes held: their freedoms are gone.

    Parameters
    ----------
    nodes : as `fixed` of `fixed_freedoms`, or None for all nodes
        A node set or several, the supports of a deck, node numbers, coordinates, a mask of freedoms, or a mapping of
        such to directions, ``with_supports(fe, {"root": "xyzrxryrz", "tip": "z"})``.
    directions : text or int
        Of nodes without a mapping: "x", "y", "z" translations, "rx", "ry", "rz" rotations, or their numbers 0..5; all
        by default. ``with_supports(fe, directions="zrxry")`` makes a model planar.
    """
    part = f"Support of '{fe.name}'"
    if isinstance(nodes, str) and nodes in fe.slanted:
        raise MeshError(
            part,
            found=f"supports '{nodes}' with {fe.slanted[nodes].shape[0]} directions across the axes",
            expected="supports along the axes: freedoms of nodes",
            remedy=f"Give the name to fem.static or fem.eigenmodes, fixed='{nodes}'",
        )
    places = held_places(fe, np.arange(len(fe.nodes)) if nodes is None else nodes, directions, part)
    if nodes is not None:
        _check_independent(fe, places)
    kept = np.flatnonzero(~np.isin(6 * fe.dofs[:, 0] + fe.dofs[:, 1], places))
    expansion = None if fe.expansion is None else fe.expansion[:, kept].tocsr()
    return replace(
        fe,
        dofs=fe.dofs[kept],
        K=fe.K[kept][:, kept].tocsr(),
        M=fe.M[kept][:, kept].tocsr(),
        expansion=expansion,
    )


def expansion_of(fe: FEModel) -> sparse.csr_matrix:
    """Return the motion (6 n, ndof) of all nodes from the freedoms."""
    if fe.expansion is not None:
        return fe.expansion
    rows = 6 * fe.dofs[:, 0] + fe.dofs[:, 1]
    return sparse.csr_matrix((np.ones(fe.ndof), (rows, np.arange(fe.ndof))), shape=(6 * len(fe.nodes), fe.ndof))


def rigid_arm(arm: np.ndarray) -> np.ndarray:
    """Return (6, 6): the motion of a point at `arm` (3,), m, from the motion of a rigid body at its
    origin."""
    x, y, z = arm
    matrix = np.eye(6)
    matrix[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    return matrix


def _motion(fe: FEModel, node: int, part: str, needs: np.ndarray) -> sparse.csr_matrix:
    """Return the six rows of the expansion that move a node; the directions in `needs` must be able to
    move."""
    motion = expansion_of(fe)[6 * node : 6 * node + 6].tocsr()
    missing = [DIRECTIONS[d] for d in needs if motion.indptr[d] == motion.indptr[d + 1]]
    if missing:
        raise MeshError(
            part,
            found=f"the node has no freedom in {', '.join(missing)}",
            expected="a node that can move there",
            remedy="A node of a solid has no rotations: put the mass or spring on a new node "
            "(with_rigid_link(fe, (x, y, z), nodes)); a held direction carries no load",
        )
    return motion


def _check_independent(fe: FEModel, places: np.ndarray) -> None:
    """Raise MeshError if a place ``6 node + direction`` to be held is moved by a link: it has no freedom of its own."""
    if fe.expansion is None:
        return
    own = np.isin(places, 6 * fe.dofs[:, 0] + fe.dofs[:, 1])
    bad = (places[(np.diff(fe.expansion.indptr)[places] > 0) & ~own] // 6).tolist()
    if bad:
        raise MeshError(
            f"Support of '{fe.name}'",
            found=f"{fe.node_name(bad[0])} depends on other nodes through a link",
            expected="nodes with independent freedoms",
            remedy="Hold the reference node of the link instead",
        )


def _symmetric(matrix) -> sparse.csr_matrix:
    return (0.5 * (matrix + matrix.T)).tocsr()
