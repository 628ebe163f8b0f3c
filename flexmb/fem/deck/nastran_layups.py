"""Layups of Nastran shells: PSHELL, PCOMP and PCOMPG as stiffnesses of a section; others are refused by name."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from flexmb.fem.deck.contents import Deck
from flexmb.fem.deck.nastran_materials import MaterialCard, Materials
from flexmb.fem.deck.nastran_text import Card
from flexmb.fem.shells.laminate_block import laminate, turned_plane
from flexmb.fem.shells.laminate_shear import diagonal_compliance, shear_compliance

__all__ = ["Layup", "layup"]


LAYUPS = frozenset(("", "NO", "SYM", "MEM", "SYMEM", "BEND", "SMEAR"))
"""Values of LAM of a PCOMP."""


@dataclass(frozen=True, eq=False)
class Layup:
    """A, B, D about the reference plane, thickness, mass per area, faces and depths of a shell property."""

    membrane: np.ndarray
    coupling: np.ndarray
    bending: np.ndarray
    thickness: float
    density: float
    nonstructural: float
    faces: np.ndarray
    depths: np.ndarray
    poisson: float
    shear: np.ndarray = field(default_factory=lambda: np.zeros((2, 2)))


def layup(card: Card, materials: Materials, deck: Deck) -> Layup:
    deck.inventory.read[card.name] += 1
    if card.name == "PSHELL":
        return _pshell(card, materials, deck)
    if card.name in ("PCOMP", "PCOMPG"):
        return _pcomp(card, materials, deck)
    raise card.refused(f"a property {card.name}", "PSHELL, PCOMP or PCOMPG", "Give these shells a structural property")


def _pshell(card: Card, materials: Materials, deck: Deck) -> Layup:
    who = f"{card.where}, card PSHELL {card.text(1)}"
    t = card.real(3, 0.0)
    if not t > 0.0:
        raise card.refused(f"T = {t:g}", "a positive thickness")
    if card.text(4) and card.integer(4) == -1:
        raise card.refused("MID2 = -1: plane strain", "a membrane or a shell", "Give MID2 a material, or none")
    heavy = "m" if card.text(2) else "b"  # MID1 gives the mass; MID2 does where it is alone
    used = {
        k: materials.get(card.integer(i), who, weighs=k == heavy)
        for k, i in (("m", 2), ("b", 4), ("s", 6))
        if card.text(i)
    }
    if "m" not in used and "b" not in used:
        raise card.refused("neither MID1 nor MID2", "a membrane or a bending material")
    for key in ("m", "b"):
        if key in used and used[key].plane is None:
            raise card.refused(f"the material {used[key].name}", "MAT1, MAT2 or MAT8 for shells")
    zero = np.zeros((3, 3))
    ratio = card.real(5, 1.0)
    q_m = used["m"].plane if "m" in used else zero
    q_b = used["b"].plane if "b" in used else zero
    assert q_m is not None
    assert q_b is not None
    coupling = zero
    if card.text(11) and card.integer(11):
        coupled = materials.get(card.integer(11), who, weighs=False).plane
        coupling = zero if coupled is None else coupled * t**2
    shear = np.zeros((2, 2))
    if "s" in used and q_b.any():
        shear = _sheared(card, used["s"], t)
    if "b" not in used:
        deck.inventory.approximated[f"PSHELL {card.text(1)}: membrane only, rotations held"] += 1
    lead = used.get("m", used.get("b"))
    assert lead is not None
    z1, z2 = card.real(9, -t / 2.0), card.real(10, t / 2.0)
    faces = np.stack([q_m if "m" in used else q_b] * 2)
    return Layup(
        q_m * t,
        coupling,
        q_b * ratio * t**3 / 12.0,
        t,
        lead.density * t,
        card.real(8, 0.0),
        faces,
        np.array([min(z1, z2), max(z1, z2)]) if min(z1, z2) < max(z1, z2) else np.array([-t / 2, t / 2]),
        lead.poisson if lead.young > 0.0 else 0.3,
        shear,
    )


def _sheared(card: Card, material: MaterialCard, thickness: float) -> np.ndarray:
    """Return the transverse shear compliance (2, 2) of TS/T and MID3, where MAT2 holds the shear moduli themselves."""
    section = card.real(7, 5.0 / 6.0) * thickness
    moduli = np.diag(material.across)
    if material.plane is not None and material.name.startswith("MAT2"):
        moduli = material.plane[:2, :2]
    finite = np.isfinite(moduli).all()
    if not (section > 0.0 and min(moduli.diagonal()) > 0.0 and (not finite or np.linalg.det(moduli) > 0.0)):
        raise card.refused(
            f"TS/T = {section / thickness:g} with transverse shear moduli {moduli.tolist()}",
            "values above zero",
            "Leave MID3 blank for shells that do not shear across",
        )
    return np.linalg.inv(section * moduli) if finite else diagonal_compliance(*(section * moduli.diagonal()))


def _across(card: Card, material: MaterialCard, deck: Deck) -> tuple[float, float]:
    """Return the transverse shear moduli of a ply; a MAT2 has none."""
    if not material.name.startswith("MAT2"):
        return material.across
    deck.inventory.approximated[f"{card.name}: plies of MAT2, which do not shear across"] += 1
    return float("inf"), float("inf")


def _pcomp(card: Card, materials: Materials, deck: Deck) -> Layup:
    who = f"{card.where}, card {card.name} {card.text(1)}"
    option = card.text(8).upper()
    if option not in LAYUPS:
        raise card.refused(f"LAM = {option}", f"blank, {', '.join(sorted(LAYUPS - {''}))}", "Write the plies in order")
    width, first = (4, 9) if card.name == "PCOMP" else (8, 9)
    shift = 0 if card.name == "PCOMP" else 1  # PCOMPG begins each ply with its global number
    plies: list[tuple[np.ndarray, float, float]] = []
    across: list[tuple[float, float]] = []
    density, last_mid, last_t = 0.0, None, None
    for at in range(first, len(card.fields), width):
        words = card.fields[at : at + width]
        if not any(words):
            continue
        mid = card.integer(at + shift, last_mid)
        t = card.real(at + shift + 1, last_t)
        last_mid, last_t = mid, t
        material = materials.get(mid, who)
        if material.plane is None:
            raise card.refused(f"the material {material.name}", "MAT1, MAT2 or MAT8 for plies")
        if not t > 0.0:
            raise card.refused(f"a ply of thickness {t:g}", "positive thicknesses")
        plies.append((material.plane, t, np.radians(card.real(at + shift + 2, 0.0))))
        across.append(_across(card, material, deck))
        density += material.density * t
    if not plies:
        raise card.refused("no plies", "at least one ply")
    if option.startswith("SYM"):
        plies += plies[::-1]
        across += across[::-1]
        density *= 2.0
    total = sum(t for _, t, _ in plies)
    z0 = card.real(2, -total / 2.0)
    a, b, d = laminate(plies, z0)
    if option in ("MEM", "SYMEM"):
        b, d = 0.0 * b, 0.0 * d
    elif option == "BEND":
        a, b = 0.0 * a, 0.0 * b
    elif option == "SMEAR":
        b, d = 0.0 * b, a * total**2 / 12.0
    if np.abs(b).max() < 1e-9 * np.abs(a).max() * total:
        b = 0.0 * b
    faces = np.stack([turned_plane(plies[k][0], plies[k][2]) for k in (0, -1)])
    shear = shear_compliance(plies, across) if d.any() else np.zeros((2, 2))
    return Layup(a, b, d, total, density, card.real(3, 0.0), faces, np.array([z0, z0 + total]), 0.3, shear)
