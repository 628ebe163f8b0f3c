"""`wear`: what a contact wears off during a run, by Archard's law."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.model.described import is_number

__all__ = ["Wear", "sliding_of", "wear"]


class Wear(NamedTuple):
    """What is worn off the sampled surface of a contact.

    The places stay what they were: a surface does not change its shape by wear.
    """

    t: np.ndarray
    """(nt,), s"""
    volume: np.ndarray
    """(nt,), m3, worn off until then"""
    markers: tuple[str, ...]
    """(n,), "body.marker" in whose axes each point stays"""
    places: np.ndarray
    """(n, 3), m, of the points in these axes"""
    depth: np.ndarray
    """(n,), m, worn off at each point at the end"""


def wear(solution, force: str, coefficient: float) -> Wear:
    """Return what a contact of surfaces has worn off, eq. (archard): ``h' = k p s'`` at every point.

    Parameters
    ----------
    solution : Solution
        With enough samples: between two of them pressure times slip is taken as a straight line.
    force : str
        Name of a `SurfaceContact` or `SkinContact` by `ElasticFoundation`.
    coefficient : float, m2/N
        k, worn volume over normal force and way, of both surfaces together as far as both wear: 1e-15 (lubricated
        steel) to 1e-12 (dry metals). Of the dimensionless coefficient K and the hardness H it is K / H.

    Source: Archard 1953, J. Appl. Phys. 24, 981, eq. 6.
    """
    if not is_number(coefficient) or coefficient < 0.0:
        raise FlexmbError(
            "Wear",
            found=f"coefficient = {coefficient!r}",
            expected="a number >= 0, m2/N",
            remedy="Write 1e-13 for 1e-4 mm3/(N m)",
        )
    known = next((phase.model for phase in solution.phases if _has(phase.model, force)), None)
    if known is None:
        names = ", ".join(part.name for part in solution.model.forces) if solution.model else ""
        raise FlexmbError(
            "Wear",
            found=f"no force '{force}'",
            expected=f"One of: {names or 'none'}",
            remedy="Name the contact of surfaces",
        )
    own = known.force(force)
    if not hasattr(own, "spots") or not own.law.sampled:
        raise FlexmbError(
            "Wear",
            found=f"force '{force}', a {type(own).__name__}",
            expected="a contact of surfaces by ElasticFoundation: other laws have no pressure",
            remedy="Use SurfaceContact with a spacing",
        )
    markers, table = own.points(known)
    volumes, depth = [], np.zeros(len(table))
    for slid in sliding_of(solution, force):
        depth = coefficient * slid
        volumes.append(float(depth @ table[:, 6]))
    return Wear(solution.t, np.array(volumes), tuple(markers), table[:, :3], depth)


def sliding_of(solution, force: str) -> Iterator[np.ndarray]:
    """Yield, for every sample of all phases, the integral of pressure times slip at every point of a contact, N/m.

    Of the area of a point only the part that faces the other surface counts.
    """
    total: Any = None
    for number, phase in enumerate(solution.phases):
        if not _has(phase.model, force):
            for _ in phase.t:
                yield np.zeros(1) if total is None else total
            continue
        series, own = solution.series(number), phase.model.force(force)
        area = own.points(phase.model)[1][:, 6]
        total = np.zeros(len(area)) if total is None else total
        before, then = np.zeros(len(area)), np.nan
        for t, spots in zip(phase.t, own.spots(series), strict=True):
            rate = np.zeros(len(area))
            np.add.at(rate, spots.point, spots.pressure * spots.slip * spots.area / area[spots.point])
            if np.isfinite(then):
                total = total + 0.5 * (t - then) * (before + rate)
            before, then = rate, t
            yield total


def _has(model, force: str) -> bool:
    """Has a model a force of this name?"""
    return model is not None and any(part.name == force for part in model.forces)
