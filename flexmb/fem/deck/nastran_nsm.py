"""Non-structural mass by lists: NSM, NSM1, NSML, NSML1 and NSMADD, as the case control chooses them (NSM = n).

NSM and NSM1 give mass per area or per length; NSML and NSML1 a total that is shared out by area or length over the
elements it names (MSC Nastran Quick Reference Guide).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmb.fem.deck.contents import Beams, Deck, Rods, Shells
from flexmb.fem.deck.nastran_links import thru
from flexmb.fem.deck.nastran_text import Bulk, Card
from flexmb.fem.frames.section import Section

__all__ = ["add_nonstructural_mass"]

PROPERTIES = {"PSHELL", "PCOMP", "PBAR", "PBARL", "PBEAM", "PBEAML", "PROD", "PTUBE", "PSHEAR", "CONROD", "ELEMENT"}
CARDS = ("NSM", "NSM1", "NSML", "NSML1")


def add_nonstructural_mass(bulk: Bulk, deck: Deck) -> None:
    """Add the masses of the chosen set; without a choice they are left out by name."""
    chosen = _sets(bulk)
    kinds = {
        card.integer(1): "PCOMP" if card.name == "PCOMPG" else card.name
        for name in ("PSHELL", "PCOMP", "PCOMPG", "PBAR", "PBARL", "PBEAM", "PBEAML", "PROD", "PTUBE", "PSHEAR")
        for card in bulk.of(name)
    }
    for card in bulk.of(*CARDS):
        if card.integer(1) not in chosen:
            deck.inventory.left_out[f"{card.name}: non-structural mass that the case control does not choose"] += 1
            continue
        kind = card.text(2).upper()
        if kind not in PROPERTIES:
            raise card.refused(f"the type {kind or 'blank'}", f"One of: {', '.join(sorted(PROPERTIES))}")
        for value, words in _values(card):
            _add(card, kind, value, words, deck, kinds)
        deck.inventory.read[card.name] += 1


def _sets(bulk: Bulk) -> set[int]:
    """Return the numbers of the chosen set and of those that NSMADD puts under its number."""
    if "NSM" not in bulk.choices:
        return set()
    chosen = {bulk.choices["NSM"]}
    for card in bulk.of("NSMADD"):
        if card.integer(1) == bulk.choices["NSM"]:
            chosen |= {card.integer(k) for k in range(2, len(card.fields)) if card.text(k)}
    return chosen


def _values(card: Card) -> list[tuple[float, list[str]]]:
    """Return values, each with the words of the identifiers it belongs to."""
    if card.name in ("NSM1", "NSML1"):
        return [(card.real(3), [word for word in card.fields[4:] if word])]
    return [(card.real(k + 1), [card.text(k)]) for k in range(3, len(card.fields), 2) if card.text(k)]


def _add(card: Card, kind: str, value: float, words: list[str], deck: Deck, kinds: dict[int, str]) -> None:
    """Add a value per area or length, or a total, to the elements of properties or of numbers."""
    if value < 0.0 or not words:
        raise card.refused(f"{value:g} for {len(words)} identifiers", "a mass >= 0 and its properties or elements")
    found: list[tuple[Shells | Beams | Rods, np.ndarray]] = []
    every = any(word.upper() == "ALL" for word in words)
    known = sorted(kinds) if kind != "ELEMENT" else sorted({int(n) for group in deck.groups() for n in group.labels})
    numbers = set(known) if every else set(thru(card, words, known))
    groups: list[Shells | Beams | Rods] = [*deck.shells, *deck.beams, *deck.rods]
    for group in groups:
        if kind in ("ELEMENT", "CONROD"):
            rows = np.isin(group.labels, list(numbers)) if not every else np.ones(len(group.labels), bool)
            if kind == "CONROD" and group.group != "conrod":
                continue
        else:
            number = int(group.group.removeprefix("pid_")) if group.group.startswith("pid_") else 0
            if number not in numbers or kinds.get(number) != kind:
                continue
            rows = np.ones(len(group.labels), bool)
        if rows.any():
            found.append((group, rows))
    if not found:
        raise card.refused(f"no elements of {kind} {', '.join(words)[:60]}", "properties or elements of the deck")
    if card.name in ("NSML", "NSML1"):
        value /= sum(float(_size(group, deck)[rows].sum()) for group, rows in found)
    for group, rows in found:
        if isinstance(group, (Shells, Rods)):
            group.mass = group.mass + value * rows
        else:
            _load(group, rows, value)


def _size(group: Shells | Beams | Rods, deck: Deck) -> np.ndarray:
    """Return areas of shells, lengths of beams and rods, (ne,)."""
    points = deck.points[group.nodes]
    if not isinstance(group, Shells):
        return np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
    last = points[:, 3] if points.shape[1] == 4 else points[:, 0]
    return 0.5 * np.linalg.norm(np.cross(points[:, 2] - points[:, 0], last - points[:, 1]), axis=1)


def _load(group: Beams, rows: np.ndarray, value: float) -> None:
    """Give beams a mass per length on the line of their nodes beside the one they have."""
    made: dict[Section, Section] = {}

    def loaded(section: Section) -> Section:
        if section not in made:
            total = section.line_mass + value
            share = section.line_mass / total if total > 0.0 else 0.0
            y, z = section.line_mass_center
            made[section] = replace(section, line_mass=total, line_mass_center=(share * y, share * z))
        return made[section]

    group.sections = [
        (loaded(a), loaded(b)) if row else (a, b) for (a, b), row in zip(group.sections, rows, strict=True)
    ]
