"""Which points of surfaces touch at the samples of a run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flexmb.model.spots import ALONE, Spots
from flexmb.surfaces.detection import find_areas, find_closest
from flexmb.surfaces.neighbours import near_among
from flexmb.surfaces.records import CONTACT, FAR, HEADER

__all__ = ["sampled_points", "surface_spots"]


def _sampled(force, model) -> dict[str, tuple]:
    """Return the sampled surfaces of a contact by name, each with the number of its first point, in order."""
    found, first = {}, 0
    surfaces = force.members(model)[0] if force.crowded(model) else [s for pair in force.pairs(model) for s in pair]
    for surface in surfaces:
        if len(surface.points[0]) and surface.name not in found:
            found[surface.name] = surface, first
            first += len(surface.points[0])
    return found


def _near(force, series) -> list[tuple]:
    """Return the pairs of surfaces of a crowd that are near each other at any sample."""
    surfaces, side, body = force.members(series.model)
    reach = np.array([min(s.shape.reach, FAR) for s in surfaces])
    places = np.stack([series.marker(s.marker).r for s in surfaces], axis=1)
    found: dict[tuple[int, int], None] = {}
    for at in places:
        found |= dict.fromkeys(map(tuple, near_among(np.ascontiguousarray(at), reach, side, body).tolist()))
    return [(surfaces[i], surfaces[j]) for i, j in sorted(found)]


def sampled_points(force, model) -> tuple[list[str], np.ndarray]:
    """Return the markers of the points of a contact, and places, normals and areas (n, 7) in their axes."""
    names, tables = [], [np.zeros((0, 7))]
    for surface, _ in _sampled(force, model).values():
        count = len(surface.points[0])
        own = HEADER + surface.shape.numbers().size
        names += [surface.marker] * count
        tables.append(surface.packed[own : own + 7 * count].reshape(-1, 7))
    return names, np.concatenate(tables)


def surface_spots(force, series) -> Iterator[Spots]:
    """Yield what touches at every sample of a phase; a law that acts at one point has no area and no listed points."""
    model, law = series.model, force.law
    own = law.numbers()
    firsts = {name: first for name, (_, first) in _sampled(force, model).items()}
    pairs = []
    for a, b in _near(force, series) if force.crowded(model) else force.pairs(model):
        contacts = np.zeros(len(a.points[0]) + len(b.points[0]) + 2, CONTACT)
        markers = series.marker(a.marker), series.marker(b.marker)
        apart = np.linalg.norm(markers[1].r - markers[0].r, axis=1)
        near = apart < a.shape.reach + b.shape.reach
        pairs.append((a, b, np.concatenate([a.packed, b.packed]), contacts, *markers, near))
    find = find_areas if law.sampled else find_closest
    for k in range(len(series.t)):
        rows = [np.zeros((0, 5))]
        for a, b, data, contacts, first, second, near in pairs:
            if not near[k]:
                continue
            R, between = first.R[k], second.r[k] - first.r[k]
            d, w = R.T @ between, R.T @ (second.w[k] - first.w[k])
            V = R.T @ (second.v[k] - first.v[k] - np.cross(first.w[k], between))
            count = find(data, 0, len(a.packed), 0.0, d, np.ascontiguousarray(R.T @ second.R[k]), contacts)
            if not count:
                continue
            found = contacts[:count]
            u = V + np.cross(w, found["x"] - d)
            along = np.einsum("ij,ij->i", u, found["n"])
            pressure = own["stiffness"] * (-found["gap"]) ** own["exponent"]
            pressure = pressure * np.maximum(1.0 - own["damping"] * along, 0.0)
            slip = np.linalg.norm(u - along[:, None] * found["n"], axis=1)
            of_b = found["sample"] > 0
            number = np.where(of_b, firsts.get(b.name, 0), firsts.get(a.name, 0)) + np.abs(found["sample"]) - 1
            number = number if law.sampled else np.full(count, ALONE)
            rows.append(np.column_stack([number, -found["gap"], pressure, slip, found["area"]]))
        found = np.concatenate(rows)
        yield Spots(found[:, 0].astype(int), *found[:, 1:].T)
