"""What a start needs beyond accelerations: their rate, and the part of a velocity that constraints determine."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.alpha.world_translation import to_world_axes
from flexmb.math.block_lu import lu_factor
from flexmb.math.block_substitution import lu_solve
from flexmb.math.weights import weigh_mass
from flexmb.system.accelerations import accelerations
from flexmb.system.program import advance, constraint_velocity, evaluate

__all__ = ["acceleration_rate", "constrained_part"]


def constrained_part(system, state, work, velocity: np.ndarray) -> np.ndarray:
    """Return the part of a velocity that the constraints determine: M x = G^T lam, G x = G velocity."""
    right = np.zeros(system.nu + system.ng)
    weigh_mass(work.weights)
    evaluate(system.program, state, work)
    constraint_velocity(work, velocity, right[system.nu :])
    held = system.program.equation_level == 0
    right[system.nu :] = np.where(held, right[system.nu :] - work.equations["rate"], 0.0)
    if not system.ng or lu_factor(work.S, system.program.pattern) >= 0:
        return np.zeros(system.nu)
    lu_solve(work.S, system.program.pattern, right)
    return right[: system.nu]


def acceleration_rate(system, state, work, probe: float, world) -> np.ndarray:
    """Return the change of the acceleration over a time `probe` of uniformly accelerated motion, per second.

    That of the frames `world` is the acceleration in W.
    """
    q = np.zeros(system.nq)
    advance(system.program, state.q, state.u + 0.5 * probe * state.a, probe, q)
    later = system.state(state.t + probe, q, state.u + probe * state.a)
    right = np.zeros(system.nu + system.ng)
    if accelerations(system.program, later, work, right, 12 if system.redundant else 2) >= 0:
        return np.full(system.nu, np.inf)
    now, then = state.a.copy(), later.a.copy()
    to_world_axes(world, state.q, state.u.copy(), now)
    to_world_axes(world, later.q, later.u.copy(), then)
    return (then - now) / probe
