"""Places of markers on plates: position and two directions as sums of nodal vectors,
at a point or as mean of a line.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flexmb.bodies.plate.data import bilinear, hermite_plate
from flexmb.errors import ModelError
from flexmb.model.described import entries_of, is_number
from flexmb.model.pose import rotation3

__all__ = ["Place", "add_masses", "at_point", "checked_masses", "functional", "place_of", "row_starts"]

MEAN = "mean"


class Place(NamedTuple):
    """Two fractions, one of which may be "mean", and a rotation (3, 3) or None."""

    s: Any
    t: Any
    rotation: Any


def place_of(value, name: str, title: str) -> Place:
    """Return the checked place of a marker."""
    parts = value if isinstance(value, tuple | list) and len(value) == 2 else (None, None)
    where, rotation = (parts[0], parts[1]) if isinstance(parts[0], tuple | list) else (parts, None)
    good = len(where) == 2 and all(
        z == MEAN if isinstance(z, str) else isinstance(z, int | float | np.number) and 0.0 <= z <= 1.0 for z in where
    )
    if not good or list(where).count(MEAN) > 1:
        raise ModelError(
            title,
            found=f"marker {name} at {value!r}",
            expected='two fractions (s, t), 0 to 1, one of which may be "mean", or ((s, t), rotation)',
            remedy=f"Write markers={{'{name}': (1.0, 0.5)}}",
        )
    s, t = where
    return Place(s, t, None if rotation is None else rotation3(rotation, title, f"rotation of marker {name}"))


def at_point(plate, s: float, t: float):
    """Return nodes (4,), coefficients (4, vectors, 3) of r and the two directions, and the speeds along s and t."""
    e, x, y = plate.element_at(s, t)
    nodes = plate.surface.cells[e]
    r = plate.surface.r[nodes]
    if plate.shear:
        N = bilinear(x, y)
        speed = np.linalg.norm(N[1:] @ r, axis=1)
        weights = np.zeros((4, 2, 3))
        weights[:, 0, 0], weights[:, 1, 1], weights[:, 0, 2] = N[0], N[0], N[1] / speed[0]
        return nodes, weights, speed
    N = hermite_plate(x, y, plate.surface.lengths[[e]])[0, :3]
    q = np.concatenate([r[:, None], plate.surface.tangents[nodes]], axis=1).reshape(12, 3)
    weights = np.zeros((4, 3, 3))
    weights[:, :, 0] = N[0].reshape(4, 3)
    # not the tangents of the interpolated surface: what a constant moment on an edge does to the nodes is work on these
    weights[:, 1, 1] = weights[:, 2, 2] = bilinear(x, y)[0]
    return nodes, weights, np.linalg.norm(N[1:] @ q, axis=1)


def functional(plate, place: Place) -> tuple[np.ndarray, np.ndarray]:
    """Return the nodes (k,) that move a marker, and their coefficients (k, vectors, 3) of r and of two directions.

    The directions are r_s and r_t of a thin plate, d and r_s of a shear-deformable one.
    """
    if MEAN not in place[:2]:
        samples = [(float(place.s), float(place.t), 1.0)]
    else:
        along = 0 if place.s == MEAN else 1
        n, (x, w) = plate.elements[along], np.polynomial.legendre.leggauss(3)
        at = ((np.arange(n)[:, None] + 0.5 * (1.0 + x)) / n).ravel()
        samples = [
            (z, float(place.t), p) if along == 0 else (float(place.s), z, p)
            for z, p in zip(at, np.tile(w, n), strict=True)
        ]
    total: dict[int, np.ndarray] = {}
    length = 0.0
    for s, t, weight in samples:
        nodes, coefficients, speed = at_point(plate, s, t)
        share = weight * (speed[0 if place.s == MEAN else 1] if MEAN in place[:2] else 1.0)
        length += share
        for node, own in zip(nodes, coefficients, strict=True):
            total[int(node)] = total.get(int(node), 0.0) + share * own
    weights = {node: own / length for node, own in total.items() if np.abs(own).max() > 1e-12 * length}
    kept = np.array(sorted(weights))
    own = np.array([weights[node] for node in kept])
    own[np.abs(own) < 1e-14] = 0.0
    return kept, own


def row_starts(nodes, pairs, size: int) -> np.ndarray:
    """Return where each node's rows begin in the columns of each other one, (k k,): see `_row_start` of the kernels."""

    def start(a: int, b: int) -> int:
        if a == b:
            return -1 - a
        return 2 * size * pairs[min(a, b), max(a, b)] + (0 if a < b else size)

    return np.array([start(int(a), int(b)) for a in nodes for b in nodes], float)


def checked_masses(given: Any, title: str) -> tuple[tuple[tuple[float, float], float], ...]:
    """Return pairs ((s, t), mass in kg); ModelError for anything else."""
    masses = []
    for pair in entries_of(given):
        good = isinstance(pair, tuple | list) and len(pair) == 2 and np.shape(pair[0]) == (2,)
        flat = (*pair[0], pair[1]) if good else ()
        if (
            not good
            or not all(is_number(z) for z in flat)
            or flat[2] <= 0.0
            or not 0.0 <= min(flat[:2]) <= max(flat[:2]) <= 1.0
        ):
            raise ModelError(
                title,
                found=f"lumped mass {pair!r}",
                expected="((s, t), mass > 0 in kg), s and t from 0 to 1",
                remedy="Write lumped_masses=[((0.5, 0.5), 2.0)]",
            )
        s, t, mass = flat
        masses.append(((float(s), float(t)), float(mass)))
    return tuple(masses)


def add_masses(plate, heads: np.ndarray) -> None:
    """Add the lumped masses to masses and moments of the elements (ne, V (V + 2)) where they are."""
    V = 4 * plate.vectors
    for (s, t), mass in plate.lumped_masses:
        e = plate.element_at(s, t)[0]
        N = at_point(plate, s, t)[1][:, :, 0].ravel()
        heads[e, : V * V] += mass * np.outer(N, N).ravel()
        heads[e, V * V : V * V + V] += mass * N
