"""Scalar points of a Nastran deck (SPOINT, EPOINT): freedoms without a place, and where they move.

A scalar point hangs on grid points by springs, dampers and MPC. What it does when these move as one rigid body,
``u = d . t + m . theta`` about the origin, gives it a place and a direction: a point that moves along d / |d| on the
line whose moment is m / |d|, or turns about m where d is zero. There it becomes a node with one freedom of its own,
and u is |d| (or |m|) times that. The other motions of the node follow a grid point that carries it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexmb.fem.deck.contents import Deck, ScalarPoint
from flexmb.fem.deck.links import Frames, LinkRows, arm, rows_of
from flexmb.fem.deck.nastran_links import thru
from flexmb.fem.deck.nastran_mpc import chosen_mpc, direction_of, terms_of
from flexmb.fem.deck.nastran_text import Bulk, Card

__all__ = ["add_scalar_points", "scalar_ends"]

ALONE = ("CELAS3", "CELAS4", "CMASS3", "CMASS4", "CDAMP3", "CDAMP4")
"""Elements between scalar points: number, property or value, two points."""
JOINING = ("CELAS1", "CELAS2", "CELAS3", "CELAS4", "CDAMP1", "CDAMP2", "CDAMP3", "CDAMP4")
"""Elements by which a point hangs on others; a mass does not hold it."""
SCALAR = (*JOINING, "CMASS1", "CMASS2", "CMASS3", "CMASS4")
SMALL = 1e-6
"""Share below which a rigid motion does not move a scalar point, or the line of one has no pitch."""
LIGHT = 1e-6
"""Weight of a damper beside the stiffest spring: it tells where a point moves where no spring does."""
FIRM = 1e3
"""Weight of an MPC."""

End = tuple[int, int]
"""Number of the deck and direction 0..5; direction -1 is the only one of a scalar point."""
Row = tuple[list[tuple[End, float]], float]
"""``sum factor * u(end) = 0`` and the weight of this equation."""


def scalar_ends(card: Card, deck: Deck) -> list[End]:
    """Return the ends of a scalar element that are not ground; MeshError for a grid point without a component."""
    alone = card.name in ALONE
    ends = []
    for at in (3, 4) if alone else (3, 5):
        if not card.text(at) or card.integer(at) == 0:
            continue
        label, word = card.integer(at), "" if alone else card.text(at + 1)
        if label in deck.scalar_points:
            ends.append((label, -1))
        elif word in ("", "0"):
            raise card.refused(f"point {label} without a component", "a scalar point, or a component 1 to 6")
        elif len(word) == 1 and word in "123456":
            ends.append((label, int(word) - 1))
        else:
            raise card.wrong(at + 1, "one digit out of 1 to 6")
    return ends


def add_scalar_points(bulk: Bulk, deck: Deck, frames: Frames, value: Callable[[Card], float]) -> None:
    """Give every scalar point a node; those that no grid point moves stay without one.

    `value` returns stiffness or damping of an element.
    """
    _name_points(bulk, deck)
    if not deck.scalar_points:
        return
    rows = _rows(bulk, deck, value)
    link = LinkRows("a scalar point")
    for part in _parts(rows):
        _place_part(deck, frames, part, rows, link)
    if link.dependent:
        deck.links.append(link)
    placed = sum(point is not None for point in deck.scalar_points.values())
    deck.inventory.read["SPOINT"] += placed
    deck.inventory.unused["SPOINT that no grid point moves"] += len(deck.scalar_points) - placed


def _name_points(bulk: Bulk, deck: Deck) -> None:
    """List the points of SPOINT and EPOINT cards, and those that an element alone makes one."""
    grids = set(deck.labels.tolist())
    for card in bulk.of("SPOINT", "EPOINT"):
        labels = thru(card, [word for word in card.fields[1:] if word])
        if both := grids & set(labels):
            raise card.refused(f"scalar point {min(both)}, which is a grid point too", "a number of its own")
        deck.scalar_points.update(dict.fromkeys(labels))
    for card in bulk.of(*SCALAR):
        for at in (3, 4) if card.name in ALONE else (3, 5):
            label = card.integer(at) if card.text(at) else 0
            bare = card.name in ALONE or card.text(at + 1) in ("", "0")
            if label and bare and label not in grids:
                deck.scalar_points.setdefault(label, None)


def _rows(bulk: Bulk, deck: Deck, value: Callable[[Card], float]) -> list[Row]:
    """Return what rigid motions of the grid points ask of scalar points, equations on grid points alone left out."""
    rows: list[Row] = []
    springs = [card for card in bulk.of(*JOINING) if any(at < 0 for _, at in scalar_ends(card, deck))]
    stiffest = dict.fromkeys(("CELAS", "CDAMP"), 0.0)
    for card in springs:
        stiffest[card.name[:5]] = max(stiffest[card.name[:5]], abs(value(card)))
    for card in springs:
        ends, most = scalar_ends(card, deck), stiffest[card.name[:5]]
        if len(ends) == 2 and value(card) != 0.0:
            weight = np.sqrt(abs(value(card)) / most) * (1.0 if card.name.startswith("CELAS") else LIGHT)
            rows.append(([(ends[0], 1.0), (ends[1], -1.0)], float(weight)))
    for card in chosen_mpc(bulk):
        terms = [((card.integer(at), direction_of(card, at, deck)), card.real(at + 2)) for at in terms_of(card)]
        if any(at < 0 for (_, at), _ in terms):
            rows.append((terms, FIRM / (max(abs(factor) for _, factor in terms) or 1.0)))
    return rows


def _parts(rows: list[Row]) -> list[list[int]]:
    """Return the scalar points that hang together, a list a part; grid points do not join parts."""
    owner: dict[int, int] = {}

    def root(k: int) -> int:
        while owner.setdefault(k, k) != k:
            k = owner[k]
        return k

    for terms, _ in rows:
        points = [label for (label, at), _ in terms if at < 0]
        for other in points:
            owner[root(other)] = root(points[0])
    found: dict[int, list[int]] = {}
    for label in sorted(owner):
        found.setdefault(root(label), []).append(label)
    return list(found.values())


def _place_part(deck: Deck, frames: Frames, part: list[int], rows: list[Row], link: LinkRows) -> None:
    """Place the points of a part by the least squares motion of its net under rigid motions of the grid points."""
    column = {label: k for k, label in enumerate(part)}
    own = [(terms, w) for terms, w in rows if any(at < 0 and label in column for (label, at), _ in terms)]
    matrix, right = np.zeros((len(own), len(part))), np.zeros((len(own), 6))
    carriers: list[int] = []
    for i, (terms, weight) in enumerate(own):
        for (label, at), factor in terms:
            if at < 0:
                matrix[i, column[label]] += weight * factor
                continue
            node = int(deck.numbers([label], "an element at a scalar point")[0])
            carriers.append(node)
            right[i] -= weight * factor * (rows_of(node, [at], frames) @ _about_origin(deck.points[node]))[0]
    if not carriers:
        return
    motions, _, rank, _ = np.linalg.lstsq(matrix, right, rcond=1e-12)
    if rank < len(part):
        return
    size = float(np.linalg.norm(np.ptp(deck.points[: len(deck.labels)], axis=0))) or 1.0
    for label, motion in zip(part, motions, strict=True):
        deck.scalar_points[label] = _placed(deck, frames, motion, carriers, link, size)


def _about_origin(point: np.ndarray) -> np.ndarray:
    """Return (6, 6): the motion at a point from translation and rotation of a rigid body about the origin."""
    return arm(np.stack([point, np.zeros(3)]), 0, 1)


def _placed(
    deck: Deck, frames: Frames, motion: np.ndarray, carriers: list[int], link: LinkRows, size: float
) -> ScalarPoint | None:
    """Return a scalar point as a node with one freedom; None where a rigid motion does not move it, or as a screw."""
    along, moment = motion[:3], motion[3:]
    factor = float(np.linalg.norm(along))
    turning = factor * size <= SMALL * float(np.linalg.norm(moment))
    if turning:
        factor, along = float(np.linalg.norm(moment)), moment
    if not factor > SMALL:
        return None
    axis = along / factor
    if turning:
        carrier = carriers[0]
        place = deck.points[carrier]
    else:
        arm_of_line = moment / factor
        if abs(arm_of_line @ axis) > SMALL * size:
            return None
        foot = np.cross(axis, arm_of_line)
        at = deck.points[carriers]
        feet = foot + ((at - foot) @ axis)[:, None] * axis
        nearest = int(np.linalg.norm(at - feet, axis=1).argmin())
        carrier, place = carriers[nearest], feet[nearest]
        if np.linalg.norm(place - deck.points[carrier]) <= SMALL * size:
            place = deck.points[carrier]
    node = len(deck.points)
    deck.points = np.vstack([deck.points, place])
    main = int(np.abs(axis).argmax())
    others = [k for k in range(3) if k != main]
    across = np.eye(3)[others] - np.outer(axis[others], axis)
    spin = np.zeros((3 if turning else 2, 6))
    if turning:  # the place moves with the carrier
        spin = np.vstack([np.eye(6)[:3], np.hstack([np.zeros((2, 3)), across])])
        candidates = [0, 1, 2, *(3 + k for k in others)]
    else:
        spin[:, :3] = across
        candidates = others
    freedoms = 6 * node + np.arange(6)
    rigid = arm(deck.points, node, carrier)
    equations = np.hstack([spin, -spin @ rigid])
    used = np.abs(equations).max(axis=0) > 0.0
    columns = np.concatenate([freedoms, 6 * carrier + np.arange(6)])
    link.add_equations(columns[used], equations[:, used], freedoms[candidates], f"Deck '{deck.name}', a scalar point")
    row = np.zeros(6)
    row[slice(3, 6) if turning else slice(0, 3)] = factor * axis
    return ScalarPoint(node=node, row=row, free=int(freedoms[main + (3 if turning else 0)]))
