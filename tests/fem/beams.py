"""Straight beams and plates of the tests of frames and shells."""

import numpy as np

from flexmb import fem
from flexmb.fem.meshes.mesh import Mesh
from flexmb.model.material import Material

STEEL = Material(young=210e9, poisson=0.3, density=7850.0)


def straight(elements, length=1.0, direction=(1.0, 0.0, 0.0)):
    """Return the nodes (n, 3) of a straight beam from the origin."""
    along = np.asarray(direction, float) / np.linalg.norm(direction)
    return np.linspace(0.0, length, elements + 1)[:, None] * along


def frequencies(fe, n):
    """Return the n lowest eigenfrequencies, Hz, by LAPACK: small models only."""
    from scipy.linalg import eigh

    values = eigh(fe.K.toarray(), fe.M.toarray(), eigvals_only=True, subset_by_index=[0, n - 1])
    return np.sqrt(np.maximum(values, 0.0)) / (2.0 * np.pi)


def solve(fe, node, force):
    """Return the nodal field (n, 6) under a force and moment (6,) at a node of a supported model."""
    load = np.zeros((len(fe.nodes), 6, 1))
    load[node, :, 0] = force
    return fe.field(np.linalg.solve(fe.K.toarray(), fe.forces(load)))[..., 0]


def plate(nx, ny, a, b, kind, distortion=0.0):
    """Return a rectangle a x b in the x-y plane: "quad", "triangle" (one diagonal) or "cross" (four
    triangles per cell)."""
    x, y = np.meshgrid(np.linspace(0.0, a, nx + 1), np.linspace(0.0, b, ny + 1), indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=1)
    inner = (x.ravel() > 0) & (x.ravel() < a) & (y.ravel() > 0) & (y.ravel() < b)
    shift = np.random.default_rng(1).uniform(-distortion, distortion, (inner.sum(), 2))
    points[inner, :2] += shift * [a / nx, b / ny]
    number = np.arange((nx + 1) * (ny + 1)).reshape(nx + 1, ny + 1)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], -1).reshape(-1, 4)
    if kind == "quad":
        return Mesh(points=points, cells=(("quad", quads),))
    if kind == "triangle":
        cells = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        return Mesh(points=points, cells=(("triangle", cells),))
    middle = len(points) + np.arange(len(quads))
    points = np.vstack([points, points[quads].mean(axis=1)])
    cells = [np.stack([quads[:, k], quads[:, (k + 1) % 4], middle], axis=1) for k in range(4)]
    return Mesh(points=points, cells=(("triangle", np.concatenate(cells)),))


def on(fe, axis, value):
    """Return the nodes with a coordinate of a value."""
    return np.flatnonzero(np.abs(fe.nodes[:, axis] - value) < 1e-9)


def simply_supported(fe, a, b):
    """Return a plate in the x-y plane with hard simple supports (w and the rotation along the edge held)."""
    x_edges = np.union1d(on(fe, 0, 0.0), on(fe, 0, a))
    y_edges = np.union1d(on(fe, 1, 0.0), on(fe, 1, b))
    fe = fem.with_supports(fe, np.union1d(x_edges, y_edges), [2])
    return fem.with_supports(fem.with_supports(fe, x_edges, [3]), y_edges, [4])
