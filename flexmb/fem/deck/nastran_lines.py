"""Beams and rods of a Nastran deck: CBAR, CBEAM, CROD, CONROD, CTUBE and their properties."""

from __future__ import annotations

import re
from collections import defaultdict
from itertools import pairwise
from math import pi

import numpy as np

from flexmb.fem.deck.contents import Beams, Deck, Rods
from flexmb.fem.deck.nastran_links import components
from flexmb.fem.deck.nastran_materials import LOWEST, Materials
from flexmb.fem.deck.nastran_text import Bulk, Card
from flexmb.fem.deck.shapes import SHAPES, Constants, constants
from flexmb.fem.frames.section import Section
from flexmb.model.material import Material

__all__ = ["add_beams", "add_rods"]

STIFF_SHEAR = 1e6
"""Shear factor that stands for "no shear deformation" (a blank K1, K2 of a PBAR)."""
NEARLY_NONE = 1e-9
"""Share of the other constants that stands for a constant given as zero: a beam needs each of them positive."""

BEYOND = ("shear relief S1", "shear relief S2", "NSI(A)", "NSI(B)", "warping CW(A)", "warping CW(B)")
"""Constants of a PBEAM behind K1 and K2 that these beams do not have."""
CLOSEST = 1e-3
"""Shares of the length by which stations differ at least: shorter pieces make the stiffness ill-conditioned."""

Stations = list[tuple[float, Section]]


def add_beams(bulk: Bulk, deck: Deck, materials: Materials, frames: dict[int, np.ndarray]) -> None:
    """Add CBAR and CBEAM with offsets, pin flags and tapers."""
    properties = {card.integer(1): card for card in bulk.of("PBAR", "PBARL", "PBEAM", "PBEAML", "PBCOMP")}
    barors = {name: bulk.of(name)[0] for name in ("BAROR", "BEAMOR") if bulk.of(name)}
    made: dict[int, tuple[Material, Stations]] = {}
    groups: dict[tuple[int, str], list] = defaultdict(list)
    for card in bulk.of("CBAR", "CBEAM"):
        default = barors.get("BAROR" if card.name == "CBAR" else "BEAMOR")
        pid = card.integer(2, default.integer(2, card.integer(1)) if default else card.integer(1))
        if pid not in made:
            if pid not in properties:
                raise card.refused(f"the property {pid}, which does not exist", "a PBAR, PBARL, PBEAM or PBEAML")
            made[pid] = _property(properties[pid], materials, deck)
        groups[(pid, card.name)].append(_element(card, default, deck, frames))
        deck.inventory.read[card.name] += 1
    for (pid, name), rows in groups.items():
        material, stations = made[pid]
        pieces = [row for given in rows for row in _pieces(deck, given, stations)]
        nodes, labels, y_axes, offsets, released, pairs = zip(*pieces, strict=True)
        deck.beams.append(
            Beams(
                nodes=np.array(nodes),
                labels=np.array(labels),
                sections=list(pairs),
                material=material,
                y_axis=np.array(y_axes),
                offsets=np.array(offsets),
                released=list(released),
                group=f"pid_{pid}",
                point_masses="all" if name == "CBAR" else "but torsion",
            )
        )


def _pieces(deck: Deck, row: tuple, stations: Stations) -> list[tuple]:
    """Return a beam as pieces between its stations, each tapered linearly; nodes between the ends are added.

    A row holds nodes, number, y-axis, offsets and released directions; a piece its pair of sections besides.
    """
    if len(stations) < 3:
        return [(*row, (stations[0][1], stations[-1][1]))]
    (a, b), label, y_axis, offsets, released = row
    start, end = deck.points[a] + offsets[0], deck.points[b] + offsets[1]
    inner = [start + x * (end - start) for x, _ in stations[1:-1]]
    nodes = [a, *range(len(deck.points), len(deck.points) + len(inner)), b]
    deck.points = np.vstack([deck.points, inner])
    arms = [offsets[0], *np.zeros((len(inner), 3)), offsets[1]]
    free = [released[0], *[frozenset()] * len(inner), released[1]]
    last = len(nodes) - 2
    return [
        (
            (nodes[k], nodes[k + 1]),
            label,
            y_axis,
            np.array([arms[k], arms[k + 1]]),
            (free[k] if k == 0 else frozenset(), free[k + 1] if k == last else frozenset()),
            (stations[k][1], stations[k + 1][1]),
        )
        for k in range(len(nodes) - 1)
    ]


