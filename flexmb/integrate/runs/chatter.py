"""Formulas that pass the same jump to and fro: a force that changes its sign at rest, as -F sign(v), holds nothing."""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["chattering"]

MANY, SHARE = 100, 0.05
"""Passes of one kink or jump, each within a few steps of the one before, and their part of all steps, from which on it
is told."""
REMEDY = (
    "JointFriction and LuGre stick; in a formula write tanh(v/0.001) in the place of sign(v), or let a Relay with "
    "hysteresis switch"
)


def chattering(system: Any, switching: Any, steps: int) -> list[str]:
    """Return the sentence about the part whose formula has passed its jump to and fro in a phase, if there is one."""
    if switching is None or not len(switching.passed):
        return []
    worst = int(np.argmax(switching.passed))
    count = int(switching.passed[worst])
    if count < max(MANY, SHARE * steps):
        return []
    return [
        f"{system.switch_owners[worst]}: its formula has passed one jump or kink {count} times in {steps} steps, each "
        f"time within a few steps of the last; expected: a few times. It chatters: behind the jump "
        f"it drives the motion back at once. {REMEDY}."
    ]
