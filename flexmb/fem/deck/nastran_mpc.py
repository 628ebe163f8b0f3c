"""Multipoint constraints of a Nastran deck: MPC and MPCADD, on grid points and scalar points."""

from __future__ import annotations

import numpy as np

from flexmb.fem.deck.contents import Deck
from flexmb.fem.deck.links import Equation, Frames, rows_of, solved_together
from flexmb.fem.deck.nastran_text import Bulk, Card

__all__ = ["add_mpc", "chosen_mpc", "direction_of", "terms_of"]


def chosen_mpc(bulk: Bulk) -> list[Card]:
    """Return the MPC cards of the set that the case control chooses, or of the only one."""
    sets = {card.integer(1) for card in bulk.of("MPC")}
    wanted = bulk.choices.get("MPC", min(sets) if len(sets) == 1 else None)
    if wanted is None:
        return []
    chosen = {wanted}
    for card in bulk.of("MPCADD"):
        if card.integer(1) == wanted:
            chosen |= {card.integer(k) for k in range(2, len(card.fields)) if card.text(k)}
    return [card for card in bulk.of("MPC") if card.integer(1) in chosen]


def terms_of(card: Card) -> list[int]:
    """Return where the terms of an MPC begin: G C A G C A, then after a blank field again; blank ones left out."""
    starts = [2, 5]
    while starts[-1] + 3 < len(card.fields):
        starts.append(starts[-1] + (5 if len(starts) % 2 == 0 else 3))
    return [at for at in starts if card.text(at)]


def direction_of(card: Card, at: int, deck: Deck) -> int:
    """Return the direction 0..5 of a term of an MPC; -1 is the only one of a scalar point."""
    if card.integer(at) in deck.scalar_points:
        return -1
    word = card.text(at + 1)
    if len(word) != 1 or word not in "123456":
        raise card.wrong(at + 1, "one digit out of 1 to 6")
    return int(word) - 1


def add_mpc(bulk: Bulk, deck: Deck, frames: Frames) -> None:
    """Add the chosen constraints: the freedom of the first term follows the others."""
    cards = chosen_mpc(bulk)
    if not cards and bulk.of("MPC"):
        sets = sorted({card.integer(1) for card in bulk.of("MPC")})
        deck.inventory.left_out[f"MPC sets {', '.join(map(str, sets))}: the case control chooses none"] += len(sets)
        return
    if others := len(bulk.of("MPC")) - len(cards):
        deck.inventory.unused["MPC of a set that is not chosen"] += others
    equations = []
    for card in cards:
        places = terms_of(card)
        if any(deck.scalar_points.get(card.integer(at), True) is None for at in places):
            deck.inventory.left_out["MPC with scalar points that no grid point moves"] += 1
            continue
        columns, row, first = [], [], None
        for at in places:
            node, direction = _freedom(card, at, deck, frames)
            columns.append(6 * node + np.arange(6))
            row.append(card.real(at + 2) * direction)
            if first is None:
                first = columns[-1][np.abs(row[-1]) > 0.0]
                if point := deck.scalar_points.get(card.integer(at)):
                    first = first[first == point.free]
        if first is None or not len(first):
            raise card.refused("no first term, or one with the factor 0", "grid point, component and factor")
        name = f"MPC {card.text(1)} at node {card.text(2)}"
        equations.append(Equation.of(name, f"{card.where}, MPC {card.text(1)}", columns, row, first))
        deck.inventory.read["MPC"] += 1
    deck.links += solved_together(equations)


def _freedom(card: Card, at: int, deck: Deck, frames: Frames) -> tuple[int, np.ndarray]:
    """Return the node of a term and its direction as a row (6,) over the node's basic freedoms."""
    point = deck.scalar_points.get(card.integer(at))
    if point is not None:
        return point.node, point.row
    node = int(deck.numbers([card.integer(at)], f"{card.where}, MPC {card.text(1)}")[0])
    return node, rows_of(node, [direction_of(card, at, deck)], frames)[0]
