"""Supports of decks: freedoms held in displacement systems of nodes, along the basic axes or across them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from flexmb.fem.deck.contents import Deck
from flexmb.fem.deck.links import Frames, rows_of

__all__ = ["keep_supports"]

ALONG = 1e-9
"""Cosines between a direction and the other basic axes below which it is one of them."""


def keep_supports(
    deck: Deck,
    name: str,
    pairs: Iterable[tuple[int, list[int]]],
    frames: Frames,
    rows: Iterable[tuple[int, np.ndarray]] = (),
) -> None:
    """Keep held directions under a name: `pairs` are nodes and directions in their displacement systems, `rows` nodes
    and a direction (6,) over their basic freedoms.

    A direction along a basic axis becomes that freedom, another one an equation over the freedoms of its node.
    """
    held: set[tuple[int, int]] = set()
    slanted = {(node, row.tobytes()): (node, row) for node, row in rows}
    for node, parts in pairs:
        axes = frames.get(node)
        for block in (range(3), range(3, 6)):
            own = [k for k in parts if k in block]
            if axes is None or len(own) == 3:
                held |= {(node, k) for k in own}
                continue
            for row in rows_of(node, own, frames):
                main = int(np.abs(row).argmax())
                if np.abs(np.delete(row, main)).max() < ALONG:
                    held.add((node, main))
                else:
                    slanted[(node, row.tobytes())] = (node, row)
    deck.supports[name] = np.array(sorted(held), np.int64).reshape(-1, 2)
    if slanted:
        deck.slanted[name] = list(slanted.values())
