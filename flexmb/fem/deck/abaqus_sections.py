"""Elements of an Abaqus deck with their sections and materials."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from flexmb.fem.deck.abaqus_lines import beam_section, following, trusses
from flexmb.fem.deck.abaqus_materials import Elastic, Materials
from flexmb.fem.deck.abaqus_model import Element, Flat
from flexmb.fem.deck.abaqus_surfaces import shape_of
from flexmb.fem.deck.abaqus_text import Block
from flexmb.fem.deck.cells import SolidCells, first_order_shells
from flexmb.fem.deck.contents import Deck, Shells, Solids
from flexmb.fem.deck.nastran_solids import turned_solid
from flexmb.fem.deck.solid_kinds import solid_element
from flexmb.fem.shells.laminate_block import laminate, turned_plane
from flexmb.fem.shells.laminate_shear import shear_compliance

__all__ = ["add_sections"]

LOW = {"tetra10": "tetra", "wedge15": "wedge", "hexahedron20": "hexahedron"}
CORNERS = {"tetra": 4, "wedge": 6, "hexahedron": 8, "pyramid": 5}
TURNLESS = 1e-4
"""Share of the shear stiffness that holds the rotation of S3 and S4 in their plane, which strains nothing; as in
Nastran, since Abaqus says only that it is small."""


def add_sections(flat: Flat, deck: Deck, materials: Materials) -> None:
    """Add all elements with a section; a message names elements without one and unknown kinds."""
    done = np.zeros(len(flat.elements), bool)
    makers = {
        "SOLID SECTION": _solid_section,
        "SHELL SECTION": _shell_section,
        "MEMBRANE SECTION": _shell_section,
        "BEAM SECTION": beam_section,
        "BEAM GENERAL SECTION": beam_section,
    }
    given = [(block, scope) for block, scope in flat.blocks if block.name in makers]
    owner = np.full(len(flat.elements), -1)
    for number, (block, scope) in enumerate(given):  # the last section holds, as in CalculiX
        chosen = flat.named(flat.element_sets, block.need("ELSET"), scope, block, "element set")
        if again := sum(owner[k] not in (-1, number) for k in dict.fromkeys(chosen)):
            deck.inventory.approximated[f"elements with two sections, by the last ({block.where})"] += again
        owner[chosen] = number
    for number, (block, scope) in enumerate(given):
        own = np.flatnonzero(owner == number)
        done[own] = True
        if len(own):
            makers[block.name]([flat.elements[k] for k in own], block, scope, flat, deck, materials)
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


def _table(group: list[Element], count: int, block: Block, deck: Deck) -> np.ndarray:
    """Return the nodes (ne, count); numbers behind the last are passed over, as CalculiX does, and told."""
    long = sum(len(element.nodes) > count for element in group)
    if long:
        deck.inventory.approximated[f"{group[0].kind} with more than {count} nodes, by the first {count}"] += long
    for element in group:
        if len(element.nodes) < count:
            raise block.wrong(
                f"element {element.label} ({element.kind}) with {len(element.nodes)} nodes", f"{count} nodes"
            )
    return np.array([element.nodes[:count] for element in group], np.int64)


def _solid_section(elements, block: Block, scope: str, flat: Flat, deck: Deck, materials: Materials) -> None:
    material = materials.get(block)
    group_name = block.parameters["ELSET"]
    for kind, group in _by_kind(elements).items():
        family, cell = shape_of(kind)
        labels = np.array([element.label for element in group])
        deck.inventory.read[kind] += len(group)
        if family == "point":
            deck.inventory.read[kind] -= len(group)
            continue
        if family == "truss":
            trusses(group, block, deck, material)
            continue
        if family == "flat":
            deck.inventory.read[kind] -= len(group)
            deck.inventory.left_out[f"{kind}: an element of plane or axisymmetric problems"] += len(group)
            continue
        if family != "solid" or material.solid is None:
            raise block.wrong(f"{kind} with the material '{material.name}'", "solid elements and a solid material")
        low = LOW.get(cell, cell)
        if kind.startswith("C3D8R"):
            deck.inventory.approximated[f"{kind} with incompatible modes, integrated fully"] += len(group)
        if low not in CORNERS:
            raise block.wrong(f"{kind}", "C3D4, C3D5, C3D6, C3D8, C3D10, C3D15 or C3D20")
        count = {"tetra10": 10, "wedge15": 15, "hexahedron20": 20}.get(cell, CORNERS[low])
        nodes = _table(group, count, block, deck)
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
                        element=solid_element(kind, cell_type),
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


def _shell_section(elements, block: Block, scope: str, flat: Flat, deck: Deck, materials: Materials) -> None:
    layers = _layers(block, scope, flat, materials)
    for kind, group in _by_kind(elements).items():
        family, count = shape_of(kind)
        if family != "shell":
            raise block.wrong(f"{kind} with a shell section", "shells: S3, S4, S6, S8 and their variants")
        nodes = _table(group, int(count), block, deck)[:, : min(int(count), 8)]
        labels = np.array([element.label for element in group])
        deck.inventory.read[kind] += len(group)
        corners = deck.points[nodes[:, : 3 if nodes.shape[1] in (3, 6) else 4]]
        angles, direction = _turns(layers, corners, block, scope, flat, materials)
        for cells, own in zip(*first_order_shells(nodes, deck.inventory, kind), strict=True):
            if not len(cells):
                continue
            one = _stretch(flat, block, deck, cells, sum(layer.thickness for layer in layers), kind)
            _, which = np.unique(np.round(angles[own], 9), axis=0, return_inverse=True)
            for k in range(int(which.max()) + 1):
                rows = np.flatnonzero(which.ravel() == k)
                deck.shells.append(
                    Shells(
                        nodes=cells[rows],
                        labels=labels[own[rows]],
                        material_x=direction[own[rows]],
                        stretch=one[rows],
                        **_stack(layers, angles[own[rows[0]]], block, flat, one[rows]),
                        group=block.parameters["ELSET"],
                        spring=TURNLESS if int(count) <= 4 else None,
                    )
                )


def _stack(layers: list[_Layer], angles: np.ndarray, block: Block, flat: Flat, stretch: np.ndarray) -> dict:
    """Return what `Shells` need of plies at their angles."""
    plies = [(layer.material.plane, layer.thickness, float(a)) for layer, a in zip(layers, angles, strict=True)]
    across = [layer.material.across for layer in layers]
    total = sum(layer.thickness for layer in layers)
    a, b, d = laminate(plies, -total / 2.0)
    if np.abs(b).max() < 1e-9 * np.abs(a).max() * total:
        b = 0.0 * b
    membrane = block.name == "MEMBRANE SECTION"
    if membrane:
        b, d = 0.0 * b, 0.0 * d
    return {
        "membrane": a,
        "coupling": b,
        "bending": d,
        "offset": _offset(block) * total * stretch,
        "thickness": total * stretch,
        "mass": sum(layer.material.density * layer.thickness for layer in layers) * stretch,
        "faces": np.stack([turned_plane(plies[k][0], plies[k][2]) for k in (0, -1)]),
        "depths": np.array([-total / 2.0, total / 2.0]),
        "shear": np.zeros((2, 2)) if membrane else _sheared(block, flat, shear_compliance(plies, across)),
        "poisson": layers[0].material.poisson,
    }


def _sheared(block: Block, flat: Flat, of_plies: np.ndarray) -> np.ndarray:
    """Return the transverse shear compliance (2, 2) of *TRANSVERSE SHEAR STIFFNESS, or that of the plies without it."""
    given = following(flat, block, "TRANSVERSE SHEAR STIFFNESS")
    if given is None:
        return of_plies
    k11, k22, k12 = given.reals(given.rows()[0] if given.rows() else [], 3, 0.0)
    k22 = k22 or k11
    if not (k11 > 0.0 and k11 * k22 > k12**2):
        raise given.wrong(f"K11, K22, K12 = {k11:g}, {k22:g}, {k12:g}", "K11, K22 > 0, K12^2 < K11 K22")
    return np.linalg.inv([[k11, k12], [k12, k22]])


def _stretch(flat: Flat, section: Block, deck: Deck, nodes: np.ndarray, total: float, kind: str) -> np.ndarray:
    """Return the thickness (ne,) of shells over their section's: the mean of *NODAL THICKNESS at their nodes.

    It counts where the section says so by its parameter NODAL THICKNESS, as in CalculiX.
    """
    given: dict[int, float] = {}
    for block, scope in flat.blocks:
        if block.name == "NODAL THICKNESS":
            for row in block.rows():
                value = block.reals(row[1:2], 1)[0]
                if not value > 0.0:
                    raise block.wrong(f"a thickness of {value:g}", "positive thicknesses")
                given |= dict.fromkeys(flat.nodes_of(row[0], scope, block), value)
    if not given or not any(node in given for node in nodes.ravel().tolist()):
        return np.ones(len(nodes))
    if "NODALTHICKNESS" not in section.parameters:
        deck.inventory.left_out["*NODAL THICKNESS of shells whose section does not ask for it"] += len(nodes)
        return np.ones(len(nodes))
    if "COMPOSITE" in section.parameters:
        deck.inventory.left_out["*NODAL THICKNESS of composite shells"] += len(nodes)
        return np.ones(len(nodes))
    own = np.array([[given.get(node, total) for node in row] for row in nodes.tolist()])
    if np.ptp(own, axis=1).any():
        deck.inventory.approximated[f"{kind} with thicknesses that differ at the nodes, their mean"] += len(nodes)
    return own.mean(axis=1) / total


def _offset(block: Block) -> float:
    """Return the offset of the mid-surface from the nodes in thicknesses; Abaqus counts it from the mid-surface."""
    word = block.parameters.get("OFFSET", "0").upper()
    if word in ("SPOS", "SNEG"):
        return -0.5 if word == "SPOS" else 0.5
    return -block.reals([word or "0"], 1)[0]


@dataclass(frozen=True)
class _Layer:
    """A ply: its material, thickness, and the angle from the section's axis or the orientation that gives it."""

    material: Elastic
    thickness: float
    angle: float
    orientation: str


