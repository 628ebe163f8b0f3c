"""What the kernels of two-marker forces share: stiffness and damping blocks of a pair."""

from __future__ import annotations

from flexmb.math.kernel import kernel

__all__ = ["add_central_block", "apply_central_force"]


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
