"""`Line`: beams along a polyline, with tapered sections and named nodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.fem.fe_model import FEModel
from flexmb.fem.frames.frame import frame
from flexmb.fem.frames.section import Section
from flexmb.model.described import Described, finite_array, is_number
from flexmb.parts.limits import check_count, largest_size
from flexmb.parts.materials import material_of

__all__ = ["Line"]

CLOSE = 1e-9
"""Fractions of the length nearer than this are one node."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Line(metaclass=Described):
    """Beams along a polyline.

    Parameters
    ----------
    points : (n, 3), m
        Corners of the line; every one is a node.
    section : Section, or two of them, or one per point
        Two taper linearly from the first to the last point, one per point in every stretch between points.
    material : Material, or the name of one
        "steel", "aluminium", "titanium" and others are ready-made.
    size : float, m, optional
        Largest length of a beam. Without it, and without `elements`, nodes are at points and named places only.
    elements : int, optional
        At least so many beams over the whole line, instead of `size`.
    nodes : mapping of name to float or list of float, -
        Named nodes at fractions 0..1 of the length of the line; several make one set, in ascending order.
    orientation : (3,), optional
        Vector whose part across the beam is the section's y-axis; see `flexmb.fem.frame`.
    shear : bool
        Shear flexibility (Timoshenko); false for Euler and Bernoulli's beams.
    rotary_inertia : bool
        Inertia of the sections about their axes.
    lumped : bool
        Diagonal mass.
    name : str
        Goes before the names of the sets "start" and "end" ("spar.start") and names the set of all nodes.
    """

    points: Any
    section: Any
    material: Any
    size: float | None = None
    elements: int | None = None
    nodes: Mapping[str, Any] = field(default_factory=dict)
    orientation: Any = None
    shear: bool = True
    rotary_inertia: bool = True
    lumped: bool = False
    name: str = ""

    @property
    def title(self) -> str:
        """How messages call it."""
        return f"Line '{self.name}'" if self.name else "Line"

    def __post_init__(self):
        points = finite_array(self.points)
        if points.ndim != 2 or points.shape[1] != 3 or len(points) < 2:
            raise ModelError(
                self.title,
                found=f"points = {self.points!r:.80}",
                expected="two points or more, each of three numbers, m",
                remedy="Write points = [[0, 0, 0], [1, 0, 0]]",
            )
        lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
        if not np.all(lengths > 1e-12 * lengths.sum()):
            bad = int(np.argmin(lengths))
            raise ModelError(
                self.title,
                found=f"points {bad} and {bad + 1} (from 0) are both at {points[bad].tolist()} m",
                expected="points one behind the other",
                remedy="Remove one of them, or look at the parameters that give them",
            )
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "material", material_of(self.material, self.title))
        self._check_sections()
        self._check_division(float(lengths.sum()))
        object.__setattr__(self, "nodes", self._places())

    def _check_sections(self) -> None:
        given = self.section if isinstance(self.section, list | tuple) else (self.section,)
        if not given or not all(isinstance(one, Section) for one in given):
            raise ModelError(
                self.title,
                found=f"section = {self.section!r:.80}",
                expected="a section, two for a taper, or one per point",
                remedy='Write section = { kind = "Section.tube", diameter = 0.05, wall = 0.003 }',
            )
        if len(given) not in (1, 2, len(self.points)):
            raise ModelError(
                self.title,
                found=f"{len(given)} sections for {len(self.points)} points",
                expected="1, or 2 for a taper" + (f", or {len(self.points)}" if len(self.points) > 2 else ""),
                remedy="Give one section, or one for each point",
            )
        object.__setattr__(self, "section", tuple(given))

    def _check_division(self, length: float) -> None:
        if self.size is not None and self.elements is not None:
            raise ModelError(
                self.title,
                found=f"size = {self.size!r} m and elements = {self.elements!r}",
                expected="one of them",
                remedy="Leave one out",
            )
        if self.elements is not None and (
            not is_number(self.elements) or self.elements != int(self.elements) or self.elements < 1
        ):
            raise ModelError(
                self.title,
                found=f"elements = {self.elements!r}",
                expected="a whole number of at least 1",
                remedy="Write elements = 20, or give size",
            )
        size = largest_size(self.size, self.title) if self.size is not None else np.inf
        check_count(self.elements or length / size, self.title, "beams")

    def _places(self) -> dict[str, tuple[float, ...]]:
        """Return the fractions of the named nodes, ascending."""
        if not isinstance(self.nodes, Mapping):
            raise ModelError(
                self.title,
                found=f"nodes = {self.nodes!r:.80}",
                expected="names with fractions of the length",
                remedy="Write nodes = { root = 0.0, tip = 1.0 }",
            )
        places = {}
        for name, value in self.nodes.items():
            fractions = finite_array(value).ravel()
            if not len(fractions) or fractions.min() < -CLOSE or fractions.max() > 1.0 + CLOSE:
                raise ModelError(
                    f"{self.title}, node '{name}'",
                    found=f"{value!r:.80}",
                    expected="a fraction 0..1 of the length of the line, or several",
                    remedy="A place y between y0 and y1 has the fraction (y - y0)/(y1 - y0)",
                )
            ordered = tuple(np.sort(np.clip(fractions, 0.0, 1.0)).tolist())
            if any(b - a <= CLOSE for a, b in pairwise(ordered)):
                raise ModelError(
                    f"{self.title}, node '{name}'",
                    found=f"the fraction {min(ordered[1:], default=0.0):g} twice among {value!r:.80}",
                    expected="different places",
                    remedy="Look at the parameters that give them",
                )
            places[str(name)] = ordered
        return places

    def finite_elements(self) -> FEModel:
        """Return the FE model of the line."""
        corners = np.asarray(self.points)
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
        fixed = along / along[-1]
        wanted = np.concatenate([fixed, *(np.array(f) for f in self.nodes.values())])
        places = _merged(wanted)
        size = self.size if self.size is not None else along[-1] / self.elements if self.elements else np.inf
        steps = np.diff(places) * along[-1]
        counts = np.maximum(1, np.ceil(steps / size * (1.0 - 1e-9))).astype(int)
        fractions = np.concatenate(
            [*(np.linspace(a, b, n, endpoint=False) for a, b, n in zip(places, places[1:], counts)), places[-1:]]
        )
        points = np.column_stack([np.interp(fractions, fixed, corners[:, k]) for k in range(3)])
        sets = {name: [int(np.argmin(np.abs(fractions - f))) for f in chosen] for name, chosen in self.nodes.items()}
        return frame(
            points,
            section=[self._section_at(f, fixed) for f in fractions],
            material=self.material,
            orientation=self.orientation,
            node_sets=sets,
            shear=self.shear,
            rotary_inertia=self.rotary_inertia,
            lumped=self.lumped,
            name=self.name or "line",
        )

    def _section_at(self, fraction: float, corners: np.ndarray) -> Section:
        given = self.section
        if len(given) == 1:
            return given[0]
        if len(given) == 2:
            return given[0].between(given[1], float(fraction))
        k = min(int(np.searchsorted(corners, fraction, side="right")) - 1, len(given) - 2)
        share = (fraction - corners[k]) / (corners[k + 1] - corners[k])
        return given[k].between(given[k + 1], float(np.clip(share, 0.0, 1.0)))


def _merged(fractions: np.ndarray) -> np.ndarray:
    """Return ascending fractions; of those closer than `CLOSE` the first one."""
    ordered = np.sort(fractions)
    return ordered[np.concatenate([[True], np.diff(ordered) > CLOSE])]
