"""Surfaces of an Abaqus deck as facets and nodes: faces S1.., SPOS, SNEG, whole element sets, sets of nodes."""

from __future__ import annotations

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.deck.abaqus_model import Element, Flat
from flexmb.fem.deck.abaqus_text import is_number
from flexmb.fem.deck.cells import EDGES
from flexmb.fem.meshes.abaqus_surfaces import FACES

__all__ = ["facets", "shape_of", "surface_nodes"]

SOLID: tuple[tuple[str, str], ...] = (
    ("C3D20", "hexahedron20"),
    ("C3D10", "tetra10"),
    ("C3D15", "wedge15"),
    ("C3D27", "hexahedron27"),
)
SOLID += (("C3D4", "tetra"), ("C3D5", "pyramid"), ("C3D6", "wedge"), ("C3D8", "hexahedron"))
SHELLS = {"S3": 3, "STRI3": 3, "S4": 4, "STRI65": 6, "S6": 6, "S8": 8, "S9": 9, "R3D3": 3, "R3D4": 4}
SHELLS |= {"M3D3": 3, "M3D4": 4, "M3D6": 6, "M3D8": 8}


def shape_of(kind: str) -> tuple[str, str]:
    """Return family ("solid", "shell", "beam", "truss", "point", "flat", "") and cell type of an element name."""
    for name, cell in SOLID:
        if kind.startswith(name):
            return "solid", cell
    for name in sorted(SHELLS, key=len, reverse=True):
        if kind == name or (kind.startswith(name) and not kind[len(name) :][:1].isdigit()):
            return ("rigid" if name.startswith("R3D") else "shell"), str(SHELLS[name])
    if kind.startswith(("B31", "B32", "B33", "PIPE3", "ELBOW")):
        return "beam", "line3" if kind.startswith(("B32", "PIPE32")) else "line"
    if kind.startswith("T3D"):
        return "truss", "line3" if kind.startswith("T3D3") else "line"
    if kind.startswith(("MASS", "ROTARYI", "SPRING", "DASHPOT", "DCOUP", "GAP")):
        return "point", kind
    if kind.startswith(("CPS", "CPE", "CAX", "CPEG")):
        return "flat", kind
    return "", kind


def _faces(flat: Flat, name: str):
    """Yield (element, face identifier) of a surface made of elements."""
    for word, side, scope in flat.surfaces[name]:
        found = _elements(flat, word, scope, name)
        for k in found:
            yield flat.elements[k], side


def _elements(flat: Flat, word: str, scope: str, name: str) -> list[int]:
    full = flat.full(flat.element_sets, word, scope)
    if full is not None:
        return flat.element_sets[full]
    if is_number(word) and int(word) in flat.scopes[scope].elements:
        return [flat.scopes[scope].elements[int(word)]]
    raise flat.surface_blocks[name].wrong(
        f"the element set or element '{word}' of surface '{name}', which does not exist",
        f"One of: {', '.join(sorted(flat.element_sets)[:12]) or 'none'}",
        "Correct the *SURFACE",
    )


def face_nodes(element: Element, side: str) -> list[int]:
    """Return all nodes of a face of an element, corners first; for beams, all nodes of the element."""
    family, cell = shape_of(element.kind)
    if family != "solid" or not side.startswith("S") or not is_number(side[1:]):
        return element.nodes
    shape = cell.rstrip("0123456789")
    faces = FACES.get(shape, ())
    number = int(side[1:]) - 1
    if not 0 <= number < len(faces):
        return []
    corners = faces[number]
    if max(corners) >= len(element.nodes):
        raise MeshError(
            f"Element {element.label} of type {element.kind}",
            found=f"{len(element.nodes)} nodes, of which a surface asks for face {side}",
            expected=f"{max(corners) + 1} nodes at least",
            remedy="Complete the element",
        )
    nodes = [element.nodes[k] for k in corners]
    first = {"tetra": 4, "wedge": 6, "hexahedron": 8}[shape]
    for k, (a, b) in enumerate(EDGES.get(cell, ())):
        if a in corners and b in corners and first + k < len(element.nodes):
            nodes.append(element.nodes[first + k])
    return nodes


