"""What runs write of their samples."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flexmb.math.structures import FloatRows, Floats, structure

__all__ = ["SampleRows"]


@structure
class SampleRows(NamedTuple):
    """Arrays of nt samples, which kernels fill row by row."""

    t: Floats
    """(nt,) s"""
    q: FloatRows
    """(nt, nq) configuration"""
    u: FloatRows
    """(nt, nu) velocity"""
    a: FloatRows
    """(nt, nu) acceleration"""
    lam: FloatRows
    """(nt, ng) multipliers"""
    works: FloatRows
    """(nt, 3) J, of loads, of drives, and lost"""

    @classmethod
    def of(cls, system, nt: int) -> SampleRows:
        """Return rows for so many samples of a system."""
        shapes = (nt,), (nt, system.nq), (nt, system.nu), (nt, system.nu), (nt, system.ng), (nt, 3)
        return cls(*map(np.zeros, shapes))

    def after(self, done: int) -> SampleRows:
        """Return the rows behind those that are done."""
        return SampleRows(*(array[done:] for array in self)) if done else self

    def first(self, done: int) -> dict[str, np.ndarray]:
        """Return the rows that are done, by name."""
        return {name: array[:done] for name, array in self._asdict().items()}