def _direction(card: Card, default: Card | None, a: int, deck: Deck, frames: dict[int, np.ndarray]) -> np.ndarray:
    """Return the orientation vector (3,) of a beam from the node `a` on: given, or towards a grid point."""
    source = default if not card.text(5) and default is not None and default.text(5) else card
    if source.text(5) and not source.is_real(5) and not source.text(6) and not source.text(7):
        other = int(deck.numbers([source.integer(5)], f"{card.where}, {card.name}")[0])
        return deck.points[other] - deck.points[a]
    return np.array([source.real(k, 0.0) for k in (5, 6, 7)]) @ frames.get(a, np.eye(3))  # in the system of end A


def _offset_systems(card: Card, default: Card | None, deck: Deck) -> str:
    """Return in which systems the orientation and the offsets of both ends are given: OFFT, as "GGG"."""
    words = [given.text(8).upper() for given in (card, default) if given is not None]
    flags = next((word for word in words if word not in ("", "1", "2")), "")  # of old: 1 a vector, 2 a grid point
    if card.name == "CBEAM" and card.is_real(8):
        deck.inventory.left_out["CBEAM: BIT, higher terms of p-elements"] += 1
        flags = ""
    if flags and not re.fullmatch("[GB][GO][GO]", flags):
        raise card.refused(f"OFFT = {flags}", "GGG, GGO, GOG, GOO or the same with B first")
    return flags or "GGG"


def _element(card: Card, default: Card | None, deck: Deck, frames: dict[int, np.ndarray]):
    """Return nodes (2,), number, y-axis (3,), offsets (2, 3) in basic axes and released directions of one beam."""
    a, b = (int(n) for n in deck.numbers([card.integer(3), card.integer(4)], f"{card.where}, {card.name}"))
    direction = _direction(card, default, a, deck, frames)
    system = _offset_systems(card, default, deck)
    offsets = np.array([[card.real(11 + 3 * end + k, 0.0) for k in range(3)] for end in range(2)])
    points = deck.points[[a, b]]
    if system[0] == "B":  # the orientation in the basic system
        direction = direction @ frames.get(a, np.eye(3)).T
    for end, node in enumerate((a, b)):
        if system[1 + end] == "O":  # along the line of the nodes
            offsets[end] = offsets[end] @ _line_axes(points, direction, card)
        else:
            offsets[end] = offsets[end] @ frames.get(node, np.eye(3))
    released = tuple(frozenset(components(card, k) if card.text(k) not in ("", "0") else ()) for k in (9, 10))
    along = points[1] + offsets[1] - points[0] - offsets[0]
    size, across = np.linalg.norm(along), np.linalg.norm(np.cross(along, direction))
    if not size > 0.0:
        raise card.refused("ends at one place", "a beam of some length", "Merge its nodes or remove it")
    if not across > 1e-6 * size * np.linalg.norm(direction):
        raise card.refused(
            f"the orientation vector {np.round(direction, 6).tolist()}, which is zero or along the beam",
            "a vector across it",
        )
    return (a, b), card.integer(1), direction, offsets, released


def _line_axes(points: np.ndarray, direction: np.ndarray, card: Card) -> np.ndarray:
    x = points[1] - points[0]
    size = np.linalg.norm(x)
    z = np.cross(x, direction)
    if not size > 0.0 or not np.linalg.norm(z) > 0.0:
        raise card.refused("an offset along a beam without direction", "two places and an orientation")
    x, z = x / size, z / np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z])


