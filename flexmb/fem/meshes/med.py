"""Meshes of MED files (.med), the format of Salome and Code_Aster: cells, and families of nodes and cells as sets.

An HDF5 file: ``ENS_MAA/<mesh>/<step>`` holds the nodes NOE and the cells MAI by kind, numbers component by component
and counted from 1. Every node and cell belongs to one family (FAM; none: family 0), ``FAS/<mesh>`` lists the groups of
each family. Solids may be numbered the other way round than here; `fem.solid` turns them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.meshes.groups import GroupedMesh
from flexmb.hdf5 import reading_foreign

__all__ = ["from_med"]

KINDS = {
    "PO1": "vertex",
    "SE2": "line",
    "SE3": "line3",
    "TR3": "triangle",
    "TR6": "triangle6",
    "QU4": "quad",
    "QU8": "quad8",
    "QU9": "quad9",
    "TE4": "tetra",
    "T10": "tetra10",
    "HE8": "hexahedron",
    "H20": "hexahedron20",
    "PE6": "wedge",
    "P15": "wedge15",
    "PY5": "pyramid",
    "P13": "pyramid13",
}
"""Names of cells in meshio's spelling by those of MED; both number the nodes alike but for the sense of rotation."""
UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}


def from_med(path: Path) -> GroupedMesh:
    """Read the one mesh of a MED file; groups become sets of nodes and of cells."""
    part = f"Mesh file '{path}'"
    with reading_foreign(path, "mesh", part) as file:
        if "ENS_MAA" not in file:
            raise _refused(
                part, f"an HDF5 file with {', '.join(file) or 'nothing'}", "a MED file with a mesh (ENS_MAA)"
            )
        name, mesh = _only(part, file["ENS_MAA"], "meshes")
        system = int(mesh.attrs.get("REP", 0))
        if system:
            raise _refused(
                part, f"the mesh '{name}' in {('', 'cylindrical', 'spherical')[system]} coordinates", "Cartesian"
            )
        step = mesh if "NOE" in mesh else _only(part, mesh, f"steps of the mesh '{name}'")[1]
        if "NOE" not in step or "MAI" not in step:
            raise _refused(part, f"the mesh '{name}' without nodes or cells", "an unstructured mesh")
        points = _table(part, step["NOE"]["COO"])
        families = _families(file["FAS"][name]) if name in file.get("FAS", ()) else {}
        blocks, cell_families = _cells(part, step["MAI"])
        nodes: dict[str, np.ndarray] = {}
        for group, rows in _members(families.get("NOEUD", {}), _family(step["NOE"], len(points))):
            nodes[group] = np.union1d(nodes.get(group, rows), rows)
        sets: dict[str, list[np.ndarray]] = {}
        for b, family in enumerate(cell_families):
            for group, rows in _members(families.get("ELEME", {}), family):
                members = sets.setdefault(group, [np.zeros(0, np.int64) for _ in blocks])
                members[b] = np.union1d(members[b], rows)
        labels = step["NOE"]["NUM"][()].astype(np.int64) if "NUM" in step["NOE"] else np.zeros(0, np.int64)
        unit, notes = _unit(mesh.attrs.get("UNI", b""))
    if len(labels) != len(points) or len(np.unique(labels)) != len(labels) or labels.min(initial=1) < 1:
        labels = np.arange(1, len(points) + 1)
    return GroupedMesh(
        points=points, blocks=blocks, node_sets=nodes, cell_sets=sets, labels=labels, unit=unit, notes=notes
    )


def _only(part: str, things, what: str) -> tuple[str, Any]:
    names = list(things)
    if len(names) != 1:
        raise _refused(part, f"{len(names)} {what}: {', '.join(names)[:200]}", "one")
    return names[0], things[names[0]]


def _table(part: str, data) -> np.ndarray:
    """Return numbers that are stored component by component as rows."""
    count, numbers = int(data.attrs["NBR"]), data[()]
    if numbers.ndim != 1 or count < 1 or len(numbers) % count:
        raise _refused(part, f"{numbers.shape} numbers of {count} nodes or cells", "as many for each")
    return numbers.reshape(count, -1, order="F")


def _cells(part: str, kinds) -> tuple[list[tuple[str, np.ndarray]], list[np.ndarray]]:
    """Return the blocks of cells and the family of every cell."""
    blocks, families = [], []
    for code in kinds:
        if code not in KINDS:
            raise _refused(part, f"cells of the kind {code}", f"one of {', '.join(KINDS)}")
        cells = _table(part, kinds[code]["NOD"]).astype(np.int64) - 1
        blocks.append((KINDS[code], cells))
        families.append(_family(kinds[code], len(cells)))
    return blocks, families


def _family(group, count: int) -> np.ndarray:
    """Return the family of every node or cell; files leave out what is zero throughout."""
    numbers = group["FAM"][()].astype(np.int64) if "FAM" in group else np.zeros(count, np.int64)
    if numbers.shape != (count,):
        raise ValueError(f"{numbers.shape} families of {count} nodes or cells")
    return numbers


def _families(found) -> dict[str, dict[int, list[str]]]:
    """Return the names of the groups by family, for nodes (NOEUD) and cells (ELEME)."""
    names: dict[str, dict[int, list[str]]] = {}
    for place in ("NOEUD", "ELEME"):
        for family in found[place].values() if place in found else ():
            texts = family["GRO"]["NOM"][()] if "GRO" in family else np.zeros((0, 80), np.int8)
            words = [row.astype(np.uint8).tobytes().split(b"\0")[0].decode("utf-8", "replace").strip() for row in texts]
            names.setdefault(place, {})[int(family.attrs["NUM"])] = [word for word in words if word]
    return names


def _members(groups: dict[int, list[str]], families: np.ndarray):
    """Yield every group of every family that occurs, with the rows of the family."""
    for family in np.unique(families):
        for group in groups.get(int(family), ()):
            yield group, np.flatnonzero(families == family)


def _unit(text) -> tuple[float | None, list[str]]:
    """Return the metres per unit from the units of the axes, 16 characters each; None if they are blank."""
    words = (text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text)).replace("\0", " ").split()
    if not words:
        return None, []
    if len(set(words)) == 1 and words[0].lower() in UNITS:
        return UNITS[words[0].lower()], []
    return None, [f"the unit of its axes is '{' '.join(words)[:60]}'; coordinates were taken as metres times `scale`"]


def _refused(part: str, found: str, expected: str) -> MeshError:
    return MeshError(part, found=found, expected=expected, remedy="Export one unstructured mesh of the part alone")
