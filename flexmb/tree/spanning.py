"""The spanning tree of a system: which joints carry the recursion, which close loops.

Every joint whose equations act on two bodies may be a tree joint; its drives go with it. Kept are the joints with the
most equations (a maximum spanning tree, Kruskal 1956), so the loops are closed by the fewest equations. Bodies that no
joint connects to the ground float: the root of their tree has six free velocities, or as many as it has.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from flexmb.errors import CompileError, did_you_mean
from flexmb.math.found_once import found_once
from flexmb.math.structures import Integers, structure

__all__ = ["Spanning", "TreeTables", "spanning_tree"]


@structure
class TreeTables(NamedTuple):
    """Flat tables of the recursion, bodies in an order with parents first."""

    iu: Integers
    """(nb,) first velocity"""
    nu: Integers
    """(nb,) number of velocities"""
    iq: Integers
    """(nb,) first coordinate"""
    parent: Integers
    """(nb,) place of the parent, -1: the ground, or none"""
    inner: Integers
    """(nb,) marker on the parent's side of the tree joint, -1: a free body"""
    outer: Integers
    """(nb,) marker on the body's own side (its first one if free; -1: a body without a frame, which neither hangs on a
    joint nor carries bodies)"""
    equations: Integers
    """(n,) equations of the tree joint of every body"""
    start_equation: Integers
    """(nb + 1,) where they begin"""
    i_plain: Integers
    """(nb + 1,) first number in the stores of the recursion, as the next three"""
    i_modal: Integers
    i_eta: Integers
    i_parent: Integers
    trees: Integers
    """(nt + 1,) first body of every tree; trees have only the ground in common"""
    cut_equations: Integers
    """(nc,) equations that close loops"""
    cut_trees: Integers
    """trees on which each one acts"""
    start_cut_tree: Integers
    """(nc + 1,) where they begin"""
    rows: Integers
    """cut equations which the multiplier of each one accelerates"""
    start_row: Integers
    """(nc + 1,) where they begin"""


@dataclass(frozen=True, kw_only=True, eq=False)
class Spanning:
    """The tree by names, and its tables.

    Parameters
    ----------
    order : tuple of str
        Moving bodies, parents first.
    joints : dict of body name to joint name
        The tree joint of every body that has one.
    cut : tuple of str
        Joints that close loops.
    tables : TreeTables
    """

    order: tuple[str, ...]
    joints: dict[str, str]
    cut: tuple[str, ...]
    tables: TreeTables


class _Groups:
    """Union-find over bodies."""

    def __init__(self, n: int):
        self.leader = list(range(n))

    def find(self, k: int) -> int:
        while self.leader[k] != k:
            self.leader[k] = self.leader[self.leader[k]]
            k = self.leader[k]
        return k

    def join(self, a: int, b: int) -> bool:
        a, b = self.find(a), self.find(b)
        self.leader[a] = b
        return a != b


def _edges(system, cut, allowed) -> tuple[dict[str, tuple[int, int]], dict[str, list[int]]]:
    """Return the two markers of every joint that can be a tree joint, and the equations of each with its drives."""
    legs, bodies = system.tables["legs"], system.tables["markers"]["body"].tolist()
    cut, may = set(cut), None if allowed is None else set(allowed)
    of_equation: dict[int, list[int]] = {}
    for equation, marker in zip(legs["equation"].tolist(), legs["marker"].tolist(), strict=True):
        of_equation.setdefault(equation, []).append(marker)
    ends: dict[str, tuple[int, int]] = {}
    equations: dict[str, list[int]] = {}
    for joint in system.joints:
        span = system.joint_equations[joint.name]
        used = {m for e in range(span.start, span.stop) for m in of_equation[e]}
        leader = getattr(joint, "joint", joint.name) if joint.prescribes else joint.name
        # what relates coordinates, or velocities against W, does not see the relative motion of two markers alone
        if joint.couples or joint.name in cut or (leader == joint.name and may is not None and leader not in may):
            continue
        places = tuple(system.marker_index[m] for m in joint.resolved_markers(system.model))
        if len(places) == 2 and used == set(places) and len({bodies[m] for m in used}) == 2:
            if leader == joint.name:
                ends[joint.name] = places
            equations.setdefault(leader, []).extend(range(span.start, span.stop))
    return ends, {name: equations[name] for name in ends}


