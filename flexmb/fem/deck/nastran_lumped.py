"""Masses, springs and dampers of a Nastran deck: CONM1/2, CMASS1-4, CELAS1-4, CBUSH, CBUSH1D, CDAMP1-4, CVISC."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexmb.fem.deck.contents import Deck, Lumped
from flexmb.fem.deck.links import Frames, rows_of
from flexmb.fem.deck.nastran_scalar import scalar_ends
from flexmb.fem.deck.nastran_systems import Systems
from flexmb.fem.deck.nastran_text import Bulk, Card
from flexmb.math.definiteness import semidefinite

__all__ = ["add_masses", "add_springs", "scalar_values"]


def add_masses(bulk: Bulk, deck: Deck, frames: Frames, systems: Systems) -> None:
    """Add concentrated masses."""
    for card in bulk.of("CONM2"):
        _conm2(card, deck, frames, systems)
    for card in bulk.of("CONM1"):
        node = _node(card, deck, 2)
        turn = _turn(card, deck, node, frames, systems, 3)
        matrix, at = np.zeros((6, 6)), 4
        for i in range(6):
            for j in range(i + 1):
                matrix[i, j] = matrix[j, i] = card.real(at, 0.0)
                at += 1
        _add(deck, card, "mass", (node,), turn.T @ matrix @ turn)
    value = scalar_values(bulk)
    for card in bulk.of("CMASS1", "CMASS2", "CMASS3", "CMASS4"):
        _scalar(card, deck, frames, "mass", value(card))
    for card in bulk.of("CDAMP5"):
        deck.inventory.left_out[f"{card.name}: capacity of heat"] += 1


def _conm2(card: Card, deck: Deck, frames: Frames, systems: Systems) -> None:
    """M at X from the node, in CID: -1 gives the place itself in the basic system; I21, I31, I32 are int xy dm ..."""
    node = _node(card, deck, 2)
    cid, mass = card.integer(3, 0), card.real(4, 0.0)
    offset = np.array([card.real(5 + k, 0.0) for k in range(3)])
    i11, i21, i22, i31, i32, i33 = (card.real(9 + k, 0.0) for k in range(6))
    inertia = np.array([[i11, -i21, -i31], [-i21, i22, -i32], [-i31, -i32, i33]])
    if cid == -1:
        offset = offset - deck.points[node]
    elif cid:
        axes = systems.system(cid, card.where).directions(deck.points[node : node + 1])[0]
        offset, inertia = offset @ axes, axes.T @ inertia @ axes
    if mass < 0.0 or not semidefinite(inertia):
        raise card.refused(f"mass {mass:g}, inertia {inertia.tolist()}", "a mass and an inertia that are not negative")
    x, y, z = offset
    arm = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = mass * np.eye(3)
    matrix[:3, 3:], matrix[3:, :3] = -mass * arm, -mass * arm.T
    matrix[3:, 3:] = mass * arm.T @ arm + inertia
    _add(deck, card, "mass", (node,), matrix)


def add_springs(bulk: Bulk, deck: Deck, frames: Frames, systems: Systems) -> None:
    """Add springs and dampers; bushings act at their own place between the two nodes."""
    value = scalar_values(bulk)
    for card in bulk.of("CELAS1", "CELAS2", "CELAS3", "CELAS4"):
        _scalar(card, deck, frames, "stiffness", value(card))
    for card in bulk.of("CDAMP1", "CDAMP2", "CDAMP3", "CDAMP4"):
        _scalar(card, deck, frames, "damping", value(card))
    bushings = {card.integer(1): card for card in bulk.of("PBUSH", "PBUSH1D")}
    for card in bulk.of("CBUSH"):
        _bush(card, deck, frames, systems, bushings)
    for card in bulk.of("CBUSH1D"):
        _bush1d(card, deck, systems, bushings)
    viscous = {}
    for card in bulk.of("PVISC"):  # two properties a card
        for at in (1, 5):
            if card.text(at):
                viscous[card.integer(at)] = (card.real(at + 1, 0.0), card.real(at + 2, 0.0))
    for card in bulk.of("CVISC"):
        pid = card.integer(2, card.integer(1))
        if pid not in viscous:
            raise card.refused(f"the property {pid}, which does not exist", "a PVISC card")
        a, b = _node(card, deck, 3), _node(card, deck, 4)
        axes = np.eye(3)
        axes[0] = _along(card, deck, a, b)
        axes[1:] = 0.0
        c = np.diag([viscous[pid][0], 0.0, 0.0, viscous[pid][1], 0.0, 0.0])
        _add(deck, card, "damping", (a, b), _between(c, axes, np.zeros(3), np.zeros(3)))


def _values(bulk: Bulk, name: str, places: tuple[int, ...], after: int) -> dict[int, float]:
    """Return the values of scalar properties by number; several may stand on one card."""
    return {
        card.integer(at): card.real(at + after, 0.0)
        for card in bulk.of(name)
        for at in places
        if card.text(at) and not card.is_real(at)
    }


def scalar_values(bulk: Bulk) -> Callable[[Card], float]:
    """Return the function that gives stiffness, damping or mass of a scalar element, its own or its property's."""
    tables = {
        "CELAS": _values(bulk, "PELAS", (1, 5), 1),
        "CDAMP": _values(bulk, "PDAMP", (1, 3, 5, 7), 1),
        "CMASS": _values(bulk, "PMASS", (1, 3, 5, 7), 1),
    }

    def value(card: Card) -> float:
        if card.name.endswith(("2", "4")):
            return card.real(2)
        pid = card.integer(2, card.integer(1))
        if pid not in tables[card.name[:5]]:
            raise card.refused(f"the property {pid}, which does not exist", "its property card")
        return tables[card.name[:5]][pid]

    return value


