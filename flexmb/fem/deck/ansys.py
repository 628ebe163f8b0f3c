"""`read_ansys_deck`: an Ansys archive (.cdb) as a `Deck`."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.deck.ansys_elements import Group, add_shells, add_solids, groups
from flexmb.fem.deck.ansys_lines import add_beams, add_rods
from flexmb.fem.deck.ansys_links import add_equations, add_rigid, add_springs_and_masses, add_supports
from flexmb.fem.deck.ansys_materials import materials, sections
from flexmb.fem.deck.ansys_text import Archive, read_archive
from flexmb.fem.deck.ansys_untaken import tell_commands, tell_untaken
from flexmb.fem.deck.contents import Deck, MissingNode
from flexmb.fem.deck.nastran_systems import System

__all__ = ["read_ansys_deck"]

MAKERS = {"solid": add_solids, "shell": add_shells, "beam": add_beams, "rod": add_rods}
SKIN = frozenset((152, 153, 154, 156, 200, 201))
"""Elements for loads, heat and meshing without stiffness."""
NAMES = {27: "MATRIX27", 40: "COMBIN40", 50: "MATRIX50", 169: "TARGE169", 170: "TARGE170", 171: "CONTA171"}
NAMES |= {172: "CONTA172", 173: "CONTA173", 174: "CONTA174", 175: "CONTA175", 176: "CONTA176", 177: "CONTA177"}
NAMES |= {179: "PRETS179", 178: "CONTA178", 250: "COMBI250", 214: "COMBI214", 263: "REINF263", 264: "REINF264"}


def read_ansys_deck(path: Path) -> Deck:
    """Read an archive that CDWRITE wrote; MeshError with file and line for whatever cannot be read."""
    part = f"Deck '{path}'"
    archive = read_archive(path)
    deck = Deck(name=path.stem, source="Ansys", labels=archive.labels, points=archive.points)
    deck.inventory.read["nodes"] = len(archive.labels)
    _refuse_single(archive)
    try:
        frames = _frames(archive)
        systems = _systems(archive)
        made, given = materials(archive, deck), sections(archive)
        links: list[Group] = []
        for group in groups(archive, deck, part, systems, made, given):
            tell_untaken(group, deck)
            if group.family in MAKERS:
                MAKERS[group.family](group, deck)
            elif group.family:
                links.append(group)
            else:
                _leave(group, deck)
        add_springs_and_masses(links, deck, frames)
        add_rigid(links, deck)
        add_equations(archive, deck, frames)
        add_supports(archive, deck, frames)
        _sets(archive, deck)
    except MissingNode as missing:
        raise MeshError(
            part, found=str(missing), expected="a node of NBLOCK", remedy="Select the nodes of all elements (NSLE)"
        ) from None
    _tell(archive, deck)
    tell_commands(archive, deck)
    return deck


def _refuse_single(archive: Archive) -> None:
    """Refuse archives that are not blocked: nodes and elements by single commands."""
    for command in archive.commands:
        last = command.name in ("EN", "N") and "-1" in command.words
        if command.name in ("E", "EN", "N") and not last:
            raise command.wrong(
                "nodes or elements by single commands", "NBLOCK and EBLOCK", "CDWRITE, DB, name, cdb, , , , BLOCKED"
            )


def _frames(archive: Archive) -> dict[int, np.ndarray]:
    """Return the nodal axes (3, 3), rows x y z: THXY about z, then THYZ about the new x, then THZX about the new y."""
    from scipy.spatial.transform import Rotation

    turned = np.flatnonzero(archive.angles.any(axis=1))
    if not len(turned):
        return {}
    matrices = Rotation.from_euler("ZXY", archive.angles[turned], degrees=True).as_matrix()
    return {int(node): matrix.T for node, matrix in zip(turned, matrices, strict=True)}


def _systems(archive: Archive) -> dict[int, System]:
    """Return the local systems: origin and angles, in one LOCAL command or in two of CDWRITE's form."""
    from scipy.spatial.transform import Rotation

    kinds, origins, angles = {}, {}, {}
    for command in archive.commands:
        if command.name != "LOCAL":
            continue
        form = command.text(1) if command.text(0).startswith("R") else ""
        at = 2 if form else 0
        number = command.integer(at)
        kind = {"CART": "0", "CYLI": "1", "SPHE": "2"}.get(command.text(at + 1)[:4], command.text(at + 1) or "0")
        kinds[number] = kind
        values = [command.real(at + 2 + k, 0.0) for k in range(6)]
        if form == "ANG":
            angles[number] = values[:3]
        elif form in ("", "LOC"):
            origins[number] = values[:3]
            if not form:
                angles[number] = values[3:]
    out = {0: System("R", np.zeros(3), np.eye(3))}
    for number, kind in kinds.items():
        if kind not in ("0", "1"):
            continue  # refused where an element with a direction uses it
        axes = Rotation.from_euler("ZXY", angles.get(number, [0.0] * 3), degrees=True).as_matrix().T
        out[number] = System("RC"[int(kind)], np.array(origins.get(number, [0.0] * 3)), axes)
    return out


def _leave(group: Group, deck: Deck) -> None:
    name = NAMES.get(group.element, f"element {group.element}")
    if group.element in SKIN and not any(group.real):
        deck.inventory.unused[f"elements {group.element} without stiffness"] += len(group.labels)
    elif group.element in SKIN:
        deck.inventory.left_out[f"SURF{group.element} with real constants (added mass, foundation)"] += len(
            group.labels
        )
    else:
        deck.inventory.left_out[f"{name}: an element that is not known"] += len(group.labels)


def _sets(archive: Archive, deck: Deck) -> None:
    """Keep components as node sets (elements by their nodes); numbers that do not exist are ignored."""
    order = np.argsort(archive.head[:, 10], kind="stable")
    numbers = archive.head[order, 10]
    for name, (kind, members) in archive.components.items():
        if kind == "ELEM":
            at = np.minimum(np.searchsorted(numbers, members), max(len(numbers) - 1, 0))
            members = archive.nodes[order[at[numbers[at] == members]]] if len(numbers) else members[:0]
        found = np.intersect1d(deck.labels, members)
        if len(found):
            deck.node_sets[name] = np.searchsorted(deck.labels, found)
        deck.inventory.read[f"components of {'elements' if kind == 'ELEM' else 'nodes'}"] += 1
    for column, word in ((0, "mat"), (1, "type"), (3, "section")):
        for number in np.unique(archive.head[:, column]):
            nodes = np.intersect1d(deck.labels, archive.nodes[archive.head[:, column] == number])
            if number > 0 and len(nodes):
                deck.node_sets.setdefault(f"{word}_{number}", np.searchsorted(deck.labels, nodes))


def _tell(archive: Archive, deck: Deck) -> None:
    """Name the commands that change the structure and were not read; apply LUMPM."""
    changing = {"CEINTF": "constraint equations", "CERIG": "links", "RBE3": "links", "M": "master freedoms"}
    changing |= {"SE": "superelements", "CPINTF": "couplings", "CPCYC": "couplings", "ENDRELEASE": "releases"}
    counts: Counter[str] = Counter()
    for command in archive.commands:
        if command.name == "LUMPM":
            deck.lumped = command.text(0) in ("ON", "1")
        elif command.name in changing:
            deck.inventory.left_out[f"{command.name}: {changing[command.name]} by a command, not by CE"] += 1
        elif command.name in ("F", "SFE", "SF", "BFE", "BF", "SFBEAM"):
            counts[command.name] += 1
    deck.inventory.unused.update(counts)
