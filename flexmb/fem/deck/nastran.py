"""`read_nastran_deck`: a Nastran deck as a `Deck`."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.deck.contents import Deck, MissingNode
from flexmb.fem.deck.nastran_lines import add_beams, add_rods
from flexmb.fem.deck.nastran_links import add_links, add_references, add_supports, thru
from flexmb.fem.deck.nastran_lumped import add_masses, add_springs, scalar_values
from flexmb.fem.deck.nastran_materials import Materials
from flexmb.fem.deck.nastran_mpc import add_mpc
from flexmb.fem.deck.nastran_names import INSTEAD, NAMES
from flexmb.fem.deck.nastran_nsm import add_nonstructural_mass
from flexmb.fem.deck.nastran_repeats import without_repeats
from flexmb.fem.deck.nastran_scalar import add_scalar_points
from flexmb.fem.deck.nastran_shells import add_shells
from flexmb.fem.deck.nastran_solids import add_solids
from flexmb.fem.deck.nastran_systems import Systems, read_grids
from flexmb.fem.deck.nastran_text import Bulk, read_bulk
from flexmb.fem.deck.nastran_untaken import tell_untaken
from flexmb.fem.meshes.nastran_cards import PROPERTY_NAME, SET_NAME

__all__ = ["read_nastran_deck"]

ELEMENT = re.compile(
    r"^(C(?!ORD|ASE|SET|SUPER|CONSTR)[A-Z]+\d*[A-Z]*|PLOTEL|GENEL|RSPLINE|RJOINT|RSSCON|RBAR1|RTRPLT1?|RBE2GS)$"
)
"""Names of cards that are elements or links, so that leaving one out changes the structure."""
KNOWN = frozenset(
    [
        "CBAR",
        "CBEAM",
        "CROD",
        "CONROD",
        "CTUBE",
        "CTRIA3",
        "CTRIAR",
        "CTRIA6",
        "CQUAD4",
        "CQUADR",
        "CQUAD8",
        "CSHEAR",
        "CTETRA",
        "CPENTA",
        "CHEXA",
        "CPYRAM",
        "CONM1",
        "CONM2",
        "CMASS1",
        "CMASS2",
        "CMASS3",
        "CMASS4",
        "CELAS1",
        "CELAS2",
        "CELAS3",
        "CELAS4",
        "CDAMP1",
        "CDAMP2",
        "CDAMP3",
        "CDAMP4",
        "CDAMP5",
        "CBUSH",
        "CBUSH1D",
        "CVISC",
        "RBE1",
        "RBE2",
        "RBE3",
        "RBAR",
        "RROD",
    ]
)
HARMLESS = frozenset(
    (
        "CBARAO",
        "PLOTEL",
        "CHBDYE",
        "CHBDYG",
        "CHBDYP",
        "CSET",
        "CSET1",
        "CAERO1",
        "CAERO2",
        "CAERO3",
        "CAERO5",
    )
)
"""Elements without stiffness and mass: for drawing, heat, aerodynamics."""
FLUID = frozenset(("CHACAB", "CHACBR", "CFLUID2", "CFLUID3", "CFLUID4", "CAXIF2", "CAXIF3", "CAXIF4"))
STRUCTURAL = re.compile(
    r"^(GRID|GRDSET|CORD[12][RCS]|MAT[1289]$|P(SOLID|SHELL|COMPG?|BARL?|BEAML?|ROD|TUBE|ELAS|BUSH|BUSH1D|DAMP|MASS|VISC|SHEAR)$|BAROR|BEAMOR|MPC|SPC|PARAM)"
)
CURVED = ("FEEDGE", "FEFACE", "GMCURV", "GMSURF")
"""Geometry of p-elements: without it their edges are straight."""
MASS_PARTS = ("NSM", "NSM1", "NSML", "NSML1", "NSMADD")


def read_nastran_deck(path: Path) -> Deck:
    """Read a Nastran deck; MeshError with file, line and card for whatever cannot be read."""
    bulk = read_bulk(path)
    part = f"Deck '{path}'"
    _refuse(bulk)
    systems = Systems(bulk)
    try:
        labels, points, frames = read_grids(bulk, systems, part)
        if not len(labels):
            raise MeshError(
                part,
                found="no grid points (GRID cards)",
                expected="the bulk data of a structure",
                remedy="Give the main file of the deck",
            )
        deck = Deck(name=path.stem, source="Nastran", labels=labels, points=points)
        deck.inventory.read["GRID"] = len(labels)
        materials = Materials(bulk, deck.inventory)
        _parameters(bulk, deck)
        without_repeats(bulk, deck.inventory)
        add_solids(bulk, deck, materials, systems)
        add_shells(bulk, deck, materials, systems)
        bulk.tables = {name: table for name, table in bulk.tables.items() if name == "GRID"}  # cells are large
        add_beams(bulk, deck, materials, frames)
        add_rods(bulk, deck, materials)
        add_nonstructural_mass(bulk, deck)
        add_scalar_points(bulk, deck, frames, scalar_values(bulk))
        add_masses(bulk, deck, frames, systems)
        add_springs(bulk, deck, frames, systems)
        add_links(bulk, deck, frames)
        add_mpc(bulk, deck, frames)
        add_supports(bulk, deck, frames, bulk.tables.get("GRID"))
        add_references(bulk, deck)
        _sets(bulk, deck)
        tell_untaken(bulk, deck)
    except MissingNode as missing:
        raise MeshError(
            part, found=str(missing), expected="a GRID card", remedy="Add the card, or correct the number"
        ) from None
    _tell(bulk, deck)
    return deck


def _refuse(bulk: Bulk) -> None:
    for name in FLUID & set(bulk.cards):
        card = bulk.cards[name][0]
        raise card.refused(f"a fluid element {name}", "a structure", "Remove the fluid from the deck")


def _parameters(bulk: Bulk, deck: Deck) -> None:
    """Apply PARAM WTMASS and COUPMASS; masses are lumped unless COUPMASS is positive."""
    found = {card.text(1).upper(): card for card in bulk.of("PARAM")}
    if "WTMASS" in found:
        deck.mass_factor = found["WTMASS"].real(2, 1.0)
        if not deck.mass_factor > 0.0:
            raise found["WTMASS"].refused(f"WTMASS = {deck.mass_factor:g}", "a positive factor")
    coupled = found["COUPMASS"].text(2).upper() if "COUPMASS" in found else "-1"
    deck.lumped = coupled in ("0", "NO", "") or coupled.startswith("-")
    if "K6ROT" in found:
        deck.inventory.read["PARAM K6ROT"] += 1
    for name in CURVED:
        if bulk.of(name):
            deck.inventory.left_out[f"{name}: curved edges and faces of p-elements"] += len(bulk.of(name))


def _sets(bulk: Bulk, deck: Deck) -> None:
    """Take SET1 and SET3 of grid points and elements, with names from preprocessors' comments, and properties."""
    names, properties = _named_in_comments(bulk)
    by_element: dict[int, np.ndarray] = {}  # made where a set of elements asks for it: a dictionary of all is large
    for card in bulk.of("SET1", "SET3"):
        kind = card.text(2).upper() if card.name == "SET3" else ""
        words = [word for word in card.fields[3 if card.name == "SET3" else 2 :] if word]
        if other := _other_things(kind, words):
            deck.inventory.unused[f"{card.name} of {other}"] += 1
            continue
        number = card.integer(1)
        of_elements = kind == "ELEM" or (not kind and (number, 2) in names and (number, 1) not in names)
        name = names.get((number, 2 if of_elements else 1), f"set_{number}")
        if of_elements and not by_element:
            by_element = _elements(deck)
        labels = np.array(thru(card, words, by_element if of_elements else deck.labels.tolist()), np.int64)
        if of_elements:
            nodes = [by_element[n] for n in labels.tolist() if n in by_element]
            found = np.concatenate(nodes) if nodes else np.zeros(0, np.int64)
        else:
            found = _rows(deck.labels, labels)
        if len(found):
            deck.node_sets[name] = np.unique(found)
        deck.inventory.read[card.name] += 1
    for group in deck.groups():
        own = properties.get(group.group, group.group)
        members = np.unique(group.nodes)
        deck.node_sets[own] = np.union1d(deck.node_sets.get(own, members[:0]), members)


