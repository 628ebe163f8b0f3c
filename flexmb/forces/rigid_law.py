"""`Rigid`: the law of bodies that do not give way, Signorini and Coulomb with Newton's or Poisson's restitution."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

from flexmb.errors import ModelError, did_you_mean
from flexmb.forces.contact_laws import ContactLaw

__all__ = ["Rigid"]

RULES = ("Newton", "Poisson")


@dataclass(frozen=True, eq=False)
class Rigid(ContactLaw):
    """Surfaces that never enter each other, eqs. (signorini, coulomb): impulses at impacts, forces while they touch.

    For `MoreauJean`; the other integrators cannot have jumps of velocities in their steps and refuse it.

    Parameters
    ----------
    restitution : float, -
        e, 0 to 1: of the velocities or of the impulses.
    rule : "Newton" or "Poisson"
        e is the normal velocity after an impact over that before, eq. (impact-law), or the impulse of expansion over
        of compression, eq. (poisson-law). Both agree for one impact without friction. Newton's law has no
        solution where a body is held from behind; a step where that is found follows Poisson's.
    friction : float, -
        mu of Coulomb: a round cone. What sticks does not creep.
    drilling : float, m
        Largest moment against spin about the normal, over the normal force: 2/3 mu R of a disc with even pressure.
    rolling : float, m
        Largest moment against rolling, over the normal force.

    Source: Moreau 1988 (law); Acary & Brogliato 2008, chapters 3 and 10; Glocker & Pfeiffer 1995 (Poisson).
    """

    _: KW_ONLY
    restitution: float = 0.0
    friction: float = 0.0
    drilling: float = 0.0
    rolling: float = 0.0
    rule: str = "Newton"

    code: ClassVar[int] = 2
    impulsive: ClassVar[bool] = True

    def __post_init__(self):
        self._require("restitution", "friction", "drilling", "rolling", zero=True)
        if not self.restitution <= 1.0:
            raise ModelError(
                "Rigid",
                found=f"restitution = {self.restitution!r}",
                expected="0 <= restitution <= 1: an impact makes no energy",
                remedy="Give the ratio of the speeds after and before, as 0.8 for steel on steel",
            )

        if self.rule not in RULES:
            raise ModelError(
                "Rigid",
                found=f"rule = {self.rule!r}",
                expected=f"One of: {', '.join(RULES)}",
                remedy=did_you_mean(str(self.rule), RULES) or "Leave it out for Newton's law",
            )

    def numbers(self) -> dict[str, float]:
        """Return the numbers of the row that compliant laws have as well."""
        given = {"stiffness": 0.0, "exponent": 1.0, "damping": 0.0, "transition": 1.0}
        return {**given, "friction": self.friction, "restitution": self.restitution}
