"""The keywords of an Abaqus file that meshio reads wrongly or not at all: sets, surfaces, element names.

NSET and ELSET (GENERATE, several definitions of one name, sets of sets), ELSET= of ELEMENT, and SURFACE of element
faces, of shell sides, of whole element sets and of nodes. Element names are mapped to the plain one of the same shape
(C3D10HS to C3D10).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from flexmb.errors import MeshError
from flexmb.fem.meshes.abaqus_surfaces import SIDES
from flexmb.fem.ranges import LARGEST, MANY, members_in

__all__ = ["AbaqusCards", "read_abaqus_cards"]

PLAIN = (
    (re.compile(r"C3D(4|6|8|10|15|20)(?!\d)"), lambda m: f"C3D{m[1]}"),
    (re.compile(r"(S|STRI|M3D|SFM3D|CPS|CPE|CAX|R3D|DS|DC2D)3(?!\d)"), lambda m: "S3"),
    (re.compile(r"(S|M3D|SFM3D|CPS|CPE|CAX|R3D|DS|DC2D)4(?!\d)"), lambda m: "S4"),
    (re.compile(r"(S|STRI6|M3D|SFM3D|CPS|CPE|CAX)(6|5)(?!\d)"), lambda m: "STRI65"),
    (re.compile(r"(S|M3D|SFM3D|CPS|CPE|CAX)8"), lambda m: "S8R"),
    (re.compile(r"(B31|T3D2|B33|PIPE31)(?!\d)"), lambda m: "B31"),
    (re.compile(r"(B32|T3D3|PIPE32)(?!\d)"), lambda m: "B32"),
)
"""Element names by shape, and the name that meshio knows."""

CONNECTORS = frozenset(
    (
        "MPC",
        "EQUATION",
        "TIE",
        "COUPLING",
        "KINEMATIC COUPLING",
        "DISTRIBUTING COUPLING",
        "RIGID BODY",
        "SHELL TO SOLID COUPLING",
        "EMBEDDED ELEMENT",
        "FASTENER",
        "NONSTRUCTURAL MASS",
    )
)
"""Keywords that join or load parts with mass and are not part of a mesh."""

GENERATORS = frozenset(("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY"))
"""Keywords that make parts of a mesh which are not in the file."""

POINT_ELEMENT = re.compile(r"MASS$|ROTARYI|SPRING|DASHPOT|CONN[23]D|DCOUP|HEATCAP|GAP|JOINTC")
"""Names of elements that are masses, springs and the like."""


@dataclass(kw_only=True)
class AbaqusCards:
    """Numbers of nodes and elements as in the file, sets by name, and the text of the mesh for meshio.

    ``surfaces[name]`` lists (element numbers, side, see abaqus_surfaces); ``nodes_of[name]`` names the element sets
    whose nodes a node set takes; ``left_out`` counts keywords and elements that carry mass or stiffness and are not
    part of a mesh; ``unread`` says which parts of sets and surfaces were not understood.
    """

    mesh_text: str = ""
    node_ids: list[int] = field(default_factory=list)
    element_ids: list[np.ndarray] = field(default_factory=list)
    node_sets: dict[str, np.ndarray] = field(default_factory=dict)
    element_sets: dict[str, np.ndarray] = field(default_factory=dict)
    surfaces: dict[str, list[tuple[np.ndarray, str]]] = field(default_factory=dict)
    nodes_of: dict[str, list[np.ndarray]] = field(default_factory=dict)
    left_out: Counter[str] = field(default_factory=Counter)
    unread: list[str] = field(default_factory=list)


def sections(path: Path):
    """Yield (keyword, options, data lines) of every keyword block; INCLUDE is followed."""
    keyword, options, data = "", {}, []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        if line.startswith("**") or not line.strip():
            continue
        if not line.lstrip().startswith("*"):
            data.append(line.strip())
            continue
        if keyword:
            yield keyword, options, data
        words = [word.strip() for word in line.strip().lstrip("*").split(",")]
        keyword, data = words[0].upper(), []
        pairs = (word.partition("=") for word in words[1:] if word)
        options = {key.strip().upper(): value.strip().strip('"') for key, _, value in pairs}
        if "INPUT" in options and keyword in ("INCLUDE", "NODE", "ELEMENT"):
            other = path.parent / options["INPUT"]
            if not other.is_file():
                raise MeshError(
                    f"Mesh file '{path}'",
                    found=f"*{keyword}, INPUT={options['INPUT']}: no such file",
                    expected="an existing file beside this one",
                    remedy="Put it there, or write one flat file",
                )
            if keyword == "INCLUDE":
                yield from sections(other)
                keyword = ""
            else:
                lines = other.read_text(encoding="utf-8", errors="replace").splitlines()
                data += [row.strip() for row in lines if row.strip() and not row.startswith("**")]
    if keyword:
        yield keyword, options, data


def read_abaqus_cards(path: Path) -> AbaqusCards:
    """Read numbers, sets and surfaces, and the NODE and ELEMENT blocks as plain text."""
    cards, nodes, elements = AbaqusCards(), ["*NODE"], []
    for keyword, options, data in sections(path):
        _check_system(path, keyword, options, data)
        if keyword == "NODE":
            rows = [[word.strip() for word in line.split(",")][:4] for line in data]  # normals may follow
            nodes += [",".join([*(word or "0." for word in row), *["0."] * (4 - len(row))]) for row in rows]
            ids = [int(row[0]) for row in rows]
            cards.node_ids += ids
            add(cards.node_sets, options.get("NSET"), np.array(ids, np.int64))
        elif keyword in CONNECTORS:
            cards.left_out[f"*{keyword}"] += 1
        elif keyword == "ELEMENT" and POINT_ELEMENT.match(options.get("TYPE", "").upper()):
            cards.left_out[f"elements {options['TYPE'].upper()}"] += len(data)
        elif keyword == "ELEMENT":
            numbers = _elements(path, options, data, elements)
            cards.element_ids.append(numbers)
            add(cards.element_sets, options.get("ELSET"), numbers)
        elif keyword == "NSET" and "ELSET" in options:
            wanted = _known(path, options["ELSET"], cards.element_sets)
            cards.nodes_of.setdefault(options["NSET"], []).append(wanted)
        elif keyword == "NSET":
            numbers = _members(path, options, data, cards.node_sets, [cards.node_ids])
            add(cards.node_sets, options["NSET"], numbers)
        elif keyword == "ELSET":
            numbers = _members(path, options, data, cards.element_sets, cards.element_ids)
            add(cards.element_sets, options["ELSET"], numbers)
        elif keyword == "SURFACE":
            _surface(path, cards, options, data)
    if len(nodes) == 1:
        raise MeshError(
            f"Mesh file '{path}'",
            found="no *NODE keyword",
            expected="an Abaqus input file with a mesh",
            remedy="Write the mesh again",
        )
    if len(set(cards.node_ids)) < len(cards.node_ids):
        twice = len(cards.node_ids) - len(set(cards.node_ids))
        raise MeshError(
            f"Mesh file '{path}'",
            found=f"{twice} node numbers twice",
            expected="one flat mesh with unique numbers",
            remedy="Export without parts and instances (Abaqus/CAE: model attribute of the input file)",
        )
    cards.mesh_text = "\n".join([*nodes, *elements, ""])
    return cards


def _check_system(path: Path, keyword: str, options: dict[str, str], data: list[str]) -> None:
    """Raise MeshError where the coordinates in the file differ from the model's."""
    moved = keyword == "INSTANCE" and any(float(word) != 0.0 for word in ",".join(data).split(",") if word.strip())
    if keyword in GENERATORS:
        raise MeshError(
            f"Mesh file '{path}'",
            found=f"*{keyword}, which makes nodes or elements",
            expected="one line per node and element",
            remedy="Write the mesh out: Abaqus/CAE does, or a mesh from its output",
        )
    turned = keyword == "SYSTEM" and data
    curved = keyword == "NODE" and options.get("SYSTEM", "R").upper() != "R"
    if moved or turned or curved:
        raise MeshError(
            f"Mesh file '{path}'",
            found=f"*{keyword} moves or turns the coordinates of its nodes",
            expected="Cartesian coordinates as they are",
            remedy="Export a flat input file, without parts and instances and in the global system",
        )


