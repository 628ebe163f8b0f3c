"""*MASS, *ROTARY INERTIA, *SPRING and *DASHPOT of an Abaqus deck as matrices of their nodes."""

from __future__ import annotations

import numpy as np

from flexmb.fem.deck.abaqus_materials import Materials
from flexmb.fem.deck.abaqus_model import Flat
from flexmb.fem.deck.abaqus_text import Block
from flexmb.fem.deck.contents import Deck, Lumped
from flexmb.fem.deck.links import Frames, rows_of
from flexmb.math.definiteness import semidefinite

__all__ = ["add_abaqus_lumped"]


def add_abaqus_lumped(flat: Flat, deck: Deck, frames: Frames, materials: Materials) -> None:
    """Add masses, springs and dampers."""
    makers = {"MASS": _mass, "ROTARY INERTIA": _rotary_inertia, "SPRING": _spring, "DASHPOT": _spring}
    for block, scope in flat.blocks:
        if block.name in makers:
            own = _oriented(block, scope, flat, deck, frames, materials)
            makers[block.name](block, scope, flat, deck, own)
    _tell_bare(flat, deck)


def _tell_bare(flat: Flat, deck: Deck) -> None:
    """Name masses, springs and dashpots to which no keyword gives a value."""
    valued = {k for _, k in flat.given}
    for k, element in enumerate(flat.elements):
        if k not in valued and element.kind.startswith(("MASS", "ROTARYI", "SPRING", "DASHPOT")):
            deck.inventory.left_out[f"{element.kind}: no keyword gives it a value"] += 1


def _oriented(block: Block, scope: str, flat: Flat, deck: Deck, frames: Frames, materials: Materials) -> Frames:
    """Return the axes of nodes, those of the ORIENTATION of springs, dashpots and inertias in place of their own."""
    if "ORIENTATION" not in block.parameters:
        return frames
    chosen = flat.named(flat.element_sets, block.need("ELSET"), scope, block, "element set")
    nodes = sorted({node for k in chosen for node in flat.elements[k].nodes})
    axes = materials.axes(block.parameters["ORIENTATION"], scope, block, flat, deck.points[nodes])
    return {**frames, **dict(zip(nodes, axes, strict=True))}


def _mass(block: Block, scope: str, flat: Flat, deck: Deck, frames: Frames) -> None:
    value = block.reals(block.rows()[0][:1], 1)[0] if block.rows() else 0.0
    if value < 0.0:
        raise block.wrong(f"a mass of {value:g}", "a mass >= 0")
    for k in _once(block, scope, flat):
        matrix = np.diag([value] * 3 + [0.0] * 3)
        _lump(deck, "mass", (flat.elements[k].nodes[0],), matrix, "*MASS")


def _rotary_inertia(block: Block, scope: str, flat: Flat, deck: Deck, frames: Frames) -> None:
    rows = block.rows()
    i11, i22, i33, i12, i13, i23 = block.reals(rows[0] if rows else [], 6, 0.0)
    inertia = np.array([[i11, i12, i13], [i12, i22, i23], [i13, i23, i33]])
    if not semidefinite(inertia):
        raise block.wrong(f"{inertia.tolist()}", "an inertia that is not negative")
    scope_axes = flat.scopes[scope].rotation
    for k in _once(block, scope, flat):
        matrix = np.zeros((6, 6))
        turn = frames[flat.elements[k].nodes[0]].T if "ORIENTATION" in block.parameters else scope_axes
        matrix[3:, 3:] = turn @ inertia @ turn.T
        _lump(deck, "mass", (flat.elements[k].nodes[0],), matrix, "*ROTARY INERTIA")


def _spring(block: Block, scope: str, flat: Flat, deck: Deck, frames: Frames) -> None:
    kind = "stiffness" if block.name == "SPRING" else "damping"
    rows = block.rows()
    for k in _once(block, scope, flat):
        element = flat.elements[k]
        nodes = tuple(element.nodes[:2])
        ends_of = 1 if element.kind.endswith("1") else 2
        if len(nodes) < ends_of:
            raise block.wrong(f"element {element.label} of type {element.kind} with {len(nodes)} nodes", f"{ends_of}")
        if element.kind in ("SPRINGA", "DASHPOTA"):
            value = _value(block, [row for row in rows if any(row)], deck)
            along = deck.points[nodes[1]] - deck.points[nodes[0]]
            size = np.linalg.norm(along)
            if not size > 0.0:
                raise block.wrong(f"element {element.label} without length", "two different places")
            row = np.concatenate([-along / size, np.zeros(3), along / size, np.zeros(3)])
        else:
            if len(rows) < 2:
                raise block.wrong("no line of directions", "directions, then the value")
            directions, value = (
                block.integers(rows[0], 1),
                _value(block, rows[1:], deck),
            )
            if not all(1 <= d <= 6 for d in directions):
                raise block.wrong(f"directions '{', '.join(rows[0])}'", "numbers 1 to 6")
            ends = [rows_of(n, [d - 1], frames)[0] for n, d in zip(nodes, directions * 2, strict=False)]
            row = np.concatenate([(-1.0) ** i * end for i, end in enumerate(ends)])
            nodes = nodes[: len(ends)]
        _lump(deck, kind, nodes, value * np.outer(row, row), f"*{block.name}")


def _value(block: Block, rows: list[list[str]], deck: Deck) -> float:
    """Return stiffness or damping: a number, or the slope of a table of (force, elongation or its rate) at rest.

    Where the table has a corner there it is the mean of both sides.
    """
    if "NONLINEAR" not in block.parameters:
        tabled = bool(rows) and len(rows[0]) > 2  # value, frequency, temperature
        if tabled and len(rows) > 1:
            deck.inventory.approximated[f"*{block.name}: value of the first temperature"] += 1
        return block.reals(rows[0 if tabled else -1][:1] if rows else [], 1)[0]
    table = [block.reals(words[:2], 2) for words in rows if any(words)]
    places = np.array([place for _, place in table])
    forces = np.array([force for force, _ in table])
    if len(table) < 2 or (np.diff(places) <= 0.0).any() or not places[0] <= 0.0 <= places[-1]:
        raise block.wrong(
            f"a table of {len(table)} rows from {places.tolist()[:1]}", "force and elongation, rising, about 0"
        )
    slopes = np.diff(forces) / np.diff(places)
    beside = (places[:-1] <= 0.0) & (places[1:] >= 0.0)
    deck.inventory.approximated[f"*{block.name}, NONLINEAR, by its slope at rest"] += 1
    return float(slopes[beside].mean())


def _once(block: Block, scope: str, flat: Flat) -> list[int]:
    """Return the elements of a keyword; MeshError where another of its kind gave one of them a value before."""
    chosen = list(dict.fromkeys(flat.named(flat.element_sets, block.need("ELSET"), scope, block, "element set")))
    for k in chosen:
        other = flat.given.setdefault((block.name, k), block)
        if other is not block:
            raise block.wrong(
                f"element {flat.elements[k].label} a second time (first at {other.where})", "each element once"
            )
    return chosen


def _lump(deck: Deck, kind: str, nodes: tuple[int, ...], matrix: np.ndarray, name: str) -> None:
    deck.lumped_parts.append(Lumped(kind=kind, nodes=nodes, matrix=matrix, name=name))
    deck.inventory.read[name] += 1
