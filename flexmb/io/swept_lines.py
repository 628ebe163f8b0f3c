"""Cables and beams for drawing: their cross-sections swept along the line, with the section forces as fields."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.bodies.line.sections import section_at
from flexmb.io.shape_surfaces import cut_into_triangles

__all__ = ["SweptLine", "section_outline"]

PER_ELEMENT = 4
"""Pieces of an element: it bends like a cubic."""
SIDES = 20


def section_outline(section: Any, round_section: bool = False) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the outer and inner outline (n, 2), m, y and z, of a section; the inner one of hollow sections, else None.

    A section of given values is drawn as the circle or rectangle with its radii of gyration.
    """
    kind, *sizes = section.shape
    if kind in ("solid_circle", "tube"):
        diameter = sizes[0]
        return _circle(diameter), _circle(diameter - 2.0 * sizes[1]) if kind == "tube" else None
    if kind == "rectangle":
        return _corners(*sizes[:2]), None
    if kind == "box":
        width, height, wall, web = sizes[:4]
        return _corners(width, height), _corners(width - 2.0 * web, height - 2.0 * wall)
    if kind == "i":
        width, height, flange, web = sizes[:4]
        y, z, u, v = 0.5 * width, 0.5 * height, 0.5 * web, 0.5 * height - flange
        outline = [
            (y, z),
            (-y, z),
            (-y, v),
            (-u, v),
            (-u, -v),
            (-y, -v),
            (-y, -z),
            (y, -z),
            (y, -v),
            (u, -v),
            (u, v),
            (y, v),
        ]
        return np.array(outline), None
    if round_section:
        return _circle(4.0 * np.sqrt(section.inertia_y / section.area)), None
    return _corners(*np.sqrt(12.0 * np.array([section.inertia_z, section.inertia_y]) / section.area)), None


def _circle(diameter: float) -> np.ndarray:
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    return 0.5 * diameter * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _corners(width: float, height: float) -> np.ndarray:
    return 0.5 * np.array([(width, height), (-width, height), (-width, -height), (width, -height)])


class SweptLine:
    """The surface of a cable or beam: outlines at stations along it, faces between them, caps at its ends.

    Parameters
    ----------
    body : AncfCable or AncfBeam

    Attributes
    ----------
    cells : tuple of (cell type, connectivity)
    fields : tuple of str
        Names of the scalars at the points: N, Q.., M.. in N and N m.
    """

    def __init__(self, body):
        self.body = body
        n = PER_ELEMENT * body.elements
        self.fractions = np.linspace(0.0, 1.0, n + 1)[: n if body.closed else None]
        self.fields = tuple(title.partition(" ")[0] for title in body.force_titles)
        is_round = not hasattr(body, "orientation")
        loops = [section_outline(section_at(body.sections, float(x)), is_round) for x in self.fractions]
        outer, inner = [loop[0] for loop in loops], [loop[1] for loop in loops if loop[1] is not None]
        hollow = len(inner) == len(outer) and len({len(loop) for loop in outer}) == 1
        if len({len(loop) for loop in outer}) > 1:  # a taper from one kind of shape to another: only its size is known
            outer = [
                _corners(*np.sqrt(12.0 * np.array([s.inertia_z, s.inertia_y]) / s.area))
                for s in (section_at(body.sections, float(x)) for x in self.fractions)
            ]
        self._build(np.array(outer), np.array(inner) if hollow else None)

    def _build(self, outer: np.ndarray, inner: np.ndarray | None) -> None:
        """Make points in the sections and cells: the sides of every face have points of their own,
        so edges stay sharp.
        """
        stations, n = outer.shape[:2]
        self.offsets: list[np.ndarray] = []
        self.station: list[np.ndarray] = []
        quads, triangles, self.count = [], [], 0
        for loop in (outer, inner):
            if loop is None:
                continue
            sharp = len(loop[0]) < SIDES
            sides = np.stack([np.arange(n), (np.arange(n) + 1) % n], axis=1)
            ring = sides.ravel() if sharp else np.arange(n)
            first = self._add(loop[:, ring], np.arange(stations))
            i, j = (np.arange(0, 2 * n, 2), np.arange(1, 2 * n, 2)) if sharp else (np.arange(n), (np.arange(n) + 1) % n)
            if loop is inner:
                i, j = j, i
            for k in range(stations if self.body.closed else stations - 1):
                a, b = first + k * len(ring), first + (k + 1) % stations * len(ring)
                quads.append(np.stack([a + i, a + j, b + j, b + i], axis=1))
        for end in () if self.body.closed else (0, stations - 1):
            first = self._add(outer[end][None], np.array([end]))
            if inner is None:
                faces = first + cut_into_triangles(outer[end])
                triangles.append(faces[:, ::-1] if end == 0 else faces)
            else:
                second, i = self._add(inner[end][None], np.array([end])), np.arange(n)
                j = (i + 1) % n
                ring_face = np.stack([first + i, first + j, second + j, second + i], axis=1)
                quads.append(ring_face[:, ::-1] if end == 0 else ring_face)
        self.cells = (("quad", np.vstack(quads)), *((("triangle", np.vstack(triangles)),) if triangles else ()))
        self.yz, self.of = np.concatenate(self.offsets), np.concatenate(self.station)

    def _add(self, loops: np.ndarray, stations: np.ndarray) -> int:
        """Add rings of points (stations, n, 2) and return the number of the first."""
        first = self.count
        self.offsets.append(loops.reshape(-1, 2))
        self.station.append(np.repeat(stations, loops.shape[1]))
        self.count += loops.shape[0] * loops.shape[1]
        return first

    def points(self, q: np.ndarray) -> np.ndarray:
        """Return the points (n, 3), m, in W for the body's coordinates q (nq,)."""
        r, axes = self.body.section_axes(q, self.fractions)
        return r[self.of] + np.einsum("nik,nk->ni", axes[self.of][:, :, 1:], self.yz)

    def values(self, q: np.ndarray) -> dict[str, np.ndarray]:
        """Return the section forces at the points by name, (n,)."""
        forces = self.body.section_forces(q, self.fractions)
        return {name: forces[self.of, k] for k, name in enumerate(self.fields)}