def _layers(block: Block, scope: str, flat: Flat, materials: Materials) -> list[_Layer]:
    """Return the plies of a section, from the bottom."""
    rows = [row for row in block.rows() if any(row)]
    if not rows:
        raise block.wrong("no thickness", "a data line with the thickness")
    if "COMPOSITE" not in block.parameters:
        rows = [[rows[0][0], "", block.need("MATERIAL"), "0"]]
    out = []
    for row in rows:
        row = [*row, "", "", "", ""][:4]
        thickness = block.reals(row[:1], 1)[0]
        if not thickness > 0.0:
            raise block.wrong(f"a thickness of {thickness:g}", "positive thicknesses")
        material, word = materials.get(block, row[2] or block.parameters.get("MATERIAL")), row[3]
        named = bool(word) and flat.full(materials.orientations, word, scope) is not None
        angle = np.radians(block.reals([word], 1, 0.0)[0]) if word and not named else 0.0
        out.append(_Layer(material, thickness, float(angle), word if named and not material.isotropic else ""))
    return out


def _turns(layers: list[_Layer], corners: np.ndarray, block: Block, scope: str, flat: Flat, materials: Materials):
    """Return the angle of each ply (ne, plies) from the 1-direction of each shell, and that direction (ne, 3).

    A ply with an orientation of its own, as CalculiX writes all of them, lies along its projected first axis.
    """
    count = corners.shape[1]
    normal = np.cross(corners[:, 2 if count == 4 else 1] - corners[:, 0], corners[:, count - 1] - corners[:, count - 3])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    section = block.parameters.get("ORIENTATION", "")
    along = _first_axis(section, corners, normal, block, scope, flat, materials)
    angles = np.tile([layer.angle for layer in layers], (len(corners), 1))
    for k, layer in enumerate(layers):
        if layer.orientation:
            own = _first_axis(layer.orientation, corners, normal, block, scope, flat, materials)
            sine = np.einsum("ei,ei->e", normal, np.cross(along, own))
            flat_part = np.einsum("ei,ei->e", along, normal) * np.einsum("ei,ei->e", own, normal)
            angles[:, k] = np.arctan2(sine, np.einsum("ei,ei->e", along, own) - flat_part)
    return angles, along


def _first_axis(
    name: str, corners: np.ndarray, normal: np.ndarray, block: Block, scope: str, flat: Flat, materials: Materials
):
    """Return the first axis (ne, 3) of an orientation; without one global x, or z where x is normal (to 0.1 degree)."""
    if name:
        return materials.axes(name, scope, block, flat, corners.mean(axis=1))[:, 0]
    along_x = np.abs(normal[:, 0]) > np.cos(np.radians(0.1))
    return np.where(along_x[:, None], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
