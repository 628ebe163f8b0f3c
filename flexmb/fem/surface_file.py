"""Surfaces with pressures as flow solvers write them: tables of points with area vectors, or meshes of triangles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import MeshError, did_you_mean
from flexmb.fem.announced import require_counts
from flexmb.fem.foreign_files import require_file, understood, whole_numbers
from flexmb.fem.gltf_scene import require_plain_scene

__all__ = ["SurfaceTable", "read_surface", "read_triangles"]

TABLES = (".csv", ".txt", ".dat")
CLOSED = (".xdmf", ".xmf", ".med", ".h5m", ".cgns", ".hmf", ".e", ".ex2", ".exo")
"""What meshio reads by the libraries of HDF5 and netCDF, which a damaged file can crash, or from files named inside."""
PRESSURES = ("p", "pressure", "P", "Pressure")

SurfaceTable = dict[str, Any]
"""points (n, 3), m; pressure (n,) or (nt,), Pa; areas (n, 3), m2, or triangles (nt, 3) and by_triangle."""


def read_surface(path: str | Path, field: str = "", scale: float = 1.0) -> SurfaceTable:
    """Return points, pressure and area vectors, or triangles, of a file.

    A table (.csv, .txt, .dat) has a line of titles and the columns x, y, z, p and ax, ay, az (area vectors, outward),
    or area, nx, ny, nz; separators are commas, semicolons or blanks. A mesh that meshio reads (.vtu, .vtk, .ply, ...)
    has triangles or quadrilaterals, whose corners go round the outward normal, and a field at points or cells.

    Parameters
    ----------
    path : str or Path
    field : str
        Name of the column or field of the pressure; by default the first of p, pressure, P, Pressure.
    scale : float
        Metres per unit of the file; areas are scaled by its square.
    """
    path = Path(path)
    part = f"Surface file '{path.name}'"
    if path.suffix.lower() in TABLES:
        return _table(path, field, scale, part)
    with understood(part, "a table (.csv) or a mesh that meshio reads", "Export .csv, .vtu or .vtk", path):
        mesh = _read(path, part)
    names = {**mesh.point_data, **mesh.cell_data}
    name = _pressure_name(list(names), field, part)
    points, triangles, blocks = _triangles(mesh, part)
    pressures = [np.asarray(mesh.cell_data[name][k], float) for k in blocks] if name in mesh.cell_data else []
    pressure = np.concatenate(pressures) if pressures else np.asarray(mesh.point_data[name], float)
    _require_finite(part, f"the field {name}", pressure)
    found = {"points": scale * points, "triangles": triangles, "pressure": pressure}
    return {**found, "by_triangle": bool(pressures)}


def read_triangles(path: str | Path, scale: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 3), m, and triangles (m, 3) of a file: STL, OBJ, PLY, VTK, OFF by meshio, GLB by trimesh.

    Parameters
    ----------
    path : str or Path
    scale : float
        Metres per unit of the file.
    """
    path = Path(path)
    part = f"Surface file '{path.name}'"
    require_file(part, path, f"a file at {path}", "Correct the path")
    if path.suffix.lower() in (".glb", ".gltf"):
        with understood(part, "a scene that trimesh reads (pip install trimesh)", "Export .stl or .ply"):
            import trimesh
        with understood(part, "a complete scene of glTF 2.0", "Export .stl or .ply", path):
            require_plain_scene(part, path)
            scene: Any = trimesh.load(path, force="mesh")
            points, faces = np.array(scene.vertices, float), np.array(scene.faces, int)
        if not len(faces):
            raise MeshError(part, found="no triangles", expected="a surface", remedy="Export .stl or .ply")
        _require_finite(part, "coordinates", points)
        return scale * points, whole_numbers(part, "corners of triangles", faces, 0, len(points) - 1)
    with understood(part, "a mesh that meshio reads", "Export .stl, .ply or .vtk", path):
        mesh = _read(path, part)
    points, triangles, _ = _triangles(mesh, part)
    return scale * points, triangles


def _read(path: Path, part: str) -> Any:
    """Return what meshio reads."""
    import meshio

    if path.suffix.lower() in CLOSED:
        raise MeshError(
            part,
            found=f"the suffix '{path.suffix}'",
            expected="a file that is complete in itself, and no HDF5 or netCDF",
            remedy="Export .vtu, .vtk, .stl or .ply",
        )
    require_counts(path)
    with np.errstate(over="ignore"):  # it reads letters of a text STL as a number of triangles first, and multiplies it
        return meshio.read(path)


