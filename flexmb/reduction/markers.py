"""Motion of markers as a linear function of the FE freedoms: interfaces, and stations on or off the mesh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from flexmb.errors import ReductionError
from flexmb.fem.fe_model import FEModel
from flexmb.reduction.interfaces import Coupling, independent_columns, rigid_block
from flexmb.reduction.selection import is_point, model_size, nodes_of, points_of, require_place

__all__ = ["MarkerMotion", "interface_motions", "rotation_at_node", "station_motions"]

_ON_NODE = 1e-9  # relative to the size of the model
_NEIGHBOURS = 12  # nodes around a point where the model has no elements


@dataclass(frozen=True, eq=False)
class MarkerMotion:
    """A marker's translation and rotation as ``matrix @ U``: (6, ndof) csr; rows 0-2 in -, rows 3-5 in 1/m."""

    name: str
    position: np.ndarray
    matrix: sparse.csr_matrix


def interface_motions(fe: FEModel, couplings: list[Coupling]) -> list[MarkerMotion]:
    """Return the motion of every interface: its own coordinates, or the motion around a bare node."""
    return [_interface(fe, c) for c in couplings]


def rotation_at_node(fe: FEModel, node: int) -> sparse.csr_matrix:
    """Return the rotation of a node, or of the material around one without rotations: (3, ndof) csr, 1/m."""
    return _at_node(fe, node)[3:]


def _interface(fe: FEModel, coupling: Coupling) -> MarkerMotion:
    if coupling.label == "bare nodes":
        return MarkerMotion(coupling.name, coupling.position, _at_node(fe, int(coupling.nodes[0])))
    read = coupling.matrix if coupling.averaging else np.linalg.pinv(coupling.matrix)
    return MarkerMotion(coupling.name, coupling.position, _rows(fe, coupling.freedoms, coupling.rows, read))


def station_motions(fe: FEModel, stations: Mapping[str, Any]) -> list[MarkerMotion]:
    """Return the motion of every station.

    A set of nodes moves as its least-squares rigid motion. A node with rotations moves as itself. A node without
    rotations, or a point, takes translation and rotation from a polynomial through the surrounding nodes. A point
    beside a line element takes them from the element's own (Hermite) interpolation.
    """
    return [_station(fe, name, where) for name, where in stations.items()]


def _station(fe: FEModel, name: str, where) -> MarkerMotion:
    from scipy.spatial import cKDTree

    part = f"Station '{name}'"
    if is_point(where):
        require_place(fe, where, part)
        points = points_of(where)
        if len(points) != 1:
            raise ReductionError(
                part,
                found=f"{len(points)} points",
                expected="one point, a node set or node numbers",
                remedy="Name one station per point",
            )
        point = points[0]
        distance, nearest = cKDTree(fe.nodes).query(point)
        if distance > _ON_NODE * model_size(fe):
            return MarkerMotion(name, point, _at_point(fe, point, int(nearest)))
        nodes = np.array([nearest])
    else:
        nodes = nodes_of(fe, where, part, moving=False)
    if len(nodes) == 1:
        return MarkerMotion(name, fe.nodes[nodes[0]].copy(), _at_node(fe, int(nodes[0])))
    point = fe.nodes[nodes].mean(axis=0)
    return MarkerMotion(name, point, _least_squares(fe, nodes, point, np.ones(len(nodes))))


def _rows(fe: FEModel, targets: np.ndarray, columns: np.ndarray, values: np.ndarray) -> sparse.csr_matrix:
    """Return (6, ndof) with values (targets, columns) at rows `targets`."""
    row, column = np.repeat(targets, len(columns)), np.tile(columns, len(targets))
    return sparse.csr_matrix((np.ravel(values), (row, column)), shape=(6, fe.ndof))


def _at_node(fe: FEModel, node: int) -> sparse.csr_matrix:
    rows = np.flatnonzero(fe.dofs[:, 0] == node)
    if not len(rows) and fe.expansion is not None:  # a link moves this node
        return fe.expansion[6 * node : 6 * node + 6].tocsr()
    directions = fe.dofs[rows, 1]
    own = _rows(fe, directions, rows, np.eye(len(rows)))
    if np.any(directions >= 3):
        return own
    around = _polynomial(fe, fe.nodes[node], node)
    return sparse.vstack([own[:3], around[3:]]).tocsr()


