"""What a Nastran deck holds besides grid points and elements: masses, rigid elements, springs.

They are not part of a mesh. Their nodes become sets, because a spider of rigid elements usually marks an interface, and
the reader says what was left out: a part without its masses would look right and vibrate wrongly.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np

from flexmb.fem.matrices.nastran import nastran_cards, nastran_float

__all__ = ["nastran_connectors"]

CONNECTORS = frozenset(
    (
        "CONM1",
        "CONM2",
        "CMASS1",
        "CMASS2",
        "CMASS3",
        "CMASS4",
        "RBE1",
        "RBE2",
        "RBE3",
        "RBAR",
        "RBAR1",
        "RROD",
        "RSPLINE",
        "RJOINT",
        "MPC",
        "CELAS1",
        "CELAS2",
        "CELAS3",
        "CELAS4",
        "CBUSH",
        "CBUSH1D",
        "CBUSH2D",
        "CGAP",
        "CFAST",
        "CWELD",
        "CSEAM",
        "CDAMP1",
        "CDAMP2",
        "CVISC",
        "GENEL",
    )
)


OFFSETS = {"CBAR": slice(11, 17), "CBEAM": slice(11, 17), "CQUAD4": slice(8, 9), "CTRIA3": slice(7, 8)}
"""Fields of the offsets of an element from its grid points."""


def nastran_connectors(path: Path) -> tuple[dict[str, np.ndarray], list[str]]:
    """Return the nodes (file numbers) of every RBE2 and RBE3 as sets "rbe2_7", and what was left out, in words."""
    count: Counter[str] = Counter()
    sets: dict[str, np.ndarray] = {}
    mass = 0.0
    for words in nastran_cards(path):
        name = words[0]
        if any(_is_nonzero(word) for word in words[OFFSETS.get(name, slice(0))]):
            count[f"offsets of {name}"] += 1
        if name not in CONNECTORS:
            continue
        count[name] += 1
        if name == "CONM2" and len(words) > 4:
            mass += nastran_float(words[4])
        elif name in ("RBE2", "RBE3"):
            nodes = _grids(words[4:]) if name == "RBE2" else _weighted_grids(words[5:])
            sets[f"{name.lower()}_{words[1]}"] = np.array(sorted(set(nodes)), np.int64)
    found = [f"{number} {name}" for name, number in sorted(count.items())]
    return sets, [f"{text} (mass {mass:.6g})" if text.endswith(" CONM2") else text for text in found]


def _is_nonzero(word: str) -> bool:
    try:
        return nastran_float(word) != 0.0
    except ValueError:  # a name or a coordinate system
        return False


def _grids(words: list[str]) -> list[int]:
    """Return the integers of a list of grid points; the thermal coefficient of an RBE2 is a real number."""
    return [int(word) for word in words if word.isdigit()]


def _weighted_grids(words: list[str]) -> list[int]:
    """Return the grid points of an RBE3: weight, component, grid, grid, ..., weight, component, ...
    until UM or ALPHA.
    """
    nodes, component_next = [], False
    for word in words:
        if word.upper() in ("UM", "ALPHA"):
            break
        if component_next:
            component_next = False
        elif word.isdigit():
            nodes.append(int(word))
        elif word:  # a weight, "1.0"; the component number follows
            component_next = True
    return nodes
