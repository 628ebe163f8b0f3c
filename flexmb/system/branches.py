"""The rates of the branches of a system: turns of joints, places on curves."""

from __future__ import annotations

import numpy as np

from flexmb.system.program import advance, evaluate

__all__ = ["Followed", "branch_rates"]

PROBE = 1e-4
"""Largest rotation, rad, or displacement, m, over which the rates are measured."""


def branch_rates(system, state, work) -> np.ndarray:
    """Return the rates (nb,), per s, of the branches at a state: their differences over a short motion."""
    if not system.branch_names:
        return np.zeros(0)
    step = PROBE / max(1.0, float(np.max(np.abs(state.u), initial=0.0)))
    found = []
    for way in (-0.5, 0.5):
        q = np.zeros(system.nq)
        advance(system.program, state.q, state.u, way * step, q)
        work.weights[0].wanted = 0
        evaluate(system.program, state._replace(q=q), work)
        found.append(work.branches.copy())
    rates = (found[1] - found[0]) / step
    return np.where(np.isfinite(rates), rates, 0.0)


class Followed:
    """The branches of a run: where a state that was reached had them, and how fast they went on before.

    Attributes
    ----------
    clock : (1,), s; branches, pace : (nb,)
    """

    def __init__(self, system, state, work):
        self.clock, self.branches = np.array([state.t]), state.q[system.program.branches :].copy()
        self.pace = branch_rates(system, state, work)

    def at(self, t: float) -> np.ndarray:
        """Return about where the branches are at time t: near enough to tell one turn from the next."""
        return self.branches + (t - self.clock[0]) * self.pace

    def reached(self, t: float, branches: np.ndarray) -> None:
        """Continue from branches (nb,) at time t."""
        if t > self.clock[0]:
            self.pace[:] = (branches - self.branches) / (t - self.clock[0])
        self.clock[0], self.branches[:] = t, branches
