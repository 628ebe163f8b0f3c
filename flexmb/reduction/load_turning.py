"""How the generalised forces of load shapes change with the deformation: loads turn with material, not with the frame.

To first order a load is F + dF with the forces of turned material and the displaced points at which they act (docs,
theory "reduction", eq. (load-turning)). Without these terms a load turns with the body frame, and every choice of the
frame is another load.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy import sparse

from flexmb.errors import ReductionError, did_you_mean
from flexmb.fem.fe_model import FEModel
from flexmb.reduction.loads import MATERIAL, Load
from flexmb.reduction.markers import MarkerMotion, rotation_at_node
from flexmb.reduction.statics import HeldBody

__all__ = ["holding_interface", "load_turning", "reaction", "wrench_turning"]

_BALANCED = 1e-9  # resultant of a preload, relative to its forces, that counts as none


def holding_interface(body: HeldBody) -> int | None:
    """Return the number of the first interface that can hold the body alone, or None."""
    for number, where in enumerate(body.slices):
        if where.stop - where.start == body.rigid.shape[1] and body.couplings[number].label != "bare nodes":
            return number
    return None


def load_turning(
    body: HeldBody, shapes: np.ndarray, markers: Sequence[MarkerMotion], loads: Mapping[str, Load]
) -> np.ndarray:
    """Return the change of the generalised force of each unit load per flexible coordinate, (nl, 6 + m, m).

    Parameters
    ----------
    body : HeldBody
    shapes : (ndof, m)
    markers : motion of the interfaces, by whose names loads say what they turn with
    loads : mapping of name to load
    """
    fe, m = body.fe, shapes.shape[1]
    modes = fe.field(shapes)
    out = np.zeros((len(loads), 6 + m, m))
    for n, (name, load) in enumerate(loads.items()):
        part = f"Load '{name}'"
        force = load.nodal(fe, part)
        change = load.surface_change(fe, part, modes) if hasattr(load, "surface_change") else None
        if change is None:
            change = _turned(force, _turn(body, shapes, modes, markers, load.turns_with, force, part))
        out[n] = generalised_change(fe, modes, force, change)
    return out


def wrench_turning(marker: MarkerMotion, shapes: np.ndarray, wrench: np.ndarray) -> np.ndarray:
    """Return the same of a wrench (6,) that turns with the marker on which it acts: (6 + m, m)."""
    moved, turn = np.split(marker.matrix @ shapes, 2)
    force, moment = np.cross(turn, wrench[:3, None], axis=0), np.cross(turn, wrench[3:, None], axis=0)
    lever = np.cross(marker.position[:, None], force, axis=0) + np.cross(moved, wrench[:3, None], axis=0)
    return np.vstack([force, lever + moment, moved.T @ force + 0.5 * turn.T @ moment])


def generalised_change(fe: FEModel, modes: np.ndarray, force: np.ndarray, change: np.ndarray) -> np.ndarray:
    """Return d(V^T F) per flexible coordinate, (6 + m, m), of nodal forces (n, 6) that change by (n, 6, m).

    The moment about the origin changes with the displacement of the points too, and a nodal moment works on the spin
    T(theta) theta', half of theta x theta' more than theta'.
    """
    m = modes.shape[2]
    out = np.empty((6 + m, m))
    out[:3] = change[:, :3].sum(axis=0)
    lever = np.cross(fe.nodes[:, :, None], change[:, :3], axis=1) + np.cross(modes[:, :3], force[:, :3, None], axis=1)
    out[3:6] = (lever + change[:, 3:]).sum(axis=0)
    out[6:] = modes.reshape(-1, m).T @ change.reshape(-1, m)
    if force[:, 3:].any():
        spun = 0.5 * np.cross(force[:, 3:, None], modes[:, 3:], axis=1)
        out[6:] += modes[:, 3:].reshape(-1, m).T @ spun.reshape(-1, m)
    return out


def reaction(body: HeldBody, marker: MarkerMotion | None, force: np.ndarray) -> np.ndarray:
    """Return the wrench (6,) with which an interface balances forces on the freedoms (ndof,), N and N m."""
    rigid = body.rigid / np.where(body.motions < 3, 1.0, body.length)
    lacking = rigid.T @ force
    if np.abs(lacking).max(initial=0.0) <= _BALANCED * (np.abs(rigid).T @ np.abs(force)).max(initial=0.0):
        return np.zeros(6)
    if marker is None:
        raise ReductionError(
            f"Preload of FE model '{body.fe.name}'",
            found=f"the resultant {np.array2string(body.rigid.T @ force, precision=3)} N, N m about the middle",
            expected="forces in equilibrium, or an interface that can hold the body and react",
            remedy="Add the reactions to the load, or a rigid or averaging interface",
        )
    wrench = np.linalg.lstsq((marker.matrix @ rigid).T, -lacking, rcond=None)[0]
    return np.asarray(wrench)


def _turned(force: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Return theta x F of forces and moments (n, 6) for rotations (n or 1, 3, m): (n, 6, m)."""
    return np.concatenate(
        [np.cross(turn, force[:, :3, None], axis=1), np.cross(turn, force[:, 3:, None], axis=1)], axis=1
    )


def _turn(body: HeldBody, shapes, modes, markers, turns_with: str | None, force: np.ndarray, part: str) -> np.ndarray:
    """Return the rotation of the axes in which the load is constant, (n or 1, 3, m)."""
    names = [marker.name for marker in markers]
    if turns_with is None:
        number = holding_interface(body)
        return _mean_rotation(body, shapes)[None] if number is None else (markers[number].matrix[3:] @ shapes)[None]
    if turns_with == MATERIAL:
        return _nodal_rotation(body.fe, shapes, modes, np.flatnonzero(force.any(axis=1)))
    if turns_with not in names:
        raise ReductionError(
            part,
            found=f"turns_with = {turns_with!r}",
            expected=f"'{MATERIAL}', or one of the interfaces: {', '.join(names) or 'none'}",
            remedy=did_you_mean(str(turns_with), [*names, MATERIAL]) or "Leave it out for the first holding interface",
        )
    return (markers[names.index(turns_with)].matrix[3:] @ shapes)[None]


def _mean_rotation(body: HeldBody, shapes: np.ndarray) -> np.ndarray:
    """Return the rotation (3, m) of the mean motion of the mass."""
    out = np.zeros((6, shapes.shape[1]))
    out[body.motions] = np.linalg.solve(body.rigid_mass, (body.fe.M @ body.rigid).T @ shapes)
    return out[3:]


def _nodal_rotation(fe: FEModel, shapes: np.ndarray, modes: np.ndarray, loaded: np.ndarray) -> np.ndarray:
    """Return the rotation of every node (n, 3, m); nodes without rotations turn as the material around them."""
    turn = modes[:, 3:].copy()
    turning = np.zeros(len(fe.nodes), bool)
    turning[fe.dofs[fe.dofs[:, 1] >= 3, 0]] = True
    if fe.expansion is not None:
        turning |= (np.diff(fe.expansion.indptr).reshape(-1, 6)[:, 3:] > 0).any(axis=1)
    still = loaded[~turning[loaded]]
    if len(still):
        rows = sparse.vstack([rotation_at_node(fe, int(node)) for node in still])
        turn[still] = (rows @ shapes).reshape(len(still), 3, -1)
    return turn
