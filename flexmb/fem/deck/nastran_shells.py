"""Shells of a Nastran deck: triangles and quadrilaterals of both orders with their axes, offsets and thicknesses, and
CSHEAR panels."""

from __future__ import annotations

import numpy as np

from flexmb.fem.deck.cells import first_order_shells
from flexmb.fem.deck.contents import Deck, Shells
from flexmb.fem.deck.nastran_layups import Layup, layup
from flexmb.fem.deck.nastran_materials import Materials
from flexmb.fem.deck.nastran_systems import Systems
from flexmb.fem.deck.nastran_text import Bulk, Card, FieldTable

__all__ = ["add_shells"]

NODES = {"CTRIA3": 3, "CTRIAR": 3, "CQUAD4": 4, "CQUADR": 4, "CTRIA6": 6, "CQUAD8": 8}
TURNLESS = ("CQUAD4", "CTRIA3")
"""Shells whose nodes do not turn in the plane: PARAM, K6ROT holds that rotation by a weak spring."""
K6ROT = 100.0
"""Where the deck does not say; the spring is 1e-6 K6ROT of the shear stiffness in the plane."""


def add_shells(bulk: Bulk, deck: Deck, materials: Materials, systems: Systems) -> None:
    """Add triangles and quadrilaterals; second order becomes first order on all nodes."""
    properties = {card.integer(1): card for card in bulk.of("PSHELL", "PCOMP", "PCOMPG", "PSHEAR", "PLPLANE")}
    made: dict[int, Layup] = {}
    spring = _spring(bulk)
    for name, count in NODES.items():
        table = bulk.tables.get(name)
        if table is None or not len(table):
            continue
        deck.inventory.read[name] += len(table)
        ids = table.integers(1)
        pids = np.where(table.blank(2), ids, table.integers(2))
        for pid in np.unique(pids):
            rows = np.flatnonzero(pids == pid)
            if int(pid) not in made:
                if int(pid) not in properties:
                    raise table.card(int(rows[0])).refused(
                        f"the property {pid}, which does not exist", "a PSHELL, PCOMP or PCOMPG card"
                    )
                made[int(pid)] = layup(properties[int(pid)], materials, deck)
            own = spring if name in TURNLESS else None
            _add_group(table.chosen(rows), count, made[int(pid)], deck, systems, f"pid_{pid}", own)
    cards = bulk.of("CSHEAR")
    if cards:
        _add_panels(cards, properties, deck, materials)


def _spring(bulk: Bulk) -> float:
    """Return the share of the shear stiffness by which PARAM, K6ROT holds the rotation in the plane of shells.

    Without any (K6ROT = 0) Nastran leaves the rotation to AUTOSPC; here a millionth keeps the matrix regular.
    """
    given = [card for card in bulk.of("PARAM") if card.text(1).upper() == "K6ROT"]
    return 1e-6 * max(given[-1].real(2, K6ROT) if given else K6ROT, 1.0)


def _add_group(
    table: FieldTable, count: int, layup: Layup, deck: Deck, systems: Systems, group: str, spring: float | None
) -> None:
    """Add the elements of one card and property."""
    corners = 3 if count in (3, 6) else 4
    what = f"{table.where(0)}, {table.name}"
    labels = table.integers(1)
    given = np.stack([table.integers(3 + k) for k in range(count)], axis=1)
    if (given[:, :corners] < 1).any():
        row, corner = np.argwhere(given[:, :corners] < 1)[0]
        raise table.card(int(row)).wrong(3 + int(corner), "the number of a grid point")
    # theta or MCID, ZOFFS and T1.. stand in other places by card
    at = {"CTRIA3": (6, 7, 11), "CTRIAR": (6, 7, 11), "CQUAD4": (7, 8, 11), "CQUADR": (7, 8, 11)}.get(
        table.name, (9, 10, 11) if table.name == "CTRIA6" else (15, 16, 11)
    )
    thickness_at = {"CTRIA6": 11, "CQUAD8": 11}.get(table.name, at[2])
    stretch = _stretch(table, [thickness_at + k for k in range(corners)], layup, deck)
    offset = table.reals(at[1], 0.0)
    nodes = np.where(given > 0, deck.numbers(np.where(given > 0, given, given[:, :1]), what), -1)
    material_x = _material_axes(table, at[0], nodes, deck, systems)
    cells, rows = first_order_shells(nodes, deck.inventory, table.name)
    mass = layup.density * stretch + layup.nonstructural
    for connectivity, own in zip(cells, rows, strict=True):
        if len(connectivity):
            deck.shells.append(
                Shells(
                    nodes=connectivity,
                    labels=labels[own],
                    membrane=layup.membrane,
                    coupling=layup.coupling,
                    bending=layup.bending,
                    material_x=material_x[own],
                    offset=offset[own],
                    thickness=layup.thickness * stretch[own],
                    mass=mass[own],
                    faces=layup.faces,
                    depths=layup.depths,
                    stretch=stretch[own],
                    poisson=layup.poisson,
                    shear=layup.shear,
                    group=group,
                    spring=spring,
                    point_masses=True,
                )
            )


