"""Load shapes of a floating body: generalised forces that change with the deformation, eq. (load-turning)."""

from __future__ import annotations

from flexmb.math.kernel import kernel

__all__ = ["add_loads", "add_loads_tangent"]


@kernel
def add_loads(shapes, turning, eta, u, first, amounts, energy, residual):
    """Subtract amount * (shape + turning eta) of every load from `residual`, and the turning of the preload.

    Parameters
    ----------
    shapes : (nl, 6 + m)
    turning : (0, nl or nl + 1; 6 + m, m)
        The last one belongs to the preload, whose amount is 1 and whose forces are in equilibrium with its stress.
    energy : Energy
        Receives the power of the loads.
    """
    nl, size = shapes.shape
    for n in range(max(nl, len(turning))):
        amount = amounts[first + n] if n < nl else 1.0
        if amount == 0.0:
            continue
        for i in range(size):
            force = shapes[n, i] if n < nl else 0.0
            if n < len(turning):
                for j in range(len(eta)):
                    force += turning[n, i, j] * eta[j]
            residual[i] -= amount * force
            if n < nl:
                energy[0].load_power += amount * force * u[i]


@kernel
def add_loads_tangent(turning, loads, first, amounts, scale, B):
    """Subtract scale * amount * turning of every load from the modal columns of `B` (6 + m, 6 + m)."""
    for n in range(len(turning)):
        amount = scale * (amounts[first + n] if n < loads else 1.0)
        if amount == 0.0:
            continue
        for i in range(turning.shape[1]):
            for j in range(turning.shape[2]):
                B[i, 6 + j] -= amount * turning[n, i, j]
