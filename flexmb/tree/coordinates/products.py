"""Products with the mass matrix of a tree and its inverse, without the matrix: by the recursions, in linear time.

Forces are affine in the second rates, ``tau = M a + b``, and second rates in the forces. So a product is a difference
of two values, divided by a power of two that makes what is looked for large against all that cancels.
"""

from __future__ import annotations

import numpy as np

__all__ = ["mass_product", "mass_solution"]

LARGE = 40
"""Binary digits by which second rates or forces exceed 1 where they are asked for."""


def _linear_part(f, x: np.ndarray) -> np.ndarray:
    """Return f(x) - f(0) of an affine function, for any size of x."""
    largest = float(np.abs(x).max(initial=0.0))
    if largest == 0.0:
        return np.zeros(len(x))
    scale = 2.0 ** (LARGE - int(np.ceil(np.log2(largest))))
    return (f(scale * x) - f(np.zeros(len(x)))) / scale


def mass_product(tree, q, a) -> np.ndarray:
    """Return M(q) a, see `JointTree.mass_product`."""
    rest = np.zeros(len(tree.rate_names))
    return _linear_part(lambda x: tree.torques(q, rest, x), np.asarray(a, float))


def mass_solution(tree, q, tau) -> np.ndarray:
    """Return M(q)^-1 tau, see `JointTree.mass_solution`."""
    rest = np.zeros(len(tree.rate_names))
    return _linear_part(lambda x: tree.accelerations(q, rest, x), np.asarray(tau, float))
