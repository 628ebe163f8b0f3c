"""How large a described part may be: a model file of a stranger ends with a message, not with the memory."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from flexmb.errors import ModelError, did_you_mean
from flexmb.model.described import is_number

__all__ = ["ELEMENTS", "check_count", "check_file", "largest_size"]

ELEMENTS = 100_000
"""Elements of one piece, and about as many of a whole part, as of a cable. Tetrahedra have some 150 000 nodes then: a
reduction of minutes with less than 10 GB (100 000 nodes take 2 min and 5 GB), not of hours."""
BYTES = 4_000_000_000
"""Size of a mesh or deck."""


def largest_size(value: Any, title: str, field: str = "size") -> float:
    """Return the size of elements; ModelError unless it is a positive number."""
    if not is_number(value) or value <= 0.0:
        raise ModelError(
            title,
            found=f"{field} = {value!r} m",
            expected="a positive number",
            remedy=f"Write {field} = 0.05 for elements of 5 cm",
        )
    return float(value)


def check_count(count: float, title: str, what: str) -> None:
    """Raise ModelError if a piece would have too many elements."""
    if not count <= ELEMENTS:
        raise ModelError(
            title,
            found=f"about {count:.6g} {what}",
            expected=f"at most {ELEMENTS} in a model file",
            remedy="Give a larger size of elements, or look at its unit: metres. Reduce a larger part once with "
            "`flexmb reduce` and name the file that it writes as data",
        )


def check_file(path: Path, title: str) -> None:
    """Raise ModelError unless a mesh or deck is a regular file of sensible size."""
    try:
        regular, size = path.is_file(), path.stat().st_size
    except (OSError, ValueError):  # there is none, or no system can have such a name
        regular, size = False, 0
    if not regular or size > BYTES:
        held = sorted(p.name for p in path.parent.iterdir() if p.is_file()) if path.parent.is_dir() else []
        there = "is a folder" if path.is_dir() else "is no regular file" if path.exists() else ""
        raise ModelError(
            title,
            found=f"the file '{path.name}' has {size} bytes"
            if regular
            else f"'{path.name}' {there}"
            if there
            else f"there is no file '{path.name}'",
            expected="a mesh or deck beside the model file",
            remedy=did_you_mean(path.name, held) or "Correct the name; it is relative to the model file",
        )
