"""Cards of a Nastran deck that give a number a second time: alike they count once, different they are refused."""

from __future__ import annotations

import numpy as np

from flexmb.fem.deck.contents import Inventory
from flexmb.fem.deck.nastran_text import Bulk, Card

__all__ = ["without_repeats"]

FAMILIES = (
    *((name,) for name in ("CBAR", "CBEAM", "CROD", "CONROD", "CTUBE", "CSHEAR", "CONM1", "CONM2")),
    *((f"{kind}{k}",) for kind in ("CELAS", "CMASS", "CDAMP") for k in range(1, 5)),
    *((name,) for name in ("CBUSH", "CBUSH1D", "CVISC", "RBE1", "RBE2", "RBE3", "RBAR", "RROD")),
    *((name,) for name in ("PSOLID", "PROD", "PTUBE", "PBUSH", "PBUSH1D", "PSHEAR")),
    ("PSHELL", "PCOMP", "PCOMPG"),
    ("PBAR", "PBARL"),
    ("PBEAM", "PBEAML", "PBCOMP"),
)
"""Cards that share numbers, which stand in their first field."""


def without_repeats(bulk: Bulk, inventory: Inventory) -> None:
    """Take cards that are written twice once; MeshError for two that differ.

    Two elements of one number would weigh twice, and of two properties one would win.
    """
    for name, table in bulk.tables.items():
        if name == "GRID":
            continue
        labels = table.integers(1)
        if (np.diff(np.sort(labels)) != 0).all():
            continue
        order = np.argsort(labels, kind="stable")
        later = np.flatnonzero(np.diff(labels[order]) == 0) + 1
        if not len(later):
            continue
        for k in later:
            if not table.alike(int(order[k]), int(order[k - 1])):
                raise _twice(table.card(int(order[k])), table.where(int(order[k - 1])))
        kept = np.ones(len(labels), bool)
        kept[order[later]] = False
        bulk.tables[name] = table.chosen(np.flatnonzero(kept))
        inventory.approximated[f"{name} written twice, taken once"] += len(later)
    for names in FAMILIES:
        first: dict[int, Card] = {}
        for name in names:
            kept_cards = []
            for card in bulk.of(name):
                other = first.setdefault(card.integer(1), card)
                if other is card:
                    kept_cards.append(card)
                elif _content(other) != _content(card):
                    raise _twice(card, other.where)
                else:
                    inventory.approximated[f"{name} written twice, taken once"] += 1
            if name in bulk.cards:
                bulk.cards[name] = kept_cards


def _content(card: Card) -> list[str]:
    words = list(card.fields)
    while words and not words[-1]:
        words.pop()
    return words


def _twice(card: Card, where: str):
    return card.refused(
        f"the number {card.text(1)} a second time (first at {where})",
        "one card per number",
        "Renumber or remove one of the two",
    )
