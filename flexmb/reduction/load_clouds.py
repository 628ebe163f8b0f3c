"""Forces at points in space, and how they reach the nodes of a mesh with the same resultant force and moment.

To beams: the force acts at the foot of its point on the nearest beam, with the moment of its arm, and the nodes get
what does the same work on cubic shapes, as `LineLoad`. To facets: the corners of the nearest triangle of a facet share
the force by area coordinates of the foot; the moment of the arm goes to nodes with rotations by the same shares, and
becomes couples of forces otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.errors import ReductionError
from flexmb.fem.fe_model import FEModel

__all__ = ["LoadCloud", "Target", "mapped_forces", "target_of"]

CHUNK = 2_000_000
"""Distances measured at once."""
SPLIT = {
    3: [(0, 1, 2)],
    6: [(0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)],
    4: [(0, 1, 2), (0, 2, 3)],
    8: [(0, 4, 7), (4, 1, 5), (5, 2, 6), (6, 3, 7), (4, 5, 6), (4, 6, 7)],
    9: [(0, 4, 8), (4, 1, 8), (1, 5, 8), (5, 2, 8), (2, 6, 8), (6, 3, 8), (3, 7, 8), (7, 0, 8)],
}
"""Facets as triangles, by the number of nodes."""


@dataclass(frozen=True, eq=False)
class LoadCloud:
    """Forces, N, and moments, N m, at points, m, all (n, 3) in body axes."""

    points: np.ndarray
    forces: np.ndarray
    moments: np.ndarray

    def resultant(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the total force (3,), N, and the total moment about the origin (3,), N m."""
        moment = self.moments + np.cross(self.points, self.forces)
        return self.forces.sum(axis=0), moment.sum(axis=0)


@dataclass(frozen=True, eq=False)
class Target:
    """What carries a load: beams (nb, 2) and triangles (nt, 3), node numbers, and which nodes have rotations (n,)."""

    lines: np.ndarray
    triangles: np.ndarray
    turning: np.ndarray

    def spacing(self, nodes: np.ndarray) -> float:
        """Return half the least length of a beam, or of an edge of a triangle, m."""
        edges = [self.lines, self.triangles[:, :2], self.triangles[:, 1:], self.triangles[:, ::2]]
        ends = np.concatenate(edges)
        lengths = np.linalg.norm(nodes[ends[:, 1]] - nodes[ends[:, 0]], axis=1)
        return 0.5 * float(np.min(lengths[lengths > 1e-6 * lengths.max()]))

    def size(self, nodes: np.ndarray) -> float:
        """Return the diagonal of its box, m."""
        used = nodes[np.unique(np.concatenate([self.lines.ravel(), self.triangles.ravel()]))]
        return float(np.linalg.norm(np.ptp(used, axis=0)))


def target_of(fe: FEModel, nodes: np.ndarray, facets: list[np.ndarray], part: str) -> Target:
    """Return the beams and shells whose nodes are all among `nodes`, or the given facets (nf, k)."""
    inside = np.isin(np.arange(len(fe.nodes)), nodes)
    lines, surfaces = [], list(facets)
    for block in fe.blocks if not facets else ():
        cells = block.connectivity[np.all(inside[block.connectivity], axis=1)]
        if block.cell_type == "line":
            lines.append(cells)
        elif block.cell_type.startswith(("triangle", "quad")):
            surfaces.append(cells)
    pieces = [cells[:, corners] for cells in surfaces for corners in SPLIT[cells.shape[1]]]
    found = Target(
        np.concatenate([*lines, np.empty((0, 2), int)]),
        np.concatenate([*pieces, np.empty((0, 3), int)]),
        _nodes_that_turn(fe),
    )
    if not len(found.lines) and not len(found.triangles):
        raise ReductionError(
            part,
            found=f"no beam, shell or facet among the {len(nodes)} nodes of the set",
            expected="a set that holds whole elements, or a facet set of solids",
            remedy="Name the set of the loaded beams or shells, or the marked surface of the mesh",
        )
    return found


