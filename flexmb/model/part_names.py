"""Names of parts: used once in a family, found with the nearest one told, and the two markers that a part names."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flexmb.errors import ModelError, did_you_mean, listed

__all__ = ["check_names", "find_part", "marker_pair"]


def marker_pair(markers: Any, title: str) -> tuple[str, str]:
    """Return two names of markers; ModelError unless it is two."""
    if not isinstance(markers, tuple | list) or len(markers) != 2 or not all(isinstance(m, str) for m in markers):
        raise ModelError(
            title,
            found=f"markers = {markers!r}",
            expected="two names 'body.marker'",
            remedy="Write markers=('ground.A', 'crank.A')",
        )
    return markers[0], markers[1]


def check_names(parts, family: str) -> None:
    """Raise ModelError if two parts of a family share a name."""
    seen: set[str] = set()
    for part in parts:
        if part.name in seen:
            raise ModelError(
                f"{family} '{part.name}'",
                found="the name is used twice",
                expected=f"one {family.lower()} of each name",
                remedy="Rename one of them",
            )
        seen.add(part.name)


def find_part(name: str, parts: Mapping[str, Any], asker: str, family: str):
    """Return the part called `name`; ModelError with the known names and the nearest one otherwise."""
    if not isinstance(name, str) or name not in parts:
        known = listed(name, sorted(parts))
        raise ModelError(
            asker,
            found=f"{family} '{name}' does not exist",
            expected=f"The model has: {known}",
            remedy=did_you_mean(name, parts) or "Correct the name",
        )
    return parts[name]