def _triangles(mesh, part: str) -> tuple[np.ndarray, np.ndarray, list[int]]:
    """Return points (n, 3), triangles (m, 3), and the block of cells of each group of them in their order."""
    triangles, blocks = [], []
    for k, block in enumerate(mesh.cells):
        wanted = {"triangle": 3, "quad": 4}.get(block.type, 0)
        if wanted and np.shape(block.data)[1:] != (wanted,):
            raise MeshError(
                part,
                found=f"cells of the kind '{block.type}' with {np.shape(block.data)[1:]} corners",
                expected=f"{wanted} each",
                remedy="Export the file again",
            )
        for corner in {"triangle": [(0, 1, 2)], "quad": [(0, 1, 2), (0, 2, 3)]}.get(block.type, []):
            triangles.append(block.data[:, corner])
            blocks.append(k)
    if not triangles:
        raise MeshError(
            part,
            found=f"cells of the kinds {sorted({b.type for b in mesh.cells})}",
            expected="triangles or quadrilaterals",
            remedy="Export the surface, not the volume",
        )
    given = np.asarray(mesh.points)
    if given.ndim != 2 or given.shape[1] not in (2, 3):
        raise MeshError(
            part,
            found=f"points of the shape {given.shape}",
            expected="two or three coordinates each",
            remedy="Export points without colours or weights",
        )
    points = np.zeros((len(given), 3))
    points[:, : given.shape[1]] = given
    _require_finite(part, "coordinates", points)
    corners = np.concatenate(triangles)
    return points, whole_numbers(part, "corners of cells, counted from 0,", corners, 0, len(points) - 1), blocks


def _require_finite(part: str, what: str, values: np.ndarray) -> None:
    """Raise MeshError for numbers that are not finite."""
    wrong = ~np.isfinite(np.asarray(values, float))
    if wrong.any():
        raise MeshError(
            part,
            found=f"{what} with {float(values[wrong].flat[0])} at place {int(np.argwhere(wrong)[0][0]) + 1}",
            expected="finite numbers",
            remedy="Export the surface again",
        )


def _pressure_name(names: list[str], field: str, part: str) -> str:
    found = [name for name in ((field,) if field else PRESSURES) if name in names]
    if not found:
        raise MeshError(
            part,
            found=f"the fields {', '.join(names) or 'none'}",
            expected=f"a pressure '{field}'" if field else f"one of {', '.join(PRESSURES)}",
            remedy=did_you_mean(field, names) or 'Name it: field = "..."',
        )
    return found[0]


def _table(path: Path, field: str, scale: float, part: str) -> SurfaceTable:
    """Read a table with titles."""
    with understood(part, "a line of titles, then numbers", "Write x,y,z,p,ax,ay,az and one line per point"):
        lines = path.read_text().splitlines()
        split = lambda line: line.replace(",", " ").replace(";", " ").split()  # noqa: E731
        titles = [title.strip('"') for title in split(lines[0].lstrip("#"))]
        rows = np.array([[float(x) for x in split(line)] for line in lines[1:] if line.strip()])
    if rows.ndim != 2 or rows.shape[1] != len(titles):
        raise MeshError(
            part,
            found=f"{len(titles)} titles over rows of the shape {rows.shape}",
            expected="as many numbers in each line as titles",
            remedy="Write x,y,z,p,ax,ay,az and one line per point",
        )
    own = dict(zip(titles, rows.T))
    pressure = own[_pressure_name(titles, field, part)]
    if all(name in own for name in ("ax", "ay", "az")):
        areas = np.column_stack([own["ax"], own["ay"], own["az"]])
    elif all(name in own for name in ("area", "nx", "ny", "nz")):
        normal = np.column_stack([own["nx"], own["ny"], own["nz"]])
        size = np.linalg.norm(normal, axis=1)
        if not np.all(size > 0.0):
            raise MeshError(
                part,
                found=f"a normal of zero at row {int(np.argmin(size)) + 1}",
                expected="outward normals",
                remedy="Export the normals again",
            )
        areas = own["area"][:, None] * normal / size[:, None]
    else:
        areas = None
    missing = [name for name in ("x", "y", "z") if name not in own]
    if areas is None or missing:
        raise MeshError(
            part,
            found=f"the columns {', '.join(titles)}",
            expected="x, y, z, p and ax, ay, az, or area, nx, ny, nz",
            remedy=f"Add {', '.join(missing) or 'the area vectors'}",
        )
    points = np.column_stack([own["x"], own["y"], own["z"]])
    for what, values in (("coordinates", points), ("pressures", pressure), ("areas or normals", areas)):
        _require_finite(part, what, values)
    return {"points": scale * points, "pressure": pressure, "areas": scale**2 * areas}
