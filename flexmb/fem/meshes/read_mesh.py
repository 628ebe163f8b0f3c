"""`read_mesh`: the one door for mesh files.

meshio reads the cells, except Nastran's, whose angles and offsets it takes for nodes. Groups are read here, because
meshio drops Nastran sets, Abaqus surfaces and second definitions of an Abaqus set; the pages docs/howto/from-gmsh.md,
docs/howto/from-nastran.md and docs/howto/from-abaqus.md state which group of which format becomes which set.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.foreign_files import require_file, understood
from flexmb.fem.meshes.groups import GroupedMesh, from_abaqus, from_gmsh, from_nastran, from_vtu, to_mesh
from flexmb.fem.meshes.med import from_med
from flexmb.fem.meshes.mesh import Mesh
from flexmb.fem.meshes.universal_mesh import from_universal
from flexmb.fem.told import keeping_warnings, tell
from flexmb.model.described import is_number

__all__ = ["read_mesh"]

READERS: dict[str, Callable[[Path], GroupedMesh]] = {
    ".msh": from_gmsh,
    ".bdf": from_nastran,
    ".nas": from_nastran,
    ".fem": from_nastran,
    ".inp": from_abaqus,
    ".vtu": from_vtu,
    ".vtk": from_vtu,
    ".med": from_med,
    ".unv": from_universal,
    ".uff": from_universal,
}
"""Readers by file suffix."""

COINCIDENT = 1e-7
"""Nodes nearer than this fraction of the mesh diagonal are reported as coincident."""


@keeping_warnings
def read_mesh(path: str | Path, *, scale: float = 1.0) -> Mesh:
    """Read a mesh of Gmsh (.msh 2 and 4), Nastran (.bdf .nas .fem), Abaqus (.inp), VTK (.vtu .vtk), Salome
    (.med), or a universal file (.unv .uff).

    Nodes that belong to no cell are dropped and the rest renumbered.

    Parameters
    ----------
    path : path
    scale : float
        Metres per unit of the file: 1e-3 for a mesh in millimetres. A universal or MED file that names its unit
        needs none; a scale other than 1 counts more, with a warning if they differ.

    Returns
    -------
    Mesh
        Cells by kind, and every named group as a set of nodes, of facets (surface groups) and of cells.

    Raises
    ------
    MeshError
        No such file, not readable, unknown kind of cell, no cells, a scale that is not a positive number.

    Warns
    -----
    MeshWarning
        Coincident nodes, a set without cells, cells that are listed twice, masses, links and surfaces that were left
        out.
    """
    if not isinstance(path, str | Path):
        raise MeshError(
            "fem.read_mesh",
            found=f"the path {path!r}",
            expected="the name of a mesh file",
            remedy='Write fem.read_mesh("part.msh")',
        )
    path = Path(path)
    part = f"Mesh file '{path}'"
    require_file(part, path, "an existing mesh file", f"The current folder is {Path.cwd()}", READERS)
    if not is_number(scale) or scale <= 0.0:
        raise MeshError(
            part,
            found=f"scale = {scale!r}",
            expected="a factor > 0: metres per unit of the mesh",
            remedy="Write scale=1e-3 for a mesh in millimetres",
        )
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise MeshError(
            part,
            found=f"the suffix '{path.suffix}'",
            expected=f"One of: {', '.join(READERS)}",
            remedy="Convert the mesh, or build a fem.Mesh from arrays",
        )
    with understood(
        part,
        f"a complete file of the format {path.suffix}",
        "Open it in the program that wrote it, and write it again",
        path,
    ):
        grouped = reader(path)
        mesh = to_mesh(grouped, path.stem, part)
    _warn_about_losses(part, grouped)
    kept = mesh.without_unused_nodes().scaled(_unit(part, grouped, float(scale)))
    for name in sorted(set(mesh.node_sets) - set(kept.node_sets)):
        tell(f"{part}: the set '{name}' holds only nodes without cells; it was dropped")
    _warn_about_coincident_nodes(part, kept)
    return kept


def _unit(part: str, grouped: GroupedMesh, scale: float) -> float:
    """Return the metres per unit of the file."""
    if grouped.unit is None or scale == 1.0:
        return scale if grouped.unit is None else grouped.unit
    if abs(scale - grouped.unit) > 1e-6 * scale:
        tell(f"{part}: its unit of length is {grouped.unit:g} m by the file itself, but scale={scale:g} was used")
    return scale


def _warn_about_losses(part: str, grouped: GroupedMesh) -> None:
    """Name what the file holds and the mesh does not."""
    found = list(grouped.notes)
    if grouped.left_out:
        found.append(
            f"left out were {', '.join(grouped.left_out)}; a mesh holds nodes, elements and sets. Add "
            "them to the FE model with fem.with_mass, fem.with_rigid_link, fem.with_averaging_link or "
            "fem.with_spring"
        )
    for text in found:
        tell(f"{part}: {text}")


def _warn_about_coincident_nodes(part: str, mesh: Mesh) -> None:
    from scipy.spatial import cKDTree

    diagonal = float(np.linalg.norm(np.ptp(mesh.points, axis=0)))
    pairs = cKDTree(mesh.points).query_pairs(COINCIDENT * diagonal, output_type="ndarray")
    if len(pairs):
        i, j = sorted(map(int, pairs[0]))
        tell(
            f"{part}: {len(pairs)} pairs of nodes coincide within {COINCIDENT * diagonal:.2g} m, the first "
            f"are {i} and {j} at {np.round(mesh.points[i], 9).tolist()}; the part is cut there unless the "
            "nodes are merged"
        )
