"""The cards of a Nastran file that meshio does not read: sets and names.

Sets: ``SET 3 = 1, 5 THRU 9, 20`` of the case control, ``SET1``, and ``SET3`` with GRID or ELEM. Names come from the
comments of preprocessors: ``$HMSET 3 1 "bore"`` (type 1 nodes, 2 elements) and ``$HMNAME PROP 7"lever"``
(HyperMesh), ``$ Femap Property 7 : lever`` (Femap). Sets without a name are called "set_3", properties "pid_7".
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.nastran_lines import nastran_lines

__all__ = ["NastranCards", "read_nastran_cards"]

SET_NAME = re.compile(r'^\$HMSET\s+(\d+)\s+(\d+)\s+"([^"]+)"')
PROPERTY_NAME = re.compile(r'^\$HMNAME\s+PROP\s+(\d+)\s*"([^"]+)"|^\$\s*Femap Property\s+(\d+)\s*:\s*(.+?)\s*$')
CASE_SET = re.compile(r"^\s*SET\s+(\d+)\s*=(.*)$", re.IGNORECASE)


@dataclass(kw_only=True)
class NastranCards:
    """Sets by name (file numbers of nodes or elements) and names of properties."""

    node_sets: dict[str, np.ndarray] = field(default_factory=dict)
    element_sets: dict[str, np.ndarray] = field(default_factory=dict)
    property_names: dict[int, str] = field(default_factory=dict)


def read_nastran_cards(path: Path) -> NastranCards:
    """Read sets and names."""
    lines = nastran_lines(path)
    names: dict[int, tuple[str, int]] = {}
    cards = NastranCards()
    found: list[tuple[int, str, list[str]]] = []  # set number, "GRID", "ELEM" or "" if the card does not say, words
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
        upper = line.upper()
        if upper.startswith(("SET1", "SET3")):
            words = fields(upper)
            while i < len(lines) and lines[i][:1] in ("+", "*", " ", ",") and lines[i].strip():
                words += fields(lines[i].upper())
                i += 1
            found.append(bulk_set(words))
    for number, kind, words in found:
        name, code = names.get(number, (f"set_{number}", 1))
        target = cards.element_sets if kind == "ELEM" or (kind == "" and code == 2) else cards.node_sets
        target[name] = expanded(path, name, words)
    return cards


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
    return int(words[1]), "", words[2:]


def expanded(path: Path, name: str, words: list[str]) -> np.ndarray:
    """Return the numbers of a list such as ``1 5 THRU 9 EXCEPT 7 20``."""
    numbers: list[int] = []
    excluded: set[int] = set()
    i, except_until = 0, -1
    try:
        while i < len(words):
            if words[i].upper() == "THRU":
                last = int(words[i + 1])
                numbers += range(numbers[-1] + 1, last + 1)
                except_until, i = last, i + 2
            elif words[i].upper() == "EXCEPT":
                i += 1
                while i < len(words) and words[i].isdigit() and int(words[i]) <= except_until:
                    excluded.add(int(words[i]))
                    i += 1
            else:
                numbers.append(int(words[i]))
                i += 1
    except (ValueError, IndexError):
        raise MeshError(
            f"Mesh file '{path}'",
            found=f"the set '{name}' reads '{' '.join(words)[:60]}'",
            expected="numbers, THRU and EXCEPT",
            remedy="Write the set as a list of numbers",
        ) from None
    return np.array([n for n in numbers if n not in excluded], np.int64)
