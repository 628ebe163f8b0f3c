"""Fields of Nastran cards that change a structure in Nastran but not here: named, card by card, in the inventory."""

from __future__ import annotations

from flexmb.fem.deck.contents import Deck
from flexmb.fem.deck.nastran_text import Bulk, Card

__all__ = ["tell_untaken"]

DAMPING = "structural damping GE: give the body its damping"
NONLINEAR = "a table beyond the stiffness and the damping"
LEFT_OUT = {
    "MAT1": {8: DAMPING},
    "MAT2": {13: DAMPING},
    "MAT8": {17: DAMPING},
    "MAT9": {31: DAMPING},
    "PCOMP": {7: DAMPING},
    "PCOMPG": {7: DAMPING},
    "CELAS2": {7: DAMPING},
    "PELAS": {3: DAMPING, 7: DAMPING},
    "PSHEAR": {5: "areas F1 of rods along the edges", 6: "areas F2 of rods along the edges"},
    "CBEAM": {17: "warping at SA", 18: "warping at SB"},
    "PBUSH1D": {9: NONLINEAR, 17: NONLINEAR, 25: NONLINEAR},
}
"""Position behind the name, and what it means."""
SCALED = "a factor on matrices"
PARAMETERS = {"G": DAMPING, "ALPHA1": DAMPING, "ALPHA2": DAMPING, "SNORM": "normals of shells at their nodes"}
PARAMETERS |= dict.fromkeys(("CK1", "CK2", "CK3", "CM1", "CM2", "CB1", "CB2"), SCALED)
"""PARAM that change the structure."""
APPROXIMATED = {"PSOLID": {4: "integration IN", 6: "integration ISOP"}}
USUAL = ("", "0", "BUBBLE", "REDUCED")
"""What a PSOLID has by default: elements with internal modes, as here."""


def tell_untaken(bulk: Bulk, deck: Deck) -> None:
    """Count the cards on which such a field has a value."""
    for name, fields in LEFT_OUT.items():
        for card in bulk.of(name):
            for at, meaning in fields.items():
                if _given(card, at):
                    deck.inventory.left_out[f"{name}: {meaning}"] += 1
    for card in bulk.of("PARAM"):
        why = PARAMETERS.get(card.text(1).upper())
        if why and (_scales(card) if why == SCALED else _given(card, 2)):
            deck.inventory.left_out[f"PARAM {card.text(1).upper()}: {why}"] += 1
    for name, fields in APPROXIMATED.items():
        for card in bulk.of(name):
            for at, meaning in fields.items():
                if card.text(at).upper() not in USUAL:
                    deck.inventory.approximated[f"{name}: {meaning}, integrated as all solids here"] += 1


def _scales(card: Card) -> bool:
    """Whether a factor, with an imaginary part or without, is another one than 1."""
    factor = card.real(2, 1.0) if card.is_real(2) or not card.text(2) else None
    imaginary = card.real(3, 0.0) if card.is_real(3) or not card.text(3) else None
    return factor != 1.0 or imaginary != 0.0


def _given(card: Card, at: int) -> bool:
    """Whether a field has a value other than zero."""
    return bool(card.text(at)) and not (card.is_real(at) and card.real(at) == 0.0) and card.text(at) != "0"
