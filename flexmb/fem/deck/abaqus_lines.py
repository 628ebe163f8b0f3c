"""Beams and trusses of an Abaqus deck."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import pi

import numpy as np

from flexmb.fem.deck.abaqus_materials import Elastic, Materials
from flexmb.fem.deck.abaqus_model import Element, Flat
from flexmb.fem.deck.abaqus_surfaces import shape_of
from flexmb.fem.deck.abaqus_text import Block
from flexmb.fem.deck.contents import Beams, Deck, Rods
from flexmb.fem.deck.nastran_materials import LOWEST
from flexmb.fem.deck.shapes import Constants, constants
from flexmb.fem.frames.section import Section
from flexmb.model.material import Material

__all__ = ["beam_section", "following", "trusses"]


def trusses(group: list[Element], block: Block, deck: Deck, material: Elastic) -> None:
    rows = block.rows()
    area = block.reals(rows[0][:1], 1, 1.0)[0] if rows else 1.0
    pairs, labels, _ = _segments(group, block)
    one = np.ones(len(pairs))
    deck.rods.append(
        Rods(
            nodes=pairs,
            labels=labels,
            axial=material.young * area * one,
            torsion=0.0 * one,
            mass=material.density * area * one,
            polar=0.0 * one,
            group=block.parameters["ELSET"],
        )
    )


def following(flat: Flat, section: Block, name: str) -> Block | None:
    """Return the keyword of a name that belongs to a section: one of those behind it, before another section."""
    at = next(k for k, (block, _) in enumerate(flat.blocks) if block is section)
    for block, _ in flat.blocks[at + 1 : at + 6]:
        if block.name == name:
            return block
        if block.name.endswith("SECTION") or block.name == "MATERIAL":
            return None
    return None


def _segments(group: list[Element], block: Block) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return pairs of nodes, element numbers, and the nodes that give the direction n1 (-1: none).

    Three nodes on a line give two pairs. One more node gives the direction.
    """
    pairs, labels, directions = [], [], []
    for element in group:
        needed = 3 if shape_of(element.kind)[1] == "line3" else 2
        if len(element.nodes) < needed:
            found = f"element {element.label} of type {element.kind} with {len(element.nodes)} nodes"
            raise block.wrong(found, f"{needed} nodes")
        for a, b in pairwise(element.nodes[:needed]):
            pairs.append((a, b))
            labels.append(element.label)
            directions.append(element.nodes[needed] if len(element.nodes) > needed else -1)
    return np.array(pairs, np.int64), np.array(labels, np.int64), np.array(directions, np.int64)


def beam_section(elements, block: Block, scope: str, flat: Flat, deck: Deck, materials: Materials) -> None:
    general = block.name == "BEAM GENERAL SECTION"
    rows = block.rows()
    shape = block.parameters.get("SECTION", "GENERAL" if general else "RECT").upper()
    if not rows:
        raise block.wrong("no data line", "the dimensions of the section")
    if general and shape == "GENERAL":
        section = _of_constants(block, rows[0], deck)
    else:
        section = _section(shape, block, block.reals([w for w in rows[0] if w]))
    material = _material(block, rows, deck, materials)
    section = _sheared(block, flat, section, material.young / (2.0 + 2.0 * material.poisson), deck)
    center = _center(shape, block, flat, rows[0], deck)
    # a section given by its constants has its shear centre at the nodes where no keyword places it
    shear_center = _pair(flat, block, "SHEAR CENTER") if shape == "GENERAL" else center
    section = replace(section, area_center=center, shear_center=shear_center, mass_center=center)
    given = len(rows) > 1 and any(rows[1])
    direction = flat.scopes[scope].rotation @ (block.reals(rows[1], 3, 0.0) if given else [0.0, 0.0, -1.0])
    group = [element for element in elements if shape_of(element.kind)[0] == "beam"]
    for element in elements:
        if element not in group:
            raise block.wrong(f"{element.kind} with a beam section", "B31, B32 or B33")
        deck.inventory.read[element.kind] += 1
    if of_three := sum(shape_of(element.kind)[1] == "line3" for element in group):
        deck.inventory.approximated["beams of three nodes, as two beams"] += of_three
    pairs, labels, towards = _segments(group, block)
    y, parallel = _sides(deck.points, pairs, towards, direction)
    if parallel.any() and _has_sides(section):
        label = labels[int(parallel.argmax())]
        if given:
            raise block.wrong(f"element {label} along its direction n1", "a direction across the beam")
        deck.inventory.approximated["beams along -z, the direction n1 where none is given, with n1 = x"] += int(
            parallel.sum()
        )
    none: frozenset[int] = frozenset()
    deck.beams.append(
        Beams(
            nodes=pairs,
            labels=labels,
            sections=[(section, section)] * len(pairs),
            material=material,
            y_axis=y,
            offsets=np.zeros((len(pairs), 2, 3)),
            released=[(none, none)] * len(pairs),
            group=block.parameters["ELSET"],
        )
    )


