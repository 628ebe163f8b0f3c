"""`Scene`: what is drawn of a solution, part by part, and where it is at each sample.

A drawn part is a mesh whose points are fixed to carriers. A carrier is an affine map to W at every time,
``x = r + A X``: the frame of a body, the axes of a marker, or a link, which stretches from one marker to another. The
nodes of a flexible body move in their carrier by its modes. A joint that a later phase has lost shrinks to nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from flexmb.errors import ModelError
from flexmb.io import solids
from flexmb.io.cell_types import skin_cells
from flexmb.io.contact_tiles import tiled_contacts
from flexmb.io.joint_glyphs import joint_glyphs, spring_glyph
from flexmb.io.plate_surfaces import PlateSurface
from flexmb.io.shape_surfaces import shape_surface
from flexmb.io.sharp_edges import with_sharp_edges
from flexmb.io.swept_lines import SweptLine
from flexmb.io.wrapped_ways import ends_between, place_on_way, way_pieces
from flexmb.results import recover

__all__ = ["DrawnPart", "Scene", "Snapshot"]


@dataclass(frozen=True, eq=False)
class DrawnPart:
    """A mesh that moves.

    Parameters
    ----------
    name : str
        Name of the body, or "joints", "springs", "supports".
    look : str
        "flexible", "rigid", "joints", "springs" or "supports": the viewer chooses the colour.
    points : (n, 3), m
        In the axes of the carriers.
    carrier : (n,) int
        Number of the carrier of each point.
    carriers : tuple
        ("body", name), ("marker", name), ("link", name a, name b) or ("way", ...) (see `wrapped_ways`), with the part
        they belong to at the end or None.
    cells : tuple of (meshio cell type, (ne, nn) int)
    data : ModalNeutralData, optional
        Modes of a flexible body; its nodes are the points.
    nodes : (n,) int, optional
        Those of its nodes that are the points; default: all.
    line : SweptLine or PlateSurface, optional
        Surface of a cable, beam or plate, which moves the points itself.
    tiles : ContactTiles, optional
        The points of a contact, which it moves.
    """

    name: str
    look: str
    points: np.ndarray
    carrier: np.ndarray
    carriers: tuple[tuple, ...]
    cells: tuple[tuple[str, np.ndarray], ...]
    data: Any = None
    nodes: Any = None
    line: Any = None
    tiles: Any = None


class Snapshot(NamedTuple):
    """Where a part is at one sample.

    points : (n, 3), m, in W. displacement : (n, 3), m, elastic part in W, or None. von_mises : (n,), Pa, or None.
    line : section forces of a cable, beam or plate, or the fields of a contact, by name, (n,), or None.
    """

    points: np.ndarray
    displacement: np.ndarray | None = None
    von_mises: np.ndarray | None = None
    line: dict[str, np.ndarray] | None = None


@dataclass(eq=False)
class Scene:
    """Parts and motion of a solution.

    Parameters
    ----------
    solution : Solution
        With its model.
    every : int
        Use every n-th sample; the last one is always there.
    stress : bool
        Evaluate the von Mises stress of bodies with stress modes.
    surface : bool
        Draw the skin of solid bodies only.

    Attributes
    ----------
    parts : tuple of DrawnPart
    samples : list of (phase number, sample number)
        Of two samples at one time (an event), the second.
    times : (nt,), s
        Of a path whose load goes down again, the numbers of the samples.
    """

    solution: Any
    every: int = 1
    stress: bool = True
    surface: bool = False
    parts: tuple[DrawnPart, ...] = field(init=False)
    samples: list[tuple[int, int]] = field(init=False)
    times: np.ndarray = field(init=False)
    size: float = field(init=False)
    _maps: dict = field(init=False, default_factory=dict, repr=False)

    def __post_init__(self):
        model = self.solution.model
        if model is None:
            raise ModelError(
                "Scene",
                found="the solution has no model",
                expected="a solution with its model",
                remedy="Load it with Solution.load(path, read_model=...)",
            )
        if self.every < 1:
            raise ModelError(
                "Scene",
                found=f"every = {self.every}",
                expected="a whole number >= 1",
                remedy="every=10 draws each tenth sample",
            )
        every = [(p, k) for p, phase in enumerate(self.solution.phases) for k in range(len(phase.t))]
        t = self.solution.t
        last_of_time = np.append(t[1:] != t[:-1], True)
        kept = [sample for sample, last in zip(every, last_of_time) if last]
        chosen = kept[:: self.every]
        self.samples = chosen if chosen[-1] == kept[-1] else [*chosen, kept[-1]]
        self.times = np.array([self.solution.phases[p].t[k] for p, k in self.samples])
        if np.any(np.diff(self.times) < 0.0):
            self.times = np.arange(len(self.samples), dtype=float)
        self.size = _size(model, self.solution)
        self.parts = (*_parts(model, _joint_size(model, self.size), self.surface), *_contacts(self.solution, model))

    def part(self, name: str) -> DrawnPart:
        """Return the part of this name."""
        return next(part for part in self.parts if part.name == name)

    def nearest(self, t: float) -> int:
        """Return the number of the frame whose time is nearest to `t`, s."""
        return int(np.argmin(np.abs(self.times - t)))

    def snapshot(self, part: DrawnPart, frame: int) -> Snapshot:
        """Return where the part is at one frame (index into `times`)."""
        phase, k = self.samples[frame]
        if part.tiles is not None:
            return Snapshot(part.tiles.points(phase, k), line=part.tiles.values(phase, k))
        if part.line is not None:
            q = self.solution.series(phase).coordinates(part.name)[0][k]
            return Snapshot(part.line.points(q), line=part.line.values(q))
        maps = [self._map(carrier, phase) for carrier in part.carriers]
        if part.data is not None:
            r, A = maps[0][0][k], maps[0][1][k]
            eta = self.solution.series(phase).modal_coordinates(part.name)[k]
            elastic = (recover.displacement(part.data, eta, part.nodes)[0]) @ A.T
            mises = None
            if self.stress and part.data.stress_modes is not None:
                mises = recover.von_mises(recover.stress(part.data, eta, part.nodes))[0]
            return Snapshot(r + part.points @ A.T + elastic, elastic, mises)
        r = np.array([m[0][k] for m in maps])[part.carrier]
        A = np.array([m[1][k] for m in maps])[part.carrier]
        return Snapshot(r + np.einsum("nij,nj->ni", A, part.points))

    def points(self, part: DrawnPart, frame: int, ids: np.ndarray, scale: float = 1.0) -> np.ndarray:
        """Return where some points of a part are at one frame, (len(ids), 3), m; `scale` magnifies elastic motion."""
        phase, k = self.samples[frame]
        if part.tiles is not None:
            return part.tiles.points(phase, k)[ids]
        if part.line is not None:
            return part.line.points(self.solution.series(phase).coordinates(part.name)[0][k])[ids]
        maps = [self._map(carrier, phase) for carrier in part.carriers]
        carrier, points = part.carrier[ids], part.points[ids]
        if part.data is not None:
            eta = self.solution.series(phase).modal_coordinates(part.name)[k]
            own = ids if part.nodes is None else part.nodes[ids]
            points = points + scale * recover.displacement(part.data, eta, own)[0]
        r, A = (np.array([m[i][k] for m in maps])[carrier] for i in (0, 1))
        return r + np.einsum("nij,nj->ni", A, points)

    def _map(self, carrier, phase: int):
        """Return r (nt, 3) and A (nt, 3, 3) of a carrier in a phase."""
        if (carrier, phase) not in self._maps:
            self._maps[carrier, phase] = self._make_map(carrier, self.solution.series(phase))
        return self._maps[carrier, phase]

    def _make_map(self, carrier, series):
        kind, *names, owner = carrier
        if kind == "body":
            q, _ = series.coordinates(names[0])
            return q[:, :3], recover.rotation_matrices(q[:, 3:7])
        motions = [series.marker(name) for name in names if isinstance(name, str)]
        if kind == "way":
            markers, radii, number, *shares = names
            ends = self._ends(markers, radii, series)
            around = ends[:, number], series.marker(markers[1 + number]), ends[:, number + 1]
            r, end = (place_on_way(*around, radii[number], share) for share in shares)
            return self._while_there(owner, series, r, _link_axes(end - r))
        r, A = motions[0].r, motions[0].R
        if kind == "link":
            A = _link_axes(motions[1].r - r)
        return self._while_there(owner, series, r, A)

    def _ends(self, markers, radii, series):
        """Return the ends of the pieces of a way, (nt, m + 1, 3); the same for all that is drawn of it."""
        known = ("ends", markers, radii, id(series))
        if known not in self._maps:
            self._maps[known] = series, ends_between([series.marker(name) for name in markers], radii)
        return self._maps[known][1]

    @staticmethod
    def _while_there(owner, series, r, A):
        """Return a map that draws nothing after its part has gone."""
        parts = (*series.model.joints, *series.model.forces)
        if owner is not None and owner not in {part.name for part in parts}:
            A = np.zeros_like(A)
        return r, A


def _link_axes(d):
    """Return matrices (nt, 3, 3) with the third column d and two unit vectors across it."""
    length = np.linalg.norm(d, axis=1)
    z = np.where(length[:, None] > 0.0, d / np.maximum(length, 1e-300)[:, None], (0.0, 0.0, 1.0))
    # one reference for all times, the axis that d is farthest from, so that the link does not spin
    reference = np.eye(3)[int(np.argmin(np.abs(z).max(axis=0)))]
    x = np.cross(reference, z)
    x /= np.maximum(np.linalg.norm(x, axis=1), 1e-12)[:, None]
    return np.stack([x, np.cross(z, x), d], axis=2)


def _size(model, solution) -> float:
    """Return the diagonal (m) of the box around all markers but the origin at the start."""
    series = solution.series(0)
    names = [name for name in model.marker_names() if name != "ground.origin"]
    r = np.array([series.marker(name).r[0] for name in names]) if names else np.zeros((1, 3))
    diagonal = float(np.linalg.norm(np.ptp(r, axis=0)))
    return diagonal if diagonal > 0.0 else 1.0


def _joint_size(model, size) -> float:
    """Return the size of a joint, m: a hundredth of the model, and small beside its parts, which may be many."""
    spans = []
    for body in model.bodies:
        r = np.array([pose.at for pose in body.marker_poses().values()]).reshape(-1, 3)
        span = float(np.linalg.norm(np.ptp(r, axis=0))) if len(r) and body.n_velocities else 0.0
        if span > 0.0:
            spans.append(span)
    return min(0.01 * size, 0.05 * float(np.median(spans))) if spans else 0.01 * size


def _parts(model, e, skin_only=False):
    """Yield the drawn parts of a model; `e` (m) is the size of a joint;
    with `skin_only` solids without their inside.
    """
    supports = []
    for body in model.bodies:
        poses = body.marker_poses()
        if body.drawn == "cells":
            data = recover.modal_data(body)
            nodes, cells = skin_cells(data.cells) if skin_only else (None, data.cells)
            points = data.nodes if nodes is None else data.nodes[nodes]
            carriers = (("body", body.name, None),)
            yield DrawnPart(body.name, "flexible", points, np.zeros(len(points), int), carriers, cells, data, nodes)
        elif body.drawn == "supports":
            used = {m for part in (*model.joints, *model.forces) if _joins(part) for m in _markers(part, model)}
            supports += [f"{body.name}.{m}" for m in poses if f"{body.name}.{m}" in used]
            if body.shape:
                yield _fixed(body.name, "supports", _shapes(body, next(iter(poses))))
        elif body.drawn == "line":
            line = SweptLine(body)
            points = line.points(body.initial_state()[0])
            yield DrawnPart(body.name, "flexible", points, np.zeros(len(points), int), (), line.cells, line=line)
        elif body.drawn == "sheet":
            sheet = PlateSurface(body)
            points = sheet.points(body.initial_state()[0])
            yield DrawnPart(body.name, "flexible", points, np.zeros(len(points), int), (), sheet.cells, line=sheet)
        elif getattr(body, "shape", ()):
            yield _fixed(body.name, "rigid", _shapes(body, ""))
        else:
            if _has_surface(model, body):  # it is drawn
                continue
            surface = _rigid_shape(body, poses, e)
            if body.has_frame:
                yield _fixed(body.name, "rigid", [(("body", body.name, None), surface)])
            else:
                center = next(iter(poses))
                yield _fixed(body.name, "rigid", [(("marker", f"{body.name}.{center}", None), solids.sphere(2 * e))])
    yield from _surfaces(model, e)
    if supports:
        foot = solids.box((3.4 * e, 3.4 * e, 1.4 * e))
        yield _fixed("supports", "supports", [(("marker", name, None), foot) for name in supports])
    glyphs = [
        (_carrier(end, joint.resolved_markers(model), joint.name), surface)
        for joint in model.joints
        for end, surface in joint_glyphs(joint, e)
    ]
    if glyphs:
        yield _fixed("joints", "joints", glyphs)
    springs = [
        (("link", *force.markers, force.name), spring_glyph(e))
        for force in model.forces
        if len(getattr(force, "markers", None) or ()) == 2 and _joins(force)
    ]
    springs += [piece for force in model.forces if hasattr(force, "through") for piece in way_pieces(force, e)]
    if springs:
        yield _fixed("springs", "springs", springs)


def _surfaces(model, e):
    """Yield the surfaces that can touch; of a half-space a square as large as the model."""
    taken = {body.name for body in model.bodies}
    for own in model.surfaces:
        if not hasattr(own, "shape"):  # a skin: its body is drawn
            continue
        points, triangles = own.shape.drawing()
        points = points if np.isfinite(own.shape.reach) else 50.0 * e * points
        drawn = solids.Surface(*with_sharp_edges(points, np.asarray(triangles)), np.zeros((0, 4), int))
        name = f"{own.name}_surface" if own.name in taken else own.name
        look = "rigid" if model.marker(own.marker)[0].n_velocities else "supports"
        yield _fixed(name, look, [(("marker", own.marker, None), drawn)])


def _contacts(solution, model):
    """Yield the contacts with areas, as squares at their points."""
    taken = {part.name for part in (*model.bodies, *model.surfaces)}
    for tiles in tiled_contacts(solution):
        name = f"{tiles.name}_contact" if tiles.name in taken else tiles.name
        count = 4 * len(tiles.chosen)
        places = tiles.corners.reshape(-1, 3)
        yield DrawnPart(name, "contact", places, np.zeros(count, int), (), tiles.cells, tiles=tiles)


def _has_surface(model, body) -> bool:
    """Has the body a surface of finite size, which shows what it looks like, and no joint or force elsewhere on it?"""
    own = [s for s in model.surfaces if hasattr(s, "shape") and s.marker.partition(".")[0] == body.name]
    near = {s.marker.partition(".")[2] for s in own if np.isfinite(s.shape.reach)}
    used = {m for part in (*model.joints, *model.forces) if _joins(part) for m in _markers(part, model) if m}
    there = {m.partition(".")[2] for m in used if m.partition(".")[0] == body.name}
    return bool(near) and there <= near | {"center"}


def _joins(part) -> bool:
    """Does the part run from marker to marker? A contact along an axis of its first marker is where the
    shapes touch.
    """
    return getattr(part, "along", None) not in ("x", "y", "z") or hasattr(part, "curve")


def _shapes(body, default):
    """Return the pieces (carrier, surface) of a body's shapes: on markers, or in its own axes."""
    for shape in body.shape:
        on = shape.on or default
        carrier = ("marker", f"{body.name}.{on}", None) if on else ("body", body.name, None)
        yield carrier, shape_surface(shape)


