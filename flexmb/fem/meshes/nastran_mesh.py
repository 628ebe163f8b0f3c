"""Grid points and elements of a Nastran file, in any field format, with what else their cards hold."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.matrices.nastran import nastran_cards, nastran_float

__all__ = ["NastranMesh", "read_nastran_mesh"]

HEXA = (*range(12), 16, 17, 18, 19, 12, 13, 14, 15)
WEDGE = (*range(9), 12, 13, 14, 9, 10, 11)
"""Nastran numbers the vertical edges before the edges of the upper face, meshio after."""

KINDS = {
    "CTETRA": {4: "tetra", 10: "tetra10"},
    "CHEXA": {8: "hexahedron", 20: "hexahedron20"},
    "CPENTA": {6: "wedge", 15: "wedge15"},
    "CPYRAM": {5: "pyramid", 13: "pyramid13"},
    "CTRIA3": {3: "triangle"},
    "CTRIAR": {3: "triangle"},
    "CTRIA6": {6: "triangle6"},
    "CQUAD4": {4: "quad"},
    "CQUADR": {4: "quad"},
    "CSHEAR": {4: "quad"},
    "CQUAD8": {8: "quad8"},
    "CBAR": {2: "line"},
    "CBEAM": {2: "line"},
    "CROD": {2: "line"},
    "CTUBE": {2: "line"},
    "CONROD": {2: "line"},
    "CBEAM3": {3: "line3"},
}
"""Cells by the name of the card and the number of its nodes; what follows the nodes (angles, offsets) is left."""

ORDER = {"hexahedron20": HEXA, "wedge15": WEDGE}
ELEMENT = re.compile(r"C(TRI|QUAD|TET|HEX|PENT|PYR|BEAM|BAR|ROD|TUBE|SHEAR)")


@dataclass(kw_only=True)
class NastranMesh:
    """Grid points (numbers and positions), and cells by kind: node numbers, element and property numbers of the file.

    ``unknown`` counts elements of cards that are no cells here.
    """

    ids: np.ndarray
    points: np.ndarray
    cells: dict[str, np.ndarray]
    elements: dict[str, np.ndarray]
    properties: dict[str, np.ndarray]
    unknown: Counter[str] = field(default_factory=Counter)


def read_nastran_mesh(path: Path) -> NastranMesh:
    """Read GRID cards and the elements of `KINDS`; MeshError names a card that cannot be read."""
    ids, points = [], []
    rows: dict[str, list[tuple[int, int, list[int]]]] = {}
    unknown: Counter[str] = Counter()
    for words in nastran_cards(path):
        name = words[0].rstrip("_")  # meshio writes CTETRA_ for ten nodes
        try:
            if name in ("GRID", "GRDSET"):
                _check_system(path, words)
            if name == "GRID":
                ids.append(int(words[1]))
                points.append([nastran_float(word) for word in [*words, "", "", ""][3:6]])
            elif name in KINDS:
                kind, element = _cell(name, words)
                rows.setdefault(kind, []).append(element)
            elif ELEMENT.match(name):
                unknown[name] += 1
        except (ValueError, IndexError):
            raise MeshError(
                f"Mesh file '{path}'",
                found=f"the card {' '.join(word for word in words if word)[:70]}",
                expected="numbers of element, property and nodes; of grid points, three coordinates",
                remedy="Write the file again, complete",
            ) from None
    return NastranMesh(
        ids=np.array(ids, np.int64),
        points=np.array(points, float).reshape(-1, 3),
        unknown=unknown,
        cells={kind: np.array([cell for _, _, cell in found], np.int64) for kind, found in rows.items()},
        elements={kind: np.array([number for number, _, _ in found], np.int64) for kind, found in rows.items()},
        properties={kind: np.array([pid for _, pid, _ in found], np.int64) for kind, found in rows.items()},
    )


def _cell(name: str, words: list[str]) -> tuple[str, tuple[int, int, list[int]]]:
    """Return cell type, and element number, property number and nodes; the property is the element's where blank."""
    kinds = KINDS[name]
    number = int(words[1])
    first, pid = (2, 0) if name == "CONROD" else (3, int(words[2] or number))
    given = words[first : first + max(kinds)]
    count = max((n for n in kinds if len(given) >= n and all(given[:n])), default=0)
    if not count or any(given[count:]):
        raise ValueError("nodes are missing")
    nodes = [int(word) for word in given[:count]]
    kind = kinds[count]
    return kind, (number, pid, [nodes[k] for k in ORDER.get(kind, range(count))])


def _check_system(path: Path, words: list[str]) -> None:
    if len(words) > 2 and words[2] not in ("", "0"):
        raise MeshError(
            f"Mesh file '{path}'",
            found=f"a grid point in the coordinate system {words[2]}: {','.join(words)[:40]}",
            expected="all grid points in the basic system",
            remedy="Export the mesh with its coordinates in the basic (global) system",
        )
