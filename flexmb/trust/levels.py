"""Constraints at three levels: the equations themselves, their rates and second rates by differences along the motion.

Integrators hold ``G u + dg/dt = 0`` and ``G a + drift = 0`` with gradients and drifts derived by hand. Here only the
values g(q, t) are asked for, at places before and after a sample on the path that has its velocity and acceleration.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.math.weights import no_matrix
from flexmb.results import Phase
from flexmb.system.program import advance, evaluate
from flexmb.trust.balance import STENCIL

__all__ = ["LEVELS", "Residual", "constraint_levels"]

LEVELS = ("position", "velocity", "acceleration")
SECOND = {-3: 2 / 180, -2: -27 / 180, -1: 270 / 180, 0: -490 / 180, 1: 270 / 180, 2: -27 / 180, 3: 2 / 180}
"""Second derivative by central differences of sixth order."""
TURN = 0.02
"""rad: what the motion turns, or moves relative to its size, in a step of the differences."""


@dataclass(frozen=True)
class Residual:
    """The largest residual of a level.

    Parameters
    ----------
    level : str
        "position", "velocity" or "acceleration".
    value : float, m or rad, per s, per s2
    equation : str
        "joint: primitive" of the worst equation.
    share : float
        Relative to the size of the model, the fastest motion, the greatest acceleration.
    at : float, s
    """

    level: str
    value: float
    equation: str
    share: float
    at: float


def constraint_levels(phase: Phase, system: Any, samples: Iterable[int]) -> list[Residual]:
    """Return the largest residuals of the three levels at some samples of a phase; nothing without constraints."""
    if not system.ng:
        return []
    work = system.workspace()
    no_matrix(work.weights)
    at_velocity = system.program.equation_level == 1
    worst: dict[str, Residual] = {}
    size, speed, change = _sizes(phase, system, work)
    for k in samples:
        h = TURN / max(speed / size, np.sqrt(change / size), 1e-3)
        values = {n: _values(phase, system, work, k, n * h) for n in SECOND}
        rate = sum(weight * values[n] for n, weight in STENCIL.items()) / h
        second = sum(weight * values[n] for n, weight in SECOND.items()) / h**2
        found = (
            (np.where(at_velocity, 0.0, values[0]), size),
            (np.where(at_velocity, values[0], rate), speed),
            (np.where(at_velocity, rate, second), change),
        )
        for level, (left, scale) in zip(LEVELS, found, strict=True):
            n = int(np.argmax(np.abs(left)))
            value = float(abs(left[n]))
            if level not in worst or value > worst[level].value:
                share = value / scale if scale > 0.0 else 0.0
                worst[level] = Residual(level, value, system.equation_names[n], share, float(phase.t[k]))
    return [worst[level] for level in LEVELS]


def _sizes(phase: Phase, system, work) -> tuple[float, float, float]:
    """Return the size of the model (m), its greatest speed (m/s) and acceleration (m/s2) over all samples.

    Angles count as the displacements they cause at the size of the model, so a model without large motion still has
    scales, from its gravity.
    """
    evaluate(system.program, _state(phase, system, 0, 0.0), work)
    places = work.markers["r"]
    size = float(np.linalg.norm(np.ptp(places, axis=0))) if len(places) else 0.0
    size = size or 1.0
    frames = np.asarray(system.program.frames, int).reshape(-1, 2)[:, 1]
    turning = np.zeros(system.nu, bool)
    for first in frames:
        turning[first + 3 : first + 6] = True
    weight = np.where(turning, size, 1.0)
    fall = float(np.linalg.norm(phase.model.gravity))
    speed = max(float(np.max(np.abs(phase.u) * weight, initial=0.0)), 1e-3 * np.sqrt(fall * size))
    change = max(float(np.max(np.abs(phase.a) * weight, initial=0.0)), 1e-3 * fall, speed * speed / size * 1e-3)
    return size, speed, change


def _state(phase: Phase, system, k: int, h: float):
    """Return the state that the velocity and acceleration of sample `k` lead to after the time `h`."""
    u, a = phase.u[k], phase.a[k]
    start = system.state(0.0, phase.q[k]).q
    q = np.empty(system.nq)
    advance(system.program, start, np.ascontiguousarray(u * h + 0.5 * a * h * h), 1.0, q)
    return system.state(phase.t[k] + h, q, u + h * a, a)


def _values(phase: Phase, system, work, k: int, h: float) -> np.ndarray:
    evaluate(system.program, _state(phase, system, k, h), work)
    return work.equations["g"].copy()
