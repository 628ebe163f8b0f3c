"""Solid elements as the program of a deck has them: without incompatible modes, or with reduced integration.

A 20-node brick integrated at 2x2x2 points has six motions beside the rigid ones that strain nothing. Neighbours in two
directions hold them; a row of bricks one element wide passes some of them on. Such bricks are fully integrated here: a
free body must not have motions without strain that no program would see once supports hold it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from flexmb.fem.deck.contents import Deck, Solids
from flexmb.fem.solids.elements import (
    HEX8_COMPATIBLE,
    HEX20_REDUCED,
    HEX_FACES,
    WEDGE6_COMPATIBLE,
    SolidElement,
)

__all__ = ["held_bricks", "solid_element"]

ROW = (
    "20-node bricks in a row one element wide, fully integrated (reduced integration gives them motions without strain)"
)
"""What became of bricks that reduced integration would leave loose."""


def solid_element(kind: str, cell_type: str) -> SolidElement | None:
    """Return the element of an Abaqus or CalculiX name, None for the usual one of the cell type."""
    if cell_type == "wedge":
        return WEDGE6_COMPATIBLE
    if cell_type == "hexahedron" and kind.startswith("C3D8") and not set(kind[4:]) & set("IR"):
        return HEX8_COMPATIBLE
    if cell_type == "hexahedron20" and kind.startswith("C3D20R"):
        return HEX20_REDUCED
    return None


def held_bricks(deck: Deck) -> Iterator[Solids]:
    """Yield the solids of a deck; bricks of reduced integration that no neighbours hold are fully integrated."""
    reduced = [group for group in deck.solids if group.element == HEX20_REDUCED]
    held = (
        _with_neighbours([group.nodes for group in deck.solids if group.cell_type == "hexahedron20"]) if reduced else {}
    )
    number = 0
    for group in deck.solids:
        if group.cell_type != "hexahedron20":
            yield group
            continue
        mine = held.get(number)
        number += 1
        if mine is None or group.element != HEX20_REDUCED or mine.all():
            yield group
            continue
        deck.inventory.approximated[ROW] += int((~mine).sum())
        for element, rows in ((HEX20_REDUCED, mine), (None, ~mine)):
            if rows.any():
                yield replace(group, nodes=group.nodes[rows], labels=group.labels[rows], element=element)


def _with_neighbours(tables: list[np.ndarray]) -> dict[int, np.ndarray]:
    """Return, for each table of cells, which have neighbours across faces of at least two directions."""
    cells = np.concatenate([table[:, :8] for table in tables])
    faces = np.sort(cells[:, np.array(HEX_FACES)], axis=2).reshape(-1, 4)
    _, which, count = np.unique(faces, axis=0, return_inverse=True, return_counts=True)
    shared = (count[which.ravel()] > 1).reshape(len(cells), 3, 2).any(axis=2)
    parts = np.split(shared.sum(axis=1) >= 2, np.cumsum([len(table) for table in tables])[:-1])
    return dict(enumerate(parts))
