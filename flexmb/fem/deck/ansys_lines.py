"""Beams, pipes and bars of an Ansys archive: BEAM188, BEAM189, PIPE288, PIPE289 and LINK180 with their sections."""

from __future__ import annotations

import numpy as np

from flexmb.fem.deck.ansys_elements import FAMILIES, Group
from flexmb.fem.deck.ansys_materials import AnsysSection
from flexmb.fem.deck.contents import Beams, Deck, Rods
from flexmb.fem.deck.nastran_materials import LOWEST
from flexmb.fem.deck.shapes import Constants, constants
from flexmb.fem.frames.section import Section
from flexmb.model.material import Material

__all__ = ["add_beams", "add_rods"]

COMPACT = 5.0 / 6.0
"""Shear factor of a section given by its constants alone."""
ALONG_Z = 1e-4
"""Sine of the angle to the global z-axis below which a beam counts as parallel to it (0.01 per cent)."""


def add_rods(group: Group, deck: Deck) -> None:
    """Add LINK180: its area is the section's or the first real constant, its added mass the second."""
    material = group.need()
    values = group.section.data if group.section is not None and group.section.data else group.real
    area = values[0] if values else 0.0
    if not area > 0.0:
        raise group.refused(f"an area of {area:g}", "a positive area (SECDATA or R)")
    added = group.real[1] if len(group.real) > 1 else 0.0
    if group.section is not None and group.section.controls:
        added = group.section.controls[0]
    one = np.ones(len(group.nodes))
    deck.rods.append(
        Rods(
            nodes=group.nodes[:, :2],
            labels=group.labels,
            axial=material.young * area * one,
            torsion=0.0 * one,
            mass=(material.density * area + added) * one,
            polar=0.0 * one,
            group=f"{group.name} of {material.name}",
        )
    )


def add_beams(group: Group, deck: Deck) -> None:
    """Add beams and pipes; three nodes on a line give two beams."""
    material = group.need()
    if not material.isotropic:
        raise group.refused(f"the orthotropic {material.name}", "an isotropic material")
    if group.section is None:
        raise group.refused("no section", "SECTYPE, n, BEAM or PIPE with SECDATA")
    made = _section(group.section, material.young / (2.0 * (1.0 + material.poisson)), deck)
    count = FAMILIES["beam"][group.element]
    ends = group.nodes[:, :count]
    if (ends < 0).any():
        raise group.refused("an element without all its nodes", f"{count} nodes")
    nodes = ends if count == 2 else np.vstack([ends[:, [0, 2]], ends[:, [2, 1]]])
    y = _y_axes(deck.points, ends, group.nodes[:, count])
    if count == 3:
        deck.inventory.approximated["beams of three nodes, as two beams"] += len(ends)
    times = len(nodes) // len(ends)
    none: frozenset[int] = frozenset()
    deck.beams.append(
        Beams(
            nodes=nodes,
            labels=np.tile(group.labels, times),
            sections=[(made, made)] * len(nodes),
            material=Material(
                young=material.young,
                poisson=material.poisson,
                density=max(material.density, LOWEST),
                name=material.name,
            ),
            y_axis=np.tile(y, (times, 1)),
            offsets=np.zeros((len(nodes), 2, 3)),
            released=[(none, none)] * len(nodes),
            group=f"{group.name} of section {group.section.where.text(0)}",
        )
    )


def _y_axes(points: np.ndarray, ends: np.ndarray, third: np.ndarray) -> np.ndarray:
    """Return the section's y (ne, 3): across the plane of the orientation node, in which z lies, else parallel to the
    global x-y plane, and global y for beams along z."""
    x = points[ends[:, 1]] - points[ends[:, 0]]
    y = np.cross([0.0, 0.0, 1.0], x)
    upright = np.linalg.norm(y, axis=1) <= ALONG_Z * np.linalg.norm(x, axis=1)
    y[upright] = [0.0, 1.0, 0.0]
    given = third >= 0
    y[given] = np.cross(points[third[given]] - points[ends[given, 0]], x[given])
    return y


