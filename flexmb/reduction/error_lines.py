"""What a reduction keeps of the error of its response, frequency by frequency, for the check of runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

__all__ = ["ErrorLines"]

_DIGITS = 7  # of a kept matrix: shares of forces cancel to a hundredth or so, not to 1e-7


@dataclass(frozen=True, eq=False)
class ErrorLines:
    """Errors of the motion of the interface freedoms, turns times the size of the body, at n frequencies.

    Parameters
    ----------
    frequencies : (n,), Hz
    by_input : (n, k), m/N
        Bound of the norm, by each interface freedom by itself.
    matrix : (n, k, k) complex, m/N, or None
        Estimate by forces on the interface freedoms; None where these are too many.
    loads : (n, k, nl) complex, m per unit of the load, or None
        By the load shapes of the body.
    spin : (n, k, 6) complex, m s2, or None
        By the symmetric acceleration fields ``A x`` with A = w w^T - w^2 I: xx, yy, zz, xy, yz, zx.
    """

    frequencies: np.ndarray
    by_input: np.ndarray
    matrix: np.ndarray | None
    loads: np.ndarray | None
    spin: np.ndarray | None

    def numbers(self) -> dict[str, Any]:
        """Return them as JSON can hold them; matrices have real and imaginary parts, (n, 2, k, ...)."""
        kept = {"matrix": self.matrix, "loads": self.loads, "spin": self.spin}
        return {
            "frequencies": self.frequencies.tolist(),
            "by_input": self.by_input.tolist(),
            **{
                name: _rounded(np.stack([one.real, one.imag], axis=1)).tolist()
                for name, one in kept.items()
                if one is not None and one.size
            },
        }


def _rounded(numbers: np.ndarray) -> np.ndarray:
    """Return numbers to a few digits of the largest at each frequency, (n, ...): short in a file."""
    size = np.abs(numbers).max(axis=tuple(range(1, numbers.ndim)))
    places = _DIGITS - np.floor(np.log10(np.where(size > 0.0, size, 1.0))).astype(int)
    return np.stack([np.round(own, place) for own, place in zip(numbers, places, strict=True)])
