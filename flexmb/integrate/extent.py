"""What makes errors comparable: every velocity as a displacement in metres, every body with the length it lives on."""

from __future__ import annotations

import numpy as np

from flexmb.math.weights import weigh_mass
from flexmb.system.lengths import ROUNDED, displacements
from flexmb.system.mobility import mass_diagonal
from flexmb.system.program import evaluate
from flexmb.told import tell

__all__ = ["SLOW", "absolute_tolerance", "extents", "reaches"]

SMALLEST = 1e-4
"""Least displacement of reference of flexible coordinates, relative to the length of the assembly."""
TURNED = 1e-3
"""A rotation error of a body moves its markers, not only its mass: so much of the assembly's length counts at least."""
BEYOND = 2.0
"""Errors that are larger than asked for by this factor are told."""
SLOW = 100.0
"""s, length of a run from which on the absolute tolerance of velocities is less: in motions that take hours they are
small."""
DIGITS = 10.0
"""Errors are not estimated closer than this, times the rounding of positions."""


def extents(system, state, work, smallest: float | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Return for every velocity the length that makes its increment a displacement, and the displacement of reference.

    Parameters
    ----------
    smallest : float, m, optional
        Least reference of flexible coordinates; it grows with the deflections that occur.

    Returns
    -------
    extent, reach : (nu,), (nu,)
        Translations have the extent 1, rotations the radius of gyration, flexible coordinates sqrt(M_jj / m): the root
        mean square displacement of the body's material per unit. The reach is the length of the assembly (see
        `flexmb.system.lengths`). First-order states have the extent 1, and their size as reach.
    """
    weigh_mass(work.weights)
    evaluate(system.program, state, work)
    diagonal = np.abs(mass_diagonal(system, work))
    extent, reach = np.ones(system.nu), np.full(system.nu, system.lengths.whole)
    for body, length in zip(system.model.bodies, system.lengths.bodies, strict=True):
        span = system.body_slices[body.name][1]
        if span.stop == span.start:
            continue
        extent[span] = displacements(body, diagonal[span])
        reach[span] = length
        if body.has_frame:
            turns = slice(span.start + 3, span.start + 6)
            extent[turns] = np.maximum(extent[turns], TURNED * length)
            reach[span.start + 6 : span.stop] = SMALLEST * length if smallest is None else smallest
    reach[system.is_state] = system.state_sizes
    return extent, reach


def reaches(system, reach: np.ndarray, rtol: float) -> np.ndarray:
    """Return the displacements of reference (nu,), none so small that `rtol` of it would be rounding; warn where the
    tolerance that was asked for is out of reach by that.
    """
    least = DIGITS * ROUNDED * system.lengths.coordinates / rtol
    for body, digits, length in zip(system.model.bodies, least, system.lengths.bodies, strict=True):
        span = system.body_slices[body.name][1]
        if body.n_velocities and digits > BEYOND * length:
            far = system.lengths.coordinates[system.model.bodies.index(body)]
            tell(
                f"{body.title} is {far:.3g} m from the origin, where positions are rounded: errors of a step are kept "
                f"below {rtol * digits:.1g} m, not below the {rtol * length:.1g} m of rtol = {rtol:g}; expected: "
                "coordinates that have the digits of the tolerance. Put the origin near the bodies, or use Explicit"
            )
        moved = slice(span.start, span.start + 6 if body.has_frame else span.stop)
        reach[moved] = np.maximum(reach[moved], digits)
    return reach


def absolute_tolerance(given: float | None, usual: float, system) -> float:
    """Return the absolute tolerance of coordinates: that which is given, or the usual one, less in a model below 1 m.

    Euler parameters have it too, so that it does not grow with the model.
    """
    return usual * min(1.0, system.lengths.whole) if given is None else given
