"""Links of a tree by constants: where joints sit in the links before, ten numbers of inertia, flexible bodies."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import numpy as np

from flexmb.errors import CompileError
from flexmb.math.rotations import euler_to_matrix
from flexmb.tree.coordinates.motions import FREE, POINTS
from flexmb.tree.flexible.tables import BENT, PLACE, Flexible, Packed, new_flexible, wide_places
from flexmb.tree.rigid.places import BALL, BEND, FIXED, FRAME, LINK, MOUNT, SINGLE
from flexmb.tree.rigid.points import is_point

__all__ = ["MARK", "Drawn", "link_marks", "link_rows", "require_known_forces"]

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


class _Modal:
    """The flexible bodies of a tree as links; those that are alike are one, with their markers."""

    def __init__(self):
        self._known: dict[Hashable, tuple[Any, tuple[str, ...]]] = {}

    def of(self, body) -> tuple[Any, tuple[str, ...]]:
        """Return a body as a link (ModalLink, None if it does not tell), and the names of its markers."""
        source = body.link_source()
        if source is None:
            return body.modal_link(), tuple(body.marker_poses())
        if source not in self._known:
            self._known[source] = body.modal_link(), tuple(body.marker_poses())
        return self._known[source]


def require_known_forces(model, remedy: str) -> None:
    """Raise CompileError if a force depends on reactions, which passes over links do not find."""
    for force in model.forces:
        if force.reads_reactions:
            raise CompileError(
                force.title,
                found="a force that depends on reactions",
                expected="forces of place and motion",
                remedy=remedy,
            )


def _check(tree, modal: _Modal) -> None:
    """Raise CompileError for what the algorithm in link axes does not know."""
    for name, row in zip(tree.tree.order, tree.rows, strict=True):
        is_body = name in tree.system.body_slices
        title = f"Body '{name}'" if is_body else name  # what has states is in the tree by its title
        found = ""
        if row["held"] == POINTS:
            found = "it has no frame" if is_body and not is_point(tree.model.body(name)) else ""
        elif row["modes"] and modal.of(tree.model.body(name))[0] is None:
            found = f"{row['modes']} modes, of which it does not tell what a link has to know"
        if found:
            joint = f" (joint '{tree.tree.joints[name]}')" if name in tree.tree.joints else ""
            raise CompileError(
                f"{title}{joint}",
                found=found,
                expected="points, rigid bodies with a frame, and reduced ones in space",
                remedy="Use fmb.accelerations(model, formulation=fmb.Recursive()), which takes every tree",
            )
    if tree.system.implicit:
        raise CompileError(
            f"Model '{tree.model.name}'",
            found="forces follow accelerations",
            expected="forces of place and motion",
            remedy="Use fmb.accelerations(model, formulation=fmb.Recursive()), which takes every force",
        )
    require_known_forces(
        tree.model, "Use fmb.accelerations(model, formulation=fmb.Recursive()), which takes every force"
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

    def three_slides(self) -> None:
        """Add the links of a point: its coordinates in W."""
        for axis in range(3):
            self.add(SINGLE, axis, slide=1.0, axis=axis)
            self.links[-1]["sign"] = 1.0

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


class Drawn:
    """The links of a tree as they come to be, parents first.

    Attributes
    ----------
    rows : list of LINK
    frames : list of (int, (3,), (3, 3))
        Of every body its link, with origin and axes of that in W; of a flexible one without meaning beyond the link.
    marks : dict of marker number to (int, (3,), (3, 3))
        Of the markers of flexible bodies: link, place and axes in it.
    """

    def __init__(self, tree, wanted, modal: _Modal):
        self.tree, self.wanted, self.modal = tree, wanted, modal
        self.rows: list[np.ndarray] = []
        self.frames: list[tuple[int, np.ndarray, np.ndarray]] = []
        self.marks: dict[int, tuple[int, np.ndarray, np.ndarray]] = {}
        self.bodies: list[np.ndarray] = []
        self.places: list[np.ndarray] = []
        self.mounts: dict[int, int] = {}
        self.packed = Packed()
        self.blocks = 0
        self.first_loads = _first_loads(tree.system)
        self.carrying: dict[int, set[int]] = {}
        for parent, row in zip(tree.tree.tables.parent.tolist(), tree.rows, strict=True):
            self.carrying.setdefault(parent, set()).add(int(row["other"]))

    def take(self, chain: _Chain, k: int, driven) -> None:
        """Add the links by which body k hangs."""
        for link in chain.links:
            self._add(link, chain, k)
            link["driven"] = link["kind"] == SINGLE and int(link["rate"]) in driven
            if link["kind"] in (BALL, FRAME):
                link["block"], self.blocks = self.blocks, self.blocks + 1

    def _add(self, link, chain: _Chain, k: int) -> None:
        """Add a link that helps to carry body k."""
        if link["parent"] < -1:
            link["parent"] = len(self.rows) - 1
        link["body"] = k
        self.rows.append(link)

    def bend(self, chain: _Chain, k: int, row) -> None:
        """Add the frame of a flexible body behind the links of its joint, then its markers that are needed."""
        system, name = self.tree.system, self.tree.tree.order[k]
        data, own_names = self.modal.of(self.tree.model.body(name))
        markers = [system.marker_index[f"{name}.{marker}"] for marker in own_names]
        chain.add(BEND)
        link = chain.links[-1]
        self._add(link, chain, k)
        own = np.zeros((), BENT)
        self.packed.body(own, data)
        at = len(self.rows) - 1
        link["block"], link["modes"], link["coordinate"] = len(self.bodies), own["m"], row["iq"] + row["coordinates"]
        link["rate"], link["mass"] = row["iv"] + row["rates"], data.mass
        link["J"] = data.ww0[UPPER]
        own["link"], own["coordinate"], own["rate"], own["q"], own["u"] = (
            at,
            link["coordinate"],
            link["rate"],
            row["q"],
            row["u"],
        )
        own["first_load"], own["clamp"] = self.first_loads.get(int(row["u"]), 0), -1
        stiffened = bool(own["stiffened"] > 0)
        if row["held"] != FREE:
            own["clamp"] = self._place(own, data, markers.index(int(row["own"])), stiffened, -1)
            if len(chain.links) > 1:  # what acts on the own marker acts on the joint
                self.marks[int(row["own"])] = (at - 1, link["r"].copy(), link["R"].copy())
        carrying = self.carrying.get(k, set())
        own["first"] = len(self.places)
        for number, marker in enumerate(markers):
            if marker in carrying or (marker in self.wanted and marker not in self.marks):
                mount = np.zeros((), LINK)
                mount["parent"], mount["kind"], mount["body"], mount["sign"] = at, MOUNT, k, 1.0
                mount["block"] = self._place(own, data, number, stiffened, len(self.rows))
                self.places[-1]["loaded"] = marker in carrying
                self.rows.append(mount)
                if marker not in self.marks:
                    self.marks[marker] = (len(self.rows) - 1, np.zeros(3), np.eye(3))
                self.mounts[marker] = len(self.rows) - 1
        own["last"] = len(self.places)
        self.bodies.append(own)
        self.frames.append((at, np.zeros(3), np.eye(3)))

    def _place(self, own, data, number: int, stiffened: bool, link: int) -> int:
        """Add a marker of the flexible body at hand and return its place."""
        place = np.zeros((), PLACE)
        place["link"], place["body"] = link, len(self.bodies)
        self.packed.place(place, data, number, stiffened)
        self.places.append(place)
        return len(self.places) - 1

    def flexible(self, links, numbers: int, profile: int) -> Flexible:
        """Return the flexible links; `numbers` of the ways from cut equations, `profile` of the matrix of these."""
        carries = np.zeros(len(links), bool)
        for k in range(len(links) - 1, -1, -1):
            kind, parent = int(links[k]["kind"]), int(links[k]["parent"])
            carries[k] |= kind == BEND or (kind == MOUNT and bool(self.places[int(links[k]["block"])]["loaded"]))
            if parent >= 0 and carries[k]:
                carries[parent] = True
        kept = (links["driven"] == 1) | (numbers > 0)  # forces of drives and loops need inertias later
        wide_of = wide_places(links, carries, kept)
        return new_flexible(links, self.bodies, self.places, self.packed, wide_of, numbers, profile)


def _first_loads(system) -> dict[int, int]:
    """Return where the amounts of the load shapes of bodies begin in work.loads, by their first velocity."""
    found, program = {}, system.program
    kinds = {type(body) for body in system.model.bodies if type(body).table is not None}
    for kind in kinds:
        address = kind.table.kernels["inertia"].compiled.address
        for k in np.flatnonzero(program.inertia == address):
            rows = program.raw[program.starts[k] : program.starts[k + 1]].view(kind.table.row)
            if "first_load" in rows.dtype.names:
                found.update(zip(rows["iu"].tolist(), rows["first_load"].tolist(), strict=True))
    return found


def link_rows(tree, state, work, wanted) -> Drawn:
    """Return the links of a tree; forces and cut joints see the markers with the numbers `wanted`.

    `work` holds an evaluation at `state`.
    """
    modal = _Modal()
    _check(tree, modal)
    driven = {tree.rate_places[name] for name in tree.drives}
    drawn = Drawn(tree, set(wanted), modal)
    for k, row in enumerate(tree.rows):
        if row["held"] == POINTS:
            _add_point(drawn, k, row, state)
            continue
        r_b, R_b = _frame(state.q[row["q"] : row["q"] + 7])
        at = int(tree.tree.tables.parent[k])
        if row["held"] == FREE:
            chain = _Chain(row, -1, np.zeros(3), np.eye(3))
            chain.add(FRAME)
            origin, axes = r_b, R_b
        else:
            own, other = (work.markers[row[name]] for name in ("own", "other"))
            if at >= 0 and tree.rows[at]["modes"]:
                chain = _Chain(row, drawn.mounts[int(row["other"])], np.zeros(3), np.eye(3))
            else:
                parent, r_p, R_p = drawn.frames[at] if at >= 0 else (-1, np.zeros(3), np.eye(3))
                chain = _Chain(row, parent, R_p.T @ (other["r"] - r_p), R_p.T @ other["R"])
            chain.hang()
            if not chain.links and not row["modes"]:
                chain.add(FIXED)
            axes = own["R"] @ chain.R.T
            origin = own["r"] - axes @ chain.r
        drawn.take(chain, k, driven)
        if row["modes"]:
            drawn.bend(chain, k, row)
            continue
        _give_inertia(drawn.rows[-1], tree.model.body(tree.tree.order[k]), r_b - origin, R_b, axes)
        drawn.frames.append((len(drawn.rows) - 1, origin, axes))
    return drawn


def _add_point(drawn: Drawn, k: int, row, state) -> None:
    """Add the links of a point mass; states of forces and blocks have none."""
    name = drawn.tree.tree.order[k]
    if name not in drawn.tree.system.body_slices:
        drawn.frames.append((-1, np.zeros(3), np.eye(3)))
        return
    chain = _Chain(row, -1, np.zeros(3), np.eye(3))
    chain.three_slides()
    drawn.take(chain, k, ())
    drawn.rows[-1]["mass"] = drawn.tree.model.body(name).rest_inertia()[0]
    drawn.frames.append((len(drawn.rows) - 1, state.q[row["q"] : row["q"] + 3].copy(), chain.R.T))


def _give_inertia(link, body, away, R_b, axes) -> None:
    """Write the inertia of a body to its link, whose axes (3, 3) stand in W; `away` (3,) to the body's origin, in W."""
    T, s = axes.T @ R_b, axes.T @ away  # T: from body axes to link axes
    mass, moment, inertia = body.rest_inertia()
    h = T @ moment
    J = T @ inertia @ T.T - _cross(s) @ _cross(h) - _cross(h) @ _cross(s) - mass * _cross(s) @ _cross(s)
    link["mass"], link["h"] = mass, h + mass * s
    link["J"] = J[UPPER]


def link_marks(tree, drawn: Drawn, work, wanted) -> np.ndarray:
    """Return the rows of the markers with numbers `wanted` that move; `work` holds the evaluation of `link_rows`."""
    place = {name: k for k, name in enumerate(tree.tree.order)}
    names = [*tree.system.slices]
    marks = []
    for number in sorted(wanted):
        marker = work.markers[number]
        k = place.get(names[marker["body"]])
        if k is None or drawn.frames[k][0] < 0:  # stands still, or is of states
            continue
        bends = tree.rows[k]["held"] != POINTS and tree.rows[k]["modes"] > 0
        if bends and number not in drawn.marks:  # the amount of a load shape
            continue
        mark = np.zeros((), MARK)
        mark["marker"] = number
        if bends:
            mark["link"], mark["s"], mark["A"] = drawn.marks[number]
        else:
            link, r, L = drawn.frames[k]
            mark["link"], mark["s"], mark["A"] = link, L.T @ (marker["r"] - r), L.T @ marker["R"]
        marks.append(mark)
    return np.array(marks, MARK)
