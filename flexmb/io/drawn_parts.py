"""What is drawn of a model: `DrawnPart`s, meshes whose points are fixed to carriers (see `scene`)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.io import solids
from flexmb.io.cell_types import skin_cells
from flexmb.io.contact_tiles import tiled_contacts
from flexmb.io.joint_glyphs import joint_glyphs, spring_glyph
from flexmb.io.plate_surfaces import PlateSurface
from flexmb.io.shape_surfaces import shape_surface
from flexmb.io.sharp_edges import with_sharp_edges
from flexmb.io.swept_lines import SweptLine
from flexmb.io.wrapped_ways import way_pieces
from flexmb.results import recover

__all__ = ["DrawnPart", "drawn_contacts", "drawn_parts", "surface_part"]


ALIKE = 0.05
"""Difference of the ends of a surface and a shape, relative to its size, up to which one of both is drawn."""


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


def _joint_size(model, size) -> float:
    """Return the size of a joint, m: a hundredth of the model, and small beside its parts, which may be many."""
    spans = []
    for body in model.bodies:
        r = np.array([pose.at for pose in body.marker_poses().values()]).reshape(-1, 3)
        span = float(np.linalg.norm(np.ptp(r, axis=0))) if len(r) and body.n_velocities else 0.0
        if span > 0.0:
            spans.append(span)
    return min(0.01 * size, 0.05 * float(np.median(spans))) if spans else 0.01 * size


def drawn_parts(model, size, skin_only=False):
    """Yield the drawn parts of a model of this size, m; with `skin_only` solids without their inside."""
    e = _joint_size(model, size)
    supports = []
    for body in model.bodies:
        if body.drawn == "supports":
            used = {m for part in (*model.joints, *model.forces) if _joins(part) for m in _markers(part, model)}
            supports += [f"{body.name}.{m}" for m in body.marker_poses() if f"{body.name}.{m}" in used]
        yield from _bodies(model, body, e, skin_only)
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


def _bodies(model, body, e, skin_only):
    """Yield what is drawn of a body: one part or none."""
    poses = body.marker_poses()
    if body.drawn == "cells":
        data = recover.modal_data(body)
        nodes, cells = skin_cells(data.cells) if skin_only else (None, data.cells)
        points = data.nodes if nodes is None else data.nodes[nodes]
        carriers = (("body", body.name, None),)
        yield DrawnPart(body.name, "flexible", points, np.zeros(len(points), int), carriers, cells, data, nodes)
    elif body.drawn == "supports":
        if body.shape:
            yield _fixed(body.name, "supports", _shapes(body, next(iter(poses))))
    elif body.drawn in ("line", "sheet"):
        line = SweptLine(body) if body.drawn == "line" else PlateSurface(body)
        points = line.points(body.initial_state()[0])
        yield DrawnPart(body.name, "flexible", points, np.zeros(len(points), int), (), line.cells, line=line)
    elif getattr(body, "shape", ()) and not _shown_by_surfaces(model, body, poses):
        yield _fixed(body.name, "rigid", _shapes(body, ""))
    elif not getattr(body, "shape", ()) and not _has_surface(model, body):  # which is drawn
        surface = _rigid_shape(body, poses, e)
        if body.has_frame:
            yield _fixed(body.name, "rigid", [(("body", body.name, None), surface)])
        else:
            center = next(iter(poses))
            yield _fixed(body.name, "rigid", [(("marker", f"{body.name}.{center}", None), solids.sphere(2 * e))])


def _surfaces(model, e):
    """Yield the surfaces that can touch; of a half-space a square as large as the model, and than any of them."""
    taken = {body.name for body in model.bodies}
    reaches = [own.shape.reach for own in model.surfaces if hasattr(own, "shape")]
    half = max(50.0 * e, 2.0 * max((reach for reach in reaches if np.isfinite(reach)), default=0.0))
    for own in model.surfaces:
        if not hasattr(own, "shape"):  # a skin: its body is drawn
            continue
        points, triangles = own.shape.drawing()
        points = points if np.isfinite(own.shape.reach) else half * points
        drawn = solids.Surface(*with_sharp_edges(points, np.asarray(triangles)), np.zeros((0, 4), int))
        look = "rigid" if model.marker(own.marker)[0].n_velocities else "supports"
        yield _fixed(surface_part(own, taken), look, [(("marker", own.marker, None), drawn)])


def surface_part(own, bodies: set[str]) -> str:
    """Return the name under which a surface is drawn, beside the names of the bodies."""
    return f"{own.name}_surface" if own.name in bodies else own.name


def drawn_contacts(solution, model):
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


def _shown_by_surfaces(model, body, poses) -> bool:
    """Is a surface of finite size drawn where the shapes of a body are, from one end to the other in all directions?"""
    own = [s for s in model.surfaces if hasattr(s, "shape") and s.marker.partition(".")[0] == body.name]
    surfaces = [(s.shape.drawing()[0], poses[s.marker.partition(".")[2]]) for s in own if np.isfinite(s.shape.reach)]
    shapes = [(shape_surface(shape).points, poses[shape.on] if shape.on else None) for shape in body.shape]
    if not surfaces:
        return False
    ends = []
    for solid in (surfaces, shapes):
        points = np.vstack([p if pose is None else p @ pose.matrix.T + pose.at for p, pose in solid])
        ends.append(np.array([points.min(axis=0), points.max(axis=0)]))
    return bool(np.abs(ends[1] - ends[0]).max() <= ALIKE * np.ptp(ends[1], axis=0).max())


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