def add(sets: dict[str, np.ndarray], name: str | None, numbers: np.ndarray) -> None:
    """Add numbers to a set; a second definition of a name extends the first, as in Abaqus."""
    if name:
        known = next((key for key in sets if key.upper() == name.upper()), name)
        sets[known] = np.union1d(sets.get(known, np.zeros(0, np.int64)), numbers)


def _elements(path: Path, options: dict[str, str], data: list[str], text: list[str]) -> np.ndarray:
    given = options.get("TYPE", "").upper()
    plain = next((name(match) for pattern, name in PLAIN if (match := pattern.match(given))), None)
    if plain is None:
        raise MeshError(
            f"Mesh file '{path}'",
            found=f"{len(data)} lines of elements of the type '{given}'",
            expected="C3D4, C3D6, C3D8, C3D10, C3D15, C3D20 and their variants, shells, beams",
            remedy="Delete these elements from the file, or mesh with another type",
        )
    size = {
        "C3D4": 4,
        "C3D6": 6,
        "C3D8": 8,
        "C3D10": 10,
        "C3D15": 15,
        "C3D20": 20,
        "S3": 3,
        "S4": 4,
        "STRI65": 6,
        "S8R": 8,
        "B31": 2,
        "B32": 3,
    }[plain]
    flat = np.array([int(word) for line in data for word in line.split(",") if word.strip()], np.int64)
    if len(flat) % (size + 1):
        raise MeshError(
            f"Mesh file '{path}'",
            found=f"{len(flat)} numbers in a block of {given} elements",
            expected=f"a multiple of {size + 1}: the number of each element and its {size} nodes",
            remedy="Write the mesh again",
        )
    table = flat.reshape(-1, size + 1)
    text.append(f"*ELEMENT, TYPE={plain}")
    # Abaqus counts the middle node of a line second, meshio last.
    rows = table[:, [0, 1, 3, 2]] if plain == "B32" else table
    text += [",".join(map(str, row)) for row in rows.tolist()]
    return table[:, 0]


