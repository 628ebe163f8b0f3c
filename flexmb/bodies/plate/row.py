"""The row of a plate: elements and markers as numbers that kernels read."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from flexmb.bodies.plate.axes import director_rows
from flexmb.bodies.plate.places import row_starts

__all__ = ["LOADS", "coupled_nodes", "plate_row"]

LOADS = ("pressure", "load_x", "load_y", "load_z")


def coupled_nodes(groups: Iterable) -> dict[tuple[int, int], int]:
    """Return the number of every pair of nodes that share a group: an element, or a mean."""
    pairs: dict[tuple[int, int], int] = {}
    for nodes in groups:
        for a in nodes:
            for b in nodes:
                if a < b:
                    pairs.setdefault((int(a), int(b)), len(pairs))
    return pairs


def plate_row(plate, compiler, place, data, drawn, pairs: dict[tuple[int, int], int]) -> dict[str, Any]:
    """Return the fields of the row of a plate.

    `data`: numbers of its elements and of their points; `drawn`: nodes and weights of its markers; `pairs`: of its
    nodes, see `coupled_nodes`.
    """
    size, cells = plate.block_size, plate.surface.cells
    heads, points = data
    rows = np.array([row_starts(nodes, pairs, size) for nodes in cells])
    elements = np.hstack([cells, rows, heads, points])
    parts = []
    for name, pose in plate.marker_poses().items():
        nodes, weights = drawn[name]
        _, a, b = plate.drawn_at(nodes, weights)
        fixed = director_rows(a, b) @ pose.matrix
        each = [np.concatenate([[node - min(nodes)], w.ravel()]) for node, w in zip(nodes, weights, strict=True)]
        parts.append(np.concatenate([[min(nodes), len(nodes)], fixed.ravel(), *each, row_starts(nodes, pairs, size)]))
    begins = len(parts) + np.concatenate([[0], np.cumsum([len(p) for p in parts])])[:-1]
    first_load, *_ = (compiler.load(plate.name, load) for load in LOADS)
    return {
        "elements": len(elements),
        "size": elements.shape[1],
        "data": place.bulk(elements),
        "geometry": place.bulk(np.concatenate([begins, *parts])),
        "couplings": compiler.couplings(plate.name),
        "first_load": first_load,
        "poisson": plate.material.poisson,
        "gravity": compiler.gravity,
    }
