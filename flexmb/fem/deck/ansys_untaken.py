"""Key options, real constants and commands of an Ansys archive that change a structure there but not here."""

from __future__ import annotations

import re

from flexmb.fem.deck.ansys_elements import Group
from flexmb.fem.deck.ansys_text import Archive
from flexmb.fem.deck.contents import Deck

__all__ = ["tell_commands", "tell_untaken"]

DAMPING = "damping of a material: give the body its damping"
KEY_OPTIONS = {
    185: {6: "mixed u-P formulation"},
    186: {6: "mixed u-P formulation"},
    187: {6: "mixed u-P formulation"},
    181: {2: "formulation of curved shells", 9: "thickness by a user routine", 10: "initial stress by a user routine"},
    281: {9: "thickness by a user routine", 10: "initial stress by a user routine"},
    188: {1: "warping", 5: "section as of a two-dimensional model"},
    189: {1: "warping", 5: "section as of a two-dimensional model"},
    288: {4: "thick pipe"},
    289: {4: "thick pipe"},
    14: {1: "nonlinear"},
}
"""By element: number of the option and what a value other than zero asks for."""
REALS = {
    14: {2: "CV2 of nonlinear damping", 3: "initial length", 4: "initial force"},
    180: {2: "tension or compression alone"},
}
"""By element: place of the real constant, from 0."""
HARMLESS = frozenset(
    """
N FINISH NUMOFF DOF TREF TOFFST BFUNIF ACEL OMEGA DOMEGA CMOMEGA CMDOMEGA CGLOC CGOMEGA DCGOMG IRLF KUSE TIME
CRPLIM NCNV NEQIT ERESX ESTIF GST NLGEOM KBC DELTIM NSUBST AUTOTS EQSLV OUTRES OUTPR ANTYPE SOLVE SAVE SHPP
NSEL ESEL ALLSEL CMSEL MPTEMP EXTOPT MODOPT MXPAND CSYS RSYS DSYS ESYS TYPE MAT REAL SECNUM LOCAL ETCON KEYW
NROPT PRED LNSRCH CNVTOL RESCONTROL TUNIF TINTP TIMINT HARFRQ FREQ HROPT HROUT TRNOPT MP MPDATA TB TBDATA
TBTEMP TBPT R RMORE SECTYPE SECDATA SECBLOCK SECOFFSET SECCONTROLS SECCONTROL CE CP D LUMPM F SFE SF BFE BF
SFBEAM DDELE FDELE SFEDELE ETLIST NLIST ELIST SHOW TITLE UNITS WAVES CPNGEN SECPLOT BFCUM FCUM DCUM SFCUM
CECMOD BUCOPT SUBOPT PSOLVE EXPASS NUMEXP SBCLOAD LSSOLVE LSWRITE PSTRES SSTIF MPAMOD DMPOPT MDAMP
""".split()  # noqa: SIM905
)
"""Commands that are read, or that a linear structure has no part in: loads, solution, selection, output."""
NAME = re.compile(r"[A-Z][A-Z0-9]{0,9}")
DAMPED = frozenset(("ALPHAD", "BETAD", "DMPRAT", "DMPSTR", "DMPSFREQ"))
KNOWN = HARMLESS | DAMPED | {"CEINTF", "CERIG", "RBE3", "M", "SE", "CPINTF", "CPCYC", "ENDRELEASE"}
MATERIAL_DAMPING = frozenset(("DAMP", "ALPD", "BETD", "DMPR", "DMPS"))


def tell_untaken(group: Group, deck: Deck) -> None:
    """Count the elements whose type or real constants ask for what they do not have here."""
    for number, meaning in KEY_OPTIONS.get(group.element, {}).items():
        if group.options.get(number, 0):
            deck.inventory.left_out[f"{group.name}, KEYOPT({number}): {meaning}"] += len(group.labels)
    for place, meaning in REALS.get(group.element, {}).items():
        if any(group.real[place : place + 1]):
            deck.inventory.left_out[f"{group.name}, real constants: {meaning}"] += len(group.labels)
    section = group.section
    if section is None:
        return
    if section.kind == "PIPE" and any(section.data[5:8]):
        deck.inventory.left_out[f"{group.name}: fluid in it, or insulation around it"] += len(group.labels)
    if section.kind == "LINK" and any(section.controls[1:2]):
        deck.inventory.left_out[f"{group.name}: tension or compression alone"] += len(group.labels)
    if section.shape == "ASEC" and any(section.data[10:]):
        deck.inventory.left_out[f"{group.name}: thicknesses and shear corrections of ASEC"] += len(group.labels)


def tell_commands(archive: Archive, deck: Deck) -> None:
    """Name the commands that nobody reads, and damping."""
    unread: dict[str, list[str]] = {}
    for command in archive.commands:
        name = command.name
        word = command.text(2 if command.text(0).startswith("R") and "." in command.text(0) else 0)
        if name in ("MP", "MPDATA") and word in MATERIAL_DAMPING:
            deck.inventory.left_out[f"{name} {word}: {DAMPING}"] += 1
        elif name in DAMPED and command.words and command.real(0, 0.0):
            deck.inventory.left_out[f"{name}: {DAMPING}"] += 1
        elif name not in KNOWN and not name.startswith(("SECDAT", "SECBLO", "SECOFF", "SECCON")):
            shown = name if NAME.fullmatch(name) else "lines that are no commands"
            unread.setdefault(shown, []).append(command.where)
    for name, places in unread.items():
        deck.inventory.left_out[f"{name}: not read (the first at {places[0]})"] += len(places)
