"""Skins of cables and beams: rings of points about the line, each ring moving with its section."""

from __future__ import annotations

import numpy as np

from flexmb.model.skin import SkinPatch, check_count

__all__ = ["tube_patches"]

FEWEST = 8
"""Points of a ring, at least."""


def tube_patches(skins, length: float, title: str):
    """Return the places of the rings on a line of the length, m, as drawn, by marker, and the patches of every skin."""
    places, patches = {}, {}
    for name, skin in skins.items():
        low, high = skin.between
        n = max(1, round(length * (high - low) / skin.spacing))
        check_count(n, name, title)
        around = max(FEWEST, round(2.0 * np.pi * skin.radius / skin.spacing))
        angle = 2.0 * np.pi * (np.arange(around) + 0.5) / around
        normals = np.column_stack([np.zeros(around), np.cos(angle), np.sin(angle)])
        areas = np.full(around, 2.0 * np.pi * skin.radius / around * length * (high - low) / n)
        own = {f"{name}[{k}]": (low + (high - low) * (k + 0.5) / n, None) for k in range(n)}
        places |= own
        patches[name] = tuple(SkinPatch(m, skin.radius * normals, normals, areas, skin.radius) for m in own)
    return places, patches
