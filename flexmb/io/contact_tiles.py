"""`ContactTiles`: what happens at the points of a contact, as small squares with fields."""

from __future__ import annotations

import numpy as np

from flexmb.results.wear import sliding_of

__all__ = ["FIELDS", "ContactTiles", "tiled_contacts"]

FIELDS = ("pressure", "slip", "pressure_times_way")
"""Pa; m/s; N/m, which times the coefficient of wear, m2/N, is the depth worn off."""


class ContactTiles:
    """A square for every point of a contact that touches at one sample at least, as large as its area.

    Parameters
    ----------
    name : str
        Of the force.
    solution : Solution
    """

    def __init__(self, name: str, solution):
        self.name, self.solution = name, solution
        phases = [number for number, phase in enumerate(solution.phases) if _contact(phase.model, name)]
        model = solution.phases[phases[0]].model
        markers, table = model.force(name).points(model)
        self.spots = {p: list(solution.phases[p].model.force(name).spots(solution.series(p))) for p in phases}
        touched = [spots.point for own in self.spots.values() for spots in own]
        self.chosen = np.unique(np.concatenate([np.zeros(0, int), *touched]))
        self.markers = [markers[k] for k in self.chosen]
        slid = [np.broadcast_to(total, len(table))[self.chosen] for total in sliding_of(solution, name)]
        ends = np.cumsum([0] + [len(phase.t) for phase in solution.phases])
        self.slid = {p: slid[ends[p] : ends[p + 1]] for p in range(len(solution.phases))}
        self.corners = _squares(table[self.chosen])
        n = len(self.chosen)
        self.cells = (("quad", np.arange(4 * n).reshape(n, 4)),)

    def points(self, phase: int, k: int) -> np.ndarray:
        """Return the corners of all squares at a sample, (4 n, 3), m, in W."""
        series = self.solution.series(phase)
        motions = [series.marker(name) for name in self.markers]
        r = np.array([motion.r[k] for motion in motions]).reshape(-1, 3)
        R = np.array([motion.R[k] for motion in motions]).reshape(-1, 3, 3)
        return (r[:, None] + np.einsum("nij,ncj->nci", R, self.corners)).reshape(-1, 3)

    def values(self, phase: int, k: int) -> dict[str, np.ndarray]:
        """Return the fields at a sample, (4 n,)."""
        found = {name: np.zeros(len(self.chosen)) for name in FIELDS}
        found["pressure_times_way"] = self.slid[phase][k]
        if phase in self.spots:
            spots = self.spots[phase][k]
            at = np.searchsorted(self.chosen, spots.point)
            np.maximum.at(found["pressure"], at, spots.pressure)
            np.maximum.at(found["slip"], at, spots.slip)
        return {name: np.repeat(values, 4) for name, values in found.items()}

    def largest(self) -> float:
        """Return the largest pressure of the run, Pa."""
        return max((float(s.pressure.max()) for own in self.spots.values() for s in own if len(s.point)), default=0.0)


def tiled_contacts(solution) -> list[ContactTiles]:
    """Return the squares of all contacts with areas that touch at some sample."""
    names = [force.name for phase in solution.phases if phase.model for force in phase.model.forces]
    found = []
    for name in dict.fromkeys(names):
        if any(_contact(phase.model, name) for phase in solution.phases):
            tiles = ContactTiles(name, solution)
            found += [tiles] if len(tiles.chosen) else []
    return found


def _contact(model, name: str) -> bool:
    """Has a model a contact with areas of this name?"""
    forces = () if model is None else model.forces
    return any(force.name == name and hasattr(force, "spots") and force.law.sampled for force in forces)


def _squares(table: np.ndarray) -> np.ndarray:
    """Return the corners (n, 4, 3) of squares at places (3), across normals (3), of given areas: (n, 7)."""
    places, normals, side = table[:, :3], table[:, 3:6], np.sqrt(table[:, 6])
    least = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    x = np.cross(least, normals)
    x *= (0.5 * side / np.linalg.norm(x, axis=1))[:, None]
    y = np.cross(normals, x)
    return np.stack([places - x - y, places + x - y, places + x + y, places - x + y], axis=1)