def _stretch(table: FieldTable, at: list[int], layup: Layup, deck: Deck) -> np.ndarray:
    """Return the thickness of each element over its property's, from thicknesses at the corners: zero is one, blank
    is the property's.
    """
    given = np.stack([~table.blank(k) for k in at], axis=1)
    own = given.any(axis=1)
    if not own.any():
        return np.ones(len(table))
    corners = np.stack([table.reals(k, 0.0) for k in at], axis=1)
    if (wrong := (corners < 0.0).any(axis=1) | (given.all(axis=1) & ~corners.any(axis=1))).any():
        row = int(wrong.argmax())
        values = ", ".join(f"{x:g}" for x in corners[row])
        raise table.card(row).refused(f"thicknesses {values} at the corners", "none below zero, one above")
    flag_at = {"CTRIA6": 14, "CQUAD8": 17}.get(table.name, 10)
    relative = table.integers(flag_at, 0) == 1  # TFLAG: fractions of the property's thickness
    full = np.where(given, corners, np.where(relative[:, None], 1.0, layup.thickness))
    if (np.ptp(full[own], axis=1) > 1e-6 * full[own].max()).any():
        deck.inventory.approximated[f"{table.name} with thicknesses that differ at the corners, their mean"] += int(
            own.sum()
        )
    mean = full.mean(axis=1)
    return np.where(own, np.where(relative, mean, mean / layup.thickness), 1.0)


def _material_axes(table: FieldTable, at: int, nodes: np.ndarray, deck: Deck, systems: Systems) -> np.ndarray:
    """Return the direction (ne, 3) of the first material axis: the side 1-2 turned by THETA, or the x of MCID."""
    points = deck.points[nodes[:, :3]]
    side = points[:, 1] - points[:, 0]
    normal = np.cross(side, deck.points[nodes[:, 3 if nodes.shape[1] in (4, 8) else 2]] - points[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    words = table.column(at)
    integral = (
        np.array([word.isdigit() and len(word) < 10 for word in words])
        if (words != b"").any()
        else np.zeros(len(words), bool)
    )
    angle = np.radians(table.reals(at, 0.0))
    angle[integral] = 0.0
    direction = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * np.cross(normal, side)
    if integral.any():
        systems_of = np.where(integral, np.where(integral, words, b"0").astype(np.int64), 0)
        for number in np.unique(systems_of[integral]):
            rows = np.flatnonzero(integral & (systems_of == number))
            centres = deck.points[nodes[rows, :3]].mean(axis=1)
            direction[rows] = systems.system(int(number), table.where(int(rows[0]))).directions(centres)[:, 0]
    return direction


def _add_panels(cards: list[Card], properties: dict[int, Card], deck: Deck, materials: Materials) -> None:
    """Add CSHEAR panels as membranes that resist shear only, and their effective edge areas not at all."""
    for card in cards:
        pid = card.integer(2, card.integer(1))
        if pid not in properties or properties[pid].name != "PSHEAR":
            raise card.refused(f"the property {pid}", "a PSHEAR card")
        source = properties[pid]
        material = materials.get(source.integer(2), source.where)
        t = source.real(3)
        nodes = deck.numbers([card.integer(3 + k) for k in range(4)], f"{card.where}, CSHEAR")[None, :]
        membrane = np.diag([0.0, 0.0, material.shear * t])
        side = deck.points[nodes[:, 1]] - deck.points[nodes[:, 0]]
        one, none = np.ones(1), np.zeros((3, 3))
        deck.shells.append(
            Shells(
                nodes=nodes,
                labels=np.array([card.integer(1)]),
                membrane=membrane,
                coupling=none,
                bending=none,
                material_x=side,
                offset=0.0 * one,
                thickness=t * one,
                mass=(material.density * t + source.real(4, 0.0)) * one,
                faces=np.stack([membrane / t] * 2),
                depths=np.array([-t / 2, t / 2]),
                stretch=one,
                poisson=0.3,
                shear=np.zeros((2, 2)),
                group=f"pid_{pid}",
                point_masses=True,
            )
        )
        deck.inventory.read["CSHEAR"] += 1
        deck.inventory.approximated["CSHEAR panels, as membranes that resist shear only"] += 1