def surface_nodes(flat: Flat, name: str) -> np.ndarray:
    """Return the sorted nodes of a surface of any kind."""
    if flat.surface_kinds[name] == "NODE":
        out: list[int] = []
        for word, _, scope in flat.surfaces[name]:
            full = flat.full(flat.node_sets, word, scope)
            if full is not None:
                out += flat.node_sets[full]
            elif is_number(word) and int(word) in flat.scopes[scope].nodes:
                out.append(flat.scopes[scope].nodes[int(word)])
            else:
                raise flat.surface_blocks[name].wrong(
                    f"the node set or node '{word}' of surface '{name}', which does not exist",
                    f"One of: {', '.join(sorted(flat.node_sets)[:12]) or 'none'}",
                    "Correct the *SURFACE",
                )
        return np.unique(np.array(out, np.int64))
    if flat.surface_kinds[name] != "ELEMENT":
        return np.zeros(0, np.int64)
    found = {node for element, side in _faces(flat, name) for node in face_nodes(element, side)}
    if any(side == "" and shape_of(element.kind)[0] == "solid" for element, side in _faces(flat, name)):
        found = {int(n) for row in facets(flat, name) for n in row if n >= 0}
    return np.array(sorted(found), np.int64)


def facets(flat: Flat, name: str, middles: bool = False) -> np.ndarray:
    """Return the corners (nf, 4) of the facets of a surface, -1 behind triangles; SNEG turned round.

    With `middles` (nf, 8): midside nodes follow the corners along the ring, -1 behind.
    """
    width = 8 if middles else 4
    if flat.surface_kinds[name] != "ELEMENT":
        return np.zeros((0, width), np.int64)
    rows: list[list[int]] = []
    whole: list[Element] = []
    for element, side in _faces(flat, name):
        family, cell = shape_of(element.kind)
        if family in ("shell", "rigid"):
            corners = element.nodes[: 3 if cell in ("3", "6") else 4]
            rows.append(_ring(element, corners[::-1] if side == "SNEG" else corners, middles))
        elif family == "solid" and side == "":
            whole.append(element)
        elif family == "solid" and is_number(side[1:]):
            count = len(FACES.get(cell.rstrip("0123456789"), ((),))[max(int(side[1:]) - 1, 0)])
            rows.append(_ring(element, face_nodes(element, side)[:count], middles))
    rows += [_ring(element, corners, middles) for element, corners in _free_faces(whole)]
    out = np.full((len(rows), width), -1, np.int64)
    for k, row in enumerate(rows):
        out[k, : len(row)] = row
    return out[(out >= 0).sum(axis=1) >= 3]


def _ring(element: Element, corners: list[int], middles: bool) -> list[int]:
    """Return the corners of a face and, if wanted and there, its midside nodes along the ring."""
    family, cell = shape_of(element.kind)
    if not middles or not corners:
        return corners
    if family == "solid":
        edges, first = EDGES.get(cell, ()), {"tetra10": 4, "wedge15": 6, "hexahedron20": 8}.get(cell, 0)
    else:
        first = 3 if cell in ("3", "6") else 4
        edges = tuple((k, (k + 1) % first) for k in range(first)) if cell in ("6", "8") else ()
    at = {frozenset((element.nodes[a], element.nodes[b])): first + k for k, (a, b) in enumerate(edges)}
    places = [at.get(frozenset(pair)) for pair in zip(corners, corners[1:] + corners[:1], strict=True)]
    if any(place is None or place >= len(element.nodes) for place in places):
        return corners
    return corners + [element.nodes[place] for place in places if place is not None]


def _free_faces(elements: list[Element]) -> list[tuple[Element, list[int]]]:
    """Return the faces that belong to one element of a set only: the surface of a whole element set."""
    seen: dict[tuple[int, ...], list[tuple[Element, list[int]]]] = {}
    for element in elements:
        shape = shape_of(element.kind)[1].rstrip("0123456789")
        for face in FACES.get(shape, ()):
            nodes = [element.nodes[k] for k in face]
            seen.setdefault(tuple(sorted(nodes)), []).append((element, nodes))
    return [found[0] for found in seen.values() if len(found) == 1]
