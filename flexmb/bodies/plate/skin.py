"""Skins of plates: points on both faces, on a grid of fractions."""

from __future__ import annotations

import numpy as np

from flexmb.bodies.plate.places import Place, functional
from flexmb.model.skin import SkinPatch, check_count

__all__ = ["face_patches"]

SIDES = np.array([(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)])


def face_patches(plate, skins):
    """Return the places of all points on the middle surface by marker, and the patches of every skin."""
    places: dict[str, Place] = {}
    patches: dict[str, tuple[SkinPatch, ...]] = {}
    for name, skin in skins.items():
        grid = plate.surface.r.reshape(*(n + 1 for n in plate.elements), 3)
        edges = [np.linalg.norm(np.diff(grid, axis=k), axis=2).sum(axis=k).max() for k in (0, 1)]
        counts = [max(1, round(edge / skin.spacing)) for edge in edges]
        check_count(float(counts[0]) * counts[1], name, plate.title)
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
    return places, patches


def _position(plate, s: float, t: float) -> np.ndarray:
    nodes, weights = functional(plate, Place(float(s), float(t), None))
    return plate.drawn_at(nodes, weights)[0]
