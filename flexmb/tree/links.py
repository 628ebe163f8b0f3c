"""Rigid links of a tree by constants: where each hinge or slide sits in the link before, and the ten numbers of inertia."""

from __future__ import annotations

import numpy as np

from flexmb.errors import CompileError
from flexmb.math.rotations import euler_to_matrix
from flexmb.tree.link_passes import LINK
from flexmb.tree.motions import HINGED

__all__ = ["link_rows"]


def _refuse(tree, name: str, found: str) -> CompileError:
    joint = f" (joint '{tree.tree.joints[name]}')" if name in tree.tree.joints else ""
    return CompileError(f"Body '{name}'{joint}", found=found,
                        expected="rigid links on revolute, prismatic and fixed joints, moved by gravity and joint forces",
                        remedy="Use fmb.accelerations(model, formulation=fmb.Recursive()), which takes every tree")


def _check(tree) -> None:
    """Raise CompileError for what the algorithm in link axes does not know."""
    if len(tree.tree.tables.cut_equations) or tree.model.forces:
        what = [*tree.tree.cut, *(force.name for force in tree.model.forces)]
        raise CompileError(f"Model '{tree.model.name}'", found=f"more than a tree of links: {', '.join(what)}",
                           expected="no loops and no forces",
                           remedy="Use fmb.accelerations(model, formulation=fmb.Recursive()), which takes every model")
    for name, row in zip(tree.tree.order, tree.rows, strict=True):
        if row["held"] != HINGED:
            raise _refuse(tree, name, "it is not held by a joint")
        if row["modes"]:
            raise _refuse(tree, name, f"{row['modes']} modes")
        if row["rates"] > 1 or row["advance"] or row["slide"][0] >= 0 or row["slide"][1] >= 0 or row["ball"] >= 0:
            raise _refuse(tree, name, "a joint that is no hinge or slide")


def _frame(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    R = np.empty((3, 3))
    euler_to_matrix(q[3:7], R)
    return q[:3], R


def _cross(r) -> np.ndarray:
    return np.array([[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]])


def link_rows(tree, state, work) -> np.ndarray:
    """Return the rows of a tree of rigid links; `work` holds an evaluation at `state` with the blocks of the bodies.

    The frame of a link stands on its own marker: axes of marker a of the joint, turned and slid by the coordinate.
    """
    _check(tree)
    links = np.zeros(len(tree.rows), LINK)
    driven = {tree.rate_names.index(name) for name in tree.drives}
    frames: list[tuple[np.ndarray, np.ndarray]] = []
    for k, (row, link) in enumerate(zip(tree.rows, links, strict=True)):
        own, other = (work.markers[row[name]] for name in ("own", "other"))
        sign = 1.0 if row["forward"] else -1.0
        slides = -1 if not row["rates"] else int(row["turn"] < 0 and row["turn_b"] < 0)
        # axes of a seen from the parent at coordinate zero
        base = other["R"].copy() if row["forward"] else other["R"] @ row["C"].T
        origin = other["r"] + sign * base @ row["d"]
        axes = own["R"] @ row["C"].T if row["forward"] else own["R"].copy()
        parent = int(tree.tree.tables.parent[k])
        r_p, R_p = frames[parent] if parent >= 0 else (np.zeros(3), np.eye(3))
        link["parent"], link["slides"], link["sign"], link["rate"] = parent, slides, sign, row["iv"]
        link["driven"] = slides >= 0 and row["iv"] in driven
        link["R"], link["r"] = R_p.T @ base, R_p.T @ (origin - r_p)
        frames.append((own["r"].copy(), axes))
        r_b, R_b = _frame(state.q[row["q"] : row["q"] + 7])
        T = axes.T @ R_b  # from body axes to link axes
        block = np.array([work.S[at : at + 6] for at in work.rows[row["u"] : row["u"] + 6]])
        mass, s = block[0, 0], axes.T @ (r_b - own["r"])
        h = T @ np.array([block[5, 1], block[3, 2], block[4, 0]])
        J = T @ block[3:, 3:] @ T.T - _cross(s) @ _cross(h) - _cross(h) @ _cross(s) - mass * _cross(s) @ _cross(s)
        link["mass"], link["h"] = mass, h + mass * s
        link["J"] = J[np.triu_indices(3)]
    return links