def _refuse_bodies_of_nodes(system) -> None:
    """The recursion inverts the mass matrix of a body as a dense one: a body of many nodes is not for it."""
    for body in system.model.bodies:
        if body.block_size < body.n_velocities:
            kind = type(body).__name__
            raise CompileError(
                body.title,
                found=f"{kind} has no frame but nodes of {body.block_size} velocities",
                expected="bodies with a frame, or points, in the recursion",
                remedy="Use GeneralizedAlpha or IDA, or Explicit without a formulation: they factorise node by node",
            )


Carriers = tuple[tuple[str, ...], tuple[str, ...]]


@found_once
def spanning_tree(system, cut: tuple[str, ...] = (), carriers: Carriers | None = None) -> Spanning:
    """Return a spanning tree of the joints of a system (found once for each choice).

    Parameters
    ----------
    system : System
    cut : tuple of str
        Joints to cut: they close loops.
    carriers : (tuple of str, tuple of str), optional
        Joints that may carry a body (unless given: all), and those that must.

    Raises
    ------
    CompileError
        If a joint in `cut` does not exist, a body is a mesh of nodes of its own, or a joint cannot carry a body as it
        must.
    """
    names, slices = [*system.slices], system.slices
    _refuse_bodies_of_nodes(system)
    for name in cut:
        if name not in system.joint_index:
            raise CompileError(
                "Recursive",
                found=f"joint '{name}' to cut does not exist",
                expected=f"one of: {', '.join(system.joint_index)}",
                remedy=did_you_mean(name, system.joint_index),
            )
    allowed, wanted = carriers or (None, ())
    ends, equations = _edges(system, cut, allowed)
    body = system.tables["markers"]["body"].tolist()
    moving = [k for k, name in enumerate(names) if slices[name][1].stop > slices[name][1].start]
    still = sorted(set(range(len(names))) - set(moving))
    groups = _Groups(len(names))
    for k in still[1:]:
        groups.join(still[0], k)
    first = set(wanted)
    candidates = sorted(ends, key=lambda n: (n not in first, -len(equations[n])))
    kept = [
        n
        for n in candidates
        if _has_frame(system, names, ends[n], body) and groups.join(int(body[ends[n][0]]), int(body[ends[n][1]]))
    ]
    if left_out := first.difference(kept):
        name = next(name for name in wanted if name in left_out)
        raise CompileError(
            f"Joint '{name}'",
            found="it closes a loop, or holds a body that has no frame",
            expected="joints to keep that form a tree of bodies with frames",
            remedy=f"Cut one of the other joints, or leave '{name}' out of keep",
        )
    order, entry, trees = _walk(kept, ends, body, still, moving)
    return _finished(system, names, order, entry, trees, ends, equations)


def _walk(kept, ends, body, still, moving):
    """Return the bodies tree by tree, parents first, the joint by which each is entered, and where trees begin."""
    beside: dict[int, list[str]] = {}
    for name in kept:
        for m in ends[name]:
            beside.setdefault(int(body[m]), []).append(name)

    def others(here):
        for name in beside.get(here, ()):
            a, b = (int(body[m]) for m in ends[name])
            yield name, b if a == here else a

    order: list[int] = []
    entry: dict[int, str] = {}
    trees = []
    roots = [(name, other) for k in still for name, other in others(k)] + [(None, k) for k in moving]
    seen = set(still)
    for joint, root in roots:
        if root in seen:
            continue
        trees.append(len(order))
        waiting = [(joint, root)]
        while waiting:
            name, here = waiting.pop()  # depth first: what is used together lies together
            if here in seen:
                continue
            seen.add(here)
            order.append(here)
            if name is not None:
                entry[here] = name
            waiting += others(here)
    return order, entry, [*trees, len(order)]