def _scalar(card: Card, deck: Deck, frames: Frames, kind: str, value: float) -> None:
    """Add value * (u_1 - u_2)^2 / 2 between two freedoms of grid points or scalar points; one may be ground."""
    ends = []
    for label, direction in scalar_ends(card, deck):
        if direction < 0:
            point = deck.scalar_points[label]
            if point is None:
                deck.inventory.left_out[f"{card.name} at scalar point {label}, which no grid point moves"] += 1
                return
            ends.append((point.node, point.row))
        else:
            node = int(deck.numbers([label], f"{card.where}, {card.name} {card.text(1)}")[0])
            ends.append((node, rows_of(node, [direction], frames)[0]))
    if not ends:
        raise card.refused("no grid point", "one or two grid points with a component")
    nodes = tuple(node for node, _ in ends)
    if len(ends) == 2 and nodes[0] == nodes[1]:
        row, nodes = ends[0][1] - ends[1][1], nodes[:1]
    else:
        row = np.concatenate([(1.0, -1.0)[k] * r for k, (_, r) in enumerate(ends)])
    _add(deck, card, kind, nodes, value * np.outer(row, row))


def _bush(card: Card, deck: Deck, frames: Frames, systems: Systems, properties: dict[int, Card]) -> None:
    pid = card.integer(2, card.integer(1))
    if pid not in properties or properties[pid].name != "PBUSH":
        raise card.refused(f"the property {pid}, which does not exist", "a PBUSH card")
    values = _pbush(properties[pid], deck)
    a = _node(card, deck, 3)
    b = _node(card, deck, 4) if card.text(4) and card.integer(4) else None
    axes = _bush_axes(card, deck, frames, systems, a, b)
    s = card.real(9, 0.5)  # S, OCID, S1, S2, S3 are the first fields of the continuation
    if card.text(10) and card.integer(10) >= 0:
        system = systems.system(card.integer(10), card.where)
        place = system.points(np.array([[card.real(11 + k, 0.0) for k in range(3)]]))[0]
    elif b is None:
        place = deck.points[a]
    else:
        place = (1.0 - s) * deck.points[a] + s * deck.points[b]
    for kind in ("stiffness", "damping"):
        diagonal = values.get(kind)
        if diagonal is None or not diagonal.any():
            continue
        matrix = np.diag(diagonal)
        if b is None:
            full = _grounded(matrix, axes, place - deck.points[a])
            _add(deck, card, kind, (a,), full, count=kind == "stiffness")
        else:
            full = _between(matrix, axes, place - deck.points[a], place - deck.points[b])
            _add(deck, card, kind, (a, b), full, count=kind == "stiffness")


def _pbush(card: Card, deck: Deck) -> dict[str, np.ndarray]:
    """Return the diagonals of stiffness and damping of a PBUSH: rows of K, B, GE, RCV, M in any order.

    Programs do not agree on M, one lumped mass or six that add no weight: the inventory names it and GE, a CBUSH at a
    time.
    """
    out: dict[str, np.ndarray] = {}
    names = {"K": "stiffness", "B": "damping"}
    for at in range(2, len(card.fields), 8):
        word = card.text(at).upper()
        known = word in ("K", "B", "GE", "M", "KMAG")
        values = np.array([card.real(at + 1 + k, 0.0) for k in range(6)]) if known else None
        if word in names and values is not None:
            out[names[word]] = values
        elif values is not None and values.any():
            shown = ", ".join(f"{x:g}" for x in values[: np.flatnonzero(values)[-1] + 1])
            what = {"M": "mass", "GE": "structural damping"}.get(word, "stiffness")
            deck.inventory.left_out[f"PBUSH {card.text(1)}: {what} {word} = {shown}"] += 1
    return out


