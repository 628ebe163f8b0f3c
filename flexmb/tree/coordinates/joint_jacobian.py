"""Joint Jacobian: the twist of a marker per rate of the tree, along the path from its body to the root."""

from __future__ import annotations

import numpy as np

from flexmb.tree.coordinates.joint_kinematics import joint_axes, relative_pose
from flexmb.tree.coordinates.motions import HINGED

__all__ = ["joint_jacobian"]


def _shifted(twists: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Return twists (6, n) in W, moved from a point by d (3,)."""
    return np.vstack([twists[:3] + np.cross(twists[3:], d, axis=0), twists[3:]])


def _own_jacobian(work, number: int) -> np.ndarray:
    marker = work.markers[number]
    return work.J[marker["iJ"] : marker["iJ"] + 6 * marker["nu"]].reshape((6, -1))


def hinge_twists(row, work) -> np.ndarray:
    """Return the unit twists (6, rates) of a body's own marker relative to its parent, at that marker, in W."""
    one, two = (row["other"], row["own"]) if row["forward"] else (row["own"], row["other"])
    a, b = work.markers[one], work.markers[two]
    d, R, axes = np.empty(3), np.empty((3, 3)), np.zeros((6, 6))
    relative_pose(a, b, d, R)
    joint_axes(row, R, axes)
    local = axes[: row["rates"]].T
    twists = np.vstack([a["R"] @ local[:3], a["R"] @ local[3:]])
    return twists if row["forward"] else -_shifted(twists, a["r"] - b["r"])


def joint_jacobian(rows, parents, work, body: int, marker: int, size: int) -> np.ndarray:
    """Return the Jacobian (6, size) of a marker on the body at place `body` of the tree (-1: it stands still).

    Each joint on the path contributes its unit twists, moved to the marker; each mode what it does at the marker while
    the body's own marker of its joint stays, eq. (tree-jacobian). `work` holds an evaluation.
    """
    out = np.zeros((6, size))
    r = work.markers[marker]["r"]
    through, k = _own_jacobian(work, marker), body
    while k >= 0:
        row = rows[k]
        rates, modes, at = int(row["rates"]), int(row["modes"]), int(row["iv"])
        if row["held"] != HINGED:
            out[:, at : at + rates + modes] = through
            break
        C, Q = (work.markers[row[name]]["r"] for name in ("own", "other"))
        out[:, at : at + rates] = _shifted(hinge_twists(row, work), r - C)
        at += rates
        out[:, at : at + modes] = through[:, 6:] - _shifted(_own_jacobian(work, row["own"])[:, 6:], r - C)
        if parents[k] >= 0:
            through = _shifted(_own_jacobian(work, row["other"]), r - Q)
        k = parents[k]
    return out
