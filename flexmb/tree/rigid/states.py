"""First-order states of forces and blocks beside links: their markers, whose twists they are, and their rates.

A state has the equation of motion of a unit mass (see `system/states.py`): nothing is passed on.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel

__all__ = ["move_states", "place_states", "resist_states", "state_rows"]


def state_rows(system, rates: dict[str, int]) -> np.ndarray:
    """Return (ns, 3) marker, place in its twist and rate of all states; `rates` has the first rate of every group."""
    return np.array(
        [
            (group.marker + k // 6, k % 6, rates[group.title] + k)
            for group in system.states
            for k in range(len(group.names))
        ],
        np.int64,
    ).reshape(-1, 3)


@kernel
def place_states(tree, work):
    """Write the states to their markers, without rates."""
    states, markers, v = tree.states, work.markers, tree.v
    for n in range(len(states)):
        marker, i = markers[states[n, 0]], states[n, 1]
        if i < 3:
            marker.v[i] = v[states[n, 2]]
        else:
            marker.w[i - 3] = v[states[n, 2]]
        marker.wrench[i] = 0.0


@kernel
def move_states(tree, work, weight):
    """Write the rates of states to tree.a: what was added to them, times a weight, and tree.tau."""
    states, markers, a, tau = tree.states, work.markers, tree.a, tree.tau
    for n in range(len(states)):
        k = states[n, 2]
        a[k] = weight * markers[states[n, 0]].wrench[states[n, 1]] + tau[k]


@kernel
def resist_states(tree, work, weight):
    """Write what rates tree.a of states need beside what was added to them, times a weight, to tree.tau."""
    states, markers, a, tau = tree.states, work.markers, tree.a, tree.tau
    for n in range(len(states)):
        k = states[n, 2]
        tau[k] = a[k] - weight * markers[states[n, 0]].wrench[states[n, 1]]
