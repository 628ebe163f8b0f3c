"""The facets that *SURFACE of an Abaqus file means: faces of solids, sides of shells, free faces of a set."""

from __future__ import annotations

import numpy as np

from flexmb.fem.meshes.facets import all_faces, row_keys, trimmed
from flexmb.fem.meshes.mesh import DIMENSION

__all__ = ["SIDES", "surface_facets"]

SIDES = ("", "SPOS", "SNEG", "S1", "S2", "S3", "S4", "S5", "S6")
"""What may stand after an element or a set of elements: nothing means all free faces of solids, the top of shells."""

FACES = {
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "hexahedron": ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
}
"""Corner nodes of the faces S1, S2, ... (Abaqus Analysis User's Guide, element library)."""

TURNED = {3: (0, 2, 1), 4: (0, 3, 2, 1), 6: (0, 2, 1, 5, 4, 3), 8: (0, 3, 2, 1, 7, 6, 5, 4)}
"""The nodes of a facet run the other way round: its bottom, SNEG."""


def surface_facets(
    blocks: list[tuple[str, np.ndarray]], element_ids: list[np.ndarray], numbers: np.ndarray, side: str
) -> list[np.ndarray]:
    """Return tables of facets (nf, nodes per facet) of one line of *SURFACE.

    Parameters
    ----------
    blocks, element_ids
        Cells as rows of nodes, and their numbers in the file.
    numbers : of int
        The elements that the line names.
    side : one of SIDES
    """
    found = []
    chosen = [cells[np.isin(ids, numbers)] for (_, cells), ids in zip(blocks, element_ids)]
    for (cell_type, _), cells in zip(blocks, chosen):
        if not len(cells):
            continue
        if DIMENSION.get(cell_type) == 2:
            if side in ("", "SPOS"):
                found.append(cells)
            elif side == "SNEG":
                found.append(cells[:, list(TURNED[cells.shape[1]])])
        elif side.startswith("S") and (face := _face(cell_type, int(side[1:]) if side[1:].isdigit() else 0)):
            found.append(cells[:, list(face)])
    return found + (_free_faces(blocks, chosen) if not side else [])


def _face(cell_type: str, number: int) -> tuple[int, ...]:
    """Return the local nodes of the face that Abaqus numbers 1, 2, ..., or () for other cells."""
    from flexmb.fem.solids.elements import SOLID_ELEMENTS

    element = SOLID_ELEMENTS.get(cell_type)
    known = FACES.get(element.family, ()) if element else ()
    if element is None or not 1 <= number <= len(known):
        return ()
    corners = frozenset(known[number - 1])
    return next(face for face in element.faces if frozenset(face[: len(corners)]) == corners)


def _free_faces(blocks: list[tuple[str, np.ndarray]], chosen: list[np.ndarray]) -> list[np.ndarray]:
    """Return the faces of the chosen solids that belong to one solid of the whole mesh only."""
    solid = [k for k, (cell_type, _) in enumerate(blocks) if DIMENSION.get(cell_type) == 3]
    if not any(len(chosen[k]) for k in solid):
        return []
    _, everywhere = all_faces([(blocks[k][0], np.asarray(blocks[k][1])) for k in solid])
    faces, corners = all_faces([(blocks[k][0], chosen[k]) for k in solid if len(chosen[k])])
    own, whole = row_keys(corners, everywhere)
    return [trimmed(faces[np.bincount(whole, minlength=int(own.max()) + 1)[own] == 1])]
