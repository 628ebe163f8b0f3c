"""Elements of an Ansys archive by type, material, real constants, section and system; its solids and shells."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.deck.ansys_materials import AnsysSection, Solid
from flexmb.fem.deck.ansys_text import Archive, Command
from flexmb.fem.deck.cells import SolidCells, first_order_shells
from flexmb.fem.deck.contents import Deck, Inventory, Shells, Solids
from flexmb.fem.deck.nastran_solids import turned_solid
from flexmb.fem.deck.nastran_systems import System
from flexmb.fem.shells.laminate_block import laminate, turned_plane
from flexmb.fem.shells.laminate_shear import shear_compliance
from flexmb.fem.solids.elements import HEX20_REDUCED

__all__ = ["Group", "add_shells", "add_solids", "groups"]

FAMILIES = {
    "solid": {45: 8, 185: 8, 285: 4, 95: 20, 186: 20, 92: 10, 187: 10},
    "shell": {181: 4, 281: 8},
    "beam": {188: 2, 189: 3, 288: 2, 289: 3},
    "rod": {180: 2},
    "mass": {21: 1},
    "spring": {14: 2},
    "rigid": {184: 2},
}
"""Families of element types by their numbers, and the nodes of each, orientation nodes left out."""
LAYOUTS = {
    "wedge": ([0, 1, 2, 4, 5, 6], [8, 9, 11, 12, 13, 15, 16, 17, 18]),
    "pyramid": ([0, 1, 2, 3, 4], [8, 9, 10, 11, 16, 17, 18, 19]),
    "tetra": ([0, 1, 2, 4], [8, 9, 11, 16, 17, 18]),
    "hexahedron": (list(range(8)), list(range(8, 20))),
}
"""Places of the corners and midside nodes of each shape in a brick whose nodes coincide (K = L, M = N = O = P)."""
HIGH = {"wedge": "wedge15", "pyramid": "pyramid13", "tetra": "tetra10", "hexahedron": "hexahedron20"}
LAYERED = (185, 186)


@dataclass(eq=False)
class Group:
    """Elements that share everything but their nodes: nodes (ne, 20) 0 .. n-1, -1 where there is none."""

    family: str
    element: int
    name: str
    options: dict[int, int]
    nodes: np.ndarray
    labels: np.ndarray
    number: int
    material: Solid | str | None
    real: list[float]
    section: AnsysSection | None
    system: System | None
    esys: int
    materials: dict[int, Solid | str]
    part: str
    inventory: Inventory

    def need(self, number: int | None = None) -> Solid:
        """Return the material; MeshError if there is none with linear elasticity."""
        found = self.material if not number else self.materials.get(number)
        if isinstance(found, Solid):
            if found.density == 0.0:
                self.inventory.weightless.add(found.name)
            return found
        number = number or self.number
        raise self.refused(
            f"the material {number}" + (f" ({found})" if found else ", which does not exist"),
            "a linear material (MP,EX and MP,NUXY or PRXY)",
            f"Give the elements a linear material: lines MP,EX,{number},2.1E11, MP,PRXY,{number},0.3 and "
            f"MP,DENS,{number},7850, in the units of the deck, anywhere in it",
        )

    def refused(self, found: str, expected: str, remedy: str = "Correct the model and write the archive again"):
        """Return an error about these elements."""
        who = f"{self.part}, {self.name} (the first is element {int(self.labels[0])})"
        return MeshError(who, found=found, expected=expected, remedy=remedy)


def groups(
    archive: Archive,
    deck: Deck,
    part: str,
    systems: dict[int, System],
    made: dict[int, Solid | str],
    given: dict[int, AnsysSection],
) -> Iterator[Group]:
    """Yield the elements of an archive in groups; the node numbers are checked here. Dead elements are left out."""
    alive = archive.head[:, 5] == 0
    if not alive.all():
        deck.inventory.left_out["dead elements (EKILL)"] += int((~alive).sum())
    head, nodes = archive.head[alive], archive.nodes[alive]
    if not len(head):
        return
    _, which = np.unique(head[:, [1, 0, 2, 3, 4]], axis=0, return_inverse=True)
    order = np.argsort(which.ravel(), kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(which.ravel()[order])) + 1):
        material, kind, real, section, system = (int(x) for x in head[rows[0], :5])
        word = archive.types.get(kind)
        if word is None:
            raise MeshError(
                f"{part}, element {int(head[rows[0], 10])}",
                found=f"the type {kind}, which no ET or ETBLOCK defines",
                expected=f"One of: {', '.join(map(str, sorted(archive.types))) or 'none'}",
                remedy="Write the archive again with CDWRITE, DB",
            )
        digits = word.lstrip("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz")
        element = int(digits) if digits.isdecimal() else 0
        family = next((name for name, known in FAMILIES.items() if element in known), "")
        name = f"{_stem(family, element)}{element}" if element else word
        own = nodes[rows]
        numbers = np.full(own.shape, -1)
        if family:
            used = own > 0
            numbers[used] = deck.numbers(own[used], f"{part}, {name}")
            deck.inventory.read[name] += len(rows)
        options = {k: value for (number, k), value in archive.options.items() if number == kind}
        yield Group(
            family=family,
            element=element,
            name=name,
            options=options,
            nodes=numbers,
            labels=head[rows, 10],
            number=material,
            material=made.get(material),
            real=archive.reals.get(real, []),
            section=given.get(section),
            system=systems.get(system),
            esys=system,
            materials=made,
            part=part,
            inventory=deck.inventory,
        )


def _stem(family: str, element: int) -> str:
    if element in (288, 289):
        return "PIPE"
    stems = {"beam": "BEAM", "rod": "LINK", "mass": "MASS", "spring": "COMBIN", "rigid": "MPC"}
    return stems.get(family, family.upper())


def add_solids(group: Group, deck: Deck) -> None:
    """Add bricks, wedges, pyramids and tetrahedra of both orders; bricks with coinciding nodes by their shape."""
    if group.element in LAYERED and group.options.get(3, 0) == 1:
        raise group.refused("layered solids (KEYOPT(3) = 1)", "homogeneous solids", "Give them a homogeneous material")
    material = group.need()
    count = FAMILIES["solid"][group.element]
    asked = group.options.get(2, 0)
    if (group.element == 185 and asked not in (2, 3)) or (group.element == 45 and group.options.get(1, 0) == 1):
        found = f"{group.name} with incompatible modes, which its key options do not ask for"
        deck.inventory.approximated[found] += len(group.labels)
    reduced = group.element == 186 and group.options.get(2, 0) == 0
    nodes = np.where(np.arange(20) < count, group.nodes, -1)
    corners = nodes[:, : {4: 4, 10: 4}.get(count, 8)]
    if (corners < 0).any():
        row = int(np.flatnonzero((corners < 0).any(axis=1))[0])
        raise group.refused(f"element {int(group.labels[row])} without all corners", f"{corners.shape[1]} corners")
    for shape, rows in _shapes(nodes, count).items():
        own = nodes[rows]
        if count in (4, 10):
            full = own[:, :10]
        else:
            ends, middles = LAYOUTS[shape]
            full = own[:, ends + middles]
        size = full.shape[1] - len(LAYOUTS[shape][1])
        full[:, size:][(full[:, size:, None] == full[:, None, :size]).any(axis=2)] = -1
        cells = SolidCells(shape, HIGH[shape], size, full, group.labels[rows])
        for cell_type, connectivity, labels in cells.parts(deck):
            for elasticity, chosen in _turned(group, material, connectivity, deck):
                deck.solids.append(
                    Solids(
                        cell_type=cell_type,
                        nodes=connectivity[chosen],
                        labels=labels[chosen],
                        elasticity=elasticity,
                        density=material.density,
                        group=f"{group.name} of {material.name}",
                        element=HEX20_REDUCED if reduced and cell_type == "hexahedron20" else None,
                    )
                )


def _shapes(nodes: np.ndarray, count: int) -> dict[str, np.ndarray]:
    """Return the rows of each shape among bricks: by which of their corners coincide."""
    if count in (4, 10):
        return {"tetra": np.arange(len(nodes))}
    edge, top = nodes[:, 2] == nodes[:, 3], (nodes[:, 4:8] == nodes[:, 4:5]).all(axis=1)
    side = nodes[:, 6] == nodes[:, 7]
    masks = {"tetra": edge & top, "pyramid": ~edge & top, "wedge": edge & side & ~top}
    masks["hexahedron"] = ~(masks["tetra"] | masks["pyramid"] | masks["wedge"])
    return {shape: np.flatnonzero(mask) for shape, mask in masks.items() if mask.any()}


def _turned(group: Group, material: Solid, nodes: np.ndarray, deck: Deck):
    """Yield (elasticity in global axes, element numbers): one for all, or one per direction of a curved system."""
    everything = np.arange(len(nodes))
    if material.isotropic:
        yield material.solid, everything
        return
    axes = _system(group).directions(deck.points[nodes].mean(axis=1))
    _, which = np.unique(np.round(axes.reshape(len(axes), 9), 9), axis=0, return_inverse=True)
    for k in range(int(which.max()) + 1):
        chosen = np.flatnonzero(which.ravel() == k)
        yield turned_solid(material.solid, axes[chosen[0]].T), chosen


def _system(group: Group) -> System:
    if group.system is None:
        raise group.refused("an element system (ESYS) that is spherical or does not exist", "a LOCAL system 0 or 1")
    return group.system


def _thickness(group: Group, deck: Deck) -> AnsysSection:
    """Return the section that real constants of a SHELL181 stand for: TK(I) to TK(L), THETA, ADMSUA, E11, E22, E12."""
    real = [*group.real, *[0.0] * 9]
    if group.element != 181 or not real[0] > 0.0 or min(real[1:4]) < 0.0:
        expected = "SECTYPE, n, SHELL with SECDATA or SECBLOCK; of SHELL181 also thicknesses as real constants"
        raise group.refused("no shell section", expected)
    corners = [real[0], *(t or real[0] for t in real[1:4])]
    if max(corners) - min(corners) > 1e-6 * max(corners):
        what = f"{group.name} with thicknesses that differ at the corners, their mean"
        deck.inventory.approximated[what] += len(group.labels)
    section = AnsysSection("SHEL", "", Command("R", ("of real constants",), group.part))
    section.layers = [(sum(corners) / 4.0, 0, real[4])]
    section.controls = [real[6], real[7], real[8], real[5]]
    return section


def add_shells(group: Group, deck: Deck) -> None:
    """Add SHELL181 and SHELL281 with layers, offset and added mass; K = L (and O) makes a triangle."""
    section = group.section
    if section is None or not section.layers:
        section = _thickness(group, deck)
    plies, across, density, names = [], [], 0.0, []
    for thickness, number, angle in section.layers:
        material = group.need(number)
        plies.append((material.plane, thickness, np.radians(angle)))
        across.append(material.across)
        density += material.density * thickness
        names.append(material)
    total = sum(t for _, t, _ in plies)
    offsets = {"": 0.0, "MID": 0.0, "TOP": -0.5 * total, "BOT": 0.5 * total}
    if section.place not in offsets and not (section.place == "USER" and not section.shift[0]):
        raise section.where.wrong(f"SECOFFSET,{section.place}", "MID, TOP or BOT", "Move the nodes to such a face")
    a, b, d = laminate(plies, -total / 2.0)
    if np.abs(b).max() < 1e-9 * np.abs(a).max() * total:
        b = 0.0 * b
    shear = shear_compliance(plies, across)
    if group.options.get(1, 0) == 1:
        b, d, shear = 0.0 * b, 0.0 * d, 0.0 * shear
    controls = [*section.controls, 0.0, 0.0, 0.0, 0.0]
    if controls[0] > 0.0 and controls[1] > 0.0 and shear.any():
        shear = _given_shear(group, controls)
    count = FAMILIES["shell"][group.element]
    given = group.nodes[:, :count]
    if (given[:, :4] < 0).any():
        row = int(np.flatnonzero((given[:, :4] < 0).any(axis=1))[0])
        raise group.refused(f"element {int(group.labels[row])} without all corners", "four corners, K = L for three")
    three = given[:, 2] == given[:, 3]
    keep = ([0, 1, 2], [0, 1, 2, 3]) if count == 4 else ([0, 1, 2, 4, 5, 7], list(range(8)))
    faces = np.stack([turned_plane(plies[k][0], plies[k][2]) for k in (0, -1)])
    for rows, places in ((np.flatnonzero(three), keep[0]), (np.flatnonzero(~three), keep[1])):
        if not len(rows):
            continue
        nodes = given[rows][:, places]
        direction = _first_axis(group, nodes, deck, all(m.isotropic for m in names))
        cells, owners = first_order_shells(nodes, deck.inventory, group.name)
        for connectivity, own in zip(cells, owners, strict=True):
            one = np.ones(len(connectivity))
            deck.shells.append(
                Shells(
                    nodes=connectivity,
                    labels=group.labels[rows][own],
                    membrane=a,
                    coupling=b,
                    bending=d,
                    material_x=direction[own],
                    offset=offsets.get(section.place, 0.0) * one,
                    thickness=total * one,
                    mass=(density + controls[3]) * one,
                    faces=faces,
                    depths=np.array([-total / 2.0, total / 2.0]),
                    stretch=one,
                    shear=shear,
                    poisson=names[0].poisson if names[0].isotropic else 0.3,
                    group=f"{group.name} of section {section.where.text(0)}",
                )
            )


def _given_shear(group: Group, controls: list[float]) -> np.ndarray:
    """Return the transverse shear compliance (2, 2) of the stiffnesses E11, E22, E12."""
    stiffness = np.array([[controls[0], controls[2]], [controls[2], controls[1]]])
    if not np.linalg.det(stiffness) > 0.0:
        raise group.refused(f"E11, E22, E12 = {controls[0]:g}, {controls[1]:g}, {controls[2]:g}", "E12^2 < E11 E22")
    return np.linalg.inv(stiffness)


def _first_axis(group: Group, nodes: np.ndarray, deck: Deck, isotropic: bool) -> np.ndarray:
    """Return the first axis (ne, 3): the x of the element system, or from the middle of side 41 to side 23."""
    corners = deck.points[nodes[:, : 3 if nodes.shape[1] in (3, 6) else 4]]
    if corners.shape[1] == 3:
        own = corners[:, 1] - corners[:, 0]
    else:
        own = corners[:, 1] + corners[:, 2] - corners[:, 0] - corners[:, 3]
    if isotropic or not group.esys:
        return own
    return _system(group).directions(corners.mean(axis=1))[:, 0]
