"""`kernel`: the one way to compile a function in flexmb."""

from __future__ import annotations

from numba import njit

__all__ = ["kernel"]

kernel = njit(cache=True, error_model="numpy", nogil=True)
"""Compile with numba; the machine code is cached on disk, so only the first run on a machine compiles.

``error_model="numpy"`` makes a division by zero give inf or nan as numpy does (found by the residual checks),
instead of a branch in every division. ``fastmath`` stays off: the order of operations is part of the result.
"""
