"""Which lengths count: those over which bodies act on each other, not the coordinates at which they happen to be.

A tolerance is a share of a length. The box around everything says nothing about a spacecraft of two bodies whose ground
is the centre of the Earth, nor about an elastic body whose only marker coincides with its hub's. Bodies that joints and
forces connect are one assembly. Its length is the largest distance between markers of its bodies and nodes of the
elastic ones. It does not depend on the axes of W. Where these have no extent (a point mass on a rod or a spring, a
rotor), the distances over which joints hold it count (of an equation that reads coordinates in W, that from its
origin); then the distances of forces; then the radius of gyration (a body
that flies by itself); then the largest distance between all markers; then 1 m.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from flexmb.errors import ModelError
from flexmb.math.rotations import euler_to_matrix
from flexmb.told import tell

__all__ = [
    "OFF",
    "ROUNDED",
    "Lengths",
    "described_lengths",
    "displacements",
    "from_own_axes",
    "require_places",
    "unit_lengths",
    "velocity_units",
    "warn_of_lost_digits",
]

NOTHING = 1e-9
"""Of all distances that occur in an assembly: a smaller extent is rounding, and no length."""
ROUNDED = 1e2 * np.finfo(float).eps
"""Relative to the largest coordinate: positions are known to this, after a few sums."""


LOST = 1e-9
"""Rounding of positions, relative to the length of their assembly, from which it is said."""


OFF = 100.0
"""Distance of an elastic body from the origin of its own axes, relative to its size, from which it is said."""
FARTHEST = 1e60
"""Largest coordinate, m: powers of it are still finite."""


CHUNK = 500
"""Points whose distances from all others are found at once."""
CORNERS = np.array([[bool(k >> i & 1) for i in range(3)] for k in range(8)])
"""Of a box: where a coordinate is the largest."""
FEW = 32
"""Points of which all distances are found at once: looking for the outer ones takes longer."""


class Lengths(NamedTuple):
    """Lengths of a system.

    bodies (nb,) : of the assembly to which each body of the model belongs, m; the ground has the largest
    whole : the largest of them, m
    coordinates (nb,) : largest distance of a body's markers from the origin of W, m
    equations (ng,) : what the residual of each equation is compared with: m, or 1 for angles
    are_lengths (ng,) : of bool
    related (ng,) : extent of the largest body that each equation relates, m; of its assembly where they have none
    """

    bodies: np.ndarray
    whole: float
    coordinates: np.ndarray
    equations: np.ndarray
    are_lengths: np.ndarray
    related: np.ndarray

    @property
    def rounding(self) -> float:
        """Distance, m, to which positions are known at these coordinates."""
        return ROUNDED * float(np.max(self.coordinates, initial=0.0))

    @property
    def digits(self) -> float:
        """Rounding of positions, relative to the lengths."""
        return float(np.finfo(float).eps * (1.0 + np.max(self.coordinates / self.bodies, initial=0.0)))


def unit_lengths(n_bodies: int, n_equations: int) -> Lengths:
    """Return lengths of 1 m, before any are known."""
    return Lengths(
        np.ones(n_bodies),
        1.0,
        np.zeros(n_bodies),
        np.ones(n_equations),
        np.zeros(n_equations, bool),
        np.ones(n_equations),
    )


def described_lengths(system, inertia: np.ndarray, forces: np.ndarray) -> Lengths:
    """Return the lengths of a system as described.

    Parameters
    ----------
    inertia : (nu,)
        Diagonal of the mass matrix.
    forces : (ng,) of bool
        Which equations have forces as multipliers: their residuals are lengths.
    """
    bodies, markers = system.model.bodies, system.tables["markers"]
    own = [markers["r"][places] for places in _places_of(markers["body"], len(bodies))]
    points = [np.vstack([r, _nodes(system, body)]) for r, body in zip(own, bodies, strict=True)]
    require_places(bodies, points)
    held = np.array([system.marker_index[m] for j in system.model.joints for m in j.places(system.model)], int)
    ties, holds = _ties(system), np.stack([system.tables["pairs"][x] for x in "ab"], axis=1)
    holds = holds[np.all(markers["body"][holds] < len(bodies), axis=1)]  # states are nowhere
    moves = np.array([body.n_velocities > 0 for body in bodies])
    assembly = _assemblies(np.minimum(markers["body"], len(bodies) - 1), np.vstack([ties, holds]), moves)
    assembly = np.where(moves, assembly, -1)
    apart = _longest(markers, assembly, ties, holds, held)
    found = np.zeros(len(bodies))
    for number, members in enumerate(_places_of(assembly, int(assembly.max(initial=-1)) + 1)):
        if len(members):
            found[members] = _length(system, members, points, apart[:, number], inertia)
    whole = float(np.max(found, initial=0.0)) or _diameter(markers["r"]) or 1.0
    found[found == 0.0] = whole
    longest = _of_legs(system, np.where(moves, found, 0.0))
    longest[longest == 0.0] = whole
    coordinates = np.array([np.abs(p).max(initial=0.0) for p in points])
    extents = np.array([_diameter(p) if m else 0.0 for p, m in zip(points, moves, strict=True)])
    extents[extents <= np.maximum(NOTHING * found, ROUNDED * coordinates)] = 0.0
    related = _of_legs(system, extents)
    related = np.where(related > 0.0, related, longest)
    return Lengths(found, whole, coordinates, np.where(forces, longest, 1.0), forces, related)


def _of_legs(system, lengths: np.ndarray) -> np.ndarray:
    """Return the largest of the lengths (nb,) of the bodies that each equation relates, (ng,)."""
    legs, largest = system.tables["legs"], np.zeros(system.ng)
    np.maximum.at(largest, legs["equation"], lengths[system.tables["markers"]["body"][legs["marker"]]])
    return largest


def require_places(bodies, points: list[np.ndarray]) -> None:
    """Raise unless squares of coordinates are finite: distances could not be distinguished."""
    for body, own in zip(bodies, points, strict=True):
        farthest = float(np.abs(own).max(initial=0.0))
        if not farthest <= FARTHEST:
            raise ModelError(
                f"Body '{body.name}'",
                found=f"a point with the coordinate {farthest:.3g} m",
                expected=f"places within {FARTHEST:.0e} m of the origin",
                remedy="Check the exponents of its position, rotation and markers",
            )


def velocity_units(system, lengths: Lengths, inertia: np.ndarray) -> np.ndarray:
    """Return what makes increments of the velocities (nu,) comparable: displacements per length, and radians.

    Flexible coordinates count by the root mean square displacement of the material, sqrt(M_jj / m), nodal gradients
    likewise beside the positions of their node.
    """
    units = np.ones(system.nu)
    for body, length in zip(system.model.bodies, lengths.bodies, strict=True):
        span = system.body_slices[body.name][1]
        if span.stop == span.start:
            continue
        own = inertia[span]
        units[span] = displacements(body, own) / length
        if body.has_frame:
            units[span.start + 3 : span.start + 6] = 1.0
    return units


def displacements(body, inertia: np.ndarray) -> np.ndarray:
    """Return the displacement (m) of a body's material per unit of each velocity, root mean square, (n,).

    `inertia` (n,) is the diagonal of its mass matrix.
    """
    if not body.has_frame and body.block_size < body.n_vector:
        # nodes: their positions count as they are, their gradients with the material around the node
        blocks = inertia.reshape(-1, body.block_size)
        return np.sqrt(blocks / np.maximum(blocks[:, :1], np.finfo(float).tiny)).ravel()
    found = np.sqrt(inertia / inertia[0]) if inertia[0] > 0.0 else np.ones(len(inertia))
    if body.has_frame:
        found[:3] = 1.0
    return found


def _nodes(system, body) -> np.ndarray:
    """Return the points (k, 3), m, in W of an elastic body as described: its nodes, or the corners of their box."""
    q = system.q0[system.body_slices[body.name][0]]
    if not body.has_frame:
        vectors = q.reshape(-1, 3)
        return vectors[np.arange(len(vectors)) % max(1, body.block_size // 3) == 0]
    least, most = body.bounds()
    corners = np.where(CORNERS, most, least)
    R = np.eye(3)
    euler_to_matrix(q[3:7], R)
    return q[:3] + corners @ R.T


def _ties(system) -> np.ndarray:
    """Return the pairs (n, 2) of markers that joints relate to each other."""
    legs, equations = system.tables["legs"], system.tables["equations"]
    first = legs["marker"][equations["leg"][legs["equation"]]] if len(legs) else legs["marker"]
    return np.stack([first, legs["marker"]], axis=1)


def _assemblies(body: np.ndarray, pairs: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """Return the number of the assembly of every body (nb,): what joints and forces connect, not by way of the ground.

    `body` (nm,) of every marker, `pairs` (n, 2) of markers, `moves` (nb,).
    """
    a, b = body[pairs].T
    among = moves[a] & moves[b]
    graph = sparse.csr_matrix((np.ones(np.sum(among)), (a[among], b[among])), shape=(len(moves), len(moves)))
    return connected_components(graph, directed=False)[1]


def _places_of(numbers: np.ndarray, count: int) -> list[np.ndarray]:
    """Return where each of 0 .. count - 1 stands among numbers (n,), ascending: in one pass, however many there are."""
    order = np.argsort(numbers, kind="stable")
    return np.split(order, np.searchsorted(numbers[order], np.arange(count + 1)))[1:-1]


def _longest(markers, assembly: np.ndarray, ties, holds, held) -> np.ndarray:
    """Return the largest distances (2, na), m, over which joints and forces hold each assembly.

    `assembly` (nb,) is the number of that of every body, -1 where it does not move; `held` are markers tied to the
    origin.
    """
    among = np.append(assembly, -1)[np.minimum(markers["body"], len(assembly))]  # states are nowhere
    longest = np.zeros((2, int(assembly.max(initial=-1)) + 1))
    for own, pairs in zip(longest, (ties, holds), strict=True):
        apart = np.linalg.norm(markers["r"][pairs[:, 0]] - markers["r"][pairs[:, 1]], axis=1)
        for end in among[pairs].T:
            np.maximum.at(own, end[end >= 0], apart[end >= 0])
    held = held[among[held] >= 0]
    np.maximum.at(longest[0], among[held], np.linalg.norm(markers["r"][held], axis=1))
    return longest


def _length(system, members, points, distances, inertia: np.ndarray) -> float:
    """Return the length (m) of the assembly of some bodies, 0 if it has none; `distances` (2,) hold it."""
    of_members = np.vstack([points[k] for k in members])
    rounded = max(NOTHING * max(distances), ROUNDED * float(np.abs(of_members).max(initial=0.0)))
    for length in (_diameter(of_members), *distances, _gyration(system, members, inertia)):
        if length > rounded:
            return float(length)
    return 0.0


def _gyration(system, members, inertia: np.ndarray) -> float:
    """Return the largest radius of gyration (m) of bodies with a frame, about its origin."""
    found = 0.0
    for body in (system.model.bodies[k] for k in members):
        own = inertia[system.body_slices[body.name][1]]
        if body.has_frame and own[0] > 0.0:
            found = max(found, float(np.sqrt(own[3:6].max() / own[0])))
    return found


def _diameter(r: np.ndarray) -> float:
    """Return the largest distance between two points (n, 3), m: whichever way the axes of W point."""
    if len(r) <= FEW:
        return float(np.sqrt(np.square(r[:, None] - r).sum(axis=2).max(initial=0.0)))
    outward = np.linalg.norm(r - r.mean(axis=0), axis=1)
    largest = float(np.linalg.norm(r - r[np.argmax(outward)], axis=1).max())
    ends = r[outward >= largest * (1.0 - ROUNDED) - outward.max()]  # nearer to the middle, none is farther apart
    for k in range(0, len(ends), CHUNK):
        squares = sum(np.subtract.outer(own, every) ** 2 for own, every in zip(ends[k : k + CHUNK].T, ends.T))
        largest = max(largest, float(np.sqrt(squares.max())))
    return largest


def from_own_axes(body) -> tuple[float, float]:
    """Return how far an elastic body with a frame is from the origin of its axes, and its size, m; 0, 0 of others, and
    of data of a single place, whose size is not known.
    """
    if not (body.has_frame and body.n_vector):
        return 0.0, 0.0
    least, most = body.bounds()
    size = float(np.linalg.norm(most - least))
    return (float(np.linalg.norm(0.5 * (least + most))), size) if size > 0.0 else (0.0, 0.0)


def warn_of_lost_digits(model, lengths: Lengths) -> None:
    """Warn of an assembly so far from the origin of W that the digits of its positions are few beside its length, and
    of an elastic body that far from its own axes.
    """
    for body in model.bodies:
        away, size = from_own_axes(body)
        if away > OFF * size:
            tell(
                f"{body.title} is {away:.3g} m from its own axes, {away / size:.2g} times its size: its velocities and "
                "moments of inertia, which refer to them, have fewer digits, and so have reactions. Put its axes near "
                "it: data.translated(...) moves the data, and at= the body back to its place"
            )
    moving = [k for k, body in enumerate(model.bodies) if body.n_velocities]
    eps = np.finfo(float).eps
    lost = {k: eps * lengths.coordinates[k] / lengths.bodies[k] for k in moving}
    k = max(lost, key=lambda k: lost[k], default=-1)
    if k < 0 or lost[k] <= LOST:
        return
    far, length = lengths.coordinates[k], lengths.bodies[k]
    tell(
        f"Model '{model.name}': {model.bodies[k].title} is {far:.3g} m from the origin, and its assembly is "
        f"{length:.3g} m long: positions are rounded to {eps * far:.1g} m, {lost[k]:.1g} of that; relative motion, and "
        "forces of stiff springs, have no more digits. Put the origin near the bodies"
    )
