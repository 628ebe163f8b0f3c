"""The spanning tree of a system: which joints carry the recursion, which close loops.

Every joint whose equations act on two bodies may be a tree joint; its drives go with it. Kept are the joints with the
most equations (a maximum spanning tree, Kruskal 1956), so the loops are closed by the fewest equations. Bodies that no
joint connects to the ground float: the root of their tree has six free velocities, or as many as it has.
"""

from __future__ import annotations

from collections import namedtuple
from dataclasses import dataclass

import numpy as np

from flexmb.errors import CompileError, did_you_mean

__all__ = ["Spanning", "TreeTables", "spanning_tree"]

TreeTables = namedtuple(
    "TreeTables",
    "iu nu parent inner outer equations start_equation cut_equations i_mass i_modal i_parent",
)
"""Flat tables of the recursion, bodies in an order with parents first.

iu, nu (nb,) : first velocity and their number
parent (nb,) : place of the parent, -1: the ground, or none
inner, outer (nb,) : marker on the parent's side and on the body's own side of the tree joint; outer = -1: no joint
equations (n,), start_equation (nb + 1,) : equations of the tree joint of every body
cut_equations (nc,) : equations that close loops
i_mass, i_modal, i_parent (nb + 1,) : first number in the stores of the recursion
"""


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


def _edges(system) -> tuple[dict[str, tuple[int, int]], dict[str, list[int]]]:
    """Return the two markers of every joint that can be a tree joint, and the equations of each with its drives."""
    legs, markers = system.tables["legs"], system.tables["markers"]
    of_equation: dict[int, list[int]] = {}
    for leg in legs:
        of_equation.setdefault(int(leg["equation"]), []).append(int(leg["marker"]))
    ends: dict[str, tuple[int, int]] = {}
    equations: dict[str, list[int]] = {}
    for joint in system.joints:
        span = system.joint_equations[joint.name]
        used = {m for e in range(span.start, span.stop) for m in of_equation[e]}
        leader = getattr(joint, "joint", joint.name) if joint.prescribes else joint.name
        if len(used) == 2 and len({int(markers[m]["body"]) for m in used}) == 2:
            if leader == joint.name:
                a, b = (system.marker_index[m] for m in joint.resolved_markers(system.model))
                ends[joint.name] = (a, b)
            equations.setdefault(leader, []).extend(range(span.start, span.stop))
    return ends, {name: equations[name] for name in ends}


def spanning_tree(system, cut: tuple[str, ...] = ()) -> Spanning:
    """Return a spanning tree of the joints of a system.

    Parameters
    ----------
    system : System
    cut : tuple of str
        Joints that shall close loops, if any are preferred.

    Raises
    ------
    CompileError
        If a joint in `cut` does not exist.
    """
    names = [body.name for body in system.model.bodies]
    for name in cut:
        if name not in system.joint_index:
            raise CompileError("Recursive", found=f"joint '{name}' to cut does not exist",
                               expected=f"One of: {', '.join(system.joint_index)}",
                               remedy=did_you_mean(name, system.joint_index))
    ends, equations = _edges(system)
    body = system.tables["markers"]["body"]
    moving = [k for k, name in enumerate(names) if system.body_slices[name][1].stop > system.body_slices[name][1].start]
    still = [k for k in range(len(names)) if k not in set(moving)]
    groups = _Groups(len(names))
    for k in still[1:]:
        groups.join(still[0], k)
    candidates = sorted((n for n in ends if n not in cut), key=lambda n: -len(equations[n]))
    kept = [n for n in candidates if groups.join(int(body[ends[n][0]]), int(body[ends[n][1]]))
            and _has_frame(system, names, ends[n], body)]
    beside: dict[int, list[str]] = {}
    for name in kept:
        for m in ends[name]:
            beside.setdefault(int(body[m]), []).append(name)
    order: list[int] = []
    entry: dict[int, str] = {}
    seen = set(still)
    for root in [None, *moving]:
        queue = list(still) if root is None else [root]
        if root is not None:
            if root in seen:
                continue
            seen.add(root)
            order.append(root)
        while queue:
            here = queue.pop(0)
            for name in beside.get(here, ()):
                a, b = (int(body[m]) for m in ends[name])
                other = b if a == here else a
                if other not in seen:
                    seen.add(other)
                    order.append(other)
                    entry[other] = name
                    queue.append(other)
    return _finished(system, names, order, entry, ends, equations)


def _has_frame(system, names, markers, body) -> bool:
    """Only bodies with a frame can hang on a tree joint: their marker moves freely with it."""
    return all(system.model.body(names[int(body[m])]).has_frame or system.tables["markers"]["nu"][m] == 0 for m in markers)


def _finished(system, names, order, entry, ends, equations) -> Spanning:
    body = system.tables["markers"]["body"]
    place = {k: n for n, k in enumerate(order)}
    slices = [system.body_slices[names[k]][1] for k in order]
    nu = np.array([s.stop - s.start for s in slices], np.int64)
    parent, inner, outer, rows, starts = [], [], [], [], [0]
    for k in order:
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
            outer.append(-1)
        starts.append(len(rows))
    parents = np.array(parent, np.int64)
    width = np.array([nu[p] if p >= 0 else 0 for p in parent], np.int64)
    modal = np.maximum(nu - 6, 0)
    cut_equations = sorted(set(range(system.ng)) - set(rows))

    def offsets(sizes):
        return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)

    tables = TreeTables(
        iu=np.array([s.start for s in slices], np.int64), nu=nu, parent=parents, inner=np.array(inner, np.int64),
        outer=np.array(outer, np.int64), equations=np.array(rows, np.int64),
        start_equation=np.array(starts, np.int64), cut_equations=np.array(cut_equations, np.int64),
        i_mass=offsets(nu * nu), i_modal=offsets(modal * modal + 12 * modal),
        i_parent=offsets(12 * width))
    of_cut = {j.name for j in system.joints
              if any(e in set(cut_equations) for e in range(*system.joint_equations[j.name].indices(system.ng)))}
    return Spanning(order=tuple(names[k] for k in order), joints={names[k]: entry[k] for k in order if k in entry},
                    cut=tuple(sorted(of_cut)), tables=tables)
