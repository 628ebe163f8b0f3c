"""`MeshFile`: solids or shells from a mesh, which a parameter may lengthen."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.fem.fe_model import FEModel
from flexmb.fem.meshes.mesh import Mesh
from flexmb.fem.meshes.read_mesh import read_mesh
from flexmb.fem.shells.shell import shell
from flexmb.fem.solids.solid import solid
from flexmb.model.described import Described, entries_of, finite_array, is_number
from flexmb.parts.limits import check_file
from flexmb.parts.materials import material_of

__all__ = ["MeshFile", "Stretch"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Stretch(metaclass=Described):
    """Lengthen a mesh between two planes: what lies before the first stays, what lies behind the second moves as it is.

    Parameters
    ----------
    along : (3,)
        Direction, normal to the planes.
    between : (2,), m
        Distance of the planes from the origin of the mesh, in metres, where the change of the length takes place.
    by : float, m
        Change of the length between them; negative shortens.
    """

    along: Any
    between: Any
    by: float

    def __post_init__(self):
        along, between = finite_array(self.along), finite_array(self.between)
        if along.shape != (3,) or not np.linalg.norm(along) > 0.0:
            raise ModelError(
                "Stretch",
                found=f"along = {self.along!r}",
                expected="a direction: three numbers, not all zero",
                remedy="Write along = [1, 0, 0]",
            )
        if between.shape != (2,) or not between[0] < between[1]:
            raise ModelError(
                "Stretch",
                found=f"between = {self.between!r} m",
                expected="two distances, the smaller one first",
                remedy="Write between = [0.1, 0.5]",
            )
        if not is_number(self.by) or self.by <= -(between[1] - between[0]):
            raise ModelError(
                "Stretch",
                found=f"by = {self.by!r} m of the {between[1] - between[0]:.6g} m between the planes",
                expected="a length that leaves something between them",
                remedy="Shorten less, or take the planes further apart",
            )
        object.__setattr__(self, "along", along / np.linalg.norm(along))
        object.__setattr__(self, "between", between)

    def moved(self, points: np.ndarray) -> np.ndarray:
        """Return the nodes (n, 3), m, of the lengthened mesh."""
        low, high = self.between
        share = np.clip((points @ self.along - low) / (high - low), 0.0, 1.0)
        return points + np.outer(share * self.by, self.along)


@dataclass(frozen=True, kw_only=True, eq=False)
class MeshFile(metaclass=Described):
    """Solids or shells of a mesh file; its groups are the sets of the part.

    Parameters
    ----------
    file : path
        Gmsh, Nastran, Abaqus or VTU mesh.
    material : Material, OrthotropicMaterial, the name of a material, or a mapping of group to these (solids)
        "steel", "aluminium", "titanium" and others are ready-made.
    thickness : float or mapping of group to float, m, optional
        The triangles and quadrilaterals are shells; without it the solid cells are taken.
    groups : list of str, optional
        Only the cells of these groups.
    scale : float
        Metres per unit of the file.
    stretch : Stretch or list of them
        Changes of length, one after another.
    lumped : bool
        Diagonal mass.
    stress_side : float, -, of shells
        Side whose stress is kept: -1 (bottom), 0 (middle) or 1 (top); without it the middle, with a warning.
    name : str
        Goes before the names of the groups, "lever.bore".
    """

    files: ClassVar[tuple[str, ...]] = ("file",)

    file: Any
    material: Any
    thickness: Any = None
    groups: Any = ()
    scale: float = 1.0
    stretch: Any = ()
    lumped: bool = False
    stress_side: float | None = None
    name: str = ""

    @property
    def title(self) -> str:
        """How messages call it."""
        return f"MeshFile '{Path(self.file).name}'"

    def __post_init__(self):
        if not isinstance(self.file, str | Path):
            raise ModelError(
                "MeshFile", found=f"file = {self.file!r:.80}", expected="a path", remedy='Write file = "flap.msh"'
            )
        check_file(Path(self.file), self.title)
        groups = entries_of(self.groups)
        if not all(isinstance(name, str) for name in groups):
            raise ModelError(
                self.title,
                found=f"groups = {self.groups!r:.80}",
                expected="names of groups of the mesh",
                remedy='Write groups = ["skin", "rib"], or leave it out for the whole mesh',
            )
        object.__setattr__(self, "groups", groups)
        given = self.material
        solids = self.thickness is None
        if isinstance(given, Mapping):
            made = {name: material_of(one, f"{self.title}, {name}", orthotropic=solids) for name, one in given.items()}
        else:
            made = material_of(given, self.title, orthotropic=solids)
        object.__setattr__(self, "material", made)
        several = [
            Stretch(**one) if isinstance(one, Mapping) and all(isinstance(key, str) for key in one) else one
            for one in entries_of(self.stretch)
        ]
        if not all(isinstance(one, Stretch) for one in several):
            raise ModelError(
                self.title,
                found=f"stretch = {self.stretch!r:.80}",
                expected="tables with along, between and by",
                remedy="Write stretch = [{ along = [1, 0, 0], between = [0.1, 0.5], by = 0.05 }]",
            )
        object.__setattr__(self, "stretch", tuple(several))
        values = self.thickness.values() if isinstance(self.thickness, Mapping) else [self.thickness]
        if not solids and not all(is_number(value) and value > 0.0 for value in values):
            raise ModelError(
                self.title,
                found=f"thickness = {self.thickness!r} m",
                expected="a positive number, or one for each group",
                remedy="Write thickness = 0.002, or { skin = 0.002, rib = 0.003 }",
            )
        self._check_side(solids)

    def _check_side(self, solids: bool) -> None:
        if self.stress_side is None:
            return
        if solids or not (is_number(self.stress_side) and abs(self.stress_side) <= 1.0):
            raise ModelError(
                self.title,
                found=f"stress_side = {self.stress_side!r}" + (" of solids" if solids else ""),
                expected="-1 (bottom), 0 (middle) or 1 (top), where thickness makes shells",
                remedy="Remove stress_side" if solids else "Write stress_side = 1 for the outer fibres on top",
            )

    def content(self) -> dict[str, Any]:
        """Return what the file holds, as digits; where it names other files, what is read with them as well."""
        data = Path(self.file).read_bytes()
        found: dict[str, Any] = {"sha256": hashlib.sha256(data).hexdigest()}
        upper = data[:64_000_000].upper()
        if Path(self.file).suffix.lower() != ".msh" and (b"INCLUDE" in upper or b"INPUT" in upper):
            mesh, digest = self._mesh(), hashlib.sha256()
            for array in (mesh.points, *(cells for _, cells in mesh.cells)):
                digest.update(np.ascontiguousarray(array).tobytes())
            for sets in (mesh.node_sets, mesh.facet_sets):
                for name in sorted(sets):
                    digest.update(name.encode() + np.ascontiguousarray(sets[name]).tobytes())
            found["read"] = digest.hexdigest()
        return found

    def _mesh(self) -> Mesh:
        mesh = read_mesh(self.file, scale=self.scale)
        return mesh.only(*self.groups) if self.groups else mesh

    def finite_elements(self) -> FEModel:
        """Return the FE model of the mesh."""
        mesh = self._mesh()
        for stretch in self.stretch:
            self._require_between(stretch, mesh.points)
            mesh = replace(mesh, points=stretch.moved(mesh.points))
        if self.thickness is None:
            return solid(mesh, self.material, lumped=self.lumped)
        return shell(mesh, self.material, self.thickness, lumped=self.lumped, stress_side=self.stress_side)

    def _require_between(self, stretch: Stretch, points: np.ndarray) -> None:
        """Raise ModelError if all of the mesh lies on one side of a stretch: it would change nothing."""
        low, high = stretch.between
        along = points @ stretch.along
        if along.max() <= low or along.min() >= high:
            axis = ", ".join(f"{x:.3g}" for x in stretch.along)
            raise ModelError(
                self.title,
                found=f"a stretch between {low:.6g} and {high:.6g} m along ({axis}); the mesh reaches "
                f"from {along.min():.6g} to {along.max():.6g} m there",
                expected="planes with some of the mesh between them",
                remedy="Give between in metres, after scale; a mesh in millimetres has scale = 1e-3",
            )
