"""The geometric stiffness that a reduction may leave out, on a few soft shapes, for each load of a body.

A part that was reduced without geometric stiffness neither buckles nor stiffens when it spins, and nothing in its
equations says so. So the reduction keeps, for every unit load, how it changes the stiffness of the softest shapes, and
a run adds these changes, each times its load (`flexmb.bodies.floating.left_out`). Where it has geometric stiffness,
they say under which loads the part buckles as its joints hold it, which its frame does not know.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import sparse

from flexmb.model.modal_arrays import LeftOutStiffness
from flexmb.reduction.basis import Basis
from flexmb.reduction.geometric import ACCELERATIONS, by_loads, coupling_stiffness, inertia_loads
from flexmb.reduction.markers import MarkerMotion
from flexmb.reduction.statics import HeldBody

__all__ = ["left_out_stiffness"]

SOFTEST = 18
"""Shapes of the lowest frequencies: slender bodies buckle and stiffen in them."""
AT_ONCE = 24
"""Loads whose forces and displacements are kept at once: for 300 000 nodes they take 29 MB each."""
MOST = 240
"""Loads that are looked at: some forty interfaces. The time grows with them; beyond, nothing is said."""


def left_out_stiffness(
    body: HeldBody,
    basis: Basis,
    interfaces: Sequence[MarkerMotion],
    forces: np.ndarray,
    matrices: np.ndarray | None = None,
) -> LeftOutStiffness | None:
    """Return the changes of stiffness by unit loads on the softest shapes; None where they are unknown.

    Shapes are seen from their mean motion. How a body is held decides which of them it can take: a column between pins
    carries four times the load that it carries when one end is clamped. So the turns of the body are coordinates too,
    the motions of the interfaces are kept, and a run that knows the joints lets what these hold stand still, where the
    stiffer shapes help with their compliance. Stresses are those of the basis, exact for loads on interfaces.

    Parameters
    ----------
    body, basis, interfaces : the held body, its shapes, and the motions of its interfaces
    forces : (ndof, nl), N
        Load shapes of unit size.
    matrices : (n, m + 3, m + 3), optional
        Geometric stiffness on the shapes of the basis and the turns about the origin, if the reduction has it.
    """
    fe, own = body.fe, len(ACCELERATIONS)
    if not fe.blocks or fe.condensed is not None or not len(basis.w2):
        return None
    if own + 6 * len(interfaces) + forces.shape[1] > MOST:
        return None
    order = np.argsort(basis.w2)
    shapes, turning = _about_the_mean(fe, basis.shapes[:, order] / np.sqrt(basis.w2[order]))
    motions = np.concatenate([np.zeros((0, shapes.shape[1])), *(marker.matrix @ shapes for marker in interfaces)])
    motions = motions.reshape(len(interfaces), 6, shapes.shape[1])
    unit = float(np.abs(motions[:, 3:, :SOFTEST]).max(initial=0.0)) or 1.0
    shapes, motions, rest = shapes[:, :SOFTEST], motions[:, :, :SOFTEST] / unit, motions[:, :, SOFTEST:] / unit
    rest = rest.reshape(6 * len(interfaces), rest.shape[2])
    if matrices is None:
        parts = [sparse.csc_matrix(inertia_loads(fe)), *(m.matrix.T for m in interfaces), sparse.csc_matrix(forces)]
        columns = sparse.hstack(parts, format="csc")
        G = _unit_stiffness(body, basis, interfaces, columns, np.hstack([shapes, unit * fe.rigid_motions()[:, 3:]]))
        G = np.concatenate([G, np.zeros((1, *G.shape[1:]))])
    else:
        chosen = order[:SOFTEST]
        T = np.zeros((len(order) + 3, len(chosen) + 3))
        T[chosen, np.arange(len(chosen))] = 1.0 / np.sqrt(basis.w2[chosen])
        T[-3:, :-3], T[-3:, -3:] = turning[:, :SOFTEST], unit * np.eye(3)
        G = T.T @ matrices @ T
    if not np.all(np.isfinite(G)):  # loads beyond the range of numbers
        return None
    return LeftOutStiffness(
        **by_loads(G, len(interfaces)),
        translations=motions[:, :3],
        turns=motions[:, 3:],
        compliance=rest @ rest.T,
    )


def _about_the_mean(fe, shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the shapes (ndof, k) without momenta, as seen from their mean motion, and the turns (3, k) that do so."""
    rigid = fe.rigid_motions()
    momenta = fe.M @ rigid
    mass = rigid.T @ momenta
    scale = 1.0 / np.sqrt(np.where(np.diag(mass) > 0.0, np.diag(mass), 1.0))  # a planar model lacks some motions
    inverse = scale[:, None] * np.linalg.pinv(mass * np.outer(scale, scale), hermitian=True) * scale
    motion = inverse @ (momenta.T @ shapes)
    return shapes - rigid @ motion, -motion[3:]


def _unit_stiffness(body: HeldBody, basis: Basis, interfaces, columns, motions) -> np.ndarray:
    """Return the geometric stiffness of the loads, columns (ndof, n), on the motions (ndof, k): (n, k, k)."""
    fe, field, parts, own = body.fe, body.fe.field(motions), [], len(ACCELERATIONS)
    for first in range(0, columns.shape[1], AT_ONCE):
        loads = columns[:, first : first + AT_ONCE].toarray()
        static = basis.shapes @ ((basis.shapes.T @ loads) / basis.w2[:, None])
        displacement = fe.field(static)
        part = np.sum([block.projected_geometric_stiffness(displacement, field) for block in fe.blocks], axis=0)
        loads[:, max(own - first, 0) : max(own + 6 * len(interfaces) - first, 0)] = 0.0  # the rest acts on nodes
        parts.append(part + coupling_stiffness(body, static, loads, interfaces, motions, own - first))
    G = np.concatenate(parts)
    return 0.5 * (G + G.transpose(0, 2, 1))
