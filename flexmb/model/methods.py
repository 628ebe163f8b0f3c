"""What an integrator and a formulation of the equations of motion must provide."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import is_number

__all__ = ["Formulation", "Integrator", "is_formulation", "is_integrator", "require_time_limit"]


@runtime_checkable
class Integrator(Protocol):
    """Frozen settings of a method; what changes in a run is made by `start`."""

    def start(self, system, state, work, t_end: float) -> Any:
        """Return the variables of a run that begins at a consistent state and shall go to t_end."""

    def run(self, system, work, variables, samples: np.ndarray, first: int, last: int, patience: float = ...) -> Any:
        """Go on through samples[first:last]; return an `Outcome`, rows and why it ended."""

    def statistics(self, variables) -> dict[str, Any]:
        """Return the numbers of the run by name."""


@runtime_checkable
class Formulation(Protocol):
    """A way to find accelerations."""

    compiled: bool
    """Do the compiled steps of `Explicit` have it for the coordinates of all bodies?"""
    closed: bool
    """Do they have it in closed form, where forces of constraints are A^T lam?"""
    unknowns: Callable[..., Any] | None
    """(system, state, work) -> the coordinates it integrates (`RelativeUnknowns`); None: coordinates of all bodies."""

    def accelerate(self, system, state, work) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations (nu,) and multipliers (ng,) at a state; its own are ignored."""


def is_integrator(value: Any) -> bool:
    """Is it an integrator, made and not only named?"""
    return not isinstance(value, type) and isinstance(value, Integrator)


def is_formulation(value: Any) -> bool:
    """Is it a formulation, made and not only named?"""
    return not isinstance(value, type) and isinstance(value, Formulation)


def require_time_limit(limit: float | None, part: str) -> None:
    """Raise ModelError unless a limit of time is None or a positive number."""
    if limit is not None and not (is_number(limit) and limit > 0.0):
        raise ModelError(
            part,
            found=f"time_limit = {limit!r}",
            expected="a positive number of seconds, or nothing",
            remedy="Leave it out for a run without a limit",
        )
