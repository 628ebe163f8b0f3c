"""`read_abaqus_deck`: an Abaqus or CalculiX deck as a `Deck`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.deck.abaqus_keywords import told
from flexmb.fem.deck.abaqus_links import add_abaqus_links, add_boundary
from flexmb.fem.deck.abaqus_lumped import add_abaqus_lumped
from flexmb.fem.deck.abaqus_materials import Materials
from flexmb.fem.deck.abaqus_model import Flat, flattened_deck
from flexmb.fem.deck.abaqus_parameters import MESH, tell_parameters
from flexmb.fem.deck.abaqus_sections import add_sections
from flexmb.fem.deck.abaqus_surfaces import facets, surface_nodes
from flexmb.fem.deck.abaqus_text import read_blocks
from flexmb.fem.deck.contents import Deck

__all__ = ["read_abaqus_deck"]

ON_AXIS = 1e-9
"""Distance from the axis of a cylindrical *TRANSFORM, in lengths of the axis, that counts as none."""


def read_abaqus_deck(path: Path) -> Deck:
    """Read an Abaqus or CalculiX deck; MeshError with file, line and keyword for whatever cannot be read."""
    part = f"Deck '{path}'"
    blocks = read_blocks(path)
    flat = flattened_deck(blocks, part)
    instances, instance_of = _instances(flat)
    deck = Deck(
        name=path.stem,
        source="Abaqus",
        labels=np.array(flat.labels, np.int64),
        points=np.array(flat.points),
        instances=instances,
        instance_of=instance_of,
    )
    deck.inventory.read["*NODE"] = len(flat.points)
    deck.inventory.left_out.update(flat.skipped)
    for block in blocks:
        if block.name in MESH:
            tell_parameters(block, deck.inventory)
    materials = Materials(flat, deck)
    steps = _model_data(flat, deck)
    frames = _frames(flat, deck)
    add_sections(flat, deck, materials)
    add_abaqus_links(flat, deck, frames, materials)
    add_abaqus_lumped(flat, deck, frames, materials)
    add_boundary(flat, deck, frames, steps)
    for name, nodes in flat.node_sets.items():
        if nodes:
            deck.node_sets[flat.names.get(name, name)] = np.unique(np.array(nodes, np.int64))
    for name, chosen in flat.element_sets.items():
        held = {node for k in chosen for node in flat.elements[k].nodes}
        if held:
            deck.node_sets.setdefault(flat.names.get(name, name), np.array(sorted(held), np.int64))
    for name in flat.surfaces:
        rows = facets(flat, name)
        if len(rows):
            deck.facet_sets[flat.names.get(name, name)] = rows
        on = surface_nodes(flat, name)
        if len(on):
            deck.node_sets.setdefault(flat.names.get(name, name), on)
    _of_instances_and_materials(flat, deck)
    return deck


def _instances(flat: Flat) -> tuple[tuple[str, ...], np.ndarray | None]:
    """Return the names of the instances and to which a node belongs (n,), -1 for the assembly; none of a flat deck."""
    placed = [scope for scope in flat.scopes.values() if scope.name]
    if not placed:
        return (), None
    owner = np.full(len(flat.labels), -1)
    for number, scope in enumerate(placed):
        owner[list(scope.nodes.values())] = number
    return tuple(scope.title for scope in placed), owner


def _of_instances_and_materials(flat: Flat, deck: Deck) -> None:
    """Add the sets that instances and materials name, where nothing else has the name."""
    for scope in flat.scopes.values():
        if scope.name and scope.nodes:
            deck.node_sets.setdefault(scope.title, np.array(sorted(scope.nodes.values()), np.int64))
    made: dict[str, set[int]] = {}
    for block, scope_name in flat.blocks:
        parameters = block.parameters
        if not block.name.endswith("SECTION"):  # *MEMBRANE, which is left out by name
            continue
        if "MATERIAL" not in parameters or "ELSET" not in parameters or parameters["MATERIAL"] in deck.node_sets:
            continue
        for element in flat.elements_of(parameters["ELSET"], scope_name, block):
            made.setdefault(parameters["MATERIAL"], set()).update(flat.elements[element].nodes)
    deck.node_sets |= {name: np.array(sorted(nodes), np.int64) for name, nodes in made.items()}


def _model_data(flat: Flat, deck: Deck) -> list:
    """Return the keywords of the first step, remove all steps, and tell what is left out or not needed."""
    kept, first, steps, inside = [], [], 0, False
    for block, scope in flat.blocks:
        if block.name == "STEP":
            steps, inside = steps + 1, True
        elif block.name == "END STEP":
            inside = False
        elif inside:
            if steps == 1:
                first.append((block, scope))
                if block.name == "BOUNDARY":
                    tell_parameters(block, deck.inventory)
        else:
            kept.append((block, scope))
            told(block.name, deck.inventory)
            tell_parameters(block, deck.inventory)
    if inside:
        deck.inventory.left_out["what may follow the last line: *STEP has no *END STEP, as in a file cut off"] += 1
    flat.blocks = kept
    return first


def _frames(flat: Flat, deck: Deck) -> dict[int, np.ndarray]:
    """Return the axes (3, 3) of nodes with *TRANSFORM, in which supports, equations and loads are meant."""
    frames: dict[int, np.ndarray] = {}
    for block, scope in flat.blocks:
        if block.name != "TRANSFORM":
            continue
        rows = block.rows()
        if not rows:
            raise block.wrong("no data line", "two points")
        values = np.array(block.reals(rows[0], 6, 0.0))
        a, b = values[:3], values[3:]
        kind = block.parameters.get("TYPE", "R").upper()[:1]
        if kind not in "RC":
            raise block.wrong(f"TYPE={kind}", "R or C")
        turn = flat.scopes[scope].rotation
        for node in flat.nodes_of(block.need("NSET"), scope, block):
            point = deck.points[node]
            if kind == "R":
                x = turn @ a
                z = np.cross(x, turn @ b)
                y = np.cross(z, x)
            else:
                z = turn @ (b - a)
                x = point - (turn @ a + flat.scopes[scope].origin)
                x = x - (x @ z) / (z @ z) * z if z.any() else x
                if z.any() and np.linalg.norm(x) <= ON_AXIS * np.linalg.norm(z):
                    x = np.cross(np.eye(3)[int(np.abs(z).argmin())], z)  # on the axis itself no radius is better
                    deck.inventory.approximated["*TRANSFORM: nodes on the axis, with any radial direction"] += 1
                y = np.cross(z, x)
            if min(np.linalg.norm(v) for v in (x, y, z)) <= 0.0:
                raise MeshError(
                    f"{block.where}, *TRANSFORM",
                    found="axes without direction",
                    expected="two directions, or an axis away from the node",
                    remedy="Correct the points",
                )
            frames[node] = np.stack([v / np.linalg.norm(v) for v in (x, y, z)])
        deck.inventory.read["*TRANSFORM"] += 1
    return frames