def _property(card: Card, materials: Materials, deck: Deck) -> tuple[Material, Stations]:
    """Return material and sections at fractions of the length of a beam property."""
    who = f"{card.where}, card {card.name} {card.text(1)}"
    given = materials.get(card.integer(2), who)
    young, shear, density = given.line(who)
    poisson = young / (2.0 * shear) - 1.0 if shear > 0.0 else 0.0
    factor = 1.0
    if not -0.99 < poisson < 0.499:  # E and G of their own: the torsion constant takes the difference
        factor, poisson = shear / (young / (2.0 * 1.3)), 0.3
    material = Material(young=young, poisson=poisson, density=max(density, LOWEST), name=given.name)
    readers = {"PBAR": _pbar, "PBARL": _pbarl, "PBEAM": _pbeam, "PBEAML": _pbeaml}
    if card.name not in readers:
        raise card.refused(
            f"a property {card.name}", "PBAR, PBARL, PBEAM or PBEAML", "Replace it by a PBEAM of its total A, I and J"
        )
    deck.inventory.read[card.name] += 1
    stations = readers[card.name](card, factor, deck)
    if len(stations) > 1 and stations[-1][0] < 1.0:
        stations.append((1.0, stations[0][1]))  # end B left out is as end A
    places = [x for x, _ in stations]
    if places[0] < 0.0 or places[-1] > 1.0 or any(b - a < CLOSEST for a, b in pairwise(places)):
        raise card.refused(
            f"stations at {', '.join(f'{x:g}' for x in places)}", "different fractions of the length, 0 to 1"
        )
    return material, stations


def _section(card: Card, factor: float, deck: Deck, **values) -> Section:
    """Return a section; constants that the card gives as zero become nearly zero, which the inventory tells."""
    area, iy, iz, j = (values.pop(k) for k in ("area", "inertia_y", "inertia_z", "torsion"))
    if min(area, iy, iz, j) < 0.0 or not max(area, iy, iz, j) > 0.0:
        raise card.refused(f"A = {area:g}, I1 = {iz:g}, I2 = {iy:g}, J = {j:g}", "A, I1, I2, J >= 0, and one above")
    if area == 0.0:
        deck.inventory.approximated[f"{card.name} {card.text(1)}: A = 0, taken as nearly zero"] += 1
        area = NEARLY_NONE * max(iy, iz, j) ** 0.5
        values |= {"shear_y": STIFF_SHEAR / NEARLY_NONE, "shear_z": STIFF_SHEAR / NEARLY_NONE}  # K A G = 0: no shear
    size = max(iy, iz, j) or NEARLY_NONE * area**2
    for symbol, value in (("I1", iz), ("I2", iy), ("J", j)):
        if value == 0.0:
            deck.inventory.approximated[f"{card.name} {card.text(1)}: {symbol} = 0, taken as nearly zero"] += 1
    iy, iz, j = (value or NEARLY_NONE * size for value in (iy, iz, j))
    product = values.pop("product_yz", 0.0)
    if product**2 >= iy * iz:
        raise card.refused(f"I12 = {product:g} with I1 = {iz:g}, I2 = {iy:g}", "I12^2 < I1 I2")
    return Section.values(area, iy, iz, j * factor, product_yz=product, polar=iy + iz, **values)


def _shears(card: Card, first: int, blank: float) -> tuple[float, float]:
    """Return the shear factors K1 (along y) and K2 (along z); blank or zero means no shear deformation for a PBAR."""
    values = [card.real(first + k, blank) for k in range(2)]
    return values[0] or STIFF_SHEAR, values[1] or STIFF_SHEAR


