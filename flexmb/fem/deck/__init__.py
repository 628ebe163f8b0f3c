"""Whole finite element decks: from the cards of a program to an `FEModel`.

A reader per program fills a `Deck`, which knows no program; `assembled` makes the model of it.
"""

from flexmb.fem.deck.read_deck import read_deck

__all__ = ["read_deck"]