def _bush_axes(card: Card, deck: Deck, frames: Frames, systems: Systems, a: int, b: int | None) -> np.ndarray:
    """Return the axes (3, 3) of a bushing: CID, or along the line of its nodes with GO or a vector."""
    if card.text(8):
        return systems.system(card.integer(8), card.where).directions(deck.points[a : a + 1])[0]
    if b is None:
        return np.eye(3)
    along = deck.points[b] - deck.points[a]
    size = float(np.linalg.norm(along))
    if not size > 1e-12 * max(float(np.abs(deck.points).max()), 1e-300):
        if not card.text(5):
            raise card.refused("coincident nodes without CID", "CID, the system of its axes")
        return np.eye(3)
    if not card.text(5):  # a spring along its line alone needs no more
        return _any_axes(along / size)
    if card.is_real(5) or card.text(6) or card.text(7):
        vector = np.array([card.real(5 + k, 0.0) for k in range(3)]) @ frames.get(a, np.eye(3))
    else:
        vector = deck.points[_node(card, deck, 5)] - deck.points[a]
    x = along / size
    z = np.cross(x, vector)
    if not np.linalg.norm(z) > 1e-9 * np.linalg.norm(vector):
        raise card.refused("an orientation along its line", "a vector across it")
    z /= np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z])


def _any_axes(x: np.ndarray) -> np.ndarray:
    y = np.cross(np.eye(3)[int(np.abs(x).argmin())], x)
    y /= np.linalg.norm(y)
    return np.stack([x, y, np.cross(x, y)])


def _bush1d(card: Card, deck: Deck, systems: Systems, properties: dict[int, Card]) -> None:
    pid = card.integer(2, card.integer(1))
    if pid not in properties:
        raise card.refused(f"the property {pid}, which does not exist", "a PBUSH1D card")
    a, b = _node(card, deck, 3), _node(card, deck, 4)
    source = properties[pid]
    if source.name == "PBUSH1D" and source.real(4, 0.0):
        deck.inventory.left_out[f"PBUSH1D {source.text(1)}: mass M = {source.real(4):g}"] += 1
    axes = np.zeros((3, 3))
    axes[0] = systems.system(card.integer(5), card.where).axes[0] if card.text(5) else _along(card, deck, a, b)
    for kind, value in (("stiffness", source.real(2, 0.0)), ("damping", source.real(3, 0.0))):
        if value:
            matrix = _between(np.diag([value, 0, 0, 0, 0, 0]), axes, np.zeros(3), np.zeros(3))
            _add(deck, card, kind, (a, b), matrix, count=kind == "stiffness")


def _along(card: Card, deck: Deck, a: int, b: int) -> np.ndarray:
    along = deck.points[b] - deck.points[a]
    size = float(np.linalg.norm(along))
    if not size > 0.0:
        raise card.refused("two nodes at one place", "nodes whose line is the direction")
    return along / size


def _between(matrix: np.ndarray, axes: np.ndarray, from_a: np.ndarray, from_b: np.ndarray) -> np.ndarray:
    """Return (12, 12) of a spring (6, 6) in its axes that acts at arms (3,) from its two nodes."""
    relative = np.hstack([-_seen(axes, from_a), _seen(axes, from_b)])
    return relative.T @ matrix @ relative


def _grounded(matrix: np.ndarray, axes: np.ndarray, arm: np.ndarray) -> np.ndarray:
    seen = _seen(axes, arm)
    return seen.T @ matrix @ seen


def _seen(axes: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """Return (6, 6): motion in the axes of a spring, at an arm from a node, from the node's motion."""
    x, y, z = arm
    out = np.zeros((6, 6))
    out[:3, :3] = out[3:, 3:] = axes
    out[:3, 3:] = axes @ np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    return out


def _turn(card: Card, deck: Deck, node: int, frames: Frames, systems: Systems, at: int) -> np.ndarray:
    cid = card.integer(at, 0)
    axes = systems.system(cid, card.where).directions(deck.points[node : node + 1])[0] if cid else np.eye(3)
    turn = np.zeros((6, 6))
    turn[:3, :3] = turn[3:, 3:] = axes
    return turn


def _node(card: Card, deck: Deck, i: int) -> int:
    return int(deck.numbers([card.integer(i)], f"{card.where}, {card.name} {card.text(1)}")[0])


def _add(deck: Deck, card: Card, kind: str, nodes: tuple[int, ...], matrix: np.ndarray, count: bool = True) -> None:
    name = f"{card.name} {card.text(1)}"
    deck.lumped_parts.append(Lumped(kind=kind, nodes=nodes, matrix=0.5 * (matrix + matrix.T), name=name))
    if count:
        deck.inventory.read[card.name] += 1
