"""Meshes of boxes and balls, made from their definitions."""

import numpy as np

import flexmb as fmb


def box(size):
    """Return vertices and triangles of a box."""
    return fmb.Cuboid(size=size).drawing()


def ball(level: int, bumps: float = 0.0):
    """Return vertices and triangles of an icosahedron, each triangle cut into four `level` times, on a ball of 1 m."""
    g = 0.5 * (1 + 5**0.5)
    vertices = np.array([(0, s, t * g) for s in (-1, 1) for t in (-1, 1)], float)
    vertices = np.concatenate([np.roll(vertices, k, axis=1) for k in range(3)])
    from scipy.spatial import ConvexHull

    triangles = ConvexHull(vertices).simplices.astype(int)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    for _ in range(level):
        edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
        unique, which = np.unique(edges, axis=0, return_inverse=True)
        middle = len(vertices) + which.reshape(3, -1)
        vertices = np.concatenate([vertices, vertices[unique].mean(axis=1)])
        a, b, c = triangles.T
        ab, bc, ca = middle
        triangles = np.concatenate([np.column_stack(t) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
        vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    size = 1.0 + bumps * np.sin(5 * vertices[:, 0]) * np.cos(4 * vertices[:, 1]) * np.sin(3 * vertices[:, 2] + 1)
    return size[:, None] * vertices, triangles
