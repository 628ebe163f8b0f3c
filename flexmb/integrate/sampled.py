"""Accelerations and multipliers of a sample, in compiled runs: where they are exact, nothing else has to look."""

from __future__ import annotations

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.system.accelerations import EXACT, accelerations

__all__ = ["accelerated"]


@inner_kernel
def _settled(right, a, lam, gravity):
    """Were the last corrections of accelerations and multipliers rounding?"""
    size, change, force, correction = gravity, 0.0, 0.0, 0.0
    for i in range(len(a)):
        size, change = max(size, abs(a[i])), max(change, abs(right[i]))
    for i in range(len(lam)):
        force, correction = max(force, abs(lam[i])), max(correction, abs(right[len(a) + i]))
    return change <= 1e2 * EXACT * size and correction <= 1e2 * EXACT * force


@kernel
def accelerated(program, work, state, right, gravity, redundant):
    """Write accelerations and multipliers of a state, as `Augmented` does; return if they are exact.

    `gravity` (m/s2) is the least acceleration that counts; `redundant` is 1 where equations depend on each other.
    """
    if redundant == 0:
        done = accelerations(program, state, work, right, 2) < 0
        if done and _settled(right, state.a, state.lam, gravity):
            return True
    return accelerations(program, state, work, right, 12) < 0 and _settled(right, state.a, state.lam, gravity)
