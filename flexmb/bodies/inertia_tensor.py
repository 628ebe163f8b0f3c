"""The inertia tensor of a rigid body: principal values or a symmetric tensor, checked."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.math.definiteness import symmetric
from flexmb.model.described import has_flag

__all__ = ["inertia_tensor"]

SINGLE = 1e-6
"""Share of the root of two moments of inertia by which J_xy and J_yx may differ, and of the second moment by which the
least may be below zero: rounding to 32 bits leaves 1e-7."""

HALF_OF_SINGLE = 2.0**-24
"""Rounding of a number to 32 bits."""
MEANT, DECIMALS = 5, 8
"""Digits of numbers that are meant as they are, and up to which rounded ones are told from others."""


def inertia_tensor(title: str, inertia: Any) -> np.ndarray:
    """Return principal moments (3,) or a tensor (3, 3), kg m2, as the symmetric tensor (3, 3) of the part `title`.

    A least moment within the rounding of the numbers is zero: a free turn about its axis would be that of the rounding.

    Raises
    ------
    ModelError
        It is not symmetric but for rounding, or no mass has such moments.
    """
    J = _tensor(title, inertia)
    principal, axes = np.linalg.eigh(J)
    if -SINGLE * principal[1] <= principal[0] <= _rounded(inertia) * principal[2]:
        principal[0] = 0.0
        J = _tensor(title, (axes * principal) @ axes.T)
    if principal[0] < 0.0 or principal[2] > (principal[0] + principal[1]) * (1.0 + 1e-6) + 1e-300:
        raise ModelError(
            title,
            found=f"principal moments of inertia {principal} kg m2",
            expected="non-negative values, none larger than the sum of the other two",
            remedy="Check signs of the products of inertia (J_xy = -int x y dm) and units (kg m2)",
        )
    return J


def _tensor(title: str, inertia: Any) -> np.ndarray:
    """Return principal values or a tensor as a symmetric tensor (3, 3); ModelError if it is none but for rounding."""
    try:
        J = np.asarray(inertia, float)
    except (TypeError, ValueError, OverflowError):
        J = np.empty(0)
    J = np.diag(J) if J.shape == (3,) else J
    found, remedy = f"inertia = {inertia!r}", "Write inertia=(Jx, Jy, Jz)"
    if J.shape == (3, 3) and not has_flag(inertia) and np.all(np.isfinite(J)):
        if symmetric(J, SINGLE):
            return 0.5 * J + 0.5 * J.T  # the sum first would overflow at 1e308
        size = np.sqrt(np.abs(np.diagonal(J)))
        i, j = divmod(int(np.argmax(np.triu(np.abs(J - J.T) - SINGLE * np.outer(size, size), 1))), 3)
        first, second = "xyz"[i], "xyz"[j]
        found = f"inertia with J_{first}{second} = {J[i, j]:.10g} and J_{second}{first} = {J[j, i]:.10g} kg m2"
        remedy = "Write each product of inertia in both of its places, or inertia=(Jx, Jy, Jz)"
    raise ModelError(
        title,
        found=found,
        expected="three principal values or a symmetric (3, 3) tensor, kg m2, about the centre of mass",
        remedy=remedy,
    )


def _rounded(inertia: Any) -> float:
    """Return the share of its largest moment up to which the least one of a tensor is rounding of its numbers.

    Numbers tell to how many digits they were written: to 32 bits, or to six to eight decimal ones. Fewer digits are
    taken for what is meant. Without products of inertia each moment has digits of its own.
    """
    given = np.array(inertia, float)
    if given.shape != (3, 3) or not np.any(np.triu(given, 1)):
        return 0.0
    numbers = given.ravel()
    with np.errstate(over="ignore"):
        if np.array_equal(numbers.astype(np.float32).astype(float), numbers):
            return 4.0 * HALF_OF_SINGLE
    for digits in range(MEANT, DECIMALS + 1):
        if all(float(f"{x:.{digits - 1}e}") == x for x in numbers.tolist()):
            return 10.0 ** (1 - digits) if digits > MEANT else 0.0
    return 0.0
