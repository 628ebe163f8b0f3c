"""Flexible links by constants: the numbers of a body for its present shape and rates, its markers, and scratch.

What is linear in the modal coordinates stands in one long row for each mode, so that a shape is one sum of rows.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from flexmb.math.eights import WIDTH
from flexmb.math.structures import ArrayOf, FloatRows, Floats, IntegerRows, Integers, structure
from flexmb.model.modal_link import ModalLink
from flexmb.tree.rigid.places import BEND, LINK_STATE, MOUNT

__all__ = ["BENT", "FACTOR", "PLACE", "RIGID", "RUN", "WIDE", "Flexible", "Packed", "new_flexible", "wide_places"]

Cubes = Annotated[np.ndarray, ArrayOf(float, 3)]

RIGID, JOINT = 0, 1
"""Links without anything flexible on them, and a joint with it: see `Flexible.runs`."""

BENT = np.dtype(
    [
        ("link", np.int32),  # place of its link
        ("m", np.int32),  # modes
        ("coordinate", np.int32),  # place of its first modal coordinate
        ("rate", np.int32),  # place of its first modal rate
        ("q", np.int32),  # first coordinate and velocity of the body
        ("u", np.int32),
        ("constants", np.int32),  # first of its numbers, see `Packed`
        ("stiffened", np.int32),  # matrices of geometric stiffness: 12 of inertia or none,
        ("by_inertia", np.int32),
        ("by_interfaces", np.int32),  # six for each of so many interfaces whose wrench does so,
        ("by_loads", np.int32),  # one for each load shape or none,
        ("preloaded", np.int32),  # and one of the preload or none
        ("shapes", np.int32),  # load shapes
        ("turning", np.int32),  # matrices by which they turn
        ("first_load", np.int32),  # place of the first amount in work.loads
        ("kept", np.int32),  # place of its K and B
        ("clamp", np.int32),  # place of its own marker among the flexible places, -1: the frame itself
        ("first", np.int32),  # other markers of it that carry links or are seen: from here
        ("last", np.int32),  # to before here
    ],
    align=True,
)
"""A flexible body."""

PLACE = np.dtype(
    [
        ("link", np.int32),  # place of the link that it is, -1 of a clamp
        ("body", np.int32),  # place of the flexible body
        ("loaded", np.int32),  # 1: carries links,
        ("rigid", np.int32),  # 1: some of them without anything flexible,
        ("wide", np.int32),  # 1: some of them with it
        ("kept", np.int32),  # place of its columns, of all places the first where no loops need them later
        ("interface", np.int32),  # number among the interfaces whose wrench stiffens the body, -1: none of them
        ("shapes", np.int32),  # place of its shapes and of where it is undeformed: `Flexible.shapes`
    ],
    align=True,
)
"""A marker of a flexible body."""

WIDE = np.dtype([("P", float, (6, WIDTH)), ("gain", float, 6)], align=True)
"""Articulated inertia that need not be symmetric, with two columns of zeros, and the column P S D of one freedom."""

FACTOR = np.dtype([("D", float, (6, 6)), ("column", float, (3, 3)), ("row", float, (3, 3))], align=True)
"""Of several freedoms: the inverse of their inertia; of a ball, C J^-1 and J^-1 B of [J, B; C, M]."""

RUN = np.dtype(
    [
        ("first", np.int32),  # links from here
        ("last", np.int32),  # to before here
        ("kind", np.int32),  # RIGID without anything flexible, one JOINT, BEND or MOUNT
        ("gives_first", np.int32),  # 1: it is the first to give an inertia to its parent
        ("light", np.int32),  # 1: a joint without inertia of its own, or of rigid links on it
        ("block", np.int32),  # place of the flexible body, or of the marker
        ("place", np.int32),  # of the marker, or the body's own one, or the first
        ("kept", np.int32),  # bytes of its numbers at a state that passes use: `LINK_STATE`
    ],
    align=True,
)
"""Links of one kind, one after another."""

FOUR = 4 * WIDTH
"""Numbers of a row that are summed up together."""

LINE = 64
"""Bytes that the processor's memory takes at once; eight numbers."""

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
"""Order of the six numbers of a symmetric matrix."""


