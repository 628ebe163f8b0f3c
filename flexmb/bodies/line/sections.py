"""What varies along a line of elements: its section, and masses fixed to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import entries_of, is_number

__all__ = ["checked_masses", "checked_sections", "section_at", "section_constants"]


def checked_sections(given: Any, needs: tuple[str, ...], title: str) -> tuple[Any, ...]:
    """Return the sections at equal distances along the line; ModelError if one lacks a constant that is needed."""
    sections = tuple(given) if isinstance(given, list | tuple) else (given,)
    for section in sections or (None,):
        missing = [name for name in needs if not getattr(section, name, 0.0) > 0.0]
        if missing:
            raise ModelError(
                title,
                found=f"section = {section!r} without {', '.join(missing)}",
                expected="a section with area (m2) and moments of inertia (m4) > 0",
                remedy="Write section=fem.Section.solid_circle(0.01)",
            )
    return sections


def section_at(sections: Sequence[Any], fraction: float) -> Any:
    """Return the section at a fraction of the length: a linear taper between two neighbours."""
    at = fraction * (len(sections) - 1)
    k = min(int(at), len(sections) - 2)
    return sections[0] if len(sections) == 1 else sections[k].between(sections[k + 1], at - k)


def section_constants(sections: Sequence[Any], fractions, names: Sequence[str]) -> np.ndarray:
    """Return constants of the section by name at fractions (n,) of the length: (len(names), n)."""
    fractions = np.atleast_1d(np.asarray(fractions, float))
    if len(sections) == 1:
        return np.array([np.full(len(fractions), getattr(sections[0], name)) for name in names])
    there = [section_at(sections, float(fraction)) for fraction in fractions]
    return np.array([[getattr(section, name) for section in there] for name in names])


def checked_masses(given: Any, title: str) -> tuple[tuple[float, float], ...]:
    """Return pairs (fraction of the length, mass in kg); ModelError for anything else."""
    masses = entries_of(given)
    for pair in masses:
        if (
            not isinstance(pair, list | tuple)
            or len(pair) != 2
            or not all(is_number(x) for x in pair)
            or not 0.0 <= pair[0] <= 1.0
            or pair[1] <= 0.0
        ):
            raise ModelError(
                title,
                found=f"lumped mass {pair!r}",
                expected="(fraction of the length, mass > 0 in kg)",
                remedy="Write lumped_masses=[(0.5, 2.0)]",
            )
    return tuple((float(at), float(mass)) for at, mass in masses)