def _nodes_that_turn(fe: FEModel) -> np.ndarray:
    """Return which nodes have all three rotations, free or by a link, (n,)."""
    carried = np.zeros((len(fe.nodes), 6), bool)
    carried[fe.dofs[:, 0], fe.dofs[:, 1]] = True
    if fe.expansion is not None:
        carried |= (fe.expansion.getnnz(axis=1) > 0).reshape(carried.shape)
    return np.all(carried[:, 3:], axis=1)


def mapped_forces(fe: FEModel, target: Target, cloud: LoadCloud, reach: float, part: str) -> np.ndarray:
    """Return the nodal forces and moments (n, 6), N and N m; ReductionError where a point is beyond `reach`, m."""
    field = np.zeros((len(fe.nodes), 6))
    to_line, at, line_gap = _nearest_lines(fe.nodes, target.lines, cloud.points)
    to_triangle, shares, gap = _nearest_triangles(fe.nodes, target.triangles, cloud.points)
    least = np.minimum(line_gap, gap)
    if len(least) and least.max() > reach:
        far = int(np.argmax(least))
        raise ReductionError(
            part,
            found=f"{np.count_nonzero(least > reach)} of {len(least)} points farther than {reach:.4g} m from the "
            f"elements, the farthest at {np.round(cloud.points[far], 4).tolist()} m by {least[far]:.4g} m",
            expected="loads in the axes and the unit of the mesh, near it",
            remedy="Look at scale, in metres per unit of the file, and at the axes; or give a larger reach",
        )
    on_line = line_gap <= gap
    _to_beams(fe.nodes, target.lines[to_line[on_line]], at[on_line], _part(cloud, on_line), field)
    off = ~on_line
    _to_triangles(fe.nodes, target, target.triangles[to_triangle[off]], shares[off], _part(cloud, off), field)
    return field


def _part(cloud: LoadCloud, chosen: np.ndarray) -> LoadCloud:
    return LoadCloud(cloud.points[chosen], cloud.forces[chosen], cloud.moments[chosen])


