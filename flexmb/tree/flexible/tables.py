"""Flexible links by constants: the numbers of a body for its present shape and rates, its markers, and scratch.

What is linear in the modal coordinates stands in one long row for each mode, so that a shape is one sum of rows.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from flexmb.math.structures import ArrayOf, FloatRows, Floats, IntegerRows, Integers, structure
from flexmb.model.modal_link import ModalLink
from flexmb.tree.rigid.places import BEND, MOUNT

__all__ = ["BENT", "FACTOR", "PLACE", "RIGID", "WIDE", "Flexible", "Packed", "new_flexible"]

Cubes = Annotated[np.ndarray, ArrayOf(float, 3)]

RIGID, JOINT = 0, 1
"""Links without anything flexible on them, and a joint with it: see `Flexible.runs`."""

BENT = np.dtype(
    [
        ("link", np.int64),  # place of its link
        ("m", np.int64),  # modes
        ("coordinate", np.int64),  # place of its first modal coordinate
        ("rate", np.int64),  # place of its first modal rate
        ("q", np.int64),  # first coordinate and velocity of the body
        ("u", np.int64),
        ("constants", np.int64),  # first of its numbers, see `Packed`
        ("stiffened", np.int64),  # matrices of geometric stiffness: 12 of inertia or none,
        ("by_inertia", np.int64),
        ("by_interfaces", np.int64),  # six for each of so many interfaces,
        ("by_loads", np.int64),  # one for each load shape or none, and the last one of the preload
        ("shapes", np.int64),  # load shapes
        ("turning", np.int64),  # matrices by which they turn
        ("first_load", np.int64),  # place of the first amount in work.loads
        ("clamp", np.int64),  # place of its own marker among the flexible places, -1: the frame itself
        ("first", np.int64),  # other markers of it that carry links or are seen: from here
        ("last", np.int64),  # to before here
    ],
    align=True,
)
"""A flexible body."""

PLACE = np.dtype(
    [
        ("link", np.int64),  # place of the link that it is, -1 of a clamp
        ("body", np.int64),  # place of the flexible body
        ("loaded", np.int64),  # 1: carries links
        ("interface", np.int64),  # number of the interface whose wrench stiffens the body, -1: none
        (
            "at",
            np.int64,
        ),  # modal columns of its twist at the body's origin (6, m), with stiffening (6, m), its lever (3,)
        ("shapes", np.int64),  # translation and rotation shapes (3, m) each among the constants
        ("s", float, 3),  # m, undeformed, in body axes
        ("A", float, (3, 3)),  # axes there
    ],
    align=True,
)
"""A marker of a flexible body."""

WIDE = np.dtype([("P", float, (6, 6)), ("gain", float, 6)], align=True)
"""Articulated inertia that need not be symmetric, and the column P S D of one freedom."""

FACTOR = np.dtype([("D", float, (6, 6)), ("column", float, (3, 3)), ("row", float, (3, 3))], align=True)
"""Of several freedoms: the inverse of their inertia; of a ball, C J^-1 and J^-1 B of [J, B; C, M]."""

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
"""Order of the six numbers of a symmetric matrix."""


@structure
class Flexible(NamedTuple):
    """The flexible links of a tree, and the links that carry them."""

    bodies: Annotated[np.ndarray, ArrayOf(BENT)]
    places: Annotated[np.ndarray, ArrayOf(PLACE)]
    wide: Annotated[np.ndarray, ArrayOf(WIDE)]
    wide_of: Integers
    """(nl,) place of a link's wide inertia, -1: its inertia is symmetric, nothing flexible hangs on it"""
    runs: IntegerRows
    """(nr, 3) links from the first to before the last, and what they are: RIGID without anything flexible, one JOINT,
    the frame of one flexible body (BEND), one of its markers (MOUNT)"""
    factors: Annotated[np.ndarray, ArrayOf(FACTOR)]
    """of wide links of several freedoms, by their blocks"""
    constants: Floats
    shapes: Cubes
    """(np, 6, mm) translation and rotation shapes of the places, for up to mm modes as in what follows"""
    E: Cubes
    """(np, 6, mm) modal columns of their twists at the origin of the body"""
    loaded: Cubes
    """(np, 6, mm) the same with what wrenches do through the stiffness"""
    lever: FloatRows
    """(np, 3) m, places in the body"""
    L: Cubes
    """(nb, mm, 8) of the bodies: K^-1 (L, h)"""
    K: Cubes
    """(nb, mm, mm) factors"""
    B: Cubes
    """(nb, 6, mm)"""
    eta: FloatRows
    """(nb, mm) modal second rates at rate zero"""
    product: FloatRows
    """(6, mm) scratch, as the next"""
    scratch: FloatRows
    """(3, n)"""
    rows: Floats
    """what the transposed wrenches of unit multipliers leave at joints and modes"""
    wrench: FloatRows
    """(nl, 6) scratch of these, zero between calls"""
    upper: Floats
    """upper half of the mobility matrix of the cut equations, by columns, then its factor"""


