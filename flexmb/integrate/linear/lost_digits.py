"""Frequencies that rounding makes: stiff springs leave no digits for soft ones."""

from __future__ import annotations

import numpy as np

__all__ = ["lost_digits"]

SHARE = 0.01
"""Rounding of the stiffness of a mode, relative to it, from which on it is told: its frequency may be off by half."""
SURE = 1.0
"""Roundings of its stiffness up to which a zero is one."""
NONE = 64.0 * np.finfo(float).eps
"""Share of the highest frequency below which a zero is one: directions of forces are rounded too, as cos(pi/2) is."""


def lost_digits(system, stiffness: np.ndarray, shapes: np.ndarray, equations, values, vectors) -> str:
    """Return the sentence about the mode that the rounding of stiffnesses matters most to; "" if it matters to none.

    A sum of stiffnesses is rounded to the digits of the largest. With the bound R of what rounding makes of K, the
    stiffness |s|^2 z^H M z of a mode z is known to z^T R z. Wheels that roll are left out.

    Parameters
    ----------
    stiffness : (nu, nu)
        Of all coordinates: says where the stiffest force of the mode is.
    shapes : (nu, nz)
        Variation of all coordinates by z.
    equations : FirstOrder
    values : (k,), 1/s
    vectors : (nz, k)
    """
    nz, n = equations.Q.shape
    if nz != n or not len(values):
        return ""
    size, zero = np.abs(vectors), values == 0.0
    bound = equations.rounded[:, :nz]
    rounding = np.sum(size * (bound @ size), axis=0)
    # sums that cancel leave rounding in columns that should be empty
    rounding[zero] = (np.einsum("ik,i->k", size, bound.max(axis=1)) * size.sum(axis=0))[zero]
    inertia = np.abs(np.sum(vectors.conj() * (equations.M @ vectors), axis=0))
    left = np.abs(np.sum(vectors.conj() * (equations.K @ vectors), axis=0))
    known = np.where(zero, left, np.abs(values) ** 2 * inertia)
    share = rounding / np.where(known > 0.0, known, np.inf)
    none = known <= (NONE * np.abs(values).max()) ** 2 * inertia
    doubtful = np.where(zero, (share < 1.0 / SURE) & ~none, share > SHARE) & (known > 0.0)
    if not np.any(doubtful):
        return ""
    k = int(np.argmax(np.where(doubtful, np.where(zero, 1.0, share), 0.0)))
    moved = np.abs(shapes @ vectors[:, k])
    owner = system.owner(int(np.argmax(moved * (np.abs(stiffness) @ moved))))
    hertz = np.sqrt(known[k] / inertia[k]) / (2.0 * np.pi)
    what = (
        f"what comes out as zero may be a vibration of {hertz:.2g} Hz"
        if zero[k]
        else f"{hertz:.2g} Hz is rounding, of a zero or of a soft spring whose digits are lost"
        if share[k] > SURE
        else f"{hertz:.4g} Hz is known to {50.0 * share[k]:.2g} % only"
    )
    times = known[k] / rounding[k] if rounding[k] else np.inf
    expected = (
        "less than once, as of a motion that nothing holds. If nothing holds it, this is rounding; otherwise what"
        if zero[k]
        else f"more than {1.0 / SHARE:g} times. What"
    )
    return (
        f"{what}: in its shape the stiffness is {times:.2g} times the rounding of the stiffest force, at {owner}; "
        f"expected: {expected} is so stiff is rigid beside the rest: use a joint in its place, or a lower stiffness."
    )
