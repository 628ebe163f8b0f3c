"""Equations that depend on each other and contradict each other later: two drives of one joint that part on the way."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flexmb.math.direct import direct
from flexmb.math.jets import sample_signals
from flexmb.math.kernel import kernel
from flexmb.math.tables import State
from flexmb.math.weights import no_matrix
from flexmb.system.complaints import worst_equations
from flexmb.system.program import run_kernels

__all__ = ["EXPECTED", "REMEDY", "Contradiction", "Scratch", "first_contradiction"]

EXPECTED = "equations that can be satisfied together at all times"
REMEDY = (
    "Two drives or joints contradict each other from then on: remove one, or make their signals agree; at a dead "
    "centre drive another joint"
)
OPEN = 100.0
"""Of the gap that the digits of a mesh may leave: where equations stay open by more, they contradict each other."""

SLIPS = 0.03
"""Part of the speeds in an equation of velocities by which it misses zero where it contradicts others."""
ACROSS = 0.1
"""How much speeds across the gradient of an equation count, of which steps leave errors along it."""
SLOW = 1e-4
"""Speeds below this, in lengths of the assembly in the time of the run, count as that."""


class Contradiction(NamedTuple):
    """sample : number of the first sample with open equations; title : of the joint; found : how far, and which."""

    sample: int
    title: str
    found: str


class Scratch(NamedTuple):
    """Storage for looks at one system; its arrays are kept from look to look."""

    work: Any
    state: Any

    @classmethod
    def of(cls, system) -> Scratch:
        """Return storage of its own."""
        scratch = cls(system.workspace(), system.state())
        no_matrix(scratch.work.weights)
        return scratch


def first_contradiction(
    system, rows: dict[str, np.ndarray], span: float, scratch: Scratch | None = None
) -> Contradiction | None:
    """Return the first sample of a block whose equations stay open, or None; the run takes `span`, s.

    `scratch` is storage to use again.

    Only equations that depend on others can: their residuals are shared out instead of brought to zero, so the
    integrator notices nothing. What contradicts itself does so more and more, so the last sample tells whether any
    does.
    """
    if not system.redundant or not len(rows["t"]):
        return None
    scratch = Scratch.of(system) if scratch is None else scratch
    last = len(rows["t"]) - 1
    opened = _open(system, scratch, rows, last, span)
    if opened is False or not np.any(opened):
        return None
    first = next(k for k in range(last + 1) if np.any(_open(system, scratch, rows, k, span)))
    opened, work = _open(system, scratch, rows, first, span), scratch.work
    worst = int(np.argmax(np.where(opened, np.abs(work.equations["g"]), 0.0)))
    name = system.joints[system.equation_owners[worst][0]].name
    return Contradiction(first, f"Joint '{name}'", f"dependent equations stay open: {worst_equations(system, work)}")


def _open(system, scratch: Scratch, rows: dict[str, np.ndarray], k: int, span: float) -> np.ndarray | bool:
    """Return which equations stay open at a row, (ng,); or False if none does."""
    work, state = scratch
    state.q[:], state.u[:] = rows["q"][k], rows["u"][k]
    program = system.program
    if not direct(system, _equations_alone)(program, work, state, float(rows["t"][k]), system.gaps):
        return False
    least, of_places = OPEN * system.gaps, program.equation_level == 0
    if not of_places.all():
        least = np.where(of_places, least, SLIPS * _speeds(system, work, span))
    return np.abs(work.equations["g"]) > least


@kernel
def _equations_alone(program, work, storage, t, gaps):
    """Evaluate signals, markers and equations, and no forces; return whether any may be open: of places by its gap, of
    velocities at all.
    """
    state = State(t, storage.q, storage.u, storage.a, storage.lam, storage.signals)
    sample_signals(t, program.signals, state.signals)
    run_kernels(program.place, 0, program, state, work)
    run_kernels(program.equations, len(program.inertia), program, state, work)
    may_be = False
    for i in range(len(gaps)):
        may_be |= program.equation_level[i] != 0 or abs(work.equations[i].g) > OPEN * gaps[i]
    return may_be


def _speeds(system, work: Any, span: float) -> np.ndarray:
    """Return how large the residual of each equation would be if nothing held the velocities that it has, (ng,)."""
    legs, markers = work.legs, work.markers
    slow, size = SLOW / span if span > 0.0 else 0.0, np.zeros(len(legs))
    for name, gradient, least in (
        ("v", legs["gradient"][:, :3], slow * system.lengths.whole),
        ("w", legs["gradient"][:, 3:], slow),
    ):
        speed = markers[name][legs["marker"]]
        size += np.abs(np.sum(gradient * speed, axis=1))
        size += np.linalg.norm(gradient, axis=1) * (ACROSS * np.linalg.norm(speed, axis=1) + least)
    found = np.zeros(system.ng)
    np.add.at(found, legs["equation"], size)
    return found