def _at_point(fe: FEModel, point: np.ndarray, nearest: int) -> sparse.csr_matrix:
    element = _nearest_line(fe, point)
    if element is not None and np.any(fe.dofs[fe.dofs[:, 0] == element[0], 1] >= 3):
        return _on_line(fe, point, *element)
    if np.any(fe.dofs[fe.dofs[:, 0] == nearest, 1] >= 3):  # a shell: rigid arm from the nearest node
        rows = np.flatnonzero(fe.dofs[:, 0] == nearest)
        at_node = _rows(fe, fe.dofs[rows, 1], rows, np.eye(len(rows)))
        return (_arm(point - fe.nodes[nearest]) @ at_node).tocsr()
    return _polynomial(fe, point, nearest)


def _arm(arm: np.ndarray) -> sparse.csr_matrix:
    """Motion of a point at `arm` from a marker's motion: u + theta x arm."""
    move = np.eye(6)
    move[:3, 3:] = [[0.0, arm[2], -arm[1]], [-arm[2], 0.0, arm[0]], [arm[1], -arm[0], 0.0]]
    return sparse.csr_matrix(move)


def _least_squares(fe: FEModel, nodes: np.ndarray, point: np.ndarray, weights: np.ndarray) -> sparse.csr_matrix:
    """Weighted least-squares rigid motion of nodes; motions the nodes do not show are zero."""
    rows = np.flatnonzero(np.isin(fe.dofs[:, 0], nodes))
    radius = np.linalg.norm(fe.nodes[nodes] - point, axis=1).max() or 1.0
    translations = rows[fe.dofs[rows, 1] < 3]
    available = independent_columns(rigid_block(fe, rows, point), radius)
    if len(independent_columns(rigid_block(fe, translations, point), radius)) == len(available):
        rows = translations
    block = rigid_block(fe, rows, point)[:, available]
    scale = np.where(available < 3, 1.0, radius)
    weight = np.sqrt(weights[np.searchsorted(nodes, fe.dofs[rows, 0])])
    read = np.linalg.pinv(weight[:, None] * block / scale) * weight / scale[:, None]
    return _rows(fe, available, rows, read)


def _surroundings(fe: FEModel, nearest: int) -> np.ndarray:
    """Nodes of the elements around a node, or the nearest nodes where the model has no elements."""
    from scipy.spatial import cKDTree

    cells = [b.connectivity[np.any(b.connectivity == nearest, axis=1)].ravel() for b in fe.blocks]
    around = np.unique(np.concatenate([*cells, [nearest]]).astype(int))
    used = np.unique(fe.dofs[:, 0])
    if len(around) < 4:
        count = min(_NEIGHBOURS, len(used))
        around = used[np.atleast_1d(cKDTree(fe.nodes[used]).query(fe.nodes[nearest], k=count)[1])]
    return np.intersect1d(around, used)


def _polynomial(fe: FEModel, point: np.ndarray, nearest: int) -> sparse.csr_matrix:
    """Translation and rotation (antisymmetric gradient) of a weighted quadratic or linear fit of the displacement.

    Quadratic where the surrounding nodes allow it, so that linear strain, e.g. bending, is met exactly.
    Beyond the nodes' own distance from each other the point follows their rigid motion: no extrapolation.
    """
    nodes = _surroundings(fe, nearest)
    arms = fe.nodes[nodes] - point
    distance = np.linalg.norm(arms, axis=1)
    size = np.linalg.norm(fe.nodes[nodes] - fe.nodes[nearest], axis=1).max() or 1.0
    weight = 1.0 / (distance / size + 1e-2)
    x = arms / size
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
    linear = np.column_stack([np.ones(len(x)), x])
    quadratic = np.column_stack([linear, *(x[:, i] * x[:, j] for i, j in pairs)])
    rows = {direction: _row_of(fe, nodes, direction) for direction in range(3)}
    complete = all(np.all(row >= 0) for row in rows.values())
    for terms in (quadratic, linear) if complete and distance.min() < size else ():
        singular = np.linalg.svd(weight[:, None] * terms, compute_uv=False)
        if len(terms) >= terms.shape[1] and singular[-1] > 1e-6 * singular[0]:
            fit = np.linalg.pinv(weight[:, None] * terms) * weight  # (terms, nodes)
            return _fit_rows(fe, rows, fit[:4] / np.array([1.0, size, size, size])[:, None])
    return _least_squares(fe, nodes, point, np.ones(len(nodes)))