def _pbar(card: Card, factor: float, deck: Deck) -> Stations:
    twisted = card.real(19, 0.0)
    ky, kz = _shears(card, 17, 0.0) if twisted == 0.0 else (STIFF_SHEAR, STIFF_SHEAR)  # I12: K1, K2 do not count
    points = tuple((card.real(9 + 2 * k, 0.0), card.real(10 + 2 * k, 0.0)) for k in range(4))
    section = _section(
        card,
        factor,
        deck,
        area=card.real(3, 0.0),
        inertia_z=card.real(4, 0.0),
        inertia_y=card.real(5, 0.0),
        torsion=card.real(6, 0.0),
        product_yz=twisted,
        shear_y=ky,
        shear_z=kz,
        line_mass=card.real(7, 0.0),
        fibres=tuple(p for p in points if any(p)),
    )
    return [(0.0, section)]


def _named(card: Card, shape: str, dimensions: list[float]) -> Constants:
    try:
        return constants(shape, dimensions)
    except KeyError:
        raise card.refused(f"the shape {shape}", f"One of: {', '.join(sorted(SHAPES))}", "Give A, I1, I2, J") from None
    except ValueError as error:
        raise card.refused(f"{shape} {dimensions}: {error}", "dimensions of that shape") from None


def _pbarl(card: Card, factor: float, deck: Deck) -> Stations:
    shape = card.text(4).upper()
    count = SHAPES[shape][0] if shape in SHAPES else 0
    c = _named(card, shape, [card.real(9 + k, 0.0) for k in range(count)])
    section = _section(card, factor, deck, **_as_section(c), line_mass=card.real(9 + count, 0.0))
    return [(0.0, section)]


def _as_section(c: Constants) -> dict:
    return {
        "area": c.area,
        "inertia_y": c.inertia_y,
        "inertia_z": c.inertia_z,
        "torsion": c.torsion,
        "product_yz": c.product_yz,
        "shear_y": c.shear_y,
        "shear_z": c.shear_z,
        "fibres": c.fibres,
    }


def _pbeaml(card: Card, factor: float, deck: Deck) -> Stations:
    shape = card.text(4).upper()
    count = SHAPES[shape][0] if shape in SHAPES else 0
    stations: Stations = []
    at, x, words = 9, 0.0, card.fields
    while True:
        dimensions = [card.real(at + k, 0.0) for k in range(count)]
        if stations and not any(dimensions):  # blank: as at end A
            section = stations[0][1]
        else:
            c = _named(card, shape, dimensions)
            y, z = -c.shear_center[0], -c.shear_center[1]  # the area centre seen from the shear centre
            section = _section(
                card,
                factor,
                deck,
                **_as_section(c),
                area_center=(y, z),
                mass_center=(y, z),
                line_mass=card.real(at + count, 0.0),
                line_mass_center=(y, z),
            )
        stations.append((x, section))
        at += count + 1
        if at + 1 >= len(words) or not any(words[at : at + 2]):
            break
        x = card.real(at + 1, 1.0)
        at += 2
    return sorted(stations, key=lambda pair: pair[0])