def _section(given: AnsysSection, shear: float, deck: Deck) -> Section:
    """Return a section with y and z as in Mechanical APDL: SECDATA of the shapes there."""
    d = given.data
    try:
        if given.kind == "PIPE":
            found, symmetric = constants("TUBE2", [d[0] / 2.0, d[1]]), True
        elif given.shape == "RECT":
            found, symmetric = constants("BAR", [d[1], d[0]]), True
        elif given.shape == "CSOL":
            found, symmetric = constants("ROD", d[:1]), True
        elif given.shape == "CTUB":
            found, symmetric = constants("TUBE", [d[1], d[0]]), True
        elif given.shape == "HREC":
            w1, w2, t1, t2, t3, t4 = d[:6]  # walls at -y, +y, -z, +z
            found, symmetric = _upright(constants("BOX1", [w1, w2, t4, t3, t2, t1])), False
        elif given.shape == "I":
            w1, w2, w3, t1, t2, t3 = d[:6]
            found, symmetric = _upright(constants("I", [w3, w1, w2, t3, t1, t2])), False
        elif given.shape == "ASEC":
            return _arbitrary(given, shear, deck)
        else:
            raise given.where.wrong(
                f"the section {given.kind},{given.shape}",
                "RECT, CSOLID, CTUBE, HREC, I or ASEC",
                "Give its constants by SECTYPE, n, BEAM, ASEC",
            )
    except (ValueError, IndexError) as error:
        raise given.where.wrong(f"{given.shape} {d}: {error}", "the dimensions of that section") from None
    centre = _place(given, found.shear_center, symmetric)
    bend = (centre[0] + found.shear_center[0], centre[1] + found.shear_center[1])
    factors = [found.shear_y, found.shear_z]
    controls = [*given.controls, 0.0, 0.0, 0.0, 0.0]
    for k, value in ((0, controls[2]), (1, controls[0])):
        if value > 0.0:
            factors[k] = value / (shear * found.area)
    return Section.values(
        found.area,
        found.inertia_y,
        found.inertia_z,
        found.torsion,
        *factors,
        product_yz=found.product_yz,
        fibres=found.fibres,
        area_center=centre,
        shear_center=bend,
        mass_center=centre,
        line_mass=controls[3],
        line_mass_center=centre,
    )


def _place(given: AnsysSection, shear_center: tuple[float, float], symmetric: bool) -> tuple[float, float]:
    """Return the area centre (y, z) from the nodes by SECOFFSET."""
    if given.place in ("", "CENT"):
        return 0.0, 0.0
    if given.place == "SHRC":
        return -shear_center[0], -shear_center[1]
    if symmetric and given.place == "ORIG":
        return 0.0, 0.0
    if symmetric and given.place == "USER":
        return -given.shift[0], -given.shift[1]
    raise given.where.wrong(f"SECOFFSET,{given.place}", "CENT or SHRC for this shape", "Give the section by ASEC")


def _arbitrary(given: AnsysSection, shear: float, deck: Deck) -> Section:
    """Return ASEC: A, Iyy, Iyz, Izz, Iw, J, CGy, CGz, SHy, SHz, the last four from the nodes' origin."""
    area, iyy, iyz, izz, _, j, cy, cz, sy, sz = ([*given.data, *[0.0] * 10])[:10]
    if not min(area, iyy, izz, j) > 0.0 or iyz**2 >= iyy * izz:
        raise given.where.wrong(
            f"A = {area:g}, Iyy = {iyy:g}, Izz = {izz:g}, Iyz = {iyz:g}, J = {j:g}", "positive constants"
        )
    if given.place == "SHRC":
        cy, cz, sy, sz = cy - sy, cz - sz, 0.0, 0.0
    elif given.place in ("", "CENT"):
        cy, cz, sy, sz = 0.0, 0.0, sy - cy, sz - cz
    elif given.place not in ("ORIG", "ORIGIN"):
        raise given.where.wrong(f"SECOFFSET,{given.place} of ASEC", "CENT, SHRC or ORIGIN")
    centre = (cy, cz)
    xz, _, xy, added = [*given.controls, *[0.0] * 4][:4]
    factors = [value / (shear * area) if value > 0.0 else COMPACT for value in (xy, xz)]
    if COMPACT in factors:
        deck.inventory.approximated["ASEC without shear stiffness (SECCONTROLS), as a compact section's"] += 1
    return Section.values(
        area,
        iyy,
        izz,
        j,
        *factors,
        product_yz=iyz,
        area_center=centre,
        shear_center=(sy, sz),
        mass_center=centre,
        line_mass=added,
        line_mass_center=centre,
    )


def _upright(c: Constants) -> Constants:
    """Return a shape whose height is along z."""
    return Constants(
        area=c.area,
        inertia_y=c.inertia_z,
        inertia_z=c.inertia_y,
        product_yz=-c.product_yz,
        torsion=c.torsion,
        shear_y=c.shear_z,
        shear_z=c.shear_y,
        shear_center=(-c.shear_center[1], c.shear_center[0]),
        fibres=tuple((-z, y) for y, z in c.fibres),
    )
