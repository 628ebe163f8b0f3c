"""What the tree joint of every body lets move, as rows for the kernels: from the primitive freedoms that joints permit.

The pose of marker b in the axes of marker a is ``d = d_0 + sum s_i e_i`` and ``R_ab = R_z(theta) C R_z(beta)`` (or
``C R(p)`` for a ball), with a constant C taken from the assembled joint: it absorbs which axes point along each other.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexmb.constraints import Coordinate
from flexmb.math.rotations import euler_to_matrix

__all__ = [
    "FREE",
    "HINGED",
    "MOTION",
    "POINTS",
    "counted_turns",
    "describable",
    "euler_places",
    "labels",
    "motion_rows",
]

HINGED, FREE, POINTS = 0, 1, 2
"""How a body is held: by a joint, a free frame, no frame at all."""

MOTION = np.dtype(
    [
        ("held", np.int64),  # HINGED, FREE or POINTS
        ("iq", np.int64),  # first relative coordinate; joint or frame first, then the body's modes
        ("iv", np.int64),  # first relative rate
        ("q", np.int64),  # first coordinate of the body
        ("u", np.int64),  # first velocity of the body
        ("modes", np.int64),  # number of its modal coordinates (POINTS: of all its coordinates)
        ("own", np.int64),  # marker C of the tree joint on the body
        ("other", np.int64),  # marker Q of the tree joint on the parent
        ("parent_q", np.int64),  # first coordinate of the parent, -1: it stands still
        ("forward", np.int64),  # 1: C is marker b of the joint; 0: marker a
        ("slide", np.int64, 3),  # place of the slide along x, y, z of a among the coordinates of the joint, -1: none
        ("turn", np.int64),  # place of the turn about z of a, -1: none
        ("turn_b", np.int64),  # place of the turn about z of b, -1: none
        ("ball", np.int64),  # place of the Euler parameters and of the angular velocity, -1: none
        ("coordinates", np.int64),  # of the joint or frame
        ("rates", np.int64),
        ("advance", float),  # m/rad, of a screw
        ("d", float, 3),  # m, from a to b in axes of a where nothing slides
        ("C", float, (3, 3)),  # axes of b in axes of a, all turns zero
        ("fixed", np.int64, 2),  # 1: marker C (Q) always has the same place in its body, which is rigid or stands still
        ("place", float, (2, 3)),  # m, that place
        ("axes", float, (2, 3, 3)),  # axes of marker C (Q) in axes of its body
    ],
    align=True,
)

ROLES = ("slide", "turn", "screw", "turn_b", "ball")
"""Of the freedoms of a tree joint, in their order from a to b."""


def describable(joint, equations: int) -> bool:
    """Can the motion that a joint permits be described by these primitives?"""
    roles = [freedom.role for freedom in joint.permits]
    turns = [role for role in roles if role != "slide"]
    return (
        all(roles)
        and sum(len(freedom.rate_labels) for freedom in joint.permits) + equations == 6
        and (len(turns) < 2 or (len(turns) == 2 and set(turns) == {"turn", "turn_b"}))
    )


def _ordered(joint):
    """Return the freedoms: slides first, then the turn about z of a, then what follows it."""
    return sorted(joint.permits, key=lambda freedom: (ROLES.index(freedom.role), getattr(freedom, "axis", "")))


def _joint_labels(joint) -> tuple[list[str], list[str]]:
    """Return the names of the coordinates and rates of a joint: "A.turn", "B.slide", "C.ball_0"."""
    freedoms = _ordered(joint)
    return (
        [f"{joint.name}.{name}" for freedom in freedoms for name in freedom.labels],
        [f"{joint.name}.{name}" for freedom in freedoms for name in freedom.rate_labels],
    )


def _about_z(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


class _Posed:
    """What `Coordinate.value` asks of a compiler: the poses of two markers."""

    def __init__(self, a, b):
        self.poses = {0: a, 1: b}

    def pose(self, marker: int):
        return self.poses[marker]


def _hinge(row, joint, a, b, turns: float) -> None:
    """Fill in what the joint lets move, with its markers (r, R) as assembled, after so many rad of a screw, about."""
    for name in ("turn", "turn_b", "ball"):
        row[name] = -1
    row["slide"] = -1
    (r_a, R_a), (r_b, R_b) = a, b
    d, R = R_a.T @ (r_b - r_a), R_a.T @ R_b
    angle, back, place = 0.0, 0.0, 0
    for freedom in _ordered(joint):
        if freedom.role == "slide":
            axis = "xyz".index(freedom.axis)
            row["slide"][axis], d[axis] = place, 0.0
        elif freedom.role == "ball":
            row["ball"], R = place, np.eye(3)
        elif freedom.role == "screw":
            row["turn"], row["advance"] = place, freedom.pitch / (2.0 * np.pi)
            angle = freedom.coordinate.value(_Posed(a, b), 0, 1)
            # a run that goes on after full turns has advanced by them
            angle += 2.0 * np.pi * np.round((turns - angle) / (2.0 * np.pi))
            d[2] -= row["advance"] * angle
        elif freedom.role == "turn":
            row["turn"], angle = place, freedom.coordinate.value(_Posed(a, b), 0, 1)
        else:
            row["turn_b"], back = place, freedom.coordinate.value(_Posed(a, b), 0, 1)
        place += 1
    row["coordinates"], row["rates"] = (place + 3, place + 2) if row["ball"] >= 0 else (place, place)
    row["d"], row["C"] = d, _about_z(-angle) @ R @ _about_z(-back)


def _in_body(marker, q, at: int) -> tuple[np.ndarray, np.ndarray]:
    """Return place and axes of a marker in its body, whose frame begins at q[at]; at -1, in W."""
    if at < 0:
        return marker["r"].copy(), marker["R"].copy()
    R = np.empty((3, 3))
    euler_to_matrix(q[at + 3 : at + 7], R)
    return R.T @ (marker["r"] - q[at : at + 3]), R.T @ marker["R"]


def _counted(turns: Mapping[str, float], markers: tuple[str, str]) -> float:
    """Return the turn between two markers as the system counts it, 0.0 if it does not."""
    return turns.get(Coordinate("turn", "x").branch(*markers), 0.0)


def motion_rows(system, tree, markers, q) -> np.ndarray:
    """Return the rows of the bodies of a tree, in its order; `markers` of an evaluation at the assembled position q."""
    tables, model, slices = tree.tables, system.model, system.slices
    turns = dict(zip(system.branch_names, q[system.program.branches :].tolist(), strict=True))
    rows = np.zeros(len(tree.order), MOTION)
    iq = iv = 0
    for k, (name, row) in enumerate(zip(tree.order, rows, strict=True)):
        at_q, at_u = slices[name]
        frame = system.has_frame(name)
        modes = at_u.stop - at_u.start - 6 * frame
        row["iq"], row["iv"], row["q"], row["u"] = iq, iv, at_q.start, at_u.start
        row["modes"], row["own"], row["other"] = modes, tables.outer[k], tables.inner[k]
        row["parent_q"] = tables.iq[tables.parent[k]] if tables.parent[k] >= 0 else -1
        if not frame:
            row["held"] = POINTS
        elif name not in tree.joints:
            row["held"], row["coordinates"], row["rates"] = FREE, 7, 6
        else:
            joint = system.joints[system.joint_index[tree.joints[name]]]
            a, b = (system.marker_index[m] for m in joint.resolved_markers(model))
            row["forward"] = int(b == tables.outer[k])
            first, second = ((markers[m]["r"].copy(), markers[m]["R"].copy()) for m in (a, b))
            _hinge(row, joint, first, second, _counted(turns, joint.resolved_markers(model)))
            rigid = (modes == 0, row["parent_q"] < 0 or rows[tables.parent[k]]["modes"] == 0)
            for end, (marker, at) in enumerate(((row["own"], row["q"]), (row["other"], row["parent_q"]))):
                row["fixed"][end] = rigid[end]
                row["place"][end], row["axes"][end] = _in_body(markers[marker], q, int(at))
        iq += row["coordinates"] + row["modes"]
        iv += row["rates"] + row["modes"]
    return rows


def labels(system, tree, rows) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names of the coordinates and of the rates of a tree (`Spanning`) with these rows."""
    q: list[str] = []
    v: list[str] = []
    for name, row in zip(tree.order, rows, strict=True):
        if row["held"] == HINGED:
            joint = system.joints[system.joint_index[tree.joints[name]]]
            of_q, of_v = _joint_labels(joint)
            q += of_q
            v += of_v
        elif row["held"] == FREE:
            q += [f"{name}.frame_{k}" for k in range(7)]
            v += [f"{name}.frame_{k}" for k in range(6)]
        modes = [f"{name}.mode_{k + 1}" for k in range(row["modes"])]
        q += modes
        v += modes
    return tuple(q), tuple(v)


def counted_turns(system, rows) -> tuple[tuple[int, int], ...]:
    """Return the turns that the model counts: (place in q, number of the branch)."""
    found = []
    names = {number: name for name, number in system.marker_index.items()}
    branches = {name: k for k, name in enumerate(system.branch_names)}
    for row in rows:
        if row["held"] != HINGED or row["turn"] < 0:
            continue
        a, b = (row["other"], row["own"]) if row["forward"] else (row["own"], row["other"])
        branch = Coordinate("turn", "z" if row["turn_b"] >= 0 else "x").branch(names[a], names[b])
        if branch in branches:
            found.append((int(row["iq"] + row["turn"]), branches[branch]))
    return tuple(found)


def euler_places(rows) -> np.ndarray:
    """Return the places (n, 4) of all Euler parameters among the coordinates of a tree."""
    free, balls = rows["held"] == FREE, (rows["held"] == HINGED) & (rows["ball"] >= 0)
    first = np.concatenate([rows["iq"][free] + 3, rows["iq"][balls] + rows["ball"][balls]])
    return first[:, None] + np.arange(4)
