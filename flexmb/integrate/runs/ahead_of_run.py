"""What a run will need of kernels: those that are missing are compiled ahead, in other processes."""

from __future__ import annotations

from typing import Any

from flexmb.integrate.runs.kept_switches import keep_switches
from flexmb.integrate.runs.switches import allowed, part_of_step
from flexmb.math.ahead import compile_ahead
from flexmb.math.jets import run_program
from flexmb.model.signal import Signal

__all__ = ["compile_ahead_of_run", "ready_for_kinks"]


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
    return compile_ahead(getattr(integrator, "entries", ()), getattr(integrator, "parts", ()), needed)


def ready_for_kinks(system: Any) -> None:
    """Make ready what runs of a system with kinks call: one that waits for the compiler in its steps looks slow."""
    if len(system.switch_owners):
        for called in (allowed, keep_switches):
            called.ready()
