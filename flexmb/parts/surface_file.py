"""`SurfaceFile`: the pressures of a flow solver, in a file beside the model, as a load shape."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from flexmb.errors import ModelError
from flexmb.fem.fe_model import FEModel
from flexmb.fem.surface_file import read_surface
from flexmb.model.described import Described, is_number
from flexmb.parts.limits import check_file
from flexmb.reduction.surface_pressure import SurfacePressure

__all__ = ["SurfaceFile"]


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfaceFile(metaclass=Described):
    """The pressures of a file, mapped onto the part with the same resultant force and moment.

    Parameters
    ----------
    file : path
        A table of points (.csv) or a mesh of triangles (.vtu, .vtk, .ply), see `flexmb.fem.read_surface`.
    field : str
        Name of the pressure; by default the first of p, pressure, P, Pressure.
    scale : float
        Metres per unit of the file.
    reference, factor : float
        As in `flexmb.reduction.SurfacePressure`: pressure on the other side, Pa; times which pressures count.
    on : set name or node numbers, optional
        Beams or shells whose nodes all lie in the set, or a facet set; by default all beams and shells.
    reach : float, m, optional
        Farther from the elements no point may lie; by default half of the diagonal of their box.
    turns_with : str, optional
        As in `flexmb.reduction.LineLoad`.
    """

    files: ClassVar[tuple[str, ...]] = ("file",)

    file: Any
    field: str = ""
    scale: float = 1.0
    reference: float = 0.0
    factor: float = 1.0
    on: Any = None
    reach: float | None = None
    turns_with: str | None = None

    def __post_init__(self):
        check_file(Path(self.file), "SurfaceFile")
        if not is_number(self.scale) or self.scale <= 0.0:
            raise ModelError(
                f"SurfaceFile '{Path(self.file).name}'",
                found=f"scale = {self.scale!r}",
                expected="metres per unit of the file, a positive number",
                remedy="Write scale = 0.001 for millimetres",
            )

    def content(self) -> dict[str, str]:
        """Return what the file holds, as digits."""
        return {"sha256": hashlib.sha256(Path(self.file).read_bytes()).hexdigest()}

    def on_nodes(self, fe: FEModel, title: str) -> SurfacePressure:
        """Return the load of a model."""
        table = read_surface(self.file, self.field, self.scale)
        return SurfacePressure(
            points=table["points"],
            pressure=table["pressure"],
            areas=table.get("areas"),
            triangles=table.get("triangles"),
            by_triangle=bool(table.get("by_triangle", False)),
            reference=self.reference,
            factor=self.factor,
            on=self.on,
            reach=self.reach,
            turns_with=self.turns_with,
        )
