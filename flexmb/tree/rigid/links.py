"""Rigid links of a tree by constants: where each joint sits in the link before, and the ten numbers of inertia."""

from __future__ import annotations

import numpy as np

from flexmb.errors import CompileError
from flexmb.math.rotations import euler_to_matrix
from flexmb.tree.coordinates.motions import FREE, POINTS
from flexmb.tree.rigid.places import BALL, FIXED, FRAME, LINK, SINGLE

__all__ = ["MARK", "link_marks", "link_rows"]

MARK = np.dtype(
    [
        ("link", np.int64),
        ("marker", np.int64),
        ("s", float, 3),  # m, place in the link's frame
        ("A", float, (3, 3)),  # axes, in the link's axes
    ],
    align=True,
)
"""A marker on a link."""

UPPER = np.triu_indices(3)


def _check(tree) -> None:
    """Raise CompileError for what the algorithm in link axes does not know."""
    for name, row in zip(tree.tree.order, tree.rows, strict=True):
        found = "it has no frame" if row["held"] == POINTS else f"{row['modes']} modes" if row["modes"] else ""
        if found:
            joint = f" (joint '{tree.tree.joints[name]}')" if name in tree.tree.joints else ""
            raise CompileError(
                f"Body '{name}'{joint}",
                found=found,
                expected="rigid bodies with a frame",
                remedy="Use fmb.accelerations(model, formulation=fmb.Recursive()), which takes every tree",
            )
    for force in tree.model.forces:
        if force.reads_reactions:
            raise CompileError(
                force.title,
                found="a force that depends on reactions",
                expected="forces of place and motion",
                remedy="Use fmb.accelerations(model, formulation=fmb.Recursive()), which takes every force",
            )


def _frame(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    R = np.empty((3, 3))
    euler_to_matrix(q[3:7], R)
    return q[:3].copy(), R


def _cross(r) -> np.ndarray:
    return np.array([[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]])


class _Chain:
    """The links by which a body hangs on its parent: one for each slide and turn, or one for a ball."""

    def __init__(self, row, parent: int, r: np.ndarray, R: np.ndarray):
        """r, R : where the working frame is in the last link so far:
        at first the parent's marker in the parent's link.
        """
        self.row, self.parent, self.r, self.R = row, parent, r, R
        self.links: list[np.ndarray] = []

    def add(self, kind: int, place: int = 0, *, turn=0.0, slide=0.0, axis=2) -> None:
        """Add a link at the working frame, which moves along or about its axis;
        the working frame goes on from there.
        """
        to_z = np.eye(3)[:, [(axis + 1) % 3, (axis + 2) % 3, axis]]
        link = np.zeros((), LINK)
        link["parent"], link["kind"], link["turn"], link["slide"] = self.parent, kind, turn, slide
        link["coordinate"], link["rate"] = self.row["iq"] + place, self.row["iv"] + place
        link["sign"] = 1.0 if kind == FRAME or self.row["forward"] else -1.0
        link["R"], link["r"] = self.R @ to_z, self.r
        self.links.append(link)
        self.parent, self.r, self.R = -2 - len(self.links), np.zeros(3), to_z.T

    def slides(self) -> None:
        """Add the slides along the axes of a."""
        for axis in range(3):
            if self.row["slide"][axis] >= 0:
                self.add(SINGLE, self.row["slide"][axis], slide=1.0, axis=axis)

    def turn_of_a(self) -> None:
        """Add the turn about z of a."""
        if self.row["turn"] >= 0:
            self.add(SINGLE, self.row["turn"], turn=1.0, slide=self.row["advance"])

    def turns_of_b(self) -> None:
        """Add the turn about z of b, or the ball."""
        if self.row["turn_b"] >= 0:
            self.add(SINGLE, self.row["turn_b"], turn=1.0)
        elif self.row["ball"] >= 0:
            self.add(BALL, self.row["ball"])

    def hang(self) -> None:
        """Add all links of a joint, from the marker of the parent to the marker of the body."""
        row = self.row
        if row["forward"]:
            self.r = self.r + self.R @ row["d"]
            self.slides()
            self.turn_of_a()
            self.R = self.R @ row["C"]
            self.turns_of_b()
        else:
            self.turns_of_b()
            self.R = self.R @ row["C"].T
            self.turn_of_a()
            self.r = self.r - self.R @ row["d"]
            self.slides()
        if not self.links:
            self.add(FIXED)


def link_rows(tree, state, work) -> tuple[np.ndarray, list[tuple[int, np.ndarray, np.ndarray]]]:
    """Return the rows of a tree of rigid links, and of every body its link with origin and axes of that in W.

    `work` holds an evaluation at `state`.
    """
    _check(tree)
    driven = {tree.rate_names.index(name) for name in tree.drives}
    rows: list[np.ndarray] = []
    frames: list[tuple[int, np.ndarray, np.ndarray]] = []
    blocks = 0
    for k, row in enumerate(tree.rows):
        r_b, R_b = _frame(state.q[row["q"] : row["q"] + 7])
        if row["held"] == FREE:
            chain = _Chain(row, -1, np.zeros(3), np.eye(3))
            chain.add(FRAME)
            origin, axes = r_b, R_b
        else:
            own, other = (work.markers[row[name]] for name in ("own", "other"))
            at = int(tree.tree.tables.parent[k])
            parent, r_p, R_p = frames[at] if at >= 0 else (-1, np.zeros(3), np.eye(3))
            chain = _Chain(row, parent, R_p.T @ (other["r"] - r_p), R_p.T @ other["R"])
            chain.hang()
            axes = own["R"] @ chain.R.T
            origin = own["r"] - axes @ chain.r
        for link in chain.links:
            if link["parent"] < -1:
                link["parent"] = len(rows) - 1
            link["body"] = k
            link["driven"] = link["kind"] == SINGLE and int(link["rate"]) in driven
            if link["kind"] in (BALL, FRAME):
                link["block"], blocks = blocks, blocks + 1
            rows.append(link)
        _give_inertia(rows[-1], tree.model.body(tree.tree.order[k]), r_b - origin, R_b, axes)
        frames.append((len(rows) - 1, origin, axes))
    return np.array(rows, LINK), frames


def _give_inertia(link, body, away, R_b, axes) -> None:
    """Write the inertia of a body to its link, whose axes (3, 3) stand in W; `away` (3,) to the body's origin, in W."""
    T, s = axes.T @ R_b, axes.T @ away  # T: from body axes to link axes
    mass, moment, inertia = body.rest_inertia()
    h = T @ moment
    J = T @ inertia @ T.T - _cross(s) @ _cross(h) - _cross(h) @ _cross(s) - mass * _cross(s) @ _cross(s)
    link["mass"], link["h"] = mass, h + mass * s
    link["J"] = J[UPPER]


def link_marks(tree, frames, work, wanted) -> np.ndarray:
    """Return the rows of the markers with numbers `wanted` that move; `work` holds the evaluation of `link_rows`."""
    place = {name: k for k, name in enumerate(tree.tree.order)}
    names = [*tree.system.slices]
    marks = []
    for number in sorted(wanted):
        marker = work.markers[number]
        k = place.get(names[marker["body"]])
        if k is not None:
            link, r, L = frames[k]
            mark = np.zeros((), MARK)
            mark["link"], mark["marker"] = link, number
            mark["s"], mark["A"] = L.T @ (marker["r"] - r), L.T @ marker["R"]
            marks.append(mark)
    return np.array(marks, MARK)