def _nearest_lines(nodes, lines, points):
    """Return the nearest beam of each point, the place 0..1 of its foot there, and the distance, m."""
    which, place, gap = np.zeros(len(points), int), np.zeros(len(points)), np.full(len(points), np.inf)
    if len(lines):
        start, along = nodes[lines[:, 0]], nodes[lines[:, 1]] - nodes[lines[:, 0]]
        square = np.maximum(np.einsum("li,li->l", along, along), 1e-300)
        step = max(1, CHUNK // len(lines))
        for first in range(0, len(points), step):
            d = points[first : first + step, None] - start
            s = np.clip(np.einsum("pli,li->pl", d, along) / square, 0.0, 1.0)
            distance = np.linalg.norm(d - s[..., None] * along, axis=2)
            best, rows = np.argmin(distance, axis=1), np.arange(len(d))
            which[first : first + step], place[first : first + step] = best, s[rows, best]
            gap[first : first + step] = distance[rows, best]
    return which, place, gap


def _nearest_triangles(nodes, triangles, points):
    """Return the nearest triangle of each point, the area coordinates (n, 3) of its foot there, the distance, m."""
    which, shares, gap = np.zeros(len(points), int), np.zeros((len(points), 3)), np.full(len(points), np.inf)
    if len(triangles):
        from scipy.spatial import cKDTree

        corners = nodes[triangles]
        middle = corners.mean(axis=1)
        radius = float(np.linalg.norm(corners - middle[:, None], axis=2).max())
        tree = cKDTree(middle)
        first = tree.query(points)[0]
        # the nearest triangle has its middle within the nearest middle's distance and two radii
        for k, candidates in enumerate(tree.query_ball_point(points, first + 2.0 * radius)):
            found = np.array(candidates, int)
            weights = _area_coordinates(corners[found], points[k])
            distance = np.linalg.norm(np.einsum("ta,tai->ti", weights, corners[found]) - points[k], axis=1)
            best = int(np.argmin(distance))
            which[k], shares[k], gap[k] = found[best], weights[best], distance[best]
    return which, shares, gap


def _area_coordinates(corners: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the area coordinates (nt, 3), all within 0..1, of the points of triangles (nt, 3, 3) nearest to p."""
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    d = p - a
    uu, uv, vv = (np.einsum("ti,ti->t", *pair) for pair in ((u, u), (u, v), (v, v)))
    ud, vd = np.einsum("ti,ti->t", u, d), np.einsum("ti,ti->t", v, d)
    square = np.maximum(uu * vv - uv * uv, 1e-300)
    s, t = (vv * ud - uv * vd) / square, (uu * vd - uv * ud) / square
    inside = np.stack([1.0 - s - t, s, t], axis=1)
    best, least = inside, np.where(np.all(inside >= 0.0, axis=1), 0.0, np.inf)
    for one, two in ((0, 1), (1, 2), (2, 0)):  # or on an edge
        along = corners[:, two] - corners[:, one]
        x = np.einsum("ti,ti->t", p - corners[:, one], along) / np.maximum(np.einsum("ti,ti->t", along, along), 1e-300)
        x = np.clip(x, 0.0, 1.0)
        far = np.linalg.norm(corners[:, one] + x[:, None] * along - p, axis=1)
        weights = np.zeros((len(x), 3))
        weights[:, one], weights[:, two] = 1.0 - x, x
        nearer = far < least
        best, least = np.where(nearer[:, None], weights, best), np.where(nearer, far, least)
    return best


def _to_beams(nodes, lines, s, cloud: LoadCloud, field) -> None:
    """Add what does the work of the loads at the places s of beams on cubic shapes."""
    along = nodes[lines[:, 1]] - nodes[lines[:, 0]]
    length = np.linalg.norm(along, axis=1)[:, None]
    t, s = along / np.maximum(length, 1e-300), s[:, None]
    foot = nodes[lines[:, 0]] + s * along
    moment = cloud.moments + np.cross(cloud.points - foot, cloud.forces)
    axial = np.einsum("ki,ki->k", cloud.forces, t)[:, None] * t
    across, twist = cloud.forces - axial, np.einsum("ki,ki->k", moment, t)[:, None] * t
    bend, turn = moment - twist, np.cross(t, across)
    push = np.cross(moment, t) / np.maximum(length, 1e-300)  # a moment acts on the slope of the deflection
    shapes = (
        (
            1.0 - s,
            1.0 - 3.0 * s**2 + 2.0 * s**3,
            s - 2.0 * s**2 + s**3,
            -6.0 * s + 6.0 * s**2,
            1.0 - 4.0 * s + 3.0 * s**2,
        ),
        (s, 3.0 * s**2 - 2.0 * s**3, s**3 - s**2, 6.0 * s - 6.0 * s**2, 3.0 * s**2 - 2.0 * s),
    )
    for end, (linear, deflection, slope, rate, bent) in enumerate(shapes):
        np.add.at(field[:, :3], lines[:, end], linear * axial + deflection * across + rate * push)
        np.add.at(field[:, 3:], lines[:, end], slope * length * turn + linear * twist + bent * bend)


def _to_triangles(nodes, target: Target, triangles, shares, cloud: LoadCloud, field) -> None:
    """Add the shares of the corners, and the moments of the arms."""
    corners = nodes[triangles]
    foot = np.einsum("ka,kai->ki", shares, corners)
    moment = cloud.moments + np.cross(cloud.points - foot, cloud.forces)
    turning = target.turning[triangles].all(axis=1)
    arm = corners - corners.mean(axis=1)[:, None]
    inertia = np.einsum("kai,kai->k", arm, arm)[:, None, None] * np.eye(3) - np.einsum("kai,kaj->kij", arm, arm)
    couple = np.zeros_like(corners)
    if len(moment) and not turning.all():
        spin = np.linalg.solve(inertia[~turning], moment[~turning][:, :, None])[:, :, 0]
        couple[~turning] = np.cross(spin[:, None], arm[~turning])
    for k in range(3):
        np.add.at(field[:, :3], triangles[:, k], shares[:, k : k + 1] * cloud.forces + couple[:, k])
        np.add.at(field[:, 3:], triangles[turning, k], shares[turning, k : k + 1] * moment[turning])
