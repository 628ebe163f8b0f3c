"""Numbers in units that cannot be meant: said as doubts, because a model may be of another world.

The speed of sound alone does not reveal every mistake: a modulus in GPa with a density in kg/mm3 gives steel's.
"""

from __future__ import annotations

import numpy as np

__all__ = ["WAVE_SPEED", "damping_doubts", "inertia_doubts", "material_doubts", "section_doubts", "size_doubts"]

SIZE = (1e-5, 150.0)
"""Diagonal of a part, m: from micromechanics to bridges."""
MASS = 5e4
"""kg; a block of steel in a box of 2 m, a wing of a large aircraft. A bracket read in millimetres is a billion times
too heavy."""
WAVE_SPEED = (30.0, 30e3)
"""m/s; rubber 50, lead 1200, steel 5100, diamond 18 000 (sqrt(E / rho))."""
DENSITY = (0.1, 25e3)
"""kg/m3; aerogel 1, osmium 22 600."""
YOUNG = (1e2, 2e12)
"""Pa; gels 1e3, diamond 1.1e12."""
THINNEST = 1e-7
"""Of a thickness or a section beside the length of its part."""


def material_doubts(young: float, density: float) -> list[str]:
    """Return sentences about a modulus (Pa) and a density (kg/m3) that no solid has."""
    units = "Units: 1 MPa = 1e6 Pa, 1 GPa = 1e9 Pa, 1 g/cm3 = 1e3 kg/m3, 1 t/mm3 = 1e12 kg/m3, 1 kg/mm3 = 1e9 kg/m3"
    speed = float(np.sqrt(young / density))
    found = []
    if not WAVE_SPEED[0] < speed < WAVE_SPEED[1]:
        found.append(
            f"{young:.4g} Pa and {density:.4g} kg/m3 give a speed of sound of {speed:.2g} m/s; solids have "
            f"{WAVE_SPEED[0]:g} to {WAVE_SPEED[1]:g}. {units}"
        )
    elif not DENSITY[0] <= density <= DENSITY[1]:
        found.append(f"the density is {density:.4g} kg/m3; solids have {DENSITY[0]:g} to {DENSITY[1]:g}. {units}")
    elif not YOUNG[0] <= young <= YOUNG[1]:
        found.append(f"Young's modulus is {young:.4g} Pa; solids have {YOUNG[0]:g} to {YOUNG[1]:g}. {units}")
    return found


def size_doubts(diagonal: float, mass: float | None, remedy: str) -> list[str]:
    """Return sentences about the diagonal (m) and the mass (kg, if known) of a part that can hardly be meant."""
    if diagonal < SIZE[0]:
        return [
            f"the diagonal is {diagonal:.6g} m, below {SIZE[0]:g} m; coordinates must be metres. Were they scaled "
            "twice, or are they in another unit?"
        ]
    if diagonal > SIZE[1]:
        return [
            f"the diagonal is {diagonal:.6g} m; coordinates must be metres. For a model in millimetres use {remedy}"
        ]
    if mass is not None and mass > MASS:
        return [
            f"the part weighs {mass:.3g} kg and is {diagonal:.3g} m long; coordinates must be metres and densities "
            f"kg/m3. For a model in millimetres use {remedy}: it would weigh {1e-9 * mass:.3g} kg"
        ]
    return []


def section_doubts(depth: float, length: float, what: str) -> list[str]:
    """Return sentences about the depth of a section or a thickness (m) beside the length (m) of its part."""
    if depth > length:
        return [f"{what} of {depth:.4g} m is larger than the part is long, {length:.4g} m; both must be metres"]
    if depth < THINNEST * length:
        return [f"{what} of {depth:.4g} m is {length / depth:.2g} times smaller than the part, {length:.4g} m; metres?"]
    return []


def damping_doubts(ratios: np.ndarray) -> list[str]:
    """Return sentences about fractions of critical damping that may be percents."""
    largest = float(np.max(ratios, initial=0.0))
    if largest <= 1.0:
        return []
    return [
        f"a ratio of {largest:.4g} is {100.0 * largest:.4g} % of critical damping: such a mode creeps back without "
        f"oscillation. If {largest:.4g} % is meant, write {0.01 * largest:.4g}"
    ]


def inertia_doubts(inertia: np.ndarray) -> list[str]:
    """Return sentences about a tensor of inertia (3, 3), kg m2, that no mass has.

    One with a principal value of zero is meant otherwise: only some axes are given.
    """
    smallest, middle, largest = np.linalg.eigvalsh(inertia).tolist()
    if smallest <= 1e-9 * largest or largest <= (smallest + middle) * (1.0 + 1e-6):
        return []
    return [
        f"the principal moments of inertia are {smallest:.4g}, {middle:.4g} and {largest:.4g} kg m2; in no mass is one "
        "larger than the sum of the other two. Check the products of inertia and the units"
    ]
