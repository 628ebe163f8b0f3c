"""`held_turns`: how firmly shells that do not turn in their plane hold that rotation where their surface is curved.

Nastran and Abaqus take the rotation about the normal out of the bending of a curved surface, by normals of its nodes.
Flat elements that meet in a fold do not: their twisting moments turn the nodes about the normal, which a weak spring
lets go, the more the finer the mesh. The softness that this adds goes with (t k)^2 over the share of the spring, k the
curvature: a share of a hundred times (t k)^2 keeps it below half a percent.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmb.fem.deck.contents import Shells

__all__ = ["held_turns"]

SMOOTH = np.radians(20.0)
"""Folds up to this angle are of a curved surface (PARAM, SNORM of Nastran); sharper ones hold each other's turn."""
FIRMNESS = 100.0
"""Share of the in-plane shear stiffness over (t k)^2."""


def held_turns(groups: Sequence[Shells], points: np.ndarray) -> list[np.ndarray | None]:
    """Return, for each group, the share (ne,) of the shear stiffness that holds the turn of its shells, or None."""
    weak = [group for group in groups if group.spring is not None]
    if not weak:
        return [None] * len(groups)
    bent = np.zeros(sum(len(group.nodes) for group in weak))
    normals = np.concatenate([_normals(points[group.nodes]) for group in weak])
    centres = np.concatenate([points[group.nodes].mean(axis=1) for group in weak])
    ends, owner = [], []
    for group, first in zip(weak, np.cumsum([0, *(len(group.nodes) for group in weak)]), strict=False):
        count = group.nodes.shape[1]
        ends.append(np.sort(np.stack([group.nodes, np.roll(group.nodes, -1, axis=1)], axis=2).reshape(-1, 2), axis=1))
        owner.append(np.repeat(first + np.arange(len(group.nodes)), count))
    edges, cell = np.vstack(ends), np.concatenate(owner)
    order = np.lexsort(edges.T)
    same = (edges[order][1:] == edges[order][:-1]).all(axis=1)
    a, b = cell[order][:-1][same], cell[order][1:][same]
    fold = np.arcsin(np.minimum(np.linalg.norm(np.cross(normals[a], normals[b]), axis=1), 1.0))
    apart = np.maximum(np.linalg.norm(centres[b] - centres[a], axis=1), 1e-300)
    curvature = np.where(fold <= SMOOTH, fold / apart, 0.0)
    for one in (a, b):
        np.maximum.at(bent, one, curvature)
    out: list[np.ndarray | None] = []
    at = 0
    for group in groups:
        if group.spring is None:
            out.append(None)
            continue
        own = bent[at : at + len(group.nodes)]
        at += len(group.nodes)
        out.append(np.clip(FIRMNESS * (group.thickness * own) ** 2, group.spring, max(group.spring, 1.0)))
    return out


def _normals(corners: np.ndarray) -> np.ndarray:
    """Return the unit normals (ne, 3) of triangles or quadrilaterals (ne, c, 3)."""
    last = corners.shape[1] - 1
    normal = np.cross(corners[:, last - 1] - corners[:, 0], corners[:, last] - corners[:, last - 2])
    return normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
