"""Solids that Gmsh makes and meshes: the one place where Gmsh itself is called."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from flexmb.broken_pipes import keep_broken_pipes_errors
from flexmb.errors import MeshError
from flexmb.fem.meshes.mesh import Mesh
from flexmb.fem.meshes.read_mesh import read_mesh

__all__ = ["Profile", "extruded"]

Circle = tuple[float, float, float]
"""x and y of the centre and radius, m."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Profile:
    """A plane figure: outline (n, 2), m, and bosses together, without the bores; names of the edges of the outline."""

    outline: np.ndarray
    bosses: tuple[Circle, ...]
    bores: Mapping[str, Circle]
    edges: tuple[str, ...] = ()


def extruded(figure: Profile, depth: float, size: float, around: int, part: str) -> Mesh:
    """Return quadratic tetrahedra of a figure extruded from z = 0 to `depth` (m), largest element `size` (m).

    The surfaces of the bores, "bottom", "top" and "sides" are groups, and of the sides those on a named edge.
    """
    with _session(part) as gmsh, tempfile.TemporaryDirectory() as folder:
        occ = gmsh.model.occ
        pieces = [(2, _polygon(occ, figure.outline))] if len(figure.outline) else []
        pieces += [(2, occ.addDisk(x, y, 0.0, r, r)) for x, y, r in figure.bosses]
        body = occ.fuse(pieces[:1], pieces[1:])[0] if len(pieces) > 1 else pieces
        if figure.bores:
            body = occ.cut(body, [(2, occ.addDisk(x, y, 0.0, r, r)) for x, y, r in figure.bores.values()])[0]
        if len(body) != 1:
            raise MeshError(
                part,
                found=f"a figure of {len(body)} separate pieces",
                expected="one piece",
                remedy="Let bosses and outline overlap, and leave material beside the bores",
            )
        volumes = [tag for dim, tag in occ.extrude(body, 0.0, 0.0, depth) if dim == 3]
        occ.synchronize()
        for name, tags in _faces(gmsh, volumes, figure, depth, part).items():
            gmsh.model.addPhysicalGroup(2, tags, name=name)
        gmsh.model.addPhysicalGroup(3, volumes, name="solid")
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", around)
        gmsh.option.setNumber("Mesh.ElementOrder", 2)
        gmsh.option.setNumber("Mesh.HighOrderOptimize", 1)
        gmsh.model.mesh.generate(3)
        path = Path(folder) / "part.msh"
        gmsh.write(str(path))
        mesh = read_mesh(path)
    sides = _sides_of(mesh, figure)
    nodes = {name: np.unique(facets) for name, facets in sides.items()}
    return replace(
        mesh,
        name="extrusion",
        facet_sets={**mesh.facet_sets, **sides},
        node_sets={**mesh.node_sets, **nodes},
    )


def _sides_of(mesh: Mesh, figure: Profile) -> dict[str, np.ndarray]:
    """Return the facets of "sides" on each named edge of the outline; an edge that a boss covers has none."""
    found, facets = {}, mesh.facet_sets.get("sides", np.zeros((0, 6), int))
    for name, start, end in zip(figure.edges, figure.outline, np.roll(figure.outline, -1, axis=0)):
        along = end - start
        length = np.linalg.norm(along)
        if not length:
            continue
        places = mesh.points[facets][:, :, :2] - start
        far = np.abs(places @ [-along[1], along[0]]) / length  # from the line
        ahead = places @ along / length
        outside = np.maximum(np.maximum(-ahead, ahead - length), far)
        on = np.all(outside < 1e-6 * length, axis=1)
        if np.any(on):
            found[name] = facets[on]
    return found


def _polygon(occ, corners: np.ndarray) -> int:
    points = [occ.addPoint(float(x), float(y), 0.0) for x, y in corners]
    lines = [occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1])]
    return occ.addPlaneSurface([occ.addCurveLoop(lines)])


def _faces(gmsh, volumes: list[int], figure: Profile, depth: float, part: str) -> dict[str, list[int]]:
    """Return the faces of the solid by the name of their group: told apart by their boxes."""
    found: dict[str, list[int]] = {"bottom": [], "top": [], "sides": [], **{name: [] for name in figure.bores}}
    close = 1e-4 * min([depth, *(r for _, _, r in figure.bores.values())])
    for _, tag in gmsh.model.getBoundary([(3, v) for v in volumes], oriented=False):
        low_x, low_y, low_z, high_x, high_y, high_z = gmsh.model.getBoundingBox(2, tag)
        where = "sides"
        if high_z < close:
            where = "bottom"
        elif low_z > depth - close:
            where = "top"
        else:
            for name, (x, y, r) in figure.bores.items():
                box = np.array([low_x, low_y, high_x, high_y])
                if np.abs(box - [x - r, y - r, x + r, y + r]).max() < close:
                    where = name
        found[where].append(tag)
    lost = [name for name in figure.bores if not found[name]]
    if lost:
        raise MeshError(
            f"{part}, bore '{lost[0]}'",
            found="the bore cuts the edge of the figure",
            expected="a whole cylinder",
            remedy="Make the bore smaller, or the figure around it larger",
        )
    return {name: tags for name, tags in found.items() if tags}


@contextmanager
def _session(part: str) -> Iterator:
    """Give gmsh with an empty model; a session of the user goes on as it was."""
    try:
        import gmsh
    except (ImportError, OSError) as error:  # OSError: its library lacks one of the system
        raise MeshError(
            part,
            found=f"Gmsh is not installed here ({error})",
            expected="the package gmsh, which makes the mesh",
            remedy="pip install 'flexmb[mesh]', or give a mesh file with MeshFile",
        ) from None
    own = not gmsh.isInitialized()
    if own:
        gmsh.initialize(["-noenv"], readConfigFiles=False, interruptible=False)
        keep_broken_pipes_errors()
    before = None if own else gmsh.model.getCurrent()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("flexmb part")
    try:
        yield gmsh
    except MeshError:
        raise
    except Exception as error:  # gmsh raises Exception with the text of its log
        raise MeshError(
            part,
            found=f"Gmsh cannot mesh it ({' '.join(str(error).split())[:160]})",
            expected="a figure without crossing edges",
            remedy="Look at the outline, or take smaller elements",
        ) from error
    finally:
        gmsh.model.remove()
        if own:
            gmsh.finalize()
        else:
            gmsh.model.setCurrent(before)