def _other_things(kind: str, words: list[str]) -> str:
    """Return what a set is of, if not of numbers of grid points or elements."""
    if kind not in ("", "GRID", "ELEM") or any(w.upper() in ("SKIN", "ALL") for w in words):
        return kind or "other things"
    return "" if all(w.isdigit() or w.upper() in ("THRU", "BY") for w in words) else "other things"


def _named_in_comments(bulk: Bulk) -> tuple[dict[tuple[int, int], str], dict[str, str]]:
    """Return names that preprocessors write in comments: of sets by number and kind (1 nodes, 2 elements), of
    properties.
    """
    names: dict[tuple[int, int], str] = {}
    properties: dict[str, str] = {}
    for line in bulk.comments:
        if match := SET_NAME.match(line):
            names[(int(match[1]), int(match[2]))] = match[3]
        elif match := PROPERTY_NAME.match(line):
            properties[f"pid_{match[1] or match[3]}"] = match[2] or match[4]
    return names, properties


def _rows(known: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """Return the rows of labels among the `known` ones, which are sorted, without labels that are not there."""
    found = np.searchsorted(known, labels)
    inside = found < len(known)
    return found[inside][known[found[inside]] == labels[inside]]


def _elements(deck: Deck) -> dict[int, np.ndarray]:
    """Return the nodes of every element by its number in the file."""
    out = {}
    for group in deck.groups():
        for label, nodes in zip(group.labels.tolist(), group.nodes, strict=True):
            out[label] = np.union1d(out[label], nodes) if label in out else nodes
    return out


def _tell(bulk: Bulk, deck: Deck) -> None:
    """Put into the inventory what was not read: structural cards by name, the rest as not needed."""
    inventory = deck.inventory
    if not bulk.ended:
        inventory.left_out["what may follow the last line: there is no ENDDATA, as in a file that was cut off"] += 1
    for name, count in sorted(bulk.counts.items()):
        if name in KNOWN or STRUCTURAL.match(name) or name in (*MASS_PARTS, *CURVED) or inventory.read.get(name):
            continue
        if ELEMENT.match(name) and name not in HARMLESS:
            inventory.left_out[f"{name}: {INSTEAD.get(name, 'an element that is not known')}"] += count
        elif name in ("DMIG", "EXTRN", "MATT1", "SUPORT", "SUPORT1"):
            if name == "DMIG":
                inventory.left_out[f"{name}: matrices of other parts"] += count
            else:
                inventory.unused[name] += count
        elif not re.fullmatch(r"[A-Z][A-Z0-9]{1,7}_?", name):
            raise MeshError(
                bulk.cards[name][0].where if bulk.cards.get(name) else f"Deck '{deck.name}'",
                found=f"{count} lines that begin with '{name[:20]}'",
                expected="cards: a name of letters and digits, then fields",
                remedy="Check whether the file is a Nastran deck, and its line ends",
            )
        elif name not in NAMES:
            where = bulk.cards[name][0].where if bulk.cards.get(name) else ""
            inventory.left_out[f"{name}: a card that is not known (the first at {where})"] += count
        else:
            inventory.unused[name] += count