@structure
class Flexible(NamedTuple):
    """The flexible links of a tree, and the links that carry them."""

    bodies: Annotated[np.ndarray, ArrayOf(BENT)]
    places: Annotated[np.ndarray, ArrayOf(PLACE)]
    wide: Annotated[np.ndarray, ArrayOf(WIDE)]
    wide_of: Integers
    """(nl,) place of a link's wide inertia, -1: its inertia is symmetric, nothing flexible hangs on it; links share one
    if it is not needed after the pass from the leaves"""
    runs: Annotated[np.ndarray, ArrayOf(RUN)]
    factors: Annotated[np.ndarray, ArrayOf(FACTOR)]
    """of wide links of several freedoms, by their blocks"""
    constants: Floats
    shapes: Cubes
    """(ns, 6, mm) translation and rotation shapes of places, which equal places share, for up to mm modes, eights of
    them as in what follows"""
    rises: Cubes
    """(ns, mm, 8) the same by modes"""
    rests: FloatRows
    """(ns, 12) m, their undeformed places in body axes, and the axes there, row by row"""
    present: FloatRows
    """(np, 12) m, places in the body, and T (3, 3) of what turned them, row by row"""
    E: Cubes
    """(nk, 6, mm) modal columns of their twists at the origin of the body; kept of every place where loops need them"""
    loaded: Cubes
    """(nk, 6, mm) the same with what wrenches do through the stiffness"""
    L: Cubes
    """(nb, mm, 8) of the bodies: K^-1 (L, h)"""
    K: Cubes
    """(nk, mm, mm) factors; kept of every body where loops need them"""
    pivots: IntegerRows
    """(nk, mm) rows that the factorisation exchanged, see `eliminate`"""
    B: Cubes
    """(nk, 6, mm)"""
    eta: FloatRows
    """(nb, mm) modal second rates at rate zero"""
    scratch: FloatRows
    """(2, n)"""
    P: FloatRows
    """(6, 8) inertia of a body's frame and force, scratch as what is around"""
    moved: FloatRows
    """(6, 8) the same of what a place carries, at the frame"""
    zeros: FloatRows
    """(6, 8), no inertia"""
    rows: Floats
    """what the transposed wrenches of unit multipliers leave at joints and modes"""
    wrench: FloatRows
    """(nl, 6) scratch of these, zero between calls"""
    upper: Floats
    """upper half of the mobility matrix of the cut equations, by columns, then its factor"""


def _filled(numbers: np.ndarray) -> np.ndarray:
    """Return numbers with zeros behind them, up to a whole number of eights."""
    numbers = np.asarray(numbers, float)
    return np.pad(numbers, [(0, 0)] * (numbers.ndim - 1) + [(0, -numbers.shape[-1] % WIDTH)])


def _by_fours(groups) -> np.ndarray:
    """Return rows (m, n) of groups, filled up: first the first four eights of all rows, then the next four."""
    rows = np.concatenate([_filled(group) for group in groups], axis=-1)
    rows = np.pad(rows, [(0, 0), (0, -rows.shape[1] % FOUR)])
    return rows.reshape(len(rows), -1, FOUR).transpose(1, 0, 2)


def _stiffening(data: ModalLink) -> list[int]:
    """Return the interfaces whose wrench stiffens a body; that of the one which carries it is balanced there."""
    return [k for k, matrices in enumerate(data.interface_stiffening) if np.any(matrices)]