class Packed:
    """The constants of flexible bodies, one after another; bodies with the same numbers share them.

    For each mode a row of ww2 (6, m), wn1 (3, m), vw1 (9,), stiffness (m,), geometric stiffness (n, m); then one of
    wn1 (3, m), its part that changes sign with the order of two modes, twice (3, m), vw1 (9,), damping (m,); then ww1
    (6, m), wn0 (3, m), vn (3, m), vw1 (9, m), vw0 (9,), nn (m, m), mean (6, m), load shapes, their turning.
    """

    def __init__(self):
        self.known: dict[bytes, int] = {}
        self.parts: list[np.ndarray] = []
        self.shapes: list[np.ndarray] = []
        self.size = 0

    def add(self, numbers: np.ndarray) -> int:
        """Return where numbers stand."""
        numbers = np.ascontiguousarray(numbers, float).ravel()
        key = numbers.tobytes()
        if key not in self.known:
            self.known[key] = self.size
            self.parts.append(numbers)
            self.size += len(numbers)
        return self.known[key]

    @property
    def numbers(self) -> np.ndarray:
        """All numbers."""
        return np.concatenate([*self.parts, np.zeros(1)])

    def body(self, row, data: ModalLink) -> None:
        """Write the constants of a body, and where they are to its row (BENT)."""
        m = data.modes
        ww2 = np.stack([data.ww2[:, :, a, b] for a, b in PAIRS], axis=1)  # (m, 6, m)
        ww1 = np.stack([data.ww1[:, a, b] for a, b in PAIRS])  # (6, m)
        groups = (
            data.inertia_stiffening,
            data.interface_stiffening.reshape(-1, m, m),
            data.load_stiffening,
            data.preload_stiffening[None],
        )
        G = np.concatenate(groups) if any(np.any(group) for group in groups) else np.zeros((0, m, m))
        odd = data.wn1 - np.transpose(data.wn1, (2, 1, 0))
        by_shape = [(ww2[j], data.wn1[j], data.vw1[j], data.stiffness[:, j], G[:, j]) for j in range(m)]
        by_rate = [(data.wn1[j], odd[j], data.vw1[j], data.damping[:, j]) for j in range(m)]
        vw1 = data.vw1.reshape(m, 9).T
        fixed = (ww1, data.wn0, data.vn, vw1, data.vw0, data.nn, data.mean, data.load_shapes, data.load_turning)
        parts = [part for rows in (*by_shape, *by_rate, fixed) for part in rows]
        row["m"], row["stiffened"] = m, len(G)
        row["constants"] = self.add(np.concatenate([np.ravel(part) for part in parts]))
        if len(G):
            row["by_inertia"] = len(data.inertia_stiffening)
            row["by_interfaces"], row["by_loads"] = len(data.interface_stiffening), len(data.load_stiffening)
        row["shapes"], row["turning"] = len(data.load_shapes), len(data.load_turning)

    def place(self, row, data: ModalLink, k: int, stiffened: bool) -> None:
        """Write the constants of marker k of a body to its row (PLACE); is the body stiffened at all?"""
        row["s"], row["A"] = data.positions[k], data.axes[k]
        row["interface"] = k if stiffened and k < len(data.interface_stiffening) else -1
        self.shapes.append(np.concatenate([data.translations[k], data.rotations[k]]))


def _runs(links, wide_of) -> np.ndarray:
    """Return the runs of links of one kind, rigid ones as long as they are."""
    runs: list[list[int]] = []
    for k, (link, wide) in enumerate(zip(links, wide_of, strict=True)):
        kind = int(link["kind"]) if link["kind"] in (BEND, MOUNT) else JOINT if wide >= 0 else RIGID
        if kind == RIGID and runs and runs[-1][2] == RIGID:
            runs[-1][1] = k + 1
        else:
            runs.append([k, k + 1, kind])
    return np.array(runs, np.int64).reshape(-1, 3)


def new_flexible(links, bodies, places, packed: Packed, wide_of, numbers: int, profile: int) -> Flexible:
    """Return the flexible links of a tree; `numbers` of its paths from cut equations, `profile` of their matrix."""
    nb, count = len(bodies), len(places)
    most = max((int(row["m"]) for row in bodies), default=1)
    size = max((int(row["m"] * (10 + row["stiffened"])) + 9 for row in bodies), default=1)
    shapes = np.zeros((count, 6, most))
    for own, given in zip(shapes, packed.shapes, strict=True):
        own[:, : given.shape[1]] = given
    wide = int(np.sum(wide_of >= 0))
    blocks = int(max(links["block"], default=0)) + 1
    return Flexible(
        bodies=np.array(bodies, BENT),
        places=np.array(places, PLACE),
        wide=np.zeros(wide, WIDE),
        wide_of=np.asarray(wide_of, np.int64),
        runs=_runs(links, wide_of),
        factors=np.zeros(blocks if wide else 1, FACTOR),
        constants=packed.numbers,
        shapes=shapes,
        E=np.zeros((count, 6, most)),
        loaded=np.zeros((count, 6, most)),
        lever=np.zeros((count, 3)),
        L=np.zeros((nb, most, 8)),
        K=np.zeros((nb, most, most)),
        B=np.zeros((nb, 6, most)),
        eta=np.zeros((nb, most)),
        product=np.zeros((6, most)),
        scratch=np.zeros((3, size)),
        rows=np.zeros(numbers),
        wrench=np.zeros((len(links) if wide else 0, 6)),
        upper=np.zeros(profile),
    )
