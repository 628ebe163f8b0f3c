"""`Release`: a joint or force breaks."""

from __future__ import annotations

from dataclasses import dataclass, replace

from flexmb.errors import ModelError, did_you_mean, listed
from flexmb.events.event import Action

__all__ = ["Release", "without_dependents"]


def _refers(part, names: set[str]) -> bool:
    """Does the part name one of the joints, forces or sensors?"""
    references = [getattr(part, field, None) for field in ("joint", "force", "sensor")]
    references += getattr(part, "joints", ()) or ()
    return any(r in names for r in references if isinstance(r, str))


def without_dependents(model, name: str):
    """Return the model without a part, and without what refers to it: drives, couplers, friction, sensors, events."""
    gone = {name}
    while True:
        more = {
            p.name
            for family in (model.joints, model.forces, model.sensors, model.events)
            for p in family
            if p.name not in gone and _refers(p, gone)
        }
        if not more:
            break
        gone |= more
    families = ("joints", "forces", "sensors", "events")
    return replace(model, **{f: tuple(p for p in getattr(model, f) if p.name not in gone) for f in families})


@dataclass(frozen=True)
class Release(Action):
    """Remove a joint or force (a strut breaks, a shaft ruptures); drives and sensors of it go with it.

    Parameters
    ----------
    part : str
        Name of the joint or force.
    """

    part: str

    def check(self, model, asker: str) -> None:
        """Raise ModelError if there is no such joint or force."""
        known = [p.name for p in (*model.joints, *model.forces)]
        if self.part not in known:
            raise ModelError(
                asker,
                found=f"there is no joint or force '{self.part}' to release",
                expected=f"One of: {listed(self.part, known)}",
                remedy=did_you_mean(self.part, known) or "Correct the name",
            )

    def apply(self, model, series):
        """Return the model without the part."""
        return without_dependents(model, self.part)