def _has_frame(system, names, markers, body) -> bool:
    """Only bodies with a frame can hang on a tree joint: their marker moves freely with it."""
    nu = system.tables["markers"]["nu"]
    return all(nu[m] == 0 or system.has_frame(names[int(body[m])]) for m in markers)


def _offsets(sizes) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


def _finished(system, names, order, entry, trees, ends, equations) -> Spanning:
    body = system.tables["markers"]["body"]
    place = {k: n for n, k in enumerate(order)}
    first_marker = {int(k): n for n, k in reversed(list(enumerate(body)))}
    of_name = system.slices
    slices = [of_name[names[k]] for k in order]
    frame = np.array([system.has_frame(names[k]) and k in first_marker for k in order], bool)
    parent, inner, outer, rows, starts = [], [], [], [], [0]
    for n, k in enumerate(order):
        if k in entry:
            a, b = ends[entry[k]]
            own, other = (a, b) if int(body[a]) == k else (b, a)
            parent.append(place.get(int(body[other]), -1))
            inner.append(other)
            outer.append(own)
            rows += equations[entry[k]]
        else:
            parent.append(-1)
            inner.append(-1)
            outer.append(first_marker[k] if frame[n] else -1)
        starts.append(len(rows))
    nu = np.array([u.stop - u.start for _, u in slices], np.int64)
    modal = np.where(frame, nu - 6, 0)
    width = np.array([modal[p] if p >= 0 else 0 for p in parent], np.int64)
    cut_equations = np.array(sorted(set(range(system.ng)) - set(rows)), np.int64)
    tables = TreeTables(
        iu=np.array([u.start for _, u in slices], np.int64),
        nu=nu,
        iq=np.array([q.start for q, _ in slices], np.int64),
        parent=np.array(parent, np.int64),
        inner=np.array(inner, np.int64),
        outer=np.array(outer, np.int64),
        equations=np.array(rows, np.int64),
        start_equation=np.array(starts, np.int64),
        i_plain=_offsets(np.where(frame, 0, nu * nu)),
        i_modal=_offsets(modal * modal + 24 * modal),
        i_eta=_offsets(modal),
        i_parent=_offsets(12 * width),
        trees=np.array(trees, np.int64),
        cut_equations=cut_equations,
        **_couplings(system, place, trees, cut_equations),
    )
    closing = set(cut_equations.tolist())
    of_cut = {
        j.name
        for j in system.joints
        if any(e in closing for e in range(*system.joint_equations[j.name].indices(system.ng)))
    }
    return Spanning(
        order=tuple(names[k] for k in order),
        joints={names[k]: entry[k] for k in order if k in entry},
        cut=tuple(sorted(of_cut)),
        tables=tables,
    )


def _couplings(system, place, trees, cut_equations) -> dict[str, np.ndarray]:
    """Return on which trees the cut equations act, and by them on which other cut equations."""
    legs, body = system.tables["legs"], system.tables["markers"]["body"]
    touched: dict[int, set[int]] = {int(e): set() for e in cut_equations}
    for leg in legs:
        k = place.get(int(body[leg["marker"]]))
        if k is not None and int(leg["equation"]) in touched:
            touched[int(leg["equation"])].add(int(np.searchsorted(trees, k, side="right")) - 1)
    acting = [sorted(touched[int(e)]) for e in cut_equations]
    on_tree: dict[int, list[int]] = {}
    for n, of_one in enumerate(acting):
        for tree in of_one:
            on_tree.setdefault(tree, []).append(n)
    coupled = [sorted({m for tree in of_one for m in on_tree[tree]}) for of_one in acting]
    return {
        "cut_trees": np.array([t for of_one in acting for t in of_one], np.int64),
        "start_cut_tree": _offsets([len(x) for x in acting]),
        "rows": np.array([m for of_one in coupled for m in of_one], np.int64),
        "start_row": _offsets([len(x) for x in coupled]),
    }
