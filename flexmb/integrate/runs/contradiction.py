"""Equations that depend on each other and contradict each other later: two drives of one joint that part on the way."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flexmb.math.weights import no_matrix
from flexmb.system.complaints import worst_equations
from flexmb.system.program import evaluate

__all__ = ["EXPECTED", "REMEDY", "Contradiction", "first_contradiction"]

EXPECTED = "equations that can be satisfied together at all times"
REMEDY = (
    "Two drives or joints contradict each other from then on: remove one, or make their signals agree; at a dead "
    "centre drive another joint"
)
OPEN = 100.0
"""Of the gap that the digits of a mesh may leave: where equations stay open by more, they contradict each other."""


class Contradiction(NamedTuple):
    """sample : number of the first sample with open equations; title : of the joint; found : how far, and which."""

    sample: int
    title: str
    found: str


def first_contradiction(system, rows: dict[str, np.ndarray], work: Any = None) -> Contradiction | None:
    """Return the first sample of a block whose equations stay open, or None; `work` is a workspace to use again.

    Only equations that depend on others can: their residuals are shared out instead of brought to zero, so the
    integrator notices nothing. What contradicts itself does so more and more, so the last sample tells whether any
    does.
    """
    if not system.redundant or not len(rows["t"]):
        return None
    work = system.workspace() if work is None else work
    last = len(rows["t"]) - 1
    if not _is_open(system, work, rows, last):
        return None
    first = next(k for k in range(last + 1) if _is_open(system, work, rows, k))
    name = system.joints[system.equation_owners[int(np.argmax(np.abs(work.equations["g"])))][0]].name
    return Contradiction(first, f"Joint '{name}'", f"dependent equations stay open: {worst_equations(system, work)}")


def _is_open(system, work: Any, rows: dict[str, np.ndarray], k: int) -> bool:
    state = system.state(*(rows[name][k] for name in ("t", "q", "u", "a", "lam")))
    no_matrix(work.weights)
    evaluate(system.program, state, work)
    held = system.program.equation_level == 0
    return bool(np.any(np.abs(work.equations["g"])[held] > OPEN * system.gaps[held]))
