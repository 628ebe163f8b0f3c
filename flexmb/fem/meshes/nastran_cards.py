"""The cards of a Nastran file that meshio does not read: sets and names.

Sets: ``SET 3 = 1, 5 THRU 9, 20`` of the case control, ``SET1``, and ``SET3`` with GRID or ELEM. Names come from the
comments of preprocessors: ``$HMSET 3 1 "bore"`` (type 1 nodes, 2 elements) and ``$HMNAME PROP 7"lever"``
(HyperMesh), ``$ Femap Property 7 : lever`` (Femap). Sets without a name are called "set_3", properties "pid_7".

What a set of the case control or a SET1 holds, its card does not say. It follows from the comment, else from the
command that uses it (``STRESS = 3`` takes elements, ``DISP = 3`` grid points), else from the numbers that exist.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.meshes.nastran_lines import nastran_lines
from flexmb.fem.ranges import LARGEST, members_in

__all__ = ["NastranCards", "read_nastran_cards"]

SET_NAME = re.compile(r'^\$HMSET\s+(\d+)\s+(\d+)\s+"([^"]+)"')
PROPERTY_NAME = re.compile(r'^\$HMNAME\s+PROP\s+(\d+)\s*"([^"]+)"|^\$\s*Femap Property\s+(\d+)\s*:\s*(.+?)\s*$')
CASE_SET = re.compile(r"^\s*SET\s+(\d+)\s*=(.*)$", re.IGNORECASE)
REQUEST = re.compile(r"^\s*([A-Z]{3,})\s*(?:\([^)]*\))?\s*=\s*(\d+)\s*$", re.IGNORECASE)
OF_ELEMENTS = ("STRE", "STRA", "FORC", "ELFO", "ELST", "ELSD", "ESE", "EKE", "EDE")
OF_NODES = (
    "DISP",
    "VECT",
    "PRES",
    "ACCE",
    "VELO",
    "SPCF",
    "MPCF",
    "OLOA",
    "GPFO",
    "SVEC",
    "SDIS",
    "SVEL",
    "SACC",
    "THER",
)
"""Output requests by their first letters, as far as Nastran reads them (MSC Nastran Quick Reference Guide)."""


@dataclass(kw_only=True)
class NastranCards:
    """Sets by name (file numbers of nodes or elements), names of properties, and sentences on what was not read."""

    node_sets: dict[str, np.ndarray] = field(default_factory=dict)
    element_sets: dict[str, np.ndarray] = field(default_factory=dict)
    property_names: dict[int, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


def read_nastran_cards(path: Path, node_ids: np.ndarray, element_ids: np.ndarray) -> NastranCards:
    """Read sets and names of a file with these grid points and elements."""
    lines = nastran_lines(path)
    names: dict[int, tuple[str, int]] = {}
    cards = NastranCards()
    found: list[tuple[int, str, list[str]]] = []  # set number, "GRID", "ELEM", "SET1" or "", words
    requests: dict[int, set[str]] = {}
    i = 0
    while i < len(lines):
        line = lines[i]
        i += 1
        if line.startswith("$"):
            if match := SET_NAME.match(line):
                names[int(match[1])] = (match[3], int(match[2]))
            elif match := PROPERTY_NAME.match(line):
                cards.property_names[int(match[1] or match[3])] = match[2] or match[4]
            continue
        if match := CASE_SET.match(line):
            text = match[2]
            while text.rstrip().endswith(",") and i < len(lines):
                text, i = text + lines[i], i + 1
            found.append((int(match[1]), "", text.replace(",", " ").split()))
            continue
        if match := REQUEST.match(line):
            kind = match[1][:4].upper()
            kind = "ELEM" if kind.startswith(OF_ELEMENTS) else "GRID" if kind.startswith(OF_NODES) else ""
            requests.setdefault(int(match[2]), set()).update([kind] if kind else [])
            continue
        upper = line.upper()
        if upper.startswith(("SET1", "SET3")):
            words = fields(upper)
            while i < len(lines) and lines[i][:1] in ("+", "*", " ", ",") and lines[i].strip():
                words += fields(lines[i].upper())
                i += 1
            found.append(bulk_set(words))
    for number, kind, words in found:
        name, code = names.get(number, (f"set_{number}", 0))
        if kind in ("", "SET1") and not code:
            uses = {"GRID"} if kind else requests.get(number, set())  # SET1 lists grid points of splines, mostly
            _sort_by_use(cards, path, name, words, uses, node_ids, element_ids)
            continue
        if kind == "ELEM" or (kind in ("", "SET1") and code == 2):
            cards.element_sets[name] = expanded(path, name, words, [element_ids])
        else:
            cards.node_sets[name] = expanded(path, name, words, [node_ids])
    return cards


def _sort_by_use(
    cards: NastranCards,
    path: Path,
    name: str,
    words: list[str],
    used_for: set[str],
    node_ids: np.ndarray,
    element_ids: np.ndarray,
) -> None:
    """Add a set whose card and comments do not say what it holds; such a set never stops the reading."""
    try:
        numbers = expanded(path, name, words, [node_ids, element_ids])
    except MeshError:
        cards.notes.append(
            f"the set '{name}' reads '{' '.join(words)[:40]}'; it is not a list of numbers and was omitted"
        )
        return
    nodes, elements = bool(np.isin(numbers, node_ids).all()), bool(np.isin(numbers, element_ids).all())
    if not nodes and not elements:  # of modes, frequencies, or of parts that are not in this file
        cards.notes.append(f"the set '{name}' names neither grid points nor elements of this file and was left out")
        return
    if nodes and elements and len(used_for) != 1:
        cards.notes.append(
            f"the numbers of the set '{name}' fit grid points and elements, and nothing says which are meant; it was "
            "taken as grid points. A comment $HMSET with the type 2 makes it a set of elements"
        )
    if elements and (not nodes or used_for == {"ELEM"}):
        cards.element_sets[name] = numbers
    else:
        cards.node_sets[name] = numbers


def fields(line: str) -> list[str]:
    """Split a card into the words of its data fields; the continuation field is left out."""
    if "," in line:
        words = [word.strip() for word in line.split(",")]
    else:
        width = 16 if "*" in line[:8] else 8
        words = [line[:8].strip()] + [line[k : k + width].strip() for k in range(8, min(len(line), 72), width)]
    return [word for k, word in enumerate(words) if word and not (word[0] in "+*" and k in (0, len(words) - 1))]


def bulk_set(words: list[str]) -> tuple[int, str, list[str]]:
    """Return number, kind and members of a SET1 or SET3 card."""
    if words[0].startswith("SET3"):
        return int(words[1]), words[2], words[3:]
    return int(words[1]), "SET1", words[2:]


def expanded(path: Path, name: str, words: list[str], known: Sequence[np.ndarray]) -> np.ndarray:
    """Return the numbers of a list such as ``1 5 THRU 9 EXCEPT 7 20``; of long ranges those `known`."""
    numbers: list[int] = []
    excluded: set[int] = set()
    i, except_until = 0, -1
    try:
        while i < len(words):
            if words[i].upper() == "THRU":
                last = int(words[i + 1])
                if not 0 <= last - numbers[-1] < LARGEST:
                    raise ValueError("descending, or too long")
                numbers += members_in(range(numbers[-1] + 1, last + 1), known, len(numbers)).tolist()
                except_until, i = last, i + 2
            elif words[i].upper() == "EXCEPT":
                i += 1
                while i < len(words) and words[i].isdigit() and int(words[i]) <= except_until:
                    excluded.add(int(words[i]))
                    i += 1
            else:
                numbers.append(int(words[i]))
                i += 1
        if any(not 0 < number < LARGEST for number in numbers):
            raise ValueError("numbers of nodes or elements")
    except (ValueError, IndexError):
        raise MeshError(
            f"Mesh file '{path}'",
            found=f"the set '{name}' reads '{' '.join(words)[:60]}'",
            expected=f"numbers from 1 to {LARGEST - 1}, ascending with THRU, and EXCEPT",
            remedy="Write the set as a list of numbers",
        ) from None
    return np.array([n for n in numbers if n not in excluded], np.int64)