def _carrier(end, markers, owner):
    return ("link", *markers, owner) if end == "link" else ("marker", markers["ab".index(end)], owner)


def _markers(part, model):
    if hasattr(part, "resolved_markers"):
        return part.resolved_markers(model)
    return getattr(part, "markers", None) or getattr(part, "through", None) or (getattr(part, "marker", None),)


def _fixed(name, look, pieces) -> DrawnPart:
    """Make a part of pieces (carrier, surface)."""
    pieces = list(pieces)
    carriers = tuple(dict.fromkeys(carrier for carrier, _ in pieces))
    surface = solids.joined(piece for _, piece in pieces)
    numbers = np.concatenate([np.full(len(piece.points), carriers.index(carrier)) for carrier, piece in pieces])
    return DrawnPart(name, look, surface.points, numbers, carriers, surface.cells)


def _rigid_shape(body, poses, e) -> solids.Surface:
    """Return tubes between the centre of mass and the markers, and balls at their ends.

    Two markers in line with the centre are one straight rod then. Bodies without markers beside the centre get the
    box with the same inertia.
    """
    center = np.array(next(iter(poses.values())).at)
    ends = [np.array(pose.at) for pose in poses.values()]
    far = [end for end in ends if np.linalg.norm(end - center) > e]
    if not far:
        return solids.box(_inertia_box(body, e)).moved(at=center)
    pieces = [solids.tube(center, end, 0.8 * e) for end in far]
    pieces += [solids.sphere(1.1 * e, at) for at in (center, *far)]
    return solids.joined(pieces)


def _inertia_box(body, e):
    """Return the edges (3,), m, of the homogeneous box with the body's mass and moments: x2 = 6 (Jy + Jz - Jx)/m."""
    J = np.diag(np.asarray(getattr(body, "inertia", np.zeros((3, 3))), float))
    edges = np.sqrt(np.maximum(6.0 * (J.sum() - 2.0 * J) / body.mass, 0.0))
    return np.clip(edges, 2.0 * e, 40.0 * e)  # inertias may be formal numbers: the box stays below half the mechanism
