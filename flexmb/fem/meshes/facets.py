"""Surface facets of solid cells: the skin, its outward orientation, and named sets of facets."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexmb.fem.solids.elements import SOLID_ELEMENTS, SolidElement

__all__ = ["oriented_facet_sets", "same_side", "skin", "without_copies"]

CORNERS = {3: 3, 6: 3, 4: 4, 8: 4, 9: 4}
"""Corner nodes of a facet by its number of nodes."""

WIDEST = 9


def all_faces(cells: list[tuple[str, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Return every face of every cell, padded with -1 to (nf, 9), outward, and its sorted corner nodes (nf, 4)."""
    faces, corners = [], []
    for cell_type, connectivity in cells:
        for face in SOLID_ELEMENTS[cell_type].faces:
            nodes = connectivity[:, list(face)]
            faces.append(np.pad(nodes, ((0, 0), (0, WIDEST - len(face))), constant_values=-1))
            nc = CORNERS[len(face)]
            corners.append(np.sort(np.pad(nodes[:, :nc], ((0, 0), (0, 4 - nc)), constant_values=-1), axis=1))
    return np.concatenate(faces), np.concatenate(corners)


def row_keys(*tables: np.ndarray) -> tuple[np.ndarray, ...]:
    """Number the rows of integer tables so that equal rows, within and between tables, have equal numbers."""
    rows = np.concatenate(tables)
    order = np.lexsort(rows.T)  # ten times faster than numpy.unique(axis=0)
    new = np.ones(len(rows), bool)
    new[1:] = (rows[order[1:]] != rows[order[:-1]]).any(axis=1)
    key = np.empty(len(rows), np.int64)
    key[order] = np.cumsum(new) - 1
    return tuple(np.split(key, np.cumsum([len(table) for table in tables])[:-1]))


def trimmed(facets: np.ndarray) -> np.ndarray:
    """Return facets without columns that hold only the filler -1."""
    wide = int((facets >= 0).sum(axis=1).max()) if len(facets) else 0
    return np.ascontiguousarray(facets[:, :wide])


def without_copies(facets: np.ndarray) -> np.ndarray:
    """Return facets, each once: a pressure acts once on a facet that a file lists twice. A back is another facet."""
    width = (facets >= 0).sum(axis=1)
    nc = np.array([CORNERS.get(w, 0) for w in range(WIDEST + 1)])[width]
    place = np.arange(4) < nc[:, None]
    ring = np.where(place, np.pad(facets, ((0, 0), (0, max(4 - facets.shape[1], 0))))[:, :4], np.iinfo(np.int64).max)
    turn = (np.arange(4) + ring.argmin(axis=1)[:, None]) % np.maximum(nc, 1)[:, None]  # begins at its least node
    ring = np.where(place, np.take_along_axis(ring, turn, axis=1), -1)
    (key,) = row_keys(ring)
    first = np.unique(key, return_index=True)[1]
    return facets[np.sort(first)]


def skin(cells: list[tuple[str, np.ndarray]]) -> np.ndarray:
    """Return the outer facets of solid cells, (nf, nodes per facet), outward; rows of a mixture end in -1."""
    faces, corners = all_faces(cells)
    (key,) = row_keys(corners)
    return trimmed(faces[np.bincount(key)[key] == 1])


def same_side(element: SolidElement, cells: np.ndarray) -> np.ndarray:
    """Return the numbers of cells that share a face with another cell and lie on the same side of it.

    Of two neighbours, each sees the common face outward: they run around it in opposite directions.
    """
    found = [np.zeros(0, int)]
    for corners in (3, 4):
        faces = [face for face in element.faces if CORNERS[len(face)] == corners]
        if not faces:
            continue
        ring = np.concatenate([cells[:, list(face[:corners])] for face in faces])
        owner = np.tile(np.arange(len(cells)), len(faces))
        (key,) = row_keys(np.sort(ring, axis=1))
        least, rows = ring.argmin(axis=1), np.arange(len(ring))
        forward = ring[rows, (least + 1) % corners] < ring[rows, (least - 1) % corners]
        balance = np.bincount(key, np.where(forward, 1.0, -1.0))[key]
        found.append(owner[np.abs(balance) > 1.5])
    return np.unique(np.concatenate(found))


def oriented_facet_sets(
    cells: list[tuple[str, np.ndarray]],
    node_sets: Mapping[str, np.ndarray],
    facet_sets: Mapping[str, np.ndarray],
    n_nodes: int,
) -> dict[str, np.ndarray]:
    """Return named facet sets with the node order of the solids, outward.

    Facets given by the mesh file are replaced by the same faces of the solids (a face between two solids points
    out of the first). A node set without facets of its own gets the outer facets whose nodes all belong to it, so
    that formats which know only sets of nodes describe surfaces too.
    """
    faces, corners = all_faces(cells)
    names = [name for name, facets in facet_sets.items() if len(facets)]
    wanted = []
    for name in names:
        given = facet_sets[name]
        width = (given >= 0).sum(axis=1)
        nc = np.array([CORNERS[int(w)] for w in width])
        first = np.where(np.arange(4) < nc[:, None], np.pad(given, ((0, 0), (0, 1)))[:, :4], -1)
        wanted.append(np.sort(first, axis=1))
    key, *asked = row_keys(corners, *wanted)
    owner = np.full(max([key.max(), *(k.max() for k in asked)]) + 1, -1)
    owner[key[::-1]] = np.arange(len(key))[::-1]  # the first cell with this face
    result = {}
    for name, k in zip(names, asked):
        found = owner[k]
        if (found >= 0).any():
            result[name] = trimmed(faces[found[found >= 0]])
    outer = faces[np.bincount(key)[key] == 1]
    member = np.zeros(n_nodes + 1, bool)
    member[-1] = True  # the filler -1
    order = np.argsort(outer[:, 0], kind="stable")  # facets by their first node: sets are many, and most are small
    begin = np.searchsorted(outer[order, 0], np.arange(n_nodes + 1))
    for name, nodes in node_sets.items():
        if name in result:
            continue
        own = np.unique(np.asarray(nodes, np.int64))
        count = begin[own + 1] - begin[own]
        ahead = np.cumsum(count) - count
        candidates = np.sort(order[np.repeat(begin[own] - ahead, count) + np.arange(count.sum())])
        member[own] = True
        inside = candidates[member[outer[candidates]].all(axis=1)]
        member[own] = False
        if len(inside):
            result[name] = trimmed(outer[inside])
    return result
