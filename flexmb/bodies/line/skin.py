"""Skins of cables and beams: rings of points about the line, each ring moving with its section."""

from __future__ import annotations

import numpy as np

from flexmb.model.skin import MOST_POINTS, SkinFacets, SkinPatch, check_count, count_along

__all__ = ["tube_patches"]

FEWEST = 8
"""Points of a ring, at least."""


def tube_patches(skins, length: float, title: str):
    """Return the places of the rings on a line of the length, m, as drawn, by marker, and the patches of every skin.

    Last, the lines between rings by which other skins see those with faces.
    """
    places, patches, facets = {}, {}, {}
    for name, skin in skins.items():
        low, high = skin.between
        rings = count_along(length * (high - low), skin.spacing)
        check_count(rings, name, title)
        ring = max(FEWEST, count_along(2.0 * np.pi * skin.radius, skin.spacing))
        check_count(rings * ring, name, title, MOST_POINTS)
        n, around = int(rings), int(ring)
        angle = 2.0 * np.pi * (np.arange(around) + 0.5) / around
        normals = np.column_stack([np.zeros(around), np.cos(angle), np.sin(angle)])
        areas = np.full(around, 2.0 * np.pi * skin.radius / around * length * (high - low) / n)
        own = {f"{name}[{k}]": (low + (high - low) * (k + 0.5) / n, None) for k in range(n)}
        places |= own
        patches[name] = tuple(SkinPatch(m, skin.radius * normals, normals, areas, skin.radius) for m in own)
        if skin.faces:
            ends = {f"{name} corner[{k}]": (low + (high - low) * k / n, None) for k in range(n + 1)}
            places |= ends
            lines = np.column_stack([np.arange(n), np.arange(1, n + 1), np.full(n, -1)])
            facets[name] = SkinFacets(tuple(ends), lines, skin.radius)
    return places, patches, facets
