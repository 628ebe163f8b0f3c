"""Runs of models that differ in numbers only: what the first one has shown is not found out again."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from flexmb.errors import ModelError
from flexmb.integrate.impulsive import require_method
from flexmb.integrate.runs.ahead_of_run import compile_ahead_of_run
from flexmb.integrate.runs.simulate import chosen_integrator, run_assembled, sample_times, state_at
from flexmb.model.block import Block
from flexmb.model.methods import require_time_limit
from flexmb.model.model import Model
from flexmb.model.orbit import require_orbit
from flexmb.results import Solution
from flexmb.system import assemble, assemble_as_drawn
from flexmb.system.alike import Alikes
from flexmb.system.branching import require_motion_to_begin
from flexmb.told import listening

__all__ = ["Family"]


class Family:
    """Simulates variants of one mechanism in this process, with the digits of `simulate`.

    Between samples no Python runs, so several threads that ask for solutions keep as many cores busy.
    """

    def __init__(self):
        self._alikes = Alikes()

    def solution(
        self,
        model: Model,
        t_end: float,
        *,
        integrator: Any = None,
        samples: Any = 201,
        start: Any = None,
        progress: Callable[[float, float], None] | None = None,
        time_limit: float | None = None,
    ) -> Solution:
        """Return the motion of a variant; arguments and errors as in `simulate`.

        Raises
        ------
        ModelError
            The integrator takes its steps in Python, or the model calls functions of the user.
        """
        integrator = chosen_integrator(model, integrator, None)
        if not (getattr(integrator, "in_kernels", False) or getattr(integrator, "in_threads", False)):
            raise ModelError(
                "sweep, engine 'compiled'",
                found=f"integrator = {integrator!r}, whose steps are Python's",
                expected="GeneralizedAlpha(...), Implicit(...), IDA(...), or Explicit(...) by DOP853 with Augmented() "
                "or Recursive()",
                remedy="Give one of these, or leave out the engine to compute the variants on processes",
            )
        _require_no_python(model)
        require_method(model, integrator, "sweep")
        require_time_limit(time_limit, "sweep")
        times = sample_times(0.0, t_end, samples)
        require_orbit(model, float(times[-1]))
        clock, told, heard = time.perf_counter(), [], []
        assembled = self._alikes.assembled(model, 0.0) if start is None else None
        if assembled is None:
            compile_ahead_of_run(model, integrator)
            state = None if start is None else state_at(start, model, 0.0)
            with listening() as heard:
                assembled = (
                    assemble_as_drawn(model, tell=told.extend) if state is None else assemble(model, t=0.0, state=state)
                )
            told += require_motion_to_begin(*assembled, assembled[0].workspace())
            if not (told or heard):  # of the next one it would not be said
                self._alikes.note(assembled[0])
        return run_assembled(
            integrator,
            assembled,
            times,
            told,
            clock,
            progress=progress,
            regular=True,
            time_limit=time_limit,
            heard=heard,
        )


def _require_no_python(model: Model) -> None:
    """Raise ModelError for a part that calls a function of the user."""
    for part in (*model.joints, *model.forces, *model.sensors):
        for found in _described(part):
            if getattr(found, "imports", ()):
                raise ModelError(
                    part.title,
                    found=f"{type(found).__name__} calls a function of Python, which one thread at a time can do",
                    expected="parts without functions of the user, for the engine 'compiled'",
                    remedy="Leave out the engine to compute the variants on processes",
                )


def _described(part: Any) -> Iterator[Any]:
    """Yield a description and, once each, all descriptions in its fields, and in the rates of blocks."""
    waiting: list[Any] = [part]
    seen: dict[int, Any] = {}
    while waiting:
        value = waiting.pop()
        if isinstance(value, Mapping):
            waiting += value.values()
        elif isinstance(value, tuple | list):
            waiting += value
        elif hasattr(value, "__dataclass_fields__") and id(value) not in seen:
            seen[id(value)] = value  # kept, so that no other gets its number
            yield value
            waiting += getattr(value, "__dict__", {}).values()
            waiting += value.rates() if isinstance(value, Block) else ()
