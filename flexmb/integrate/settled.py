"""Accelerations of samples where forces follow accelerations: those near the integrator's own."""

from __future__ import annotations

import numpy as np

from flexmb.system.damped_accelerations import damped_accelerations

__all__ = ["settle", "settle_rows"]


def settle(system, state, work, a: np.ndarray, lam: np.ndarray) -> None:
    """Write to state.a and state.lam the accelerations and multipliers near those of the integrator, `a` (nu,) and
    `lam` (ng,); these themselves, which are as exact as its steps, where no others are found."""
    found = damped_accelerations(system, state._replace(a=a, lam=lam), work)
    state.a[:], state.lam[:] = (a, lam) if found is None else found


def settle_rows(system, work, rows: dict[str, np.ndarray]) -> None:
    """Settle the accelerations `a` (n, nu) and multipliers `lam` (n, ng) of samples in place."""
    for k, t in enumerate(rows["t"]):
        state = system.state(float(t), rows["q"][k], rows["u"][k])
        settle(system, state, work, rows["a"][k].copy(), rows["lam"][k].copy())
        rows["a"][k], rows["lam"][k] = state.a, state.lam
