"""Stretches of a line on which distributed loads act: markers at Gauss points, and the length that each stands for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import check_mapping, is_number

__all__ = ["Stretch", "checked_stretches", "places_of"]

GAUSS = np.polynomial.legendre.leggauss(3)
"""Exact for a uniform load on elements of third order, also where a stretch ends inside of one."""


class Stretch(NamedTuple):
    """Markers (names) of a stretch and the fractions of the whole length where they are."""

    markers: tuple[str, ...]
    fractions: np.ndarray
    weights: np.ndarray
    """Length that each stands for, m as drawn."""


def checked_stretches(given, elements: int, length: float, title: str) -> dict[str, Stretch]:
    """Return the stretches by name; ModelError unless each is two fractions of the length (m), the first smaller."""
    given = {} if given is None else given
    check_mapping(given, title, "stretches", '{"wind": (0.2, 0.8)}')
    return {name: _stretch(name, ends, elements, length, title) for name, ends in given.items()}


def _stretch(name, ends, elements, length, title) -> Stretch:
    if (
        not isinstance(ends, list | tuple)
        or len(ends) != 2
        or not all(is_number(x) for x in ends)
        or not 0.0 <= ends[0] < ends[1] <= 1.0
    ):
        raise ModelError(
            title,
            found=f"stretch {name} = {ends!r}",
            expected="two fractions of the length, 0 <= from < to <= 1",
            remedy=f"Write stretches={{'{name}': (0.0, 1.0)}}",
        )
    inner = np.arange(np.ceil(ends[0] * elements + 1e-9), np.floor(ends[1] * elements - 1e-9) + 1.0) / elements
    borders = np.concatenate([[ends[0]], inner, [ends[1]]])
    half = 0.5 * np.diff(borders)
    fractions = (borders[:-1, None] + half[:, None] * (1.0 + GAUSS[0])).ravel()
    weights = length * (half[:, None] * GAUSS[1]).ravel()
    return Stretch(tuple(f"{name}[{k}]" for k in range(len(fractions))), fractions, weights)


def places_of(stretches: Mapping[str, Stretch]) -> dict[str, tuple[float, None]]:
    """Return the places of all their markers on the line."""
    return {
        marker: (float(at), None)
        for stretch in stretches.values()
        for marker, at in zip(stretch.markers, stretch.fractions, strict=True)
    }