def _members(
    path: Path,
    options: dict[str, str],
    data: list[str],
    known: dict[str, np.ndarray],
    ids: Sequence[ArrayLike],
) -> np.ndarray:
    """Return the numbers of a set; of long ranges those of `ids`, the nodes or elements so far."""
    found = [np.zeros(0, np.int64)]
    for line in data:
        words = [word.strip() for word in line.split(",") if word.strip()]
        if "GENERATE" in options:
            found.append(members_in(_span(path, words), ids, sum(map(len, found))))
            continue
        for word in words:
            if word.isdigit():
                found.append(np.array([int(word)]))
                continue
            found.append(_known(path, word, known))
    return np.concatenate(found)


def _span(path: Path, words: list[str]) -> range:
    """Return the range of a line of GENERATE: first, last and increment, as decks have it."""
    try:
        given = words * 2 if len(words) == 1 else words
        first, last, step = map(int, given if len(given) > 2 else [*given, "1"])
        if step > 0 and 0 < first <= last < LARGEST and (last - first) // step <= MANY:
            return range(first, last + 1, step)
    except ValueError:
        pass
    raise MeshError(
        f"Mesh file '{path}'",
        found=f"a set with GENERATE {', '.join(words)[:60]}",
        expected=f"first, last and a positive increment, {MANY} numbers at most",
        remedy="Correct the file, or write the mesh again",
    )


def _known(path: Path, word: str, known: dict[str, np.ndarray]) -> np.ndarray:
    """Return the members of a set defined before; names are the same in capitals."""
    name = next((key for key in known if key.upper() == word.strip('"').upper()), None)
    if name is None:
        raise MeshError(
            f"Mesh file '{path}'",
            found=f"a set that refers to the unknown set '{word}'",
            expected="sets of numbers or of sets defined before",
            remedy="Write the mesh again",
        )
    return known[name]


def _surface(path: Path, cards: AbaqusCards, options: dict[str, str], data: list[str]) -> None:
    """Read a surface: of nodes as a node set, of elements as lists of elements with their side."""
    name, kind = options.get("NAME", "surface"), options.get("TYPE", "ELEMENT").upper()
    if kind not in ("ELEMENT", "NODE") or "COMBINE" in options:
        what = f"COMBINE={options['COMBINE']}" if "COMBINE" in options else f"TYPE={kind}"
        cards.unread.append(f"surface '{name}' with {what}")
        return
    for line in data:
        word, _, rest = (piece.strip() for piece in line.partition(","))
        sets = cards.node_sets if kind == "NODE" else cards.element_sets
        numbers = np.array([int(word)]) if word.isdigit() else _known(path, word, sets)
        side = rest.partition(",")[0].strip().upper()
        if kind == "NODE":
            add(cards.node_sets, name, numbers)  # a second number is the area of contact
        elif side in SIDES:
            cards.surfaces.setdefault(name, []).append((numbers, side))
        else:
            cards.unread.append(f"surface '{name}' on '{word}', face {side}")