class Packed:
    """The constants of flexible bodies, one after another; bodies with the same numbers share them.

    Rows over the modes are filled up to eights, mm numbers. For each mode a row of ww2 (6, mm), wn1 (3, mm), stiffness
    (mm,), geometric stiffness (n, mm), vw1 (9,), by fours of eights of columns; then one of wn1 (3, mm), its part that
    changes sign with the order of two modes, twice (3, mm), damping (mm,), vw1 (9,); then ww1 (6, mm), wn0 (3, mm),
    vn (3, mm), vw1 (9, mm), nn (m, mm), mean (6, mm), mass, ww0 (6,), vw0 (9,), load shapes, their turning.
    """

    def __init__(self):
        self.known: dict[bytes, int] = {}
        self.parts: list[np.ndarray] = []
        self.shapes: list[np.ndarray] = []
        self.rests: list[np.ndarray] = []
        self.known_shapes: dict[bytes, int] = {}
        self.bodies: dict[int, tuple[ModalLink, dict[str, int]]] = {}
        self.places: dict[tuple[int, int], int] = {}
        self.size = 0

    def add(self, numbers: np.ndarray) -> int:
        """Return where numbers stand."""
        numbers = _filled(np.ravel(numbers))
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
        if id(data) not in self.bodies:
            self.bodies[id(data)] = data, self._packed(data)
        for name, value in self.bodies[id(data)][1].items():
            row[name] = value

    def _packed(self, data: ModalLink) -> dict[str, int]:
        """Add the constants of a body and return what its row (BENT) says of them."""
        m = data.modes
        ww2 = np.stack([data.ww2[:, :, a, b] for a, b in PAIRS], axis=1)  # (m, 6, m)
        ww1 = np.stack([data.ww1[:, a, b] for a, b in PAIRS])  # (6, m)
        groups = (
            data.inertia_stiffening,
            data.interface_stiffening[_stiffening(data)].reshape(-1, m, m),
            data.load_stiffening,
            data.preload_stiffening[None][: int(np.any(data.preload_stiffening))],
        )
        G = np.concatenate(groups) if any(np.any(group) for group in groups) else np.zeros((0, m, m))
        odd = data.wn1 - np.transpose(data.wn1, (2, 1, 0))
        vw1 = data.vw1.reshape(m, 9)
        pairs, spins = (np.moveaxis(group, 1, 0) for group in (ww2, data.wn1))
        by_shape = (*pairs, *spins, data.stiffness.T, *G, vw1)
        by_rate = (*spins, *np.moveaxis(odd, 1, 0), data.damping.T, vw1)
        parts = [_by_fours(by_shape), _by_fours(by_rate)]
        parts += [_filled(rows) for rows in (ww1, data.wn0, data.vn, vw1.T, data.nn, data.mean)]
        parts += [np.array([data.mass]), data.ww0[np.triu_indices(3)], data.vw0, data.load_shapes, data.load_turning]
        return {
            "m": m,
            "constants": self.add(np.concatenate([np.ravel(part) for part in parts])),
            "stiffened": len(G),
            "by_inertia": len(data.inertia_stiffening) if len(G) else 0,
            "by_interfaces": len(_stiffening(data)) if len(G) else 0,
            "by_loads": len(data.load_stiffening) if len(G) else 0,
            "preloaded": int(np.any(data.preload_stiffening)),
            "shapes": len(data.load_shapes),
            "turning": len(data.load_turning),
        }

    def place(self, row, data: ModalLink, k: int, stiffened: bool) -> None:
        """Write the constants of marker k of a body to its row (PLACE); is the body stiffened at all?"""
        row["interface"] = _stiffening(data).index(k) if stiffened and k in _stiffening(data) else -1
        if (id(data), k) not in self.places:
            self.places[id(data), k] = self._shaped(data, k)
        row["shapes"] = self.places[id(data), k]

    def _shaped(self, data: ModalLink, k: int) -> int:
        """Return the place of the shapes of marker k of a body, whose constants were added."""
        rest = np.concatenate([data.positions[k], np.ravel(data.axes[k])])
        shapes = np.ascontiguousarray(np.concatenate([data.translations[k], data.rotations[k]]))
        place = self.known_shapes.setdefault(shapes.tobytes() + rest.tobytes(), len(self.shapes))
        if place == len(self.shapes):
            self.shapes.append(shapes)
            self.rests.append(rest)
        return place


def _runs(links, wide_of, bodies) -> np.ndarray:
    """Return the runs of links of one kind, rigid ones as long as they are."""
    runs: list[np.ndarray] = []
    fields = LINK_STATE.fields or {}
    last = {int(link["parent"]): k for k, (link, wide) in enumerate(zip(links, wide_of, strict=True)) if wide >= 0}
    loaded = {int(link["parent"]) for link, wide in zip(links, wide_of, strict=True) if wide < 0}
    for k, (link, wide) in enumerate(zip(links, wide_of, strict=True)):
        kind = int(link["kind"]) if link["kind"] in (BEND, MOUNT) else JOINT if wide >= 0 else RIGID
        if kind == RIGID and runs and runs[-1]["kind"] == RIGID:
            runs[-1]["last"] = k + 1
            continue
        own = link["mass"] != 0.0 or np.any(link["h"]) or np.any(link["J"])
        run = np.zeros((), RUN)
        run["first"], run["last"], run["kind"], run["block"] = k, k + 1, kind, link["block"]
        run["gives_first"] = last.get(int(link["parent"]), -1) == k
        run["light"] = kind == JOINT and not own and k not in loaded
        run["place"] = max(0, int(bodies[int(link["block"])]["clamp"])) if kind == BEND else link["block"]
        uses_all = kind == JOINT and not run["light"]
        run["kept"] = LINK_STATE.itemsize if uses_all else fields["J" if kind == JOINT else "gain"][1]
        runs.append(run)
    return np.array(runs, RUN).reshape(-1)


