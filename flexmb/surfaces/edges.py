"""Sharp edges and flat faces of surfaces, by which they meet others where no corner does.

An edge of a solid stands out if its faces turn away from each other; only such ones meet others. Of each its ends are
kept, and the directions from it into both faces: a direction n is normal to the surface there, somewhere between the
normals of the faces, if it is at right angles to the edge and leads into neither face.

Packed, a surface begins with a `HEAD` of numbers: how many edges, where they and the nodes of their tree are, how many
corners, where they and their ways into the solid are, how many faces, where they and their outlines are, and by how
much all is rounded (m). Places count from there. An edge has `LINE` numbers (ends; directions into the faces, zeros
for the line in a capsule), a face `FACE` (outward normal, distance from the marker, first corner and number of corners
of its outline), a corner 3.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from flexmb.surfaces.closed_mesh import inset, twins
from flexmb.surfaces.trees import built

__all__ = [
    "CORNERS",
    "CORNERS_AT",
    "EDGES",
    "EDGES_AT",
    "FACE",
    "FACES",
    "FACES_AT",
    "HEAD",
    "LINE",
    "NODES_AT",
    "NO_EDGES",
    "OUTLINES_AT",
    "ROUND",
    "WAYS_AT",
    "Edges",
    "edges_of_solid",
    "packed_edges",
]

EDGES, EDGES_AT, NODES_AT, CORNERS, CORNERS_AT, WAYS_AT, FACES, FACES_AT, OUTLINES_AT, ROUND = range(10)
HEAD, LINE, FACE = 10, 12, 6
INSET = 1e-6
"""Way of a corner into the solid, relative to its thickness, to a place that tells which of two faces it rests on."""
FLAT = 1e-5
"""Sine between neighbours up to which they are one face: more than what numbers of single precision leave."""
MOST = 1000
"""Edges up to which a convex solid has faces: with more of them it is round rather than flat."""


class Edges(NamedTuple):
    """Edges of a surface, in the axes of its marker."""

    lines: np.ndarray
    """(n, 12) m, ends of each, and directions from it into both faces"""
    corners: np.ndarray
    """(k, 3) m"""
    ways: np.ndarray
    """(k, 3) m, from each a little into the solid, behind all faces there"""
    outlines: list[np.ndarray]
    """(m, 3) each, m: corners of the flat faces of a convex solid, round the outward normal; else none"""
    radius: float = 0.0
    """m, by which edges are rounded"""


NO_EDGES = Edges(np.zeros((0, LINE)), np.zeros((0, 3)), np.zeros((0, 3)), [])


def edges_of_solid(vertices: np.ndarray, triangles: np.ndarray, thickness: float, convex: bool) -> Edges:
    """Return the edges of a closed mesh (triangles (m, 3) of vertices (n, 3), m) of a `thickness` (m), and if it is
    `convex` its faces.
    """
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    twin = twins(triangles, len(vertices))
    face = np.arange(len(start)) // 3
    along = vertices[end] - vertices[start]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    here, beyond = normals[face], normals[face[twin]]
    sine = np.einsum("ij,ij->i", np.cross(here, beyond), along)
    cosine = np.einsum("ij,ij->i", here, beyond)
    stands_out = (sine > FLAT) | ((cosine < 0.0) & (sine > -FLAT))
    own = np.flatnonzero(stands_out & (start < end))
    into = np.cross(here[own], along[own]), -np.cross(beyond[own], along[own])
    lines = np.column_stack([vertices[start[own]], vertices[end[own]], *into])
    flat = (np.abs(sine) <= FLAT) & (cosine > 0.0)
    outlines = _outlines(vertices, start, end, face, twin, flat) if convex and len(lines) <= MOST else []
    ways = inset(vertices, triangles, INSET * thickness)
    return Edges(lines, vertices, ways, outlines)


def _outlines(vertices, start, end, face, twin, flat) -> list[np.ndarray]:
    """Return the outlines of what flat edges join; none if one of them is not simple."""
    count = face[-1] + 1
    joined = coo_array((np.ones(int(flat.sum()), np.int8), (face[flat], face[twin[flat]])), shape=(count, count))
    parts, of_face = connected_components(joined, directed=False)
    after: list[dict[int, int]] = [{} for _ in range(parts)]
    rim = np.flatnonzero(~flat)
    for k, m, n in zip(of_face[face[rim]].tolist(), start[rim].tolist(), end[rim].tolist(), strict=True):
        after[k][m] = n
    if sum(map(len, after)) < len(rim):
        return []
    outlines = []
    for ways in after:
        way = [next(iter(ways))] if ways else []
        while ways and len(way) <= len(ways) and ways[way[-1]] != way[0]:
            way.append(ways[way[-1]])
        if len(way) != len(ways) or len(way) < 3:
            return []
        outlines.append(vertices[way])
    return outlines


def packed_edges(edges: Edges) -> np.ndarray:
    """Return all that kernels need."""
    lines = edges.lines
    ends = lines[:, :6].reshape(-1, 2, 3)
    order, nodes = built(ends.min(axis=1), ends.max(axis=1))
    faces, outlines = _packed_faces(edges.outlines)
    nodes_at = HEAD + lines.size
    corners_at = nodes_at + nodes.size
    ways_at = corners_at + edges.corners.size
    faces_at = ways_at + edges.ways.size
    head = np.zeros(HEAD)
    head[[EDGES, EDGES_AT, NODES_AT, ROUND]] = len(lines), HEAD, nodes_at, edges.radius
    head[[CORNERS, CORNERS_AT, FACES, FACES_AT]] = len(edges.corners), corners_at, len(faces), faces_at
    head[[WAYS_AT, OUTLINES_AT]] = ways_at, faces_at + faces.size
    blocks = (head, lines[order], nodes, edges.corners, edges.ways, faces, outlines)
    return np.concatenate([block.ravel() for block in blocks])


def _packed_faces(outlines: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of faces (n, FACE), and all corners of their outlines (m, 3), m."""
    faces = np.zeros((len(outlines), FACE))
    if not outlines:
        return faces, np.zeros((0, 3))
    counts = np.array([len(outline) for outline in outlines])
    first, corners = np.cumsum(counts) - counts, np.concatenate(outlines)
    after = np.arange(len(corners)) + 1
    after[first + counts - 1] = first
    normals = np.add.reduceat(np.cross(corners, corners[after]), first, axis=0)  # of twice the area, by Newell
    faces[:, :3] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    faces[:, 3] = np.maximum.reduceat(np.einsum("ij,ij->i", corners, np.repeat(faces[:, :3], counts, axis=0)), first)
    faces[:, 4], faces[:, 5] = first, counts
    return faces, corners
