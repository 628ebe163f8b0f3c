"""Skins of plates: points on both faces, on a grid of fractions."""

from __future__ import annotations

import numpy as np

from flexmb.bodies.plate.places import Place, functional
from flexmb.errors import ModelError
from flexmb.model.skin import SkinFacets, SkinPatch, check_count, count_along

__all__ = ["face_patches"]

SIDES = np.array([(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)])


def face_patches(plate, skins):
    """Return the places of all points on the middle surface by marker, the patches of every skin, and the faces."""
    places: dict[str, Place] = {}
    patches: dict[str, tuple[SkinPatch, ...]] = {}
    facets: dict[str, SkinFacets] = {}
    for name, skin in skins.items():
        grid = plate.surface.r.reshape(*(n + 1 for n in plate.elements), 3)
        edges = [np.linalg.norm(np.diff(grid, axis=k), axis=2).sum(axis=k).max() for k in (0, 1)]
        along = [count_along(edge, skin.spacing) for edge in edges]
        check_count(along[0] * along[1], name, plate.title)
        counts = [int(count) for count in along]
        corners = np.array(
            [
                [_position(plate, s, t) for t in np.linspace(0.0, 1.0, counts[1] + 1)]
                for s in np.linspace(0.0, 1.0, counts[0] + 1)
            ]
        )
        one, two = corners[1:, 1:] - corners[:-1, :-1], corners[:-1, 1:] - corners[1:, :-1]
        areas = 0.5 * np.linalg.norm(np.cross(one, two), axis=2)
        found = []
        for i in range(counts[0]):
            for j in range(counts[1]):
                s, t = (i + 0.5) / counts[0], (j + 0.5) / counts[1]
                marker, half = f"{name}[{len(found)}]", 0.5 * plate.thickness_at(s, t).item()
                places[marker] = Place(s, t, None)
                found.append(SkinPatch(marker, half * SIDES, SIDES, np.full(2, areas[i, j]), half))
        patches[name] = tuple(found)
        if skin.faces:
            facets[name] = _faces(plate, counts, name, places)
    return places, patches, facets


def _faces(plate, counts, name: str, places) -> SkinFacets:
    """Return triangles between the corners of the grid, whose places are added; they need one thickness."""
    number = np.arange((counts[0] + 1) * (counts[1] + 1)).reshape(counts[0] + 1, counts[1] + 1)
    grid = np.meshgrid(*(np.linspace(0.0, 1.0, n + 1) for n in counts), indexing="ij")
    half = 0.5 * plate.thickness_at(*grid)
    if half.max() > (1.0 + 1e-9) * half.min():
        raise ModelError(
            plate.title,
            found=f"skin {name} with faces on a plate {2 * half.min():.4g} to {2 * half.max():.4g} m thick",
            expected="one thickness: the middle surface is thickened by its half",
            remedy="Let this skin be the first of the contact, without faces",
        )
    names = tuple(f"{name} corner[{k}]" for k in range(number.size))
    for (i, j), k in np.ndenumerate(number):
        places[names[k]] = Place(grid[0][i, j].item(), grid[1][i, j].item(), None)
    a, b, c, d = (x.ravel() for x in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    return SkinFacets(
        names, np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])]), half.flat[0].item()
    )


def _position(plate, s: float, t: float) -> np.ndarray:
    nodes, weights = functional(plate, Place(float(s), float(t), None))
    return plate.drawn_at(nodes, weights)[0]
