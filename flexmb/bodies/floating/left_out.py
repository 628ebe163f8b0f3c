"""Loads of a body whose reduction has left out geometric stiffness, beside those that would change its stiffness."""

from __future__ import annotations

import numpy as np

from flexmb.bodies.floating.row import mean_motion
from flexmb.bodies.floating.stiffness import load_scales, mean_acceleration
from flexmb.math.rotations import euler_to_matrix

__all__ = ["LeftOut"]

ALIGNED = 1e-6
"""Sine of the angle between directions that count as one; of the largest singular value."""


class LeftOut:
    """Change of stiffness by the loads of one body, from the matrices of its reduction (`ModalNeutralData.left_out`).

    The matrices of all loads, with their signs, make one, whose largest eigenvalue, in size, is the change. The body is
    seen from its mean motion, as between pins, and from each interface that a joint or force holds against turning, as
    clamped there; the largest change counts. An interface may be held by what yields, so a change can be told too high;
    two interfaces that hold an end together, as bearings do, are not seen as a clamp, so it can be told too low.

    Parameters
    ----------
    body : FloatingBody
    data, row : its reduced data, as they are in the model, and its row
    causes : sequence of str
        What each load is called.
    system : System
    """

    def __init__(self, body, data, row, causes, system):
        known = data.left_out
        self.row, self.causes, self.turns, self.markers = row, causes, known.turns, system.marker_index
        groups = (known.inertia, known.interface.reshape(-1, *known.preload.shape), known.loads, known.preload[None])
        self.matrices = np.concatenate(groups)
        self.holders = [_holders(system.model, f"{body.name}.{name}") for name in data.marker_names[: len(known.turns)]]

    def share(self, bulk, state, work) -> tuple[float, str]:
        """Return the relative change of stiffness, and what has the largest part in it."""
        row, R, fall = self.row, np.empty((3, 3)), np.empty(6)
        iu, first, scales = row["iu"], row["first_load"], np.empty(len(self.matrices))
        A = state.a[iu : iu + 6 + row["modes"]].copy()
        euler_to_matrix(state.q[row["iq"] + 3 : row["iq"] + 7], R)
        A[:3] -= R.T @ row["gravity"]
        mean_acceleration(mean_motion(bulk, row["mass"], row["modes"]), A, fall)
        wrenches = work.markers[row["marker"] : row["marker"] + row["interfaces"]]
        load_scales(state.u[iu : iu + 6], fall, R, wrenches, work.loads[first : first + row["loads"]], scales)
        G = np.tensordot(scales, self.matrices, 1)
        change, shape = max((_largest(T.T @ G @ T, T) for T in self._views(R, work)), key=lambda found: found[0])
        parts: dict[str, float] = {}
        for cause, part in zip(self.causes, scales * np.einsum("j,ijk,k->i", shape, self.matrices, shape), strict=True):
            parts[cause] = parts.get(cause, 0.0) + part
        return change, max(parts, key=lambda cause: abs(parts[cause]))

    def _views(self, R, work):
        """Yield, for each way to see the shapes, what they are with the turn of the body, (k + 3, k)."""
        soft = self.matrices.shape[1] - 3
        yield np.eye(soft + 3, soft)
        for turn, holders in zip(self.turns, self.holders):
            held = [np.zeros((0, 3))]
            for equation, number, pair in holders:
                held.append(_about(equation, number, *(work.markers[self.markers[name]]["R"] for name in pair)))
            s, axes = np.linalg.svd(np.concatenate(held) @ R)[1:] if sum(map(len, held)) else ((), np.eye(3))
            some = axes[: np.count_nonzero(np.asarray(s) > ALIGNED * max(s, default=0.0))]
            if len(some):
                yield np.vstack([np.eye(soft), -some.T @ some @ turn])


def _about(equation, number, *R) -> np.ndarray:
    """Return the directions (n, 3), in W, about which an equation, or a force (None), holds its marker."""
    return np.eye(3) if equation is None else equation.held_turns(number, *R[:2])


def _largest(relative, T) -> tuple[float, np.ndarray]:
    """Return the eigenvalue that is largest in size, and its shape with the turn of the body."""
    values, vectors = np.linalg.eigh(relative)
    k = int(np.abs(values).argmax())
    return float(abs(values[k])), T @ vectors[:, k]


def _holders(model, marker: str) -> list[tuple]:
    """Return (equation, its number among the markers, markers) of the joints at a marker, and (None, ...) of forces."""
    found = []
    for joint in model.joints:
        markers = joint.resolved_markers(model)
        if marker in markers:
            found += [(equation, markers.index(marker), markers) for equation in joint.equations_in(model)]
    for force in model.forces:
        pair = _held_by(force, model)
        if marker in pair:
            found.append((None, 0, pair))
    return found


def _held_by(force, model) -> tuple[str, ...]:
    """Return the markers that a force can hold against turning."""
    if not force.holds_turns:
        return ()
    if hasattr(force, "place"):
        coordinate, markers = force.place(model)
        return markers if coordinate.kind == "turn" else ()
    return getattr(force, "markers", None) or ()
