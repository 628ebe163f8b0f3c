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
from flexmb.io.drawn_parts import DrawnPart, drawn_contacts, drawn_parts
from flexmb.io.wrapped_ways import ends_between, place_on_way
from flexmb.results import recover

__all__ = ["Scene", "Snapshot"]


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
        self.parts = (*drawn_parts(model, self.size, self.surface), *drawn_contacts(self.solution, model))

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
            if self.stress and part.data.has_stress:
                mises = recover.von_mises(recover.stress(part.data, eta, part.nodes))[0]
                there = part.data.stressed if part.nodes is None else part.data.stressed[part.nodes]
                mises = np.where(there, mises, np.nan)
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