def _row_of(fe: FEModel, nodes: np.ndarray, direction: int) -> np.ndarray:
    row = np.full(len(fe.nodes), -1)
    mine = fe.dofs[:, 1] == direction
    row[fe.dofs[mine, 0]] = np.flatnonzero(mine)
    return row[nodes]


def _fit_rows(fe: FEModel, rows: dict[int, np.ndarray], fit: np.ndarray) -> sparse.csr_matrix:
    """Rows of u = fit[0] U and theta_k = 1/2 (du_b/dx_a - du_a/dx_b)."""
    matrix = sparse.lil_matrix((6, fe.ndof))
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3
        matrix[k, rows[k]] = fit[0]
        matrix[3 + k, rows[b]] = 0.5 * fit[1 + a]
        matrix[3 + k, rows[a]] = -0.5 * fit[1 + b]
    return matrix.tocsr()


def _nearest_line(fe: FEModel, point: np.ndarray) -> tuple[int, int, float] | None:
    """Return (first node, second node, fraction) of the line element nearest to the point, or None.

    None also where a node of other elements is nearer: a point on a skin does not belong to its stringer.
    """
    from scipy.spatial import cKDTree

    best, found = (1.0 + 1e-9) * float(cKDTree(fe.nodes).query(point)[0]), None
    for block in fe.blocks:
        if not block.cell_type.startswith("line"):
            continue
        first, second = fe.nodes[block.connectivity[:, 0]], fe.nodes[block.connectivity[:, 1]]
        along = second - first
        fraction = np.clip(np.einsum("ij,ij->i", point - first, along) / np.einsum("ij,ij->i", along, along), 0.0, 1.0)
        distance = np.linalg.norm(first + fraction[:, None] * along - point, axis=1)
        i = int(np.argmin(distance))
        if distance[i] <= best:
            ends = block.connectivity[i]
            best, found = distance[i], (int(ends[0]), int(ends[1]), float(fraction[i]))
    return found


def _on_line(fe: FEModel, point: np.ndarray, first: int, second: int, s: float) -> sparse.csr_matrix:
    """Hermite interpolation between two nodes with rotations, and a rigid arm to a point off the axis.

    Transverse: u = H1 u1 + H2 u2 + L (H3 theta1 + H4 theta2) x t, theta = t x du/dx; axial and torsion linear.
    """
    along = fe.nodes[second] - fe.nodes[first]
    length = np.linalg.norm(along)
    t = along / length
    axial, cross = (
        np.outer(t, t),
        np.array([[0, t[2], -t[1]], [-t[2], 0, t[0]], [t[1], -t[0], 0]]),
    )  # theta x t
    transverse = np.eye(3) - axial
    H = (1 - 3 * s**2 + 2 * s**3, 3 * s**2 - 2 * s**3, s - 2 * s**2 + s**3, s**3 - s**2)
    dH = (6 * s**2 - 6 * s, 6 * s - 6 * s**2, 1 - 4 * s + 3 * s**2, 3 * s**2 - 2 * s)
    N = np.zeros((6, 12))
    for i, (share, columns) in enumerate(((1.0 - s, slice(0, 6)), (s, slice(6, 12)))):
        block = N[:, columns]
        block[:3, :3] = share * axial + H[i] * transverse
        block[:3, 3:] = length * H[2 + i] * cross
        block[3:, :3] = -cross @ transverse * dH[i] / length  # t x (.) = -(.) x t
        block[3:, 3:] = share * axial - dH[2 + i] * cross @ cross
    N = _arm(point - fe.nodes[first] - s * along).toarray() @ N
    matrix = sparse.lil_matrix((6, fe.ndof))
    for node, columns in ((first, N[:, :6]), (second, N[:, 6:])):
        for row in np.flatnonzero(fe.dofs[:, 0] == node):
            matrix[:, row] = columns[:, [fe.dofs[row, 1]]]
    return matrix.tocsr()
