"""In which units a deck may be: judged by stiffness, density, size and mass together, all systems that fit by rank.

Every system turns the numbers of the deck into SI. A system fits as well as its moduli and densities match
something that structures are made of; the distance is counted in decades.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.fem.deck.contents import Deck
from flexmb.fem.deck.units import SYSTEMS, factors

__all__ = ["doubt", "ranked"]

MATERIALS = {
    "steel": (2.1e11, 7850.0),
    "aluminium": (7.0e10, 2700.0),
    "titanium": (1.1e11, 4430.0),
    "magnesium": (4.5e10, 1780.0),
    "copper": (1.2e11, 8900.0),
    "carbon fibre": (1.0e11, 1600.0),
    "glass fibre": (2.5e10, 1900.0),
    "concrete": (3.0e10, 2400.0),
    "wood": (1.1e10, 550.0),
    "plastic": (2.5e9, 1200.0),
    "rubber": (5.0e6, 1100.0),
    "honeycomb or foam": (1.0e8, 60.0),
}
"""Young's modulus, Pa, and density, kg/m3: mean values (Ashby, Materials Selection in Mechanical Design, appendix)."""
NEAR = 0.7
"""Decades between a material of the table and one that is still like it: alloys, laminates, smeared sections."""
FAR = 2.5
"""Decades beyond which a system is not named."""
FURTHER = 1.5
"""Decades behind the best system up to which others are named."""
BETTER = 0.5
"""Decades by which another system must fit better before the one that was meant is doubted."""
SIZE, MASS = (1e-2, 100.0), (1e-4, 1e6)
"""m and kg between which structures mostly lie; beyond, each decade counts as one of material."""
GRAVITY = 9.80665


@dataclass(frozen=True)
class Fit:
    """How well a system of units fits: distance in decades, what the materials look like, size, mass, modulus, density.

    `weights` says that densities are taken as weight per volume.
    """

    units: str
    distance: float
    material: str
    size: float
    mass: float
    young: float
    density: float | None
    weights: bool = False

    def __str__(self) -> str:
        rho = "" if self.density is None else f", {self.density:.3g} kg/m3"
        like = f"like {self.material}, " if self.material else ""
        told = (
            f"{like}{self.young:.3g} Pa{rho}, {self.size:.3g} m, {self.mass:.3g} kg"
            if self.young
            else (f"{self.size:.3g} m, {self.mass:.3g} kg")
        )
        extra = ", with densities that are weights: PARAM, WTMASS is missing" if self.weights else ""
        return f"'{self.units}'{extra} ({told})"


def ranked(deck: Deck, mass: float) -> list[Fit]:
    """Return how well each system of units fits the numbers of a deck, the best first.

    Parameters
    ----------
    deck : Deck
        In the units of the file, or converted (`Deck.units`): numbers are turned back first.
    mass : float
        Of the whole model, in the units that the deck is in now.
    """
    numbers = _numbers(deck, mass)
    found = [_fit(units, *numbers) for units in SYSTEMS]
    if any(rho is not None for _, rho in numbers[0]) and deck.mass_factor == 1.0:
        found += [_fit(units, *numbers, weights=True) for units in SYSTEMS]
    return sorted(found, key=lambda fit: fit.distance)


def _numbers(deck: Deck, mass: float) -> tuple[list[tuple[float, float | None]], float, float]:
    """Return moduli with densities, size and mass as they stand in the file."""
    length, m, time = factors(deck.units, "units") if deck.units else (1.0, 1.0, 1.0)
    pressure, density = m / length / time**2, m / length**3
    stuffs = [(e / pressure, None if rho is None else rho / density) for e, rho in _materials(deck)]
    return stuffs, float(np.linalg.norm(np.ptp(deck.points, axis=0))) / length, mass / m


def _materials(deck: Deck) -> list[tuple[float, float | None]]:
    """Return modulus and density of every group of elements, as they stand in the deck; None without a density."""
    pairs = [(_young(s.elasticity), s.density) for s in deck.solids]
    pairs += [
        (float(np.abs(s.faces).max()), float(np.median(s.mass / np.maximum(s.thickness, 1e-300)))) for s in deck.shells
    ]
    pairs += [(b.material.young, b.material.density) for b in deck.beams]
    return [(e, rho * deck.mass_factor if rho > 1e-25 else None) for e, rho in pairs if e > 0.0]


def _young(elasticity: np.ndarray) -> float:
    """Return the largest Young's modulus of an elasticity (6, 6); its entries grow without bounds with nu at 0.5."""
    try:
        compliance = np.diag(np.linalg.inv(elasticity))[:3]
    except np.linalg.LinAlgError:
        compliance = np.zeros(3)
    return float(1.0 / compliance.min()) if compliance.min() > 0.0 else float(np.abs(elasticity).max())


def _fit(units: str, stuffs: list[tuple[float, float | None]], size: float, mass: float, weights: bool = False) -> Fit:
    length, m, time = factors(units, "units")
    g = GRAVITY / (length / time**2) if weights else 1.0
    pressure, density = m / length / time**2, m / length**3 / g
    near = [_nearest(e * pressure, None if rho is None else rho * density) for e, rho in stuffs]
    own = sorted(near, key=lambda pair: pair[0])[len(near) // 2] if near else (0.0, "")
    outside = _decades(size * length, SIZE) + (_decades(mass * m / g, MASS) if mass > 0.0 else 0.0)
    young = [e * pressure for e, _ in stuffs]
    known = [rho * density for _, rho in stuffs if rho is not None]
    return Fit(
        units=units,
        distance=own[0] + outside,
        material=own[1] if own[0] < NEAR else "",
        size=size * length,
        mass=mass * m / g,
        young=float(np.median(young)) if young else 0.0,
        density=float(np.median(known)) if known else None,
        weights=weights,
    )


def _nearest(young: float, density: float | None) -> tuple[float, str]:
    """Return the distance in decades of modulus and density from the nearest material, and its name."""
    distances = {
        name: abs(np.log10(young / e)) + (0.0 if density is None else abs(np.log10(density / rho)))
        for name, (e, rho) in MATERIALS.items()
    }
    name = min(distances, key=lambda key: distances[key])
    return float(distances[name]), name


def _decades(value: float, bounds: tuple[float, float]) -> float:
    if not value > 0.0:
        return 0.0
    return float(max(np.log10(bounds[0] / value), np.log10(value / bounds[1]), 0.0))


def doubt(deck: Deck, mass: float) -> str:
    """Return words if another system of units fits a deck better than the one it is taken in, else ""."""
    meant = deck.units or "m, kg, s"
    own = _fit(meant, *_numbers(deck, mass))
    same = factors(meant, "units")
    others = [f for f in ranked(deck, mass) if f.distance < FAR and (f.weights or factors(f.units, "units") != same)]
    others = [f for f in others if f.distance < others[0].distance + FURTHER]
    better = others and others[0].distance < own.distance - BETTER and own.distance > NEAR
    if not better and own.distance < FAR:
        return ""
    rho = "" if own.density is None else f"a density of {own.density:.3g} kg/m3, "
    told = f"a modulus of {own.young:.3g} Pa, " if own.young else ""
    told = f"in '{meant}' it has {told}{rho}a size of {own.size:.3g} m and a mass of {own.mass:.3g} kg, no structure's"
    if not others:
        return f"{told}. No system of units makes a structure of it: look at its materials"
    listed = "; ".join(f"{rank}. {fit}" for rank, fit in enumerate(others, 1))
    return f"{told}. Units that fit, the best first: {listed}"