def _pbeam(card: Card, factor: float, deck: Deck) -> Stations:
    """Return the stations of a PBEAM: end A in fields 4 to 17, then 16 fields a station, then shear and offsets."""
    rows: list[tuple[float, list[float]]] = [(0.0, [card.real(3 + k, 0.0) for k in range(6)])]
    words = card.fields
    at = 9 if len(words) > 9 and words[9].upper() in ("YES", "NO", "YESA") else 17  # no stress points at end A
    while at < len(words) and words[at].upper() in ("YES", "NO", "YESA"):
        first = rows[0][1]
        rows.append((card.real(at + 1, 1.0), [card.real(at + 2 + k, first[k]) if k < 6 else 0.0 for k in range(6)]))
        at += 16 if words[at].upper() == "YES" else 8  # the others have no line of stress points
    ky, kz = (card.real(at + k, 1.0) or STIFF_SHEAR for k in range(2))
    for k, what in enumerate(BEYOND):
        if card.real(at + 2 + k, 0.0):
            deck.inventory.left_out[f"PBEAM {card.text(1)}: {what}"] += 1
    ends = [[card.real(at + 8 + k, 0.0) for k in range(8)]]
    nsm, neutral = ends[0][:4], ends[0][4:]
    # M1(A), M2(A), M1(B), M2(B), N1(A), N2(A), N1(B), N2(B); blank at B is as at A
    for values, start in ((nsm, at + 8), (neutral, at + 12)):
        for k in (2, 3):
            if not card.text(start + k):
                values[k] = values[k - 2]
    if not any(x >= 1.0 for x, _ in rows):
        rows.append((1.0, list(rows[0][1])))
    stations: Stations = []
    for x, (area, i1, i2, i12, j, mass) in sorted(rows, key=lambda row: row[0]):
        center = tuple((1.0 - x) * neutral[k] + x * neutral[2 + k] for k in range(2))
        extra = tuple((1.0 - x) * nsm[k] + x * nsm[2 + k] for k in range(2))
        stations.append(
            (
                x,
                _section(
                    card,
                    factor,
                    deck,
                    area=area,
                    inertia_z=i1,
                    inertia_y=i2,
                    product_yz=i12,
                    torsion=j,
                    shear_y=ky,
                    shear_z=kz,
                    area_center=center,
                    mass_center=center,
                    line_mass=mass,
                    line_mass_center=extra,
                ),
            )
        )
    return stations


def add_rods(bulk: Bulk, deck: Deck, materials: Materials) -> None:
    """Add CROD, CONROD and CTUBE: bars that carry axial force and torque."""
    properties = {card.integer(1): card for card in bulk.of("PROD", "PTUBE")}
    rows: dict[str, list] = defaultdict(list)
    for card in bulk.of("CROD", "CONROD", "CTUBE"):
        if card.name == "CONROD":
            source, nodes, group = card, (card.integer(2), card.integer(3)), "conrod"
        else:
            pid = card.integer(2, card.integer(1))
            if pid not in properties:
                raise card.refused(f"the property {pid}, which does not exist", "a PROD or PTUBE card")
            source, nodes, group = properties[pid], (card.integer(3), card.integer(4)), f"pid_{pid}"
        who = f"{source.where}, card {source.name} {source.text(1)}"
        young, shear, density = materials.get(source.integer(4 if card.name == "CONROD" else 2), who).line(who)
        area, j, extra = _rod_constants(source)
        pair = deck.numbers(nodes, f"{card.where}, {card.name}")
        rows[group].append((pair, card.integer(1), young * area, shear * j, density * area + extra, density * j))
        deck.inventory.read[card.name] += 1
    for group, found in rows.items():
        nodes_, labels, axial, torsion, mass, polar = (np.array(column) for column in zip(*found, strict=True))
        deck.rods.append(
            Rods(
                nodes=nodes_,
                labels=labels,
                axial=axial,
                torsion=torsion,
                mass=mass,
                polar=polar,
                group=group,
                point_masses=True,
            )
        )


def _rod_constants(card: Card) -> tuple[float, float, float]:
    """Return area, torsion constant and non-structural mass per length."""
    if card.name == "PTUBE":
        outer, wall = card.real(3), card.real(4, 0.0)
        end = card.real(6, 0.0) or outer
        area, polar = 0.0, 0.0
        for outside in (outer, end):  # the mean of both ends, as Nastran weighs a tapered tube
            inner = outside - 2.0 * wall if wall else 0.0
            if not 0.0 <= inner < outside:
                raise card.refused(f"OD = {outside:g}, T = {wall:g}", "0 <= T <= OD / 2")
            area += pi / 8 * (outside**2 - inner**2)
            polar += pi / 64 * (outside**4 - inner**4)
        return area, polar, card.real(5, 0.0)
    first = 5 if card.name == "CONROD" else 3
    area = card.real(first, 0.0)
    if area < 0.0:
        raise card.refused(f"A = {area:g}", "A >= 0")
    return area, card.real(first + 1, 0.0), card.real(first + 3, 0.0)
