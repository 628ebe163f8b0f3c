"""Materials of a Nastran deck: MAT1, MAT2, MAT8, MAT9; others are refused by name where an element uses them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.deck.contents import Inventory
from flexmb.fem.deck.nastran_text import Bulk, Card
from flexmb.math.definiteness import semidefinite

__all__ = ["INCOMPRESSIBLE", "MaterialCard", "Materials"]

LOWEST = 1e-30
"""Density of a material without one: `Material` wants a positive number, and this adds nothing to any mass."""

INCOMPRESSIBLE = 0.4999
"""Poisson's ratio that stands for one up to 0.5, at which a solid has no finite stiffness against pressure."""


@dataclass(frozen=True, eq=False)
class MaterialCard:
    """A material: plane stress and solid elasticity in its own axes, density, and E, G, nu where it is isotropic."""

    name: str
    density: float
    plane: np.ndarray | None
    solid: np.ndarray | None
    young: float = 0.0
    shear: float = 0.0
    poisson: float = 0.0
    across: tuple[float, float] = (float("inf"), float("inf"))
    """Transverse shear moduli G_1z, G_2z of a ply; inf where the card gives none."""

    def line(self, who: str) -> tuple[float, float, float]:
        """Return E, G and density for a beam or rod."""
        if not self.young > 0.0:
            raise MeshError(
                who,
                found=f"the material {self.name}",
                expected="an isotropic one (MAT1) with E > 0",
                remedy="Give the property a MAT1",
            )
        return self.young, self.shear, self.density


class Materials:
    """The materials by number."""

    def __init__(self, bulk: Bulk, inventory: Inventory):
        self.inventory = inventory
        self.made: dict[int, MaterialCard] = {}
        self.cards: dict[int, Card] = {}
        for name in sorted(bulk.cards):
            if name.startswith("MAT") and name[3:] in {"1", "2", "3", "8", "9", "10", "11", "HP", "ORT"}:
                for card in bulk.cards[name]:
                    number = card.integer(1)
                    if number in self.cards and self.cards[number].fields != card.fields:
                        raise card.refused(f"material {number} a second time", "one card per number")
                    self.cards[number] = card

    def get(self, number: int, who: str, weighs: bool = True) -> MaterialCard:
        """Return a material; MeshError if it does not exist or is of a kind that is not known.

        Where it `weighs`, its elements take their mass from it, and the inventory names it if it has no density.
        """
        if number not in self.made:
            if number not in self.cards:
                raise MeshError(
                    who,
                    found=f"the material {number}, which does not exist",
                    expected=f"One of: {', '.join(map(str, sorted(self.cards))) or 'none'}",
                    remedy="Add its MAT card",
                )
            made = self.made[number] = _material(self.cards[number])
            if made.poisson == INCOMPRESSIBLE:
                self.inventory.approximated[f"{made.name}: Poisson's ratio near 0.5, taken as {INCOMPRESSIBLE:g}"] += 1
        if weighs and self.made[number].density == 0.0:
            self.inventory.weightless.add(self.made[number].name)
        return self.made[number]


def _material(card: Card) -> MaterialCard:
    name = f"{card.name} {card.text(1)}"
    kinds = {"MAT1": _isotropic, "MAT2": _plane_anisotropic, "MAT8": _plane_orthotropic, "MAT9": _anisotropic}
    if card.name not in kinds:
        raise card.refused(
            f"a material {card.name}",
            "MAT1, MAT2, MAT8 or MAT9: linear elastic structures",
            "Fluids and nonlinear materials have no part in a linear reduction; remove their elements",
        )
    return kinds[card.name](card, name)


def _isotropic(card: Card, name: str) -> MaterialCard:
    e, g, nu = (card.real(k, np.nan) if card.text(k) else np.nan for k in (2, 3, 4))
    if np.isnan(e) and np.isnan(g):
        raise card.refused("neither E nor G", "E and nu, E and G, or G and nu")
    if np.isnan(e):
        nu = 0.0 if np.isnan(nu) else nu
        e = 2.0 * g * (1.0 + nu)
    elif np.isnan(g):
        nu = 0.0 if np.isnan(nu) else nu
        g = e / (2.0 * (1.0 + nu))
    elif np.isnan(nu):
        nu = e / (2.0 * g) - 1.0 if g > 0.0 else 0.0
    if e < 0.0 or g < 0.0 or card.real(5, 0.0) < 0.0:
        raise card.refused(f"E = {e:g}, G = {g:g}, rho = {card.real(5, 0.0):g}", "E, G, rho >= 0")
    if not -1.0 < nu <= 0.5:  # E and G of a bar that fit no single material: no plate or solid has them
        return MaterialCard(name, card.real(5, 0.0), None, None, e, g, nu, (g, g))
    nu = min(nu, INCOMPRESSIBLE)
    plane = e / (1.0 - nu**2) * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.0]])
    plane[2, 2] = e / (2.0 * (1.0 + nu))
    solid = np.diag([e / (1.0 + nu)] * 3 + [e / (2.0 * (1.0 + nu))] * 3)
    solid[:3, :3] += e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    return MaterialCard(name, card.real(5, 0.0), plane, solid, e, g, nu, (g, g))


def _plane_anisotropic(card: Card, name: str) -> MaterialCard:
    g = [card.real(k, 0.0) for k in range(2, 8)]
    plane = np.array([[g[0], g[1], g[2]], [g[1], g[3], g[4]], [g[2], g[4], g[5]]])
    return MaterialCard(name, card.real(8, 0.0), plane, None, across=(g[0], g[3]))  # as MID3: the shear moduli


def _plane_orthotropic(card: Card, name: str) -> MaterialCard:
    e1, e2, nu12, g12 = (card.real(k, 0.0) for k in (2, 3, 4, 5))
    if not (e1 > 0.0 and e2 > 0.0):
        raise card.refused(f"E1 = {e1:g}, E2 = {e2:g}", "positive moduli")
    rest = 1.0 - nu12**2 * e2 / e1
    if not rest > 0.0:
        raise card.refused(f"nu12 = {nu12:g} with E2 / E1 = {e2 / e1:g}", "nu12^2 < E1 / E2")
    plane = np.array([[e1 / rest, nu12 * e2 / rest, 0.0], [nu12 * e2 / rest, e2 / rest, 0.0], [0.0, 0.0, g12]])
    g1z, g2z = (card.real(k, 0.0) or float("inf") for k in (6, 7))
    return MaterialCard(name, card.real(8, 0.0), plane, None, across=(g1z, g2z))


def _anisotropic(card: Card, name: str) -> MaterialCard:
    values = [card.real(k, 0.0) for k in range(2, 23)]
    solid = np.zeros((6, 6))
    solid[np.triu_indices(6)] = values
    solid = solid + np.triu(solid, 1).T
    if not semidefinite(solid) or not solid.any():
        raise card.refused("an elasticity that is not positive", "a positive definite matrix G11 .. G66")
    return MaterialCard(name, card.real(23, 0.0), None, solid)
