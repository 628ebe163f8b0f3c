"""`read_deck`: the deck of another program as an `FEModel`, with everything that it says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from flexmb.errors import MeshError
from flexmb.fem.deck.abaqus import read_abaqus_deck
from flexmb.fem.deck.ansys import read_ansys_deck
from flexmb.fem.deck.assemble import assembled
from flexmb.fem.deck.cells import SECOND_ORDER
from flexmb.fem.deck.contents import Deck
from flexmb.fem.deck.inventory import inventory_text, mass_and_center, source_of
from flexmb.fem.deck.nastran import read_nastran_deck
from flexmb.fem.deck.unit_doubts import doubt
from flexmb.fem.deck.units import converted
from flexmb.fem.fe_model import FEModel
from flexmb.fem.foreign_files import require_file
from flexmb.fem.shells.shell import check_side
from flexmb.fem.solids.elements import HEX8_COMPATIBLE
from flexmb.fem.told import keeping_warnings, tell

__all__ = ["DECK_READERS", "read_deck"]

DECK_READERS: dict[str, Callable[[Path], Deck]] = {
    ".bdf": read_nastran_deck,
    ".dat": read_nastran_deck,
    ".nas": read_nastran_deck,
    ".pch": read_nastran_deck,
    ".fem": read_nastran_deck,
    ".blk": read_nastran_deck,
    ".inp": read_abaqus_deck,
    ".cdb": read_ansys_deck,
}
"""Readers by file suffix."""


@keeping_warnings
def read_deck(
    path: str | Path,
    *,
    units: str | None = None,
    lumped: bool | None = None,
    stress_side: float | None = None,
    show: bool = True,
) -> FEModel:
    """Return the FE model that a deck describes: elements, properties, materials, links, springs and masses.

    The model is free: supports of the deck are kept by name in `FEModel.supports` and held only where asked for
    (``fem.eigenmodes(fe, "spc")``). Reference nodes of links are offered as interfaces (`FEModel.reference_points`,
    ``reduction.reduce(fe, interfaces="all")``).

    Parameters
    ----------
    path : path
        Nastran: .bdf .dat .nas .pch .fem; Abaqus and CalculiX: .inp; Ansys: .cdb.
    units : str, optional
        Units of the deck, "mm, t, s", "mm, kg, ms", "in, lbf s2/in, s" or "m, kg, s"; everything is converted to SI.
        Without it the numbers stay as they are, and a warning is given where they cannot be SI.
    lumped : bool, optional
        Whether element masses are lumped at the nodes; default: as the program of the deck does it.
    stress_side : float
        Where the stress of shells is taken, as in `fem.shell`: -1 bottom, 0 middle (membrane stress), +1 top. Default:
        the middle, and the reduction of shells that bend warns of it.
    show : bool
        Print the inventory: what was read, approximated, left out, and the mass.

    Returns
    -------
    FEModel
        Nodes and cells carry the numbers of the deck (`numbering`); ``"node 63241"`` and ``"element 812"`` name them
        wherever a set may be named. `source` holds the inventory, `warnings` what was told.

    Raises
    ------
    MeshError
        With file, line and card: missing nodes or properties, numbers that cannot be read, circular includes, links
        that contradict each other, cards that cannot be represented.

    Warns
    -----
    MeshWarning
        Something was left out; materials have no density; the units cannot be SI.
    """
    path = _path_of(path)
    part = f"Deck '{path}'"
    reader = _reader_of(path, part)
    check_side(stress_side, part)
    try:
        deck = converted(reader(path), units, part)
        deck.stress_side = None if stress_side is None else float(stress_side)
        fe = assembled(deck, deck.lumped if lumped is None else lumped)
    except MemoryError:
        raise MeshError(
            part, found="more than fits into memory", expected="a smaller deck", remedy="Reduce parts by themselves"
        ) from None
    if show:
        print(inventory_text(deck, fe))
    _tell(deck, fe, part)
    source = source_of(deck, path)
    return replace(fe, source=source if stress_side is None else {**source, "stress_side": deck.stress_side})


def _path_of(path: Any) -> Path:
    if not isinstance(path, str | Path):
        raise MeshError(
            "fem.read_deck",
            found=f"the path {path!r}",
            expected="the name of a deck",
            remedy='Write fem.read_deck("wing.bdf")',
        )
    return Path(path)


def _reader_of(path: Path, part: str) -> Callable[[Path], Deck]:
    """Return the reader of an existing deck, by its suffix."""
    require_file(part, path, "an existing deck", f"The current folder is {Path.cwd()}", DECK_READERS)
    reader = DECK_READERS.get(path.suffix.lower())
    if reader is None:
        raise MeshError(
            part,
            found=f"the suffix '{path.suffix}'",
            expected=f"One of: {', '.join(DECK_READERS)}",
            remedy="Rename the deck, or read a plain mesh with fem.read_mesh",
        )
    return reader


def _tell(deck: Deck, fe: FEModel, part: str) -> None:
    """Warn of units, of what was left out, of shells of second order, bricks that lock, materials without density."""
    if words := doubt(deck, mass_and_center(fe)[0]):
        tell(f"{part}: {words}")
    if deck.inventory.left_out:
        left = "; ".join(f"{what} ({n})" for what, n in sorted(deck.inventory.left_out.items()) if n)
        tell(f"{part}: left out: {left}")
    divided = {what: n for what, n in deck.inventory.approximated.items() if SECOND_ORDER in what}
    if divided:
        kinds = "; ".join(f"{what} ({n})" for what, n in sorted(divided.items()))
        tell(f"{part}: {kinds}: where few of them stand in the width of a part, refine it and compare")
    if locking := sum(len(group.labels) for group in deck.solids if group.element == HEX8_COMPATIBLE):
        tell(
            f"{part}: {locking} C3D8 are far too stiff in bending, here as in their program: with C3D8I in the deck "
            "they are not"
        )
    if weightless := sorted(deck.inventory.weightless):
        tell(f"{part}: materials without density, whose elements weigh nothing: {', '.join(weightless)}")
