"""What forces on a coordinate share that have first-order states: pairs of their markers, and their tangent."""

from __future__ import annotations

from typing import Any

from flexmb.math.kernel import kernel

__all__ = ["add_state_tangent", "state_pairs"]


def state_pairs(compiler, x: dict[str, Any], states: int) -> tuple[int, int]:
    """Return the pairs of both markers of a coordinate's row `x` with the marker of the states."""
    return compiler.pair(x["a"], states), compiler.pair(x["b"], states)


@kernel
def add_state_tangent(pairs, work, g, k, force_by_state, rate_by_x, rate_by_speed, rate_by_state):
    """Add what couples state k < 6 with a coordinate of gradient g (12,), eq. (state-residual).

    The arguments are dF/dz, and the derivatives of z' by the coordinate, its rate and z itself, without a minus. A
    state is a velocity, so columns of states stand in D. The derivatives of F by the coordinate and its rate go to
    `add_tangent`.
    """
    for side in range(2):
        pair = work.pairs[pairs[side]]
        for i in range(6):
            pair.D[i, 6 + k] -= force_by_state * g[6 * side + i]
            pair.K[6 + k, i] -= rate_by_x * g[6 * side + i]
            pair.D[6 + k, i] -= rate_by_speed * g[6 * side + i]
    work.pairs[pairs[0]].D[6 + k, 6 + k] -= rate_by_state
