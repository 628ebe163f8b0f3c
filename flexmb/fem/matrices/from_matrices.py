"""`from_matrices`: an FE model from stiffness and mass matrices of another program."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy import sparse

from flexmb.errors import MeshError
from flexmb.fem.fe_model import FEModel
from flexmb.fem.matrices.checks import check_definite, check_rigid_motions, check_symmetric, check_wave_speed
from flexmb.fem.plausibility import warn_about_size
from flexmb.fem.told import keeping_warnings

__all__ = ["from_matrices"]


@keeping_warnings
def from_matrices(
    K,
    M,
    nodes,
    dofs=None,
    *,
    node_sets: Mapping[str, object] | None = None,
    length_unit: float = 1.0,
    mass_unit: float = 1.0,
    name: str = "part",
) -> FEModel:
    """Return an FE model of given matrices, checked: symmetry, definiteness, rigid motions, units.

    Geometric stiffness and stress need elements; a model of matrices has none.

    Parameters
    ----------
    K, M : (ndof, ndof), dense or sparse
        Stiffness and mass.
    nodes : (n, 3)
        Node positions, body axes.
    dofs : (ndof, 2), int
        Node number (from 0) and direction (0..2 translation x y z, 3..5 rotation x y z) of every row.
        Default: node by node, with three or six freedoms each, whichever fits.
    node_sets : mapping of name to node numbers
    length_unit : float, m
        Length of the unit in which K, M and nodes are given: 1e-3 for millimetres.
    mass_unit : float, kg
        1e3 for tonnes (the mass unit of N, mm, s). Time is in seconds, rotations in radians.

    Raises
    ------
    MeshError
        Wrong shapes, numbers that are not finite, a matrix that is not symmetric or not positive
        semidefinite.

    Warns
    -----
    MeshWarning
        Rigid motions that cost energy or masses that differ between directions; an implausible wave speed.
    """
    part = f"Matrices '{name}'"
    nodes = _positions(part, nodes)
    stiffness, mass = (check_symmetric(part, symbol, matrix) for symbol, matrix in (("K", K), ("M", M)))
    if stiffness.shape != mass.shape:
        raise MeshError(
            part,
            found=f"K has the shape {stiffness.shape}, M {mass.shape}",
            expected="two matrices of the same freedoms",
            remedy="Export both from one model with the same supports; condensed models lose rows",
        )
    dofs = _dofs(part, dofs, stiffness.shape[0], len(nodes))
    rotation = dofs[:, 1] >= 3
    scale = sparse.diags(np.where(rotation, length_unit, 1.0) * np.sqrt(mass_unit))
    stiffness, mass = (scale @ stiffness @ scale).tocsr(), (scale @ mass @ scale).tocsr()
    sets = {key: np.atleast_1d(np.asarray(value, int)) for key, value in (node_sets or {}).items()}
    fe = FEModel(nodes=length_unit * nodes, dofs=dofs, K=stiffness, M=mass, node_sets=sets, name=name)
    warn_about_size(part, fe.nodes, remedy="length_unit=1e-3")
    check_definite(part, fe)
    check_rigid_motions(part, fe)
    check_wave_speed(part, fe)
    return fe


def _positions(part: str, nodes) -> np.ndarray:
    """Return node positions (n, 3); MeshError if they are not such."""
    array = np.array(nodes, float)
    if array.ndim != 2 or array.shape[1] != 3 or len(array) == 0:
        raise MeshError(
            part,
            found=f"nodes have the shape {array.shape}",
            expected="(n, 3)",
            remedy="Give one row x, y, z per node; planar meshes need z = 0",
        )
    if not np.isfinite(array).all():
        bad = int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])
        raise MeshError(
            part,
            found=f"node {bad} is at {array[bad].tolist()}",
            expected="finite coordinates",
            remedy="Check the node table",
        )
    return array


def _dofs(part: str, dofs, size: int, number_of_nodes: int) -> np.ndarray:
    if dofs is None:
        per_node, rest = divmod(size, number_of_nodes)
        if rest or per_node not in (3, 6):
            raise MeshError(
                part,
                found=f"{size} rows and {number_of_nodes} nodes",
                expected="three or six rows per node",
                remedy="Give dofs=(ndof, 2): node number from 0 and direction 0..5 of every row",
            )
        return np.stack(
            [np.repeat(np.arange(number_of_nodes), per_node), np.tile(np.arange(per_node), number_of_nodes)],
            axis=1,
        )
    dofs = np.array(dofs, int)
    if dofs.shape != (size, 2):
        raise MeshError(
            part,
            found=f"dofs of shape {dofs.shape}",
            expected=f"({size}, 2), one row per matrix row",
            remedy="Give node number from 0 and direction 0..5 of every row",
        )
    if dofs.min() < 0 or dofs[:, 0].max() >= number_of_nodes or dofs[:, 1].max() > 5:
        raise MeshError(
            part,
            found=f"dofs name node {dofs[:, 0].max()}, direction {dofs[:, 1].max()}",
            expected=f"nodes 0..{number_of_nodes - 1}, directions 0..5",
            remedy="Numbers start at 0 here; subtract 1 from file numbers",
        )
    if len(np.unique(dofs, axis=0)) != size:
        values, count = np.unique(dofs, axis=0, return_counts=True)
        raise MeshError(
            part,
            found=f"node {values[count.argmax()][0]}, direction {values[count.argmax()][1]} appears in "
            f"{count.max()} rows of dofs",
            expected="every freedom once",
            remedy="Check the order of the rows",
        )
    return dofs
