"""Units of decks: a deck says nothing about them, so they are given, or judged by what no structure has."""

from __future__ import annotations

from flexmb.fem.deck.contents import Deck
from flexmb.fem.fe_model import FEModel


def converted(fe: FEModel, deck: Deck, units: str | None) -> FEModel:
    return fe
