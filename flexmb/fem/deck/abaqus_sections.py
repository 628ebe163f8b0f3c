"""Elements of an Abaqus deck with their sections and materials."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from flexmb.fem.deck.abaqus_model import Element, Flat
from flexmb.fem.deck.abaqus_surfaces import shape_of
from flexmb.fem.deck.abaqus_text import Block
from flexmb.fem.deck.cells import SolidCells, first_order_shells
from flexmb.fem.deck.contents import Beams, Deck, Rods, Shells, Solids
from flexmb.fem.deck.nastran_materials import LOWEST
from flexmb.fem.deck.nastran_shells import turned_solid
from flexmb.fem.deck.shapes import Constants, constants
from flexmb.fem.laminate_block import laminate, shear_stiffness, turned_plane
from flexmb.fem.section import Section
from flexmb.model.material import Material

__all__ = ["Materials", "add_sections"]

LOW = {"tetra10": "tetra", "wedge15": "wedge", "hexahedron20": "hexahedron"}
CORNERS = {"tetra": 4, "wedge": 6, "hexahedron": 8, "pyramid": 5}


@dataclass(eq=False)
class Elastic:
    """A material: elasticity (6, 6) in its own axes, plane stress (3, 3), density, E and nu where isotropic."""

    name: str
    density: float
    solid: np.ndarray | None
    plane: np.ndarray
    young: float
    poisson: float
    across: tuple[float, float]
    isotropic: bool


class Materials:
    """The materials and orientations of a deck by name."""

    def __init__(self, flat: Flat, deck: Deck):
        self.blocks: dict[str, list[Block]] = {}
        self.heads: dict[str, Block] = {}
        self.orientations: dict[str, tuple[Block, str]] = {}
        self.made: dict[str, Elastic] = {}
        current = None
        for block, scope in flat.blocks:
            if block.name == "MATERIAL":
                current = block.need("NAME").lower()
                self.blocks.setdefault(current, [])
                self.heads[current] = block
            elif block.name in ("ELASTIC", "DENSITY", "DAMPING", "PLASTIC", "HYPERELASTIC") and current is not None:
                self.blocks[current].append(block)
            elif block.name == "ORIENTATION":
                prefix = f"{scope}." if scope else ""
                self.orientations[prefix + block.need("NAME").lower()] = (block, scope)
        deck.inventory.read["*MATERIAL"] = len(self.heads)

    def get(self, block: Block, name: str | None = None) -> Elastic:
        """Return the material of a section."""
        wanted = (name or block.need("MATERIAL")).lower()
        if wanted not in self.made:
            if wanted not in self.heads:
                known = ", ".join(sorted(self.heads)) or "none"
                raise block.wrong(f"the material '{wanted}', which does not exist", f"One of: {known}")
            self.made[wanted] = _elastic(wanted, self.heads[wanted], self.blocks[wanted])
        return self.made[wanted]

    def axes(self, word: str, scope: str, block: Block, flat: Flat, points: np.ndarray) -> np.ndarray:
        """Return the axes (n, 3, 3), rows 1, 2, 3, of an orientation at points (n, 3)."""
        name = flat.full(self.orientations, word, scope)
        if name is None:
            known = ", ".join(sorted(self.orientations)) or "none"
            raise block.wrong(f"the orientation '{word}', which does not exist", f"One of: {known}")
        given, own = self.orientations[name]
        return _orientation(given, flat.scopes[own].rotation, flat.scopes[own].origin, points)


def _elastic(name: str, head: Block, blocks: list[Block]) -> Elastic:
    density, elastic = 0.0, None
    for block in blocks:
        if block.name == "DENSITY" and block.rows():
            density = block.reals(block.rows()[0][:1])[0]
        elif block.name == "ELASTIC":
            elastic = block
        elif block.name == "HYPERELASTIC":
            raise block.wrong(f"the hyperelastic material '{name}'", "*ELASTIC", "Give its modulus for small strains")
    if elastic is None or not elastic.rows():
        raise head.wrong(f"the material '{name}' without *ELASTIC", "*ELASTIC with its constants")
    if density < 0.0:
        raise head.wrong(f"a density of {density:g}", "a density >= 0")
    word = elastic.parameters.get("TYPE", "ISOTROPIC").upper()
    known = ("ISOTROPIC", "ENGINEERING CONSTANTS", "ORTHOTROPIC", "ANISOTROPIC", "LAMINA")
    kind = next((name for name in known if word[:3] == name[:3]), word)
    values = [x for row in elastic.rows()[:3] for x in elastic.reals([w for w in row if w])]
    if kind == "ISOTROPIC":
        e, nu = (*elastic.reals([w for w in elastic.rows()[0][:2] if w]), 0.0)[:2]
        if not e > 0.0 or not -1.0 < nu <= 0.5:
            raise elastic.wrong(f"E = {e:g}, nu = {nu:g}", "E > 0, -1 < nu < 0.5")
        nu, g = min(nu, 0.4999), e / (2.0 * (1.0 + min(nu, 0.4999)))
        solid = np.diag([2.0 * g] * 3 + [g] * 3)
        solid[:3, :3] += e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
        plane = e / (1.0 - nu**2) * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, (1.0 - nu) / 2.0]])
        return Elastic(name, density, solid, plane, e, nu, (g, g), True)
    needs = {"ENGINEERING CONSTANTS": 9, "ORTHOTROPIC": 9, "ANISOTROPIC": 21, "LAMINA": 6}
    if kind not in needs:
        raise elastic.wrong(f"TYPE={kind}", f"ISOTROPIC, {', '.join(needs)}")
    if len(values) < needs[kind]:
        raise elastic.wrong(f"{len(values)} constants", f"{needs[kind]} for TYPE={kind}")
    if kind == "LAMINA":
        e1, e2, nu12, g12, g13, g23 = values[:6]
        rest = 1.0 - nu12**2 * e2 / e1 if e1 > 0.0 else 0.0
        if not (e1 > 0.0 and e2 > 0.0 and rest > 0.0):
            raise elastic.wrong(f"E1 = {e1:g}, E2 = {e2:g}, nu12 = {nu12:g}", "moduli > 0, nu12^2 < E1 / E2")
        plane = np.array([[e1, nu12 * e2, 0.0], [nu12 * e2, e2, 0.0], [0.0, 0.0, g12 * rest]]) / rest
        return Elastic(name, density, None, plane, 0.0, nu12, (g13 or np.inf, g23 or np.inf), False)
    solid = _stiffness(kind, values, elastic)
    compliance = np.linalg.inv(solid)
    plane = np.linalg.inv(compliance[np.ix_([0, 1, 3], [0, 1, 3])])
    return Elastic(name, density, solid, plane, 0.0, 0.3, (solid[5, 5], solid[4, 4]), False)


def _stiffness(kind: str, v: list[float], block: Block) -> np.ndarray:
    """Return (6, 6) in the order xx, yy, zz, xy, yz, zx; Abaqus writes 11, 22, 33, 12, 13, 23."""
    solid = np.zeros((6, 6))
    if kind == "ENGINEERING CONSTANTS":
        e1, e2, e3, nu12, nu13, nu23, g12, g13, g23 = v[:9]
        if min(e1, e2, e3, g12, g13, g23) <= 0.0:
            raise block.wrong("moduli that are not positive", "nine engineering constants, moduli > 0")
        compliance = np.zeros((6, 6))
        compliance[:3, :3] = [
            [1 / e1, -nu12 / e1, -nu13 / e1],
            [-nu12 / e1, 1 / e2, -nu23 / e2],
            [-nu13 / e1, -nu23 / e2, 1 / e3],
        ]
        compliance[3, 3], compliance[4, 4], compliance[5, 5] = 1 / g12, 1 / g23, 1 / g13
        solid = np.linalg.inv(compliance)
    elif kind == "ORTHOTROPIC":
        d1111, d1122, d2222, d1133, d2233, d3333, d1212, d1313, d2323 = v[:9]
        solid[:3, :3] = [[d1111, d1122, d1133], [d1122, d2222, d2233], [d1133, d2233, d3333]]
        solid[3, 3], solid[4, 4], solid[5, 5] = d1212, d2323, d1313
    else:
        place = [0, 1, 2, 3, 5, 4]  # 11, 22, 33, 12, 13, 23
        at = 0
        for j in range(6):
            for i in range(j + 1):
                solid[place[i], place[j]] = solid[place[j], place[i]] = v[at]
                at += 1
    if not np.linalg.eigvalsh(solid)[0] > 0.0:
        raise block.wrong("an elasticity that is not positive", "constants of a stable material")
    return solid


def _orientation(block: Block, rotation: np.ndarray, origin: np.ndarray, points: np.ndarray) -> np.ndarray:
    rows = block.rows()
    if not rows:
        raise block.wrong("no data line", "two points")
    system = block.parameters.get("SYSTEM", "RECTANGULAR").upper()
    values = np.array(block.reals(rows[0], 9, 0.0))
    a, b = values[:3], values[3:6]
    if system.startswith("RECT"):
        x = a - values[6:9]
        z = np.cross(x, b - values[6:9])
        if not np.linalg.norm(z) > 0.0:
            raise block.wrong("directions on one line", "two different directions")
        frame = np.stack(
            [x / np.linalg.norm(x), np.cross(z, x) / np.linalg.norm(np.cross(z, x)), z / np.linalg.norm(z)]
        )
        axes = np.broadcast_to(frame @ rotation.T, (len(points), 3, 3)).copy()
    elif system.startswith("CYL"):
        line = rotation @ (b - a)
        line = line / (np.linalg.norm(line) or 1.0)
        radial = points - (rotation @ a + origin)
        radial = radial - np.outer(radial @ line, line)
        size = np.linalg.norm(radial, axis=1)
        if (size <= 0.0).any():
            raise block.wrong("an element on the axis of a cylindrical orientation", "elements off the axis")
        radial /= size[:, None]
        axes = np.stack([radial, np.cross(line, radial), np.broadcast_to(line, radial.shape)], axis=1)
    else:
        raise block.wrong(f"SYSTEM={system}", "RECTANGULAR or CYLINDRICAL")
    if len(rows) > 1:
        axis, angle = block.reals(rows[1], 2, 0.0)
        k = int(axis or 1) - 1
        i, j = [(1, 2), (2, 0), (0, 1)][k]
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        axes[:, i], axes[:, j] = c * axes[:, i] + s * axes[:, j], c * axes[:, j] - s * axes[:, i]
    return axes


def add_sections(flat: Flat, deck: Deck, materials: Materials) -> None:
    """Add all elements with a section; elements without one, and kinds that are not known, are told."""
    done = np.zeros(len(flat.elements), bool)
    makers = {
        "SOLID SECTION": _solid_section,
        "SHELL SECTION": _shell_section,
        "MEMBRANE SECTION": _shell_section,
        "BEAM SECTION": _beam_section,
        "BEAM GENERAL SECTION": _beam_section,
    }
    for block, scope in flat.blocks:
        if block.name not in makers:
            continue
        chosen = flat.named(flat.element_sets, block.need("ELSET"), scope, block, "element set")
        fresh = [k for k in dict.fromkeys(chosen) if not done[k]]
        done[fresh] = True
        if fresh:
            makers[block.name]([flat.elements[k] for k in fresh], block, scope, flat, deck, materials)
        deck.inventory.read[f"*{block.name}"] += 1
    bare: dict[str, int] = defaultdict(int)
    for k in np.flatnonzero(~done):
        family, _ = shape_of(flat.elements[k].kind)
        if family not in ("point", "rigid"):
            bare[flat.elements[k].kind] += 1
    for kind, count in sorted(bare.items()):
        family = shape_of(kind)[0]
        why = "no section" if family else "an element that is not known"
        if family == "flat":
            why = "an element of plane or axisymmetric problems"
        deck.inventory.left_out[f"{kind}: {why}"] += count


def _by_kind(elements: list[Element]) -> dict[str, list[Element]]:
    out: dict[str, list[Element]] = defaultdict(list)
    for element in elements:
        out[element.kind].append(element)
    return out


def _table(group: list[Element], count: int, block: Block) -> np.ndarray:
    for element in group:
        if len(element.nodes) != count:
            raise block.wrong(
                f"element {element.label} ({element.kind}) with {len(element.nodes)} nodes", f"{count} nodes"
            )
    return np.array([element.nodes for element in group], np.int64)


def _solid_section(elements, block: Block, scope: str, flat: Flat, deck: Deck, materials: Materials) -> None:
    material = materials.get(block)
    group_name = block.parameters["ELSET"]
    for kind, group in _by_kind(elements).items():
        family, cell = shape_of(kind)
        labels = np.array([element.label for element in group])
        deck.inventory.read[kind] += len(group)
        if family == "truss":
            _trusses(group, block, deck, material)
            continue
        if family == "flat":
            deck.inventory.read[kind] -= len(group)
            deck.inventory.left_out[f"{kind}: an element of plane or axisymmetric problems"] += len(group)
            continue
        if family != "solid" or material.solid is None:
            raise block.wrong(f"{kind} with the material '{material.name}'", "solid elements and a solid material")
        low = LOW.get(cell, cell)
        if low not in CORNERS:
            raise block.wrong(f"{kind}", "C3D4, C3D5, C3D6, C3D8, C3D10, C3D15 or C3D20")
        count = {"tetra10": 10, "wedge15": 15, "hexahedron20": 20}.get(cell, CORNERS[low])
        nodes = _table(group, count, block)
        full = np.full((len(nodes), {"tetra": 10, "wedge": 15, "hexahedron": 20, "pyramid": 13}[low]), -1)
        full[:, :count] = nodes
        high = {"tetra": "tetra10", "wedge": "wedge15", "hexahedron": "hexahedron20", "pyramid": "pyramid13"}[low]
        for cell_type, connectivity, own in SolidCells(low, high, CORNERS[low], full, labels).parts(deck):
            for elasticity, chosen in _turned(material, connectivity, block, scope, flat, deck, materials):
                deck.solids.append(
                    Solids(
                        cell_type=cell_type,
                        nodes=connectivity[chosen],
                        labels=own[chosen],
                        elasticity=elasticity,
                        density=material.density,
                        group=group_name,
                    )
                )


def _turned(material: Elastic, nodes: np.ndarray, block: Block, scope: str, flat: Flat, deck: Deck, all_: Materials):
    """Yield (elasticity in global axes, element numbers)."""
    assert material.solid is not None
    everything = np.arange(len(nodes))
    if material.isotropic or "ORIENTATION" not in block.parameters:
        turn = flat.scopes[scope].rotation
        yield (material.solid if material.isotropic else turned_solid(material.solid, turn)), everything
        return
    centres = deck.points[nodes].mean(axis=1)
    axes = all_.axes(block.parameters["ORIENTATION"], scope, block, flat, centres)
    _, which = np.unique(np.round(axes.reshape(len(axes), 9), 9), axis=0, return_inverse=True)
    for k in range(int(which.max()) + 1):
        chosen = np.flatnonzero(which.ravel() == k)
        yield turned_solid(material.solid, axes[chosen[0]].T), chosen


def _trusses(group: list[Element], block: Block, deck: Deck, material: Elastic) -> None:
    rows = block.rows()
    area = block.reals(rows[0][:1], 1, 1.0)[0] if rows else 1.0
    pairs, labels = _segments(group)
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


def _segments(group: list[Element]) -> tuple[np.ndarray, np.ndarray]:
    """Return pairs of nodes and element numbers; three nodes on a line give two pairs."""
    pairs, labels = [], []
    for element in group:
        ends = element.nodes if len(element.nodes) <= 3 else element.nodes[:2]
        for a, b in pairwise(ends):
            pairs.append((a, b))
            labels.append(element.label)
    return np.array(pairs, np.int64), np.array(labels, np.int64)


def _shell_section(elements, block: Block, scope: str, flat: Flat, deck: Deck, materials: Materials) -> None:
    plies, names, across, density = _plies(block, scope, flat, materials)
    total = sum(t for _, t, _ in plies)
    offset = _offset(block) * total
    a, b, d = laminate(plies, -total / 2.0)
    if np.abs(b).max() < 1e-9 * np.abs(a).max() * total:
        b = 0.0 * b
    membrane = block.name == "MEMBRANE SECTION"
    if membrane:
        b, d = 0.0 * b, 0.0 * d
    shear = float("inf") if membrane else shear_stiffness(plies, across)
    faces = np.stack([turned_plane(plies[k][0], plies[k][2]) for k in (0, -1)])
    for kind, group in _by_kind(elements).items():
        family, count = shape_of(kind)
        if family != "shell":
            raise block.wrong(f"{kind} with a shell section", "shells: S3, S4, S6, S8 and their variants")
        nodes = _table(group, int(count), block)[:, : min(int(count), 8)]
        labels = np.array([element.label for element in group])
        deck.inventory.read[kind] += len(group)
        direction = _shell_direction(block, scope, flat, deck, materials, nodes)
        for cells, own in zip(*first_order_shells(nodes, deck.inventory, kind), strict=True):
            if len(cells):
                one = np.ones(len(cells))
                deck.shells.append(
                    Shells(
                        nodes=cells,
                        labels=labels[own],
                        membrane=a,
                        coupling=b,
                        bending=d,
                        material_x=direction[own],
                        offset=offset * one,
                        thickness=total * one,
                        mass=density * one,
                        faces=faces,
                        depths=np.array([-total / 2.0, total / 2.0]),
                        stretch=one,
                        shear=shear,
                        poisson=materials.get(block, names[0]).poisson,
                        group=block.parameters["ELSET"],
                    )
                )


def _offset(block: Block) -> float:
    """Return the offset of the mid-surface from the nodes in thicknesses; Abaqus counts it from the mid-surface."""
    word = block.parameters.get("OFFSET", "0").upper()
    if word in ("SPOS", "SNEG"):
        return -0.5 if word == "SPOS" else 0.5
    return -block.reals([word or "0"])[0]


def _plies(block: Block, scope: str, flat: Flat, materials: Materials):
    """Return plies (elasticity, thickness, angle), their materials, shear moduli, and the mass per area."""
    plies, names, across, density = [], [], [], 0.0
    rows = [row for row in block.rows() if any(row)]
    if not rows:
        raise block.wrong("no thickness", "a data line with the thickness")
    if "COMPOSITE" not in block.parameters:
        rows = [[rows[0][0], "", block.need("MATERIAL"), "0"]]
    for row in rows:
        row = [*row, "", "", "", ""][:4]
        thickness = block.reals(row[:1])[0]
        if not thickness > 0.0:
            raise block.wrong(f"a thickness of {thickness:g}", "positive thicknesses")
        material = materials.get(block, row[2] or block.parameters.get("MATERIAL"))
        word = row[3]
        named = bool(word) and flat.full(materials.orientations, word, scope) is not None
        if named and not material.isotropic:
            raise block.wrong(f"a ply with the orientation '{word}'", "an angle in degrees", "Give the ply an angle")
        angle = np.radians(block.reals([word], 1, 0.0)[0]) if word and not named else 0.0
        plies.append((material.plane, thickness, angle))
        names.append(material.name)
        across.append(material.across)
        density += material.density * thickness
    return plies, names, across, density


def _shell_direction(block: Block, scope: str, flat: Flat, deck: Deck, materials: Materials, nodes) -> np.ndarray:
    """Return the 1-direction (ne, 3) of shells: the projected global x-axis, or z where x is normal (to 0.1 degree)."""
    corners = 3 if nodes.shape[1] in (3, 6) else 4
    points = deck.points[nodes[:, :corners]]
    normal = np.cross(
        points[:, 2 if corners == 4 else 1] - points[:, 0], points[:, corners - 1] - points[:, corners - 3]
    )
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    if "ORIENTATION" in block.parameters:
        return materials.axes(block.parameters["ORIENTATION"], scope, block, flat, points.mean(axis=1))[:, 0]
    along_x = np.abs(normal[:, 0]) > np.cos(np.radians(0.1))
    return np.where(along_x[:, None], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])


def _beam_section(elements, block: Block, scope: str, flat: Flat, deck: Deck, materials: Materials) -> None:
    general = block.name == "BEAM GENERAL SECTION"
    rows = block.rows()
    shape = block.parameters.get("SECTION", "GENERAL" if general else "RECT").upper()
    if not rows:
        raise block.wrong("no data line", "the dimensions of the section")
    if general and shape == "GENERAL":
        area, i11, i12, i22, j = block.reals(rows[0], 5, 0.0)
        if not area > 0.0 or i11 <= 0.0 or i22 <= 0.0 or j < 0.0:
            raise block.wrong(f"A = {area:g}, I11 = {i11:g}, I22 = {i22:g}, J = {j:g}", "positive constants")
        section = Section.values(area, i11, i22, j or 1e-9 * (i11 + i22), 1e6, 1e6, product_yz=-i12)
        young, shear = (*block.reals(rows[2], 2, 0.0),) if len(rows) > 2 else (0.0, 0.0)
        density = block.reals([block.parameters.get("DENSITY", "0") or "0"])[0]
        name = "general"
        if "MATERIAL" in block.parameters:
            elastic = materials.get(block)
            young, poisson, density, name = elastic.young, elastic.poisson, elastic.density, elastic.name
        else:
            poisson = young / (2.0 * shear) - 1.0 if shear > 0.0 else 0.0
    else:
        section = _section(shape, block, block.reals([w for w in rows[0] if w]))
        elastic = materials.get(block)
        young, poisson, density, name = elastic.young, elastic.poisson, elastic.density, elastic.name
    if not young > 0.0 or not -1.0 < poisson < 0.5:
        raise block.wrong(f"E = {young:g}, nu = {poisson:g}", "an isotropic material")
    direction = np.array(block.reals(rows[1], 3, 0.0)) if len(rows) > 1 and any(rows[1]) else np.array([0.0, 0.0, -1.0])
    direction = flat.scopes[scope].rotation @ direction
    group = [element for element in elements if shape_of(element.kind)[0] == "beam"]
    for element in elements:
        if element not in group:
            raise block.wrong(f"{element.kind} with a beam section", "B31, B32 or B33")
        deck.inventory.read[element.kind] += 1
    if any(len(element.nodes) == 3 for element in group):
        deck.inventory.approximated["beams of three nodes, as two beams"] += sum(len(e.nodes) == 3 for e in group)
    pairs, labels = _segments(group)
    along = deck.points[pairs[:, 1]] - deck.points[pairs[:, 0]]
    y = np.broadcast_to(direction, along.shape).copy()
    parallel = np.linalg.norm(np.cross(along, y), axis=1) <= 1e-6 * np.linalg.norm(along, axis=1) * np.linalg.norm(y[0])
    y[parallel] = [1.0, 0.0, 0.0]
    none: frozenset[int] = frozenset()
    deck.beams.append(
        Beams(
            nodes=pairs,
            labels=labels,
            sections=[(section, section)] * len(pairs),
            material=Material(young=young, poisson=poisson, density=max(density, LOWEST), name=name),
            y_axis=y,
            offsets=np.zeros((len(pairs), 2, 3)),
            released=[(none, none)] * len(pairs),
            group=block.parameters["ELSET"],
        )
    )


def _section(shape: str, block: Block, d: list[float]) -> Section:
    """Return a section: the first local axis (1) is y, the second (2) is z."""
    try:
        if shape.startswith("RECT"):
            c = constants("BAR", [d[1] if len(d) > 1 else d[0], d[0]])  # a along 1, b along 2
        elif shape in ("CIRC", "CIRCULAR"):
            # CalculiX gives two thicknesses, Abaqus one radius
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
    """Return a shape whose height is along the second local axis."""
    return Section.values(
        c.area,
        c.inertia_z,
        c.inertia_y,
        c.torsion,
        c.shear_z,
        c.shear_y,
        product_yz=-c.product_yz,
        fibres=tuple((-z, y) for y, z in c.fibres),
    )
