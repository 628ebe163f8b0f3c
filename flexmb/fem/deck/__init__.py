"""Whole finite element decks: from the cards of a program to an `FEModel`.

A reader per program fills a `Deck`, which knows no program; `assembled` makes the model of it.
"""

from flexmb.fem.deck.checks import DeckChecks, deck_checks
from flexmb.fem.deck.read_deck import DECK_READERS, read_deck

__all__ = ["DECK_READERS", "DeckChecks", "deck_checks", "read_deck"]
