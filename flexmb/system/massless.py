"""Bodies without inertia in some freedom: a weightless link, a rod that is thin as a line.

Such a motion is determined if the joints determine it: M and G together must have full column rank (Udwadia &
Phohomsiri 2006). The factorisation takes bodies before their multipliers and needs a regular block; a small inertia is
added to the matrix for it, eq. (lent-inertia). The residual does not contain it, so the result belongs to the massless
body.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.linalg import qr

from flexmb.errors import CompileError
from flexmb.system.needles import longest_arms

__all__ = ["inertia_floor"]

SINGULAR = 1e-12
"""Singular values of a body's mass matrix below this, with its diagonal scaled to one, count as zero."""
FLOOR = 1e-8
"""Added inertia, relative to the body's own, to its mass by the arms of its joints, or to those of all bodies."""
ROUNDING = 1e-6
"""Change of an equation by a motion, of that by the strongest motion of the body, that is rounding: inertias of 32
bits, or seven digits, know the direction of an axis to 1e-7."""
HELD = 1e-9
"""How far the joints must hold a massless motion, relative to its strongest hold."""


def _typical(M: sparse.csr_matrix, bodies) -> tuple[float, ...]:
    """Return the geometric means of masses (1 kg where there are none) and moments of inertia (0) of all bodies."""
    diagonal = M.diagonal()
    masses = np.concatenate([diagonal[u][:3] for _, u in bodies])
    moments = np.concatenate([diagonal[u][3:6] for body, u in bodies if body.has_frame] or [np.zeros(0)])
    means = (float(np.exp(np.mean(np.log(x[x > 0.0])))) if np.any(x > 0.0) else 0.0 for x in (masses, moments))
    return next(means) or 1.0, next(means)


def _sizes(diagonal: np.ndarray, arm: float, typical: tuple[float, ...]) -> tuple[float, float]:
    """Return the mass and the moment of inertia beside which what is lent to a body is small.

    They are its own, or what these make of each other over the arm of its joints, m; those of all bodies, if it has
    none.
    """
    mass, moment = np.max(diagonal[:3]), np.max(diagonal[3:6], initial=0.0)
    if mass > 0.0:
        return mass, moment if moment > 0.0 else mass * arm**2
    if moment > 0.0:
        return moment / arm**2, moment
    return typical[0], typical[1] if typical[1] > 0.0 else typical[0] * arm**2


def _beyond(system, place: int) -> CompileError:
    return CompileError(
        system.owner(place),
        found="an inertia beyond the range of numbers",
        expected="masses (kg), lengths (m) and inertias (kg m2) whose products are finite",
        remedy="Correct the number of this body",
    )


def _without_inertia(system, M: sparse.csr_matrix, spans: list[slice]) -> list[tuple[np.ndarray, slice]]:
    """Return the blocks of M that are singular, (n, n) with their velocities:
    all bodies are examined together.
    """
    found = []
    M = M.tocoo()
    for n in sorted({u.stop - u.start for u in spans}):
        alike = [u for u in spans if u.stop - u.start == n]
        block_of = np.full(M.shape[0], -1)
        first = np.array([u.start for u in alike])
        block_of[first[:, None] + np.arange(n)] = np.arange(len(alike))[:, None]
        own = (block_of[M.row] >= 0) & (block_of[M.row] == block_of[M.col])
        number = block_of[M.row[own]]
        blocks = np.zeros((len(alike), n, n))
        blocks[number, M.row[own] - first[number], M.col[own] - first[number]] = M.data[own]
        diagonal = np.abs(np.diagonal(blocks, axis1=1, axis2=2))
        some = diagonal.min(axis=1) > 0.0
        scale = 1.0 / np.sqrt(np.where(some[:, None], diagonal, 1.0))
        scaled = blocks * scale[:, :, None] * scale[:, None, :]
        if not np.isfinite(scaled).all():
            raise _beyond(system, alike[int(np.argmin(np.isfinite(scaled).all(axis=(1, 2))))].start)
        # not its symmetric part: what accelerations stiffen is in the rows of the modes alone
        singular = ~some | ~(np.linalg.svd(scaled, compute_uv=False)[:, -1] > SINGULAR)
        found += [(blocks[k], alike[k]) for k in np.flatnonzero(singular)]
    return sorted(found, key=lambda item: item[1].start)


def inertia_floor(system, M: sparse.csr_matrix, G: sparse.csr_matrix) -> tuple[np.ndarray, np.ndarray, int]:
    """Return the velocities and places in the iteration matrix (nf, 2), the inertia that is added there (nf,), and the
    number of a velocity that has neither inertia nor a constraint (-1: there is none).
    """
    if not np.isfinite(M.data).all():
        place = int(M.tocoo().row[np.argmin(np.isfinite(M.data))])
        raise _beyond(system, place)
    bodies = [
        (body, system.body_slices[body.name][1])
        for body in system.model.bodies
        if (body.has_frame or body.n_velocities == 3) and body.block_size == body.n_velocities
    ]
    rows, motions = system.tables["rows"], []
    places: list[tuple[int, int]] = []
    values: list[float] = []
    typical: tuple[float, ...] | None = None
    arms: dict[str, float] = {}
    of_start = {u.start: body for body, u in bodies}
    for block, u in _without_inertia(system, M, [u for _, u in bodies]):
        diagonal = np.abs(np.diag(block))
        typical, arms = typical or _typical(M, bodies), arms or longest_arms(system.model)
        name = of_start[u.start].name
        size = _sizes(diagonal, arms.get(name) or system.lengths.whole, typical)
        frame = min(6, len(diagonal))  # the modes of a reduced body have mass
        floor = np.concatenate([np.repeat(size, [3, frame - 3]), diagonal[frame:]])
        _, s, V = np.linalg.svd(block / np.sqrt(np.outer(floor, floor)))
        places += [(u.start + k, rows[u.start + k] + k) for k in range(frame)]
        values += list(FLOOR * floor[:frame])
        kernel = V[s <= SINGULAR * max(1.0, s[0])]
        scaled = G[:, u] @ sparse.diags_array(1.0 / np.sqrt(floor))
        rounding = ROUNDING * sparse.linalg.norm(scaled, axis=1)  # of a massless axis that is turned in space
        for way in kernel:
            change = scaled @ way
            change[np.abs(change) <= rounding] = 0.0
            motions.append((u.start + int(np.argmax(np.abs(way))), change))
    return np.array(places, np.int64).reshape(-1, 2), np.array(values, float), _loose(motions)


def _loose(motions) -> int:
    """Return the velocity of a massless motion, (velocity, change of the constraints),
    that no constraint holds, or -1.
    """
    if not motions:
        return -1
    changes = np.array([change for _, change in motions])
    if not np.isfinite(changes).all():
        return -1  # equations without value: assembling names them
    largest = np.abs(changes).max(axis=1, keepdims=True)
    _, R, order = qr((changes / np.where(largest > 0.0, largest, 1.0)).T, mode="economic", pivoting=True)
    held = np.zeros(len(motions))
    held[: min(R.shape)] = np.abs(np.diag(R))
    return motions[int(order[np.argmin(held)])][0] if held.min() <= HELD else -1
