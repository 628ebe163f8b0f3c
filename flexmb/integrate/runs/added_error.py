"""What the errors of the steps of a run have added up to, and the words for it.

Each step is as accurate as its tolerance, but errors add up, and a sensitive motion lets them grow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from flexmb.integrate.runs.counts import together
from flexmb.integrate.runs.reaction_errors import OF_REACTIONS, smaller, unresolved

__all__ = ["ADDED_UP", "UNKNOWN", "AddedError", "is_of_a_pole", "started_again", "tell_of", "told_of"]

SHARE = 0.05
"""Of the largest motion, from which on a run warns."""
ADDED_UP = "errors added up"
"""Name in the statistics: the largest share."""
UNKNOWN = "not estimated"
"""There, where an integrator does not tell."""
TOO_LONG = (
    "what the errors of steps add up to is not known: something swings, turns, grows or dies away within less than a "
    "step, which steps do not follow. If it matters to what you look at, give a smaller rtol or step; flexmb.verify "
    "compares"
)

TO_A_POLE = (
    "what the errors of steps add up to is not estimated: the last steps went towards a time at which a force or a "
    "drive has no value"
)

NOT_SHARED_ALIKE = (
    "how well steps resolve reactions is not estimated where equations depend on each other: steps share multipliers "
    "among them otherwise than samples do. Where single values of them matter, compare with IDA, or make the equations "
    "independent: see flexmb.check"
)


@dataclass(frozen=True, kw_only=True)
class AddedError:
    """An estimate of the error of a motion.

    Parameters
    ----------
    share : float, -
        The largest error until now, relative to the largest motion: of displacements or of rotations.
    error, motion : float, m or rad
    unit : str
    t : float, s
        When it was largest.
    owner : str
        What has this error.
    lost : bool
        It grew so much that it was not followed any further.
    blind : bool
        Something has touched: all of this is about the time before, what errors add up to later is not known.
    unsure : bool
        Errors grow by themselves: it is known to an order of magnitude, and told as it may be.
    """

    share: float
    error: float
    motion: float
    unit: str
    t: float
    owner: str
    lost: bool
    blind: bool
    unsure: bool = False

    def sentences(self, integrator: Any) -> list[str]:
        """Return the warning, if the share is too large."""
        if not self.share > SHARE:
            return []
        less = smaller(integrator)
        more = "and more later" if self.lost else "the most until something touched" if self.blind else "at the most"
        until = " until then" if self.lost else ""
        have = "grow by themselves, and may have added up to" if self.unsure else "have added up to about"
        return [
            f"{type(integrator).__name__}: the errors of its steps {have} {self.error:.2g} {self.unit} "
            f"of {self.owner} at t = {self.t:.4g} s, {more}; that is {100.0 * self.share:.2g} % of the largest motion"
            f"{until}; expected: less than {100.0 * SHARE:g} %. Give {less}, or compare with another integrator; a "
            "motion that lets small disturbances grow has no course that holds for long: see flexmb.verify."
        ]

    @property
    def number(self) -> float | str:
        """What stands in the statistics: the share, or that it is not known."""
        return UNKNOWN if self.blind else self.share

    def notes(self) -> list[str]:
        """Return what the estimate leaves out."""
        if not self.blind:
            return []
        return [
            "what the errors of steps add up to is not known where something touches, nor after it; from there on the "
            "balance of energy alone is watched. flexmb.verify compares with other runs"
        ]


def told_of(integrator: Any, system: Any, variables: Any) -> AddedError | None:
    """Return what the errors of an integrator's steps have added up to, if it says so."""
    estimate = getattr(integrator, "added_error", None)
    return None if estimate is None or not system.nu else estimate(system, variables)


def is_of_a_pole(error: AddedError, lost: float | None) -> bool:
    """Is an error that of the steps towards the time from which on a force has no value? They go beside it or over it,
    and what they are wrong by says nothing about the samples, which end before.
    """
    return lost is not None and error.t > lost


def started_again(integrator: Any, before: Any, start: Sequence[Any], within: bool = False) -> Any:
    """Return the variables of an integrator that starts, at (system, state, work, t_end), where it has been at work.

    `within` a phase, what is told at its end goes on too.
    """
    variables = integrator.start(*start)
    if before is None:
        return variables
    if within and hasattr(integrator, "goes_on_telling"):
        integrator.goes_on_telling(before, variables)
    return integrator.taken_over(start[0], before, variables) if hasattr(integrator, "taken_over") else variables


def tell_of(
    integrator: Any,
    system: Any,
    variables: Any,
    statistics: dict[str, Any],
    validity: Any,
    *,
    lost: float | None = None,
) -> None:
    """Write the largest share to the statistics of a run, and give its warning and note.

    `lost` is the time, s, of the last sample before a force or drive has no value any more.
    """
    error = told_of(integrator, system, variables)
    if error is not None and is_of_a_pole(error, lost):
        statistics[ADDED_UP] = UNKNOWN
        validity.note([TO_A_POLE])
        return
    if error is None and getattr(integrator, "follow_errors", True) and system.nu:
        statistics[ADDED_UP] = UNKNOWN
        validity.note([TOO_LONG] if hasattr(integrator, "added_error") else [])
    if hasattr(integrator, "notes_of_reactions") and system.nu:
        validity.note(integrator.notes_of_reactions(system, variables))
    if error is None:
        return
    before = statistics.get(ADDED_UP, 0.0)
    statistics[ADDED_UP] = UNKNOWN if UNKNOWN in (before, error.number) else max(error.share, before)
    validity.tell(error.sentences(integrator))
    if hasattr(integrator, "reaction_errors"):
        shares = integrator.reaction_errors(system, variables)
        if shares:
            known = statistics.get(OF_REACTIONS, {})
            statistics[OF_REACTIONS] = together({OF_REACTIONS: known}, {OF_REACTIONS: shares})[OF_REACTIONS]
        if system.redundant and not getattr(integrator, "shares_as_samples", True):
            validity.note([NOT_SHARED_ALIKE])
        if error.share <= SHARE:  # else the motion itself is not followed
            validity.note(unresolved(shares))
    validity.note(error.notes())
