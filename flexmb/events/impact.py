"""`Impact`: two bodies bounce off each other."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

from flexmb.errors import ModelError
from flexmb.events.event import Action
from flexmb.model.described import entries_of

__all__ = ["Impact"]


@dataclass(frozen=True)
class Impact(Action):
    """Let two markers bounce with a coefficient of restitution: velocities jump, positions stay, no time passes.

    Along the direction n from a to b the relative velocity is reversed, ``n.v_ba(after) = -e n.v_ba(before)``, by an
    impulse P at marker b and its opposite on the body of a, without friction. The joints answer with impulses of their
    own, so the whole mechanism takes part and all constraints hold before and after::

        M (u_after - u_before) = G^T Lambda + c P,     G (u_after - u_before) = 0

    with c the generalised force of P = 1. Markers that separate already are left alone. Several impacts at one time
    happen one after the other. Source: Glocker 2001, Newton's law of impact; eq. (impact).

    Parameters
    ----------
    markers : (str, str)
        a and b, "body.marker", the places that touch.
    restitution : float
        e from 0 (plastic) to 1 (elastic).
    along : "x", "y", "z" or None
        Axis of marker a that is normal to the contact, towards b; None: the line from a to b (two balls).
    """

    markers: tuple[str, str]
    _: KW_ONLY
    restitution: float
    along: str | None = None

    strikes: ClassVar[bool] = True

    def __post_init__(self):
        object.__setattr__(self, "markers", entries_of(self.markers))

    def check(self, model, asker: str) -> None:
        """Raise ModelError if a marker does not exist, or the values are out of range."""
        if len(self.markers) != 2 or not all(isinstance(m, str) for m in self.markers):
            raise ModelError(
                asker,
                found=f"Impact with markers = {self.markers!r}",
                expected="two names 'body.marker'",
                remedy="Write Impact(('ground.floor', 'ball.center'), restitution=0.8, along='z')",
            )
        for name in self.markers:
            model.marker(name, asker)
        if not (isinstance(self.restitution, int | float) and 0.0 <= self.restitution <= 1.0):
            raise ModelError(
                asker,
                found=f"restitution = {self.restitution!r}",
                expected="a number from 0 to 1",
                remedy="With 0.8 a ball rises to 64 % of its height",
            )
        if self.along not in ("x", "y", "z", None):
            raise ModelError(
                asker,
                found=f"along = {self.along!r}",
                expected="'x', 'y', 'z' or nothing",
                remedy="Name the axis of the first marker that is normal to the contact",
            )

    def apply(self, model, series):
        """Return the model as it is; the velocities are the integrator's business."""
        return model
