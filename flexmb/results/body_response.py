"""How a reduced body by itself answers to forces on its interfaces, and at which frequency it vibrates when held."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.linalg import eigh, null_space

__all__ = ["elastic_and_rigid", "held_frequency", "motion_by_forces"]

HELD = 1e-9
"""Motion of held freedoms, relative to the largest, that is rounding."""


def elastic_and_rigid(data: Any) -> Callable[[float], tuple[np.ndarray, np.ndarray]]:
    """Return a function of the frequency, Hz: the elastic and the rigid response (k, k), m/N, of the reduced body."""
    loss = 1.0 + 2j * data.quality["transfer"]["damping"]
    mass, stiffness = _matrices(data)
    w2, modes = eigh(stiffness, mass)  # of the free body: six rigid motions, then elastic ones against the mean motion
    shapes = _freedoms(data) @ modes
    rigid, elastic = shapes[:, :6], shapes[:, 6:]

    def response(hertz: float) -> tuple[np.ndarray, np.ndarray]:
        square = (2.0 * np.pi * hertz) ** 2
        return elastic / (loss * w2[6:] - square) @ elastic.T, rigid @ rigid.T / -square

    return response


def _freedoms(data: Any) -> np.ndarray:
    """Return the motion (k, 6 + m) of interface freedoms by rigid motions and modes; turns by the size of the body."""
    rows = []
    length = data.quality["transfer"]["length"]
    for number, row in enumerate(data.quality["interfaces"]):
        x, y, z = data.marker_positions[number]
        lever = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        move = np.hstack([np.eye(3), lever, data.marker_translations[number]])
        turn = length * np.hstack([np.zeros((3, 3)), np.eye(3), data.marker_rotations[number]])
        rows.append(np.vstack([move, turn])[row["freedoms"]])
    return np.vstack(rows)


def motion_by_forces(
    data: Any, frequencies: np.ndarray, forces: np.ndarray, loads: np.ndarray, spin: np.ndarray
) -> float:
    """Return the mean square of the elastic motion of interface freedoms, m2, that loads make.

    Parameters
    ----------
    forces, loads, spin : (n, k), (n, nl), (n, 6)
        Amplitudes of forces on interface freedoms, of load shapes, and of the fields of spin (`acting_loads`).
    """
    loss = 1.0 + 2j * data.quality["transfer"]["damping"]
    mass, stiffness = _matrices(data)
    w2, modes = eigh(stiffness, mass)
    freedoms = _freedoms(data)
    given = forces @ freedoms + loads @ data.load_shapes + spin @ _centrifugal(data)
    swing = (given @ modes[:, 6:]) / (loss * w2[6:] - (2.0 * np.pi * frequencies[:, None]) ** 2)
    return float(np.sum(np.abs(swing @ (freedoms @ modes[:, 6:]).T) ** 2))


def _centrifugal(data: Any) -> np.ndarray:
    """Return the generalised forces (6, 6 + m) of the symmetric acceleration fields A x: xx, yy, zz, xy, yz, zx.

    With A = w w^T - w^2 I they are -m A c, -w x J w and, of the flexible coordinates, w^T J_j w / 2.
    """
    inertia, found = data.invariants, []
    first = inertia.vw0
    moment = np.array([first[1, 2], first[2, 0], first[0, 1]])  # m c, of -m c~
    for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)):
        A = np.zeros((3, 3))
        A[i, j] = A[j, i] = 1.0
        square = A - 0.5 * np.trace(A) * np.eye(3)  # w w^T
        turned = square @ inertia.ww0
        torque = np.array([turned[1, 2] - turned[2, 1], turned[2, 0] - turned[0, 2], turned[0, 1] - turned[1, 0]])
        found.append(np.concatenate([-A @ moment, -torque, 0.5 * np.einsum("ab,jab->j", square, inertia.ww1)]))
    return np.array(found)


def held_frequency(data: Any, held: np.ndarray) -> float:
    """Return the lowest angular frequency, rad/s, with the interface freedoms `held` (k,) at rest, rigid motions apart.

    Infinite where nothing is left that vibrates.
    """
    mass, stiffness = _matrices(data)
    rows = _freedoms(data)[held]
    free = null_space(rows, rcond=HELD) if len(rows) else np.eye(len(mass))
    w2 = eigh(free.T @ stiffness @ free, free.T @ mass @ free, eigvals_only=True)
    loose = 6 - (np.linalg.matrix_rank(rows[:, :6], tol=HELD * np.abs(rows[:, :6]).max()) if len(rows) else 0)
    return float(np.sqrt(max(w2[loose], 0.0))) if len(w2) > loose and w2[loose] > 0.0 else np.inf


def _matrices(data: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return mass and stiffness (6 + m, 6 + m) of the free reduced body."""
    inertia = data.invariants
    mass = np.block(
        [
            [inertia.vv, inertia.vw0, inertia.vn],
            [inertia.vw0.T, inertia.ww0, inertia.wn0],
            [inertia.vn.T, inertia.wn0.T, inertia.nn],
        ]
    )
    stiffness = np.zeros_like(mass)
    stiffness[6:, 6:] = data.stiffness
    return mass, stiffness