def wide_places(links, carries, kept) -> np.ndarray:
    """Return the place of each link's wide inertia, -1 of links that do not carry anything flexible.

    Inertias pass from the leaves to the roots. A link gives its place back as soon as its parent has its inertia, so
    that a chain gets along with three, which stay in the nearest memory; links that are `kept` (nl,) have their own.
    Frames of flexible bodies, whose inertia goes to the joint at once, share the first.
    """
    places = np.where(links["kind"] == BEND, 0, -1)
    free: list[int] = []
    count = 1

    def take(k: int) -> None:
        nonlocal count
        if k >= 0 and carries[k] and places[k] < 0:
            places[k] = free.pop() if free and not kept[k] else count
            count += int(places[k] == count)

    mounts: dict[int, list[int]] = {}
    for n in np.flatnonzero((links["kind"] == MOUNT) & carries).tolist():
        mounts.setdefault(int(links[n]["parent"]), []).append(n)
    for k in range(len(links) - 1, -1, -1):
        bends = links[k]["kind"] == BEND
        if not carries[k] or links[k]["kind"] == MOUNT:  # its body takes its inertia
            continue
        done = mounts.get(k, []) if bends else [k]
        for n in done:
            take(n)
        if bends:
            free += [int(places[n]) for n in done if not kept[n]]
        take(int(links[k]["parent"]))
        if not bends and not kept[k]:
            free.append(int(places[k]))
    return places


def _zeros(shape, dtype=float) -> np.ndarray:
    """Return zeros that begin where a line of the processor's memory begins, so that no eight lie in two lines."""
    dtype, count = np.dtype(dtype), int(np.prod(shape))
    room = np.zeros(count * dtype.itemsize + LINE, np.uint8)
    first = -room.ctypes.data % LINE
    return room[first : first + count * dtype.itemsize].view(dtype).reshape(shape)


def _placed(numbers: np.ndarray) -> np.ndarray:
    """Return the same numbers, from the beginning of a line on."""
    placed = _zeros(numbers.shape, numbers.dtype)
    placed[...] = numbers
    return placed


def _tell_carried(links, wide_of, places) -> None:
    """Tell the places what hangs on them."""
    carried = {int(row["link"]): row for row in places if row["link"] >= 0}
    for link, wide in zip(links, wide_of, strict=True):
        if int(link["parent"]) in carried:
            carried[int(link["parent"])]["wide" if wide >= 0 else "rigid"] = 1


def new_flexible(links, bodies, places, packed: Packed, wide_of, numbers: int, profile: int) -> Flexible:
    """Return the flexible links of a tree; `numbers` of its paths from cut equations, `profile` of their matrix."""
    nb, count = len(bodies), len(places)
    kept, loaded = (nb, count) if numbers else (min(nb, 1), min(count, 1))
    for rows in (bodies, places):
        for k, row in enumerate(rows):
            row["kept"] = k if numbers else 0
    _tell_carried(links, wide_of, places)
    most = -(-max((int(row["m"]) for row in bodies), default=1) // WIDTH) * WIDTH
    size = max((most * (10 + int(row["stiffened"])) for row in bodies), default=1) + 2 * WIDTH + FOUR
    rests = np.array(packed.rests, float).reshape(-1, 12)
    shapes = _zeros((len(packed.shapes), 6, most))
    rises = _zeros((len(packed.shapes), most, WIDTH))
    for own, turned, given in zip(shapes, rises, packed.shapes, strict=True):
        own[:, : given.shape[1]] = given
        turned[: given.shape[1], :6] = given.T
    wide = int(max(wide_of, default=-1)) + 1
    blocks = int(max(links["block"], default=0)) + 1
    return Flexible(
        bodies=np.array(bodies, BENT),
        places=np.array(places, PLACE),
        wide=_zeros(wide, WIDE),
        wide_of=np.asarray(wide_of, np.int64),
        runs=_runs(links, wide_of, bodies),
        factors=np.zeros(blocks if wide else 1, FACTOR),
        constants=_placed(packed.numbers),
        shapes=shapes,
        rises=rises,
        rests=rests,
        present=np.zeros((count, 12)),
        E=_zeros((loaded, 6, most)),
        loaded=_zeros((loaded, 6, most)),
        L=_zeros((nb, most, 8)),
        K=_zeros((kept, most, most)),
        pivots=np.full((kept, most), -1, np.int64),
        B=_zeros((kept, 6, most)),
        eta=_zeros((nb, most)),
        scratch=_zeros((2, size)),
        P=_zeros((6, WIDTH)),
        moved=_zeros((6, WIDTH)),
        zeros=_zeros((6, WIDTH)),
        rows=np.zeros(numbers),
        wrench=np.zeros((len(links) if wide else 0, 6)),
        upper=np.zeros(profile),
    )
