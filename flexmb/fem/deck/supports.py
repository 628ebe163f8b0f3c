"""Supports of decks: freedoms held in displacement systems of nodes, as freedoms in the basic axes."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from flexmb.fem.deck.contents import Deck
from flexmb.fem.deck.links import Frames

__all__ = ["held_directions"]


def held_directions(pairs: Iterable[tuple[int, list[int]]], frames: Frames, deck: Deck, name: str) -> np.ndarray:
    """Return held (node, basic direction) rows (k, 2); directions across basic ones are named and left out."""
    out, slanted = [], 0
    for node, parts in pairs:
        axes = frames.get(node)
        for block in (range(3), range(3, 6)):
            own = [k for k in parts if k in block]
            if axes is None or len(own) == 3:
                out += [(node, k) for k in own]
                continue
            for k in own:
                row = axes[k - block[0]]
                main = int(np.abs(row).argmax())
                if abs(abs(row[main]) - 1.0) < 1e-6:
                    out.append((node, block[0] + main))
                else:
                    slanted += 1
    if slanted:
        deck.inventory.left_out[f"{name}: supports in a turned displacement system, across the basic axes"] += slanted
    return np.unique(np.array(out, np.int64).reshape(-1, 2), axis=0)
