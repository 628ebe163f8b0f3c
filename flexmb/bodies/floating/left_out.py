"""Loads of a body whose reduction has left out geometric stiffness, beside those that would change its stiffness."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.bodies.floating.row import mean_motion
from flexmb.bodies.floating.stiffness import mean_acceleration
from flexmb.math.rotations import euler_to_matrix

__all__ = ["LeftOut"]


class LeftOut:
    """Change of stiffness by the loads of one body, from the numbers of its reduction (`ModalNeutralData.left_out`).

    The changes by all loads, along each axis, are added in size: an upper estimate.
    """

    def __init__(self, data, row):
        known = data.left_out
        self.row, self.numbers = row, known
        nothing = np.zeros((2, 3))
        self.interfaces = [(name, known["interfaces"].get(name, nothing)) for name in data.marker_names]
        self.loads = [(name, known["loads"].get(name, 0.0)) for name in data.load_names]

    def share(self, bulk, state, work) -> tuple[float, str]:
        """Return the relative change of stiffness, and what has the largest part in it."""
        row, R, fall = self.row, np.empty((3, 3)), np.empty(6)
        A = state.a[row["iu"] : row["iu"] + 6 + row["modes"]].copy()
        euler_to_matrix(state.q[row["iq"] + 3 : row["iq"] + 7], R)
        A[:3] -= R.T @ row["gravity"]
        mean_acceleration(mean_motion(bulk, row["mass"], row["modes"]), A, fall)
        v, w = state.u[row["iu"] : row["iu"] + 3], state.u[row["iu"] + 3 : row["iu"] + 6]
        axes, origin = self.numbers["axes"], self.numbers["origin"]
        there = fall[:3] + np.cross(w, v) + np.cross(fall[3:], origin) + np.cross(w, np.cross(w, origin))
        parts: dict[str, Any] = {
            "acceleration": np.abs(there @ axes) @ self.numbers["acceleration"]
            + np.abs(fall[3:] @ axes) @ self.numbers["turning"],
            "spin": w @ w * self.numbers["spin"],
        }
        for k, (name, by_unit) in enumerate(self.interfaces[: row["interfaces"]]):
            wrench = work.markers[row["marker"] + k]["wrench"].reshape(2, 3) @ R @ axes
            parts[f"interface '{name}'"] = float(np.sum(np.abs(wrench) * by_unit))
        for k, (name, by_load) in enumerate(self.loads):
            parts[f"load '{name}'"] = abs(work.loads[row["first_load"] + k]) * by_load
        return float(sum(parts.values())), max(parts, key=lambda cause: parts[cause])
