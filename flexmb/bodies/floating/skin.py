"""Skins of a reduced body: points of its free surface as stations that move and turn with its modes.

A point on a triangle of nodes moves by their shapes, weighted as its place is. Its area vector N = (b - a) x (c - a)
changes by dN with the modes, so the normal n turns by ``n x dn``, ``dn = (1 - n n^T) dN / |N|``, which are the rotation
shapes of the station.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmb.errors import ModelError
from flexmb.fem.meshes.skin_triangles import skin_triangles
from flexmb.math.triangles import centres_of_parts
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.model.skin import Skin, SkinFacets, SkinPatch, check_count

__all__ = ["with_skins"]


def with_skins(data: ModalNeutralData, skins, title: str):
    """Return the data with a station for every point of the skins, their patches and faces, and the thickness, m.

    The thickness is twice the volume per area of the solid, as in `Shape`.
    """
    patches, faces, thickness = {}, {}, {}
    outer, sheets = skin_triangles(data.cells) if len(data.nodes) else (np.zeros((0, 3), int),) * 2
    for name, skin in skins.items():
        solid = skin.radius is None
        triangles = _chosen(data, outer if solid else sheets, skin, name, title)
        data, patches[name] = _stationed(data, triangles, skin, name, title)
        if skin.faces:
            data, faces[name] = _with_corners(data, triangles, skin, name, title)
        thickness[name] = _thickness(data.nodes, outer) if solid else 2.0 * skin.radius
    return data, patches, faces, thickness


def _chosen(data, triangles, skin: Skin, name: str, title: str) -> np.ndarray:
    """Return the triangles of a skin."""
    if not len(triangles):
        shells = "shells" if skin.radius is not None else "solids"
        raise ModelError(
            title,
            found=f"skin {name}: the data '{data.name}' have no {shells}"
            + (" (are they without mesh?)" if not len(data.nodes) else ""),
            expected="data with nodes and cells: solids, or shells with the radius of the skin half their thickness",
            remedy="Give radius= for shells, leave it out for solids; frames have no skin",
        )
    if skin.nodes is None:
        return triangles
    member = np.zeros(len(data.nodes), bool)
    member[data.nodes_named(skin.nodes, title)] = True
    found = triangles[member[triangles].all(axis=1)]
    if not len(found):
        raise ModelError(
            title,
            found=f"skin {name}: no facet of the free surface has all its nodes in {skin.nodes!r:.60}",
            expected="a set of nodes that covers facets",
            remedy="Name a set of a surface, or leave nodes out for all",
        )
    return found


def _thickness(nodes, triangles) -> float:
    a, b, c = (nodes[triangles[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    return float(abs(np.einsum("ij,ij->", a, cross)) / 1.5 / np.linalg.norm(cross, axis=1).sum())


def _stationed(data, triangles, skin: Skin, name: str, title: str):
    """Return the data with stations at the points of the triangles, and their patches."""
    a, b, c = (data.nodes[triangles[:, k]] for k in range(3))
    da, db, dc = (data.shapes[triangles[:, k]] for k in range(3))
    size, n, turn = _turns(a, b, c, da, db, dc)
    longest = np.max([np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    cuts = np.maximum(1, np.ceil(longest / skin.spacing)).astype(int)
    check_count(np.sum(cuts.astype(float) ** 2), name, title)
    places, shapes, turns, normals, areas = [], [], [], [], []
    for k in np.unique(cuts):
        own = np.flatnonzero(cuts == k)
        for u, v, w in centres_of_parts(k):
            places.append(u * a[own] + v * b[own] + w * c[own])
            shapes.append(u * da[own] + v * db[own] + w * dc[own])
            turns.append(turn[own])
            normals.append(n[own])
            areas.append(0.5 * size[own] / k**2)
    normal, area = np.concatenate(normals), np.concatenate(areas)
    names = tuple(f"{name}[{k}]" for k in range(len(area)))
    more = _with_markers(data, names, *(np.concatenate(parts) for parts in (places, shapes, turns)))
    r = skin.radius or 0.0
    sides = np.array([1.0, -1.0]) if r else np.array([1.0])
    return more, tuple(
        SkinPatch(marker, r * sides[:, None] * n, sides[:, None] * n, np.full(len(sides), part), r)
        for marker, n, part in zip(names, normal, area)
    )


def _turns(a, b, c, da, db, dc):
    """Return twice the areas (n,) of triangles, their normals (n, 3), and how these turn with the modes (n, 3, m)."""
    N = np.cross(b - a, c - a)
    size = np.linalg.norm(N, axis=1)
    n = N / size[:, None]
    dN = np.cross(db - da, (c - a)[:, :, None], axis=1) + np.cross((b - a)[:, :, None], dc - da, axis=1)
    dn = (dN - n[:, :, None] * np.einsum("ti,tim->tm", n, dN)[:, None]) / size[:, None, None]
    return size, n, np.cross(n[:, :, None], dn, axis=1)


def _with_markers(data, names, places, shapes, turns):
    """Return the data with more stations."""
    return replace(
        data,
        marker_names=(*data.marker_names, *names),
        marker_positions=np.concatenate([data.marker_positions.reshape(-1, 3), places]),
        marker_translations=np.concatenate([data.marker_translations, shapes]),
        marker_rotations=np.concatenate([data.marker_rotations, turns]),
    )


def _with_corners(data, triangles, skin: Skin, name: str, title: str):
    """Return the data with stations at the corners of the triangles, and the faces between them.

    Forces on faces with a thickness have a lever about the corners, which turn with the mean of the faces around them.
    """
    nodes, facets = np.unique(triangles, return_inverse=True)
    facets = facets.reshape(-1, 3)
    check_count(len(nodes), name, title)
    turns = np.zeros((len(nodes), 3, data.n_modes))
    if skin.radius is not None:
        corners = [data.nodes[triangles[:, k]] for k in range(3)], [data.shapes[triangles[:, k]] for k in range(3)]
        size, _, turn = _turns(*corners[0], *corners[1])
        total = np.zeros(len(nodes))
        for k in range(3):
            np.add.at(total, facets[:, k], size)
            np.add.at(turns, facets[:, k], size[:, None, None] * turn)
        turns /= total[:, None, None]
    names = tuple(f"{name} corner[{k}]" for k in range(len(nodes)))
    more = _with_markers(data, names, data.nodes[nodes], data.shapes[nodes], turns)
    return more, SkinFacets(names, facets, skin.radius or 0.0)
