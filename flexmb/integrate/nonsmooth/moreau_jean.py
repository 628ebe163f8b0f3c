"""`MoreauJean`: time stepping over impacts and friction, all impulses of a step found together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.integrate.alpha.world_translation import frames_in_world_axes
from flexmb.integrate.motion import run_samples
from flexmb.integrate.nonsmooth.step import Stepper
from flexmb.integrate.runs.added_error import AddedError
from flexmb.integrate.runs.gap import added_error
from flexmb.integrate.runs.outcome import Outcome
from flexmb.model.described import Described, is_number

__all__ = ["MoreauJean"]


@dataclass(frozen=True, kw_only=True)
class MoreauJean(metaclass=Described):
    """Time stepping of Moreau and Jean with projection: for `Rigid` contacts, any number of which may strike at once.

    Steps do not stop at impacts. An impact acts at the middle of its step, so its time is known to half a step, and the
    motion after it to the first order of the step. Between impacts the method is the midpoint rule, of second order,
    implicit in springs and modes. Joints are closed exactly at the end of every step, positions and velocities.
    Steps end where compliant contacts begin, and are divided there until none changes the speed of an impact by more
    than a tenth: their rebounds are resolved whatever the step. Accelerations, reactions and contact forces of a sample
    are means over the step that ends there; an impact of impulse P shows as the force P / step. Theory: nonsmooth.

    Parameters
    ----------
    step : float, s
        The longest step. Steps are shortened to end at samples, and at compliant contacts.
    tolerance : float, -
        What contacts may miss their laws by, relative to the velocity that they have to change in the step. A step
        in which it is not reached ends the run.
    sweeps : int
        Most sweeps over all contacts in a step.
    follow_errors : bool
        Follow what the errors of the steps add up to, until something touches, and warn of it. It costs half as much
        again.

    Source: Moreau 1988; Jean 1999; Acary 2013 (projection); Alart & Curnier 1991 (contacts).
    """

    step: float
    tolerance: float = 1e-8
    sweeps: int = 5000
    follow_errors: bool = True
    impulsive: ClassVar[bool] = True
    """Does it follow laws with impulses?"""
    divides: ClassVar[bool] = True
    """Does it divide steps by itself, so that a divided one needs no warning?"""

    def __post_init__(self):
        for name in ("step", "tolerance", "sweeps"):
            value = getattr(self, name)
            if not (is_number(value) and value > 0.0) or (name == "sweeps" and value != int(value)):
                raise ModelError(
                    "MoreauJean",
                    found=f"{name} = {value!r}",
                    expected="a positive whole number" if name == "sweeps" else "a positive number",
                    remedy="Write MoreauJean(step=1e-4); impacts are known to half a step",
                )

    def start(self, system, state, work, t_end: float) -> Any:
        """Return the method at the start."""
        duration = max(t_end - state.t, self.step)
        return Stepper(self, system, state, work, frames_in_world_axes(system), duration)

    def run(
        self, system, work, variables: Stepper, samples: np.ndarray, first: int, last: int, patience: float = np.inf
    ) -> Outcome:
        """Integrate through samples[first:last] and return the rows and why it ended; after `patience` seconds those
        so far, to be called again from the next."""
        return run_samples(variables, system, samples, first, last, patience)

    def jumped(self, system, work, variables: Stepper) -> bool:
        """Go on after a jump of the loads; return if it can."""
        variables.doubled.catch_up()
        return True

    @staticmethod
    def goes_on_telling(before: Stepper, variables: Stepper) -> None:
        """Take over what is told of a phase, where the method begins anew within it."""
        variables.made_by_impacts += before.made_by_impacts
        variables.lateness.goes_on_from(before.lateness)

    @staticmethod
    def taken_over(system, before: Stepper, variables: Stepper) -> Stepper:
        """Return the variables of a new start with what the errors of the steps before have added up to."""
        variables.doubled.goes_on_from(before.doubled, before, variables)
        return variables

    def added_error(self, system, variables: Stepper) -> AddedError | None:
        """Return what the errors of the steps have added up to so far; None if they are not followed."""
        follows = self.follow_errors and variables.doubled.known
        return added_error(system, variables.doubled.gap[0]) if follows else None

    @staticmethod
    def notes_of_reactions(system, variables: Stepper) -> list[str]:
        """Return the note about a reaction that steps tell late, if there is one."""
        return variables.lateness.notes(system, variables.present())

    @staticmethod
    def statistics(variables: Stepper) -> dict[str, Any]:
        """Return the numbers of the run."""
        return dict(variables.counts)