def _of_constants(block: Block, row, deck: Deck) -> Section:
    """Return the section of *BEAM GENERAL SECTION, SECTION=GENERAL."""
    area, i11, i12, i22, j, *sectorial = block.reals(row, 7, 0.0)
    if any(sectorial):
        deck.inventory.left_out["*BEAM GENERAL SECTION: sectorial moment and warping constant"] += 1
    if not area > 0.0 or i11 <= 0.0 or i22 <= 0.0 or j < 0.0:
        raise block.wrong(f"A = {area:g}, I11 = {i11:g}, I22 = {i22:g}, J = {j:g}", "positive constants")
    return Section.values(area, i11, i22, j or 1e-9 * (i11 + i22), 1e6, 1e6, product_yz=-i12)


def _material(block: Block, rows, deck: Deck, materials: Materials) -> Material:
    """Return the material of beams: that which the card names, or the moduli on the third line of a general section."""
    if block.name == "BEAM GENERAL SECTION" and "MATERIAL" not in block.parameters:
        young, shear = block.reals(rows[2], 2, 0.0) if len(rows) > 2 else (0.0, 0.0)
        density = block.reals([block.parameters.get("DENSITY", "0") or "0"], 1)[0]
        name, poisson = "general", young / (2.0 * shear) - 1.0 if shear > 0.0 else 0.0
        if density == 0.0:
            deck.inventory.weightless.add(f"*BEAM GENERAL SECTION of {block.parameters.get('ELSET', '')}")
    else:
        elastic = materials.get(block)
        young, poisson, density, name = elastic.young, elastic.poisson, elastic.density, elastic.name
    if not young > 0.0 or not -1.0 < poisson < 0.5:
        raise block.wrong(f"E = {young:g}, nu = {poisson:g}", "an isotropic material")
    return Material(young=young, poisson=poisson, density=max(density, LOWEST), name=name)


def _sides(points: np.ndarray, pairs: np.ndarray, towards: np.ndarray, direction) -> tuple[np.ndarray, np.ndarray]:
    """Return the directions n1 (n, 3) of beams, x for those along it, and which these are, (n,) bool."""
    along = points[pairs[:, 1]] - points[pairs[:, 0]]
    y = np.broadcast_to(direction, along.shape).copy()
    own = towards >= 0
    y[own] = points[towards[own]] - points[pairs[own, 0]]
    sizes = np.linalg.norm(along, axis=1) * np.linalg.norm(y, axis=1)
    parallel = np.linalg.norm(np.cross(along, y), axis=1) <= 1e-6 * sizes
    y[parallel] = [1.0, 0.0, 0.0]
    return y, parallel


def _has_sides(section: Section) -> bool:
    """Whether the directions of a section matter."""
    size = section.inertia_y + section.inertia_z
    uneven = abs(section.inertia_y - section.inertia_z) + abs(section.product_yz) > 1e-9 * size
    return uneven or section.area_center != (0.0, 0.0)


def _sheared(block: Block, flat: Flat, section: Section, modulus: float, deck: Deck) -> Section:
    """Return a section with the K23, K13 of *TRANSVERSE SHEAR STIFFNESS, along 2 and 1; one counts for both."""
    given = following(flat, block, "TRANSVERSE SHEAR STIFFNESS")
    if given is None:
        return section
    second, first = given.reals(given.rows()[0][:2] if given.rows() else [], 2, 0.0)
    if given.rows() and any(given.rows()[0][2:3]):
        deck.inventory.left_out["*TRANSVERSE SHEAR STIFFNESS: compensation of slenderness of a beam"] += 1
    first, second = first or second, second or first
    if not (first > 0.0 and second > 0.0):
        raise given.wrong(f"K23, K13 = {second:g}, {first:g}", "stiffnesses above zero")
    return replace(section, shear_y=first / (modulus * section.area), shear_z=second / (modulus * section.area))


def _pair(flat: Flat, block: Block, name: str) -> tuple[float, float]:
    """Return the place (1, 2) that a keyword behind a section gives, zero without it."""
    given = following(flat, block, name)
    first, second = given.reals(given.rows()[0][:2] if given.rows() else [], 2, 0.0) if given is not None else (0, 0)
    return float(first), float(second)


