"""What the kernels of forces share: central forces between two points, and the law of a one-sided contact."""

from __future__ import annotations

from flexmb.math.kernel import kernel

__all__ = ["add_central_block", "apply_central_force", "one_sided"]


@kernel
def apply_central_force(a, b, direction, force):
    """Pull marker b towards marker a with `force` (N) along the unit `direction` from a to b."""
    for i in range(3):
        a.wrench[i] += force * direction[i]
        b.wrench[i] -= force * direction[i]


@kernel
def add_central_block(matrix, along, across, e):
    """Add the (3, 3) block along e e^T + across (I - e e^T) with the signs of a force between two points."""
    for i in range(3):
        for j in range(3):
            k = (along - across) * e[i] * e[j]
            if i == j:
                k += across
            matrix[i, j] += k
            matrix[6 + i, 6 + j] += k
            matrix[i, 6 + j] -= k
            matrix[6 + i, j] -= k


@kernel
def one_sided(p, rate, stiffness, exponent, damping, depth):
    """Return the force of a penetration p, its derivatives by p and by the rate p', and the energy stored.

    ``F = k p^e + c w(p/d) p'``, eq. (one-sided), with ``w(s) = s^2 (3 - 2 s)`` up to s = 1; never pulling.
    """
    if p <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    s = min(p / depth, 1.0)
    share = s * s * (3.0 - 2.0 * s)
    energy = stiffness * p ** (exponent + 1.0) / (exponent + 1.0)
    force = stiffness * p**exponent + damping * share * rate
    if force <= 0.0:
        return 0.0, 0.0, 0.0, energy
    slope = stiffness * exponent * p ** (exponent - 1.0) + damping * 6.0 * s * (1.0 - s) / depth * rate
    return force, slope, damping * share, energy
