"""Directions of supports in one notation: text such as "xyzrx", or numbers 0 to 5."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from flexmb.errors import MeshError

__all__ = ["direction_numbers"]

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")


def direction_numbers(directions: str | Iterable[int], part: str) -> np.ndarray:
    """Return sorted numbers, 0..2 translation x y z, 3..5 rotation x y z; MeshError for anything else."""
    if isinstance(directions, str):
        found = re.findall(r"r?[xyz]", directions)
        if not found or "".join(found) != re.sub(r"[ ,]", "", directions):
            raise MeshError(
                part,
                found=f"directions '{directions}'",
                expected="letters out of x y z rx ry rz",
                remedy="Write for example 'xyz' or 'xyrz'",
            )
        directions = [DIRECTIONS.index(d) for d in found]
    try:
        numbers = np.unique(np.array(list(directions)))
    except TypeError:
        numbers = np.array([directions])
    if numbers.dtype.kind not in "iu" or not len(numbers) or numbers[0] < 0 or numbers[-1] > 5:
        raise MeshError(
            part,
            found=f"directions {numbers.tolist()}",
            expected="numbers 0..5, or text such as 'xyzrx'",
            remedy="0, 1, 2 are translations along x, y, z; 3, 4, 5 rotations",
        )
    return numbers.astype(int)