def _center(shape: str, block: Block, flat: Flat, row: list[str], deck: Deck) -> tuple[float, float]:
    """Return the area centre (1, 2) from the line of nodes.

    *CENTROID of sections given by constants; the height l of an I, at which its nodes lie; OFFSET1 and OFFSET2 of
    CalculiX, the place of the nodes over the centre in thicknesses; a box with unlike walls. An L has its centre at the
    nodes, as a message says.
    """
    if shape == "GENERAL":
        return _pair(flat, block, "CENTROID")
    for name in ("CENTROID", "SHEAR CENTER"):
        if following(flat, block, name) is not None:
            deck.inventory.left_out[f"*{name} behind a section {shape}, which has its own"] += 1
    d = block.reals([word for word in row if word])
    words = [block.parameters.get(name, "0") or "0" for name in ("OFFSET1", "OFFSET2")]
    if shape in ("I", "L") and any(block.reals(words)):
        deck.inventory.left_out[f"*{block.name}: OFFSET1, OFFSET2 of a section {shape}"] += 1
        words = ["0", "0"]
    if shape == "I" and len(d) >= 7:
        low, height, b1, b2, t1, t2, t3 = d[:7]
        areas = np.array([b1 * t1, b2 * t2, (height - t1 - t2) * t3])
        middle = float(areas @ [t1 / 2, height - t2 / 2, (height + t1 - t2) / 2] / areas.sum()) - low
        return 0.0, middle if abs(middle) > 1e-6 * height else 0.0
    if shape == "L":
        deck.inventory.approximated["sections L, with their area centres at the nodes"] += 1
    sizes = [d[0] * (2.0 if shape == "PIPE" or (shape.startswith("CIRC") and len(d) < 2) else 1.0)] * 2
    if shape.startswith(("RECT", "CIRC", "BOX")) and len(d) > 1:
        sizes = d[:2]
    first, second = (-x * size for x, size in zip(block.reals(words), sizes, strict=True))
    if shape == "BOX":
        right, top, left, bottom = (d + d[2:3] * 4)[2:6]
        (a, b), inner = sizes, sizes[0] - right - left
        areas = np.array([right * b, left * b, top * inner, bottom * inner])
        first += float(areas @ [a - right, left - a, left - right, left - right]) / (2.0 * areas.sum())
        second += float(areas[2:] @ [b - top, bottom - b]) / (2.0 * areas.sum())
    return first + 0.0, second + 0.0


def _section(shape: str, block: Block, d: list[float]) -> Section:
    """Return a section: the first local axis (1) is y, the second (2) is z."""
    try:
        if shape.startswith("RECT"):
            c = constants("BAR", [d[1] if len(d) > 1 else d[0], d[0]])  # a along 1, b along 2
        elif shape in ("CIRC", "CIRCULAR"):
            # CalculiX gives two thicknesses, Abaqus one radius
            if len(d) > 1 and d[1] != d[0]:
                return _ellipse(d[0] / 2.0, d[1] / 2.0)
            c = constants("ROD", [d[0] if len(d) < 2 else d[0] / 2.0])
        elif shape == "PIPE":
            c = constants("TUBE2", d[:2])
        elif shape == "BOX":
            a, b, t1, t2, t3, t4 = (d + d[2:3] * 4)[:6]
            c = constants("BOX1", [b, a, t1, t3, t2, t4])
        elif shape == "I":
            # l, h, b1, b2, t1, t2, t3: height along 2, flanges along 1
            _, h, b1, b2, t1, t2, t3 = d[:7]
            return _swapped(constants("I", [h, b1, b2, t3, t1, t2]))
        elif shape == "L":
            a, b, t1, t2 = d[:4]
            return _swapped(constants("L", [a, b, t1, t2]))
        else:
            raise block.wrong(f"SECTION={shape}", "RECT, CIRC, PIPE, BOX, I, L or GENERAL", "Give A, I11, I22, J")
    except (ValueError, IndexError) as error:
        raise block.wrong(f"{shape} {d}: {error}", "the dimensions of that section") from None
    return _made(c)


def _ellipse(first: float, second: float) -> Section:
    """Return an ellipse of half axes along 1 and 2, with the shear factor of a circle.

    Torsion: S. Timoshenko & J. N. Goodier, Theory of Elasticity, the section on elliptic bars.
    """
    if not (first > 0.0 and second > 0.0):
        raise ValueError("dimensions that are not positive")
    area = pi * first * second
    return Section.values(
        area,
        area * second**2 / 4.0,
        area * first**2 / 4.0,
        area * (first * second) ** 2 / (first**2 + second**2),
        0.9,
        0.9,
        fibres=((first, 0.0), (0.0, second), (-first, 0.0), (0.0, -second)),
    )


def _made(c: Constants) -> Section:
    return Section.values(
        c.area,
        c.inertia_y,
        c.inertia_z,
        c.torsion,
        c.shear_y,
        c.shear_z,
        product_yz=c.product_yz,
        fibres=c.fibres,
    )


def _swapped(c: Constants) -> Section:
    """Return a shape whose height is along the second local axis and whose width, z, along the first."""
    return Section.values(
        c.area,
        c.inertia_z,
        c.inertia_y,
        c.torsion,
        c.shear_z,
        c.shear_y,
        product_yz=c.product_yz,
        fibres=tuple((z, y) for y, z in c.fibres),
    )
