"""Why a run ended early, and what it may have missed: sentences for its user."""

from __future__ import annotations

import numpy as np

from flexmb.errors import IntegrationError
from flexmb.integrate.runs.runaway import REMEDY as REMEDY_OF_RUNAWAY
from flexmb.integrate.runs.unknown_value import REMEDY as REMEDY_OF_VALUES
from flexmb.model.model import Model
from flexmb.results import Status

__all__ = ["LASTING", "divided_steps", "failed_with", "missed_times", "require_end"]

LASTING = (
    "Bodies that stay in contact after bouncing need a force of contact: use Contact or OneSidedSpring; or end "
    "the run by an event with Stop"
)
"""Remedy for impacts that come closer and closer."""


def missed_times(system, times: np.ndarray) -> list[str]:
    """Return the sentences about signals of which not all jumps and pulses were found."""
    titles = dict.fromkeys(
        system.signal_times.titles[k] for k in system.signal_times.between(times[0], times[-1]).missed
    )
    return [
        f"{title} has a signal that changes too often between t = {times[0]:.6g} s and {times[-1]:.6g} s to find all "
        "its jumps and pulses; expected: times that can be found in advance, at which steps end. Steps may pass over "
        "a pulse: limit the integrator's step to the shortest pulse that matters, or give a shorter t_end."
        for title in titles
    ]


def divided_steps(integrator, statistics, t: float) -> list[str]:
    """Return the sentence about steps of fixed size that could not be taken as they are, until `t`, s."""
    step = getattr(integrator, "step", None)
    count = sum(statistics.get(name, 0) for name in ("rejected by iteration", "cut at contacts"))
    if step is None or not count or getattr(integrator, "divides", False):
        return []
    return [
        f"{type(integrator).__name__}: steps of the given size, {step:g} s, were divided {count} times until "
        f"t = {t:.6g} s, where the iteration did not converge or a contact would have been passed; expected: "
        "steps of one size. Give a smaller step, or leave it out: the step then follows the error."
    ]


def failed_with(model: Model, outcome, unknown: str | None, gone: str | None = None) -> Status:
    """Return how the run ended; an error in the function of a force is the cause and comes first.

    A force or drive without a value explains the failure too, and a motion that has grown without bound.
    """
    parts = [part for part in (*model.forces, *model.joints) if hasattr(part, "complaint")]
    told = [f"{part.title}: {part.complaint()}" for part in parts if part.complaint()]
    if not told and unknown:
        return Status.failed(f"{unknown}; {outcome.failure}", REMEDY_OF_VALUES)
    if not told and gone:
        return Status.failed(f"{gone}; {outcome.failure}", REMEDY_OF_RUNAWAY)
    if not told:
        return Status.failed(outcome.failure, outcome.remedy)
    return Status.failed(f"{'; '.join(told)}; {outcome.failure}", "Correct the function of the force")


def require_end(status: Status, model: Model, solution) -> None:
    """Raise IntegrationError, with what was computed, if a run has failed."""
    if status.kind == "failed":
        raise IntegrationError(
            f"Model '{model.name}'",
            found=status.message,
            expected="a motion that the integrator can follow",
            remedy=status.remedy,
            solution=solution,
        )
