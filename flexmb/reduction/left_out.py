"""How much the geometric stiffness that a reduction leaves out would count: a number for each load of a body.

A part that was reduced without geometric stiffness neither buckles nor stiffens when it spins, and nothing in its
equations says so. So the reduction keeps, for every unit load, by how much it changes the stiffness of the softest
shapes, and a run compares its loads with that (`flexmb.bodies.floating.left_out`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy import sparse

from flexmb.reduction.basis import Basis
from flexmb.reduction.geometric import coupling_stiffness, inertia_loads
from flexmb.reduction.markers import MarkerMotion
from flexmb.reduction.statics import HeldBody

__all__ = ["left_out_stiffness"]

SOFTEST = 12
"""Shapes, those of the lowest frequencies: slender bodies buckle and stiffen in them."""
AT_ONCE = 24
"""Loads whose forces and displacements are kept at once: those of 300 000 nodes take 29 MB each."""
MOST = 240
"""Loads that are looked at: those of some forty interfaces. The time grows with them; beyond, nothing is said."""


def left_out_stiffness(
    body: HeldBody, basis: Basis, interfaces: Sequence[MarkerMotion], forces: np.ndarray, names: Sequence[str]
) -> dict[str, Any] | None:
    """Return the largest relative change of stiffness by each unit load, as JSON can hold it; None where it is unknown.

    The change is the largest eigenvalue of ``K^-1 K_g`` on the softest shapes, in size: 1 at the buckling load. Shapes
    are seen from the mean motion and from each interface in turn, and the largest value counts: a column in its mean
    frame buckles under four times the load that it carries when one end is clamped. Stresses are those of the basis,
    exact for loads on interfaces.

    Parameters
    ----------
    body, basis, interfaces : the held body, its shapes, and the motions of its interfaces
    forces : (ndof, nl), N
        Load shapes of unit size, with `names`.

    Returns
    -------
    dict
        ``acceleration`` (3,), s2/m, ``turning`` (3,), s2, of angular acceleration, ``spin``, s2, of the square of the
        angular velocity, ``interfaces``: name to (6,), 1/N and 1/(N m), ``loads``: name to one over its unit; ``axes``
        (3, 3) and ``origin`` (3,), m: of the numbers, in body axes.
    """
    fe, count = body.fe, 12 + 6 * len(interfaces) + len(names)
    if not fe.blocks or fe.condensed is not None or not len(basis.w2) or count > MOST:
        return None
    soft = np.argsort(basis.w2)[:SOFTEST]
    shapes, turns = basis.shapes[:, soft], fe.rigid_motions()[:, 3:]
    parts = [sparse.csc_matrix(_inertia(fe)), *(marker.matrix.T for marker in interfaces), sparse.csc_matrix(forces)]
    G = _unit_stiffness(body, basis, interfaces, sparse.hstack(parts, format="csc"), np.hstack([shapes, turns]))
    if not np.all(np.isfinite(G)):  # loads beyond the range of numbers
        return None
    flexible = 1.0 / np.sqrt(basis.w2[soft])
    largest = np.zeros(len(G))
    for seen in (None, *interfaces):
        T = np.vstack([np.eye(len(soft)), np.zeros((3, len(soft))) if seen is None else -(seen.matrix[3:] @ shapes)])
        relative = flexible[:, None] * (T.T @ G @ T) * flexible
        largest = np.maximum(largest, np.abs(np.linalg.eigvalsh(relative)).max(axis=1))
    by_interface = largest[9 : 9 + 6 * len(interfaces)].reshape(-1, 6)
    return {
        "acceleration": largest[:3].tolist(),
        "turning": largest[3:6].tolist(),
        "spin": float(largest[6:9].max()),
        "interfaces": {marker.name: row.tolist() for marker, row in zip(interfaces, by_interface)},
        "loads": dict(zip(names, largest[9 + 6 * len(interfaces) :].tolist())),
        "axes": np.eye(3).tolist(),
        "origin": [0.0, 0.0, 0.0],
    }


def _inertia(fe) -> np.ndarray:
    """Return the nodal forces (ndof, 9) of unit accelerations, angular accelerations and spins about the axes."""
    unit = inertia_loads(fe)  # of A_k, then of B_kl at 3 + 3 k + l
    B = np.zeros((6, 3, 3))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        B[i, k, j], B[i, j, k] = 1.0, -1.0
        B[3 + i, j, j] = B[3 + i, k, k] = -1.0
    return np.hstack([unit[:, :3], unit[:, 3:] @ B.reshape(6, 9).T])


def _unit_stiffness(body: HeldBody, basis: Basis, interfaces, columns, motions) -> np.ndarray:
    """Return the geometric stiffness of the loads, columns (ndof, n), on the motions (ndof, k): (n, k, k)."""
    fe, field, parts = body.fe, body.fe.field(motions), []
    for first in range(0, columns.shape[1], AT_ONCE):
        loads = columns[:, first : first + AT_ONCE].toarray()
        static = basis.shapes @ ((basis.shapes.T @ loads) / basis.w2[:, None])
        displacement = fe.field(static)
        part = np.sum([block.projected_geometric_stiffness(displacement, field) for block in fe.blocks], axis=0)
        loads[:, max(9 - first, 0) : max(9 + 6 * len(interfaces) - first, 0)] = 0.0  # the rest acts on nodes
        parts.append(part + coupling_stiffness(body, static, loads, interfaces, motions, 9 - first))
    G = np.concatenate(parts)
    return 0.5 * (G + G.transpose(0, 2, 1))
