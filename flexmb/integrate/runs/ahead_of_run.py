"""What a run will need of kernels: those that are missing are compiled ahead, in other processes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from flexmb.integrate.runs.kept_switches import keep_switches
from flexmb.integrate.runs.switches import allowed, part_of_step
from flexmb.math.ahead import compile_ahead
from flexmb.math.jets import run_program
from flexmb.model.signal import Signal
from flexmb.system.observe import observe_samples
from flexmb.system.program import row_kernels

__all__ = ["compile_ahead_of_kinds", "compile_ahead_of_run", "ready_for_kinks"]


def compile_ahead_of_run(model: Any, integrator: Any) -> int:
    """Compile the kernels of an integrator in other processes, and of those on demand what a model shows that it needs.

    Returns
    -------
    int
        The number of processes that were started.
    """
    parts = *model.bodies, *model.joints, *model.forces
    needed = []
    if any(isinstance(value, Signal) for part in parts for value in vars(part).values()):
        needed.append(run_program)
    if any(getattr(getattr(part, "table", None), "switches", 0) for part in parts):
        needed += [allowed, keep_switches, part_of_step]
    equations = (equation for joint in model.joints for equation in joint.equations_in(model))
    rows = row_kernels(part.table for part in (*model.bodies, *equations, *model.forces))
    return compile_ahead(getattr(integrator, "entries", ()), getattr(integrator, "parts", ()), needed, rows)


def compile_ahead_of_kinds(kinds: Iterable[Any], integrator: Any) -> int:
    """Compile what a run with sensors of reactions needs in other processes, where its model is not there yet.

    Parameters
    ----------
    kinds : iterable of kinds of bodies, primitive equations and forces
    integrator : integrator, or its class

    Returns
    -------
    int
        The number of processes that were started. As this one is busy with something else, they go through the
        kernels in the order of its calls.
    """
    rows = row_kernels(kind.table for kind in kinds)
    parts = run_program, *rows, *getattr(integrator, "parts", ())
    return compile_ahead(getattr(integrator, "entries", ()), parts, [run_program, observe_samples], rows)


def ready_for_kinks(system: Any) -> None:
    """Make ready what runs of a system with kinks call: one that waits for the compiler in its steps looks slow."""
    if len(system.switch_owners):
        for called in (allowed, keep_switches):
            called.ready()
