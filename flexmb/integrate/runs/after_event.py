"""The system after an event; where the event has taken away what another part needs, the message says so."""

from __future__ import annotations

from typing import Any

from flexmb.errors import CompileError, ModelError
from flexmb.model.model import FAMILIES
from flexmb.system import assemble

__all__ = ["assembled_after"]


def assembled_after(event, before, following, t: float, state):
    """Return system and consistent state of the model `following` an event at t, s, that changed the model `before`.

    Raises
    ------
    ModelError, CompileError
        The model after the event is wrong: a controller measures a joint that the event has removed. The message names
        the event, and what it has removed.
    """
    try:
        return assemble(following, t=t, state=state)
    except (ModelError, CompileError) as error:
        removed = _removed(event, before, following)
        titles = [part.title for part in removed]
        what = f", which has removed {', '.join(titles)}" if removed else ""
        lacks = any(f"'{part.name}" in f"{error.part} {error.found}" for part in removed)
        raise type(error)(
            error.part,
            found=f"after {event.title}{what}: {error.found}",
            expected=error.expected,
            remedy="Let the same event release or change what needs it, or end the run there with Stop"
            if lacks
            else error.remedy,
        ) from None


def _removed(event, before, following) -> list[Any]:
    """Return the parts that an event has removed, but for the event itself."""
    return [
        part
        for family in FAMILIES
        for part in getattr(before, family)
        if part.name != event.name and all(part.name != left.name for left in getattr(following, family))
    ]
