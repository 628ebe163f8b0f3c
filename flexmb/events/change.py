"""`Change`: a part gets other parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from flexmb.events.event import Action

__all__ = ["Change"]


@dataclass(frozen=True, init=False)
class Change(Action):
    """Replace fields of a part: ``Change("motor", angle=...)``.

    Parameters
    ----------
    part : str
    values : fields and their new values
    """

    part: str
    values: Mapping[str, Any] = field(default_factory=dict)

    def __init__(self, part: str, **values: Any):
        object.__setattr__(self, "part", part)
        object.__setattr__(self, "values", values)

    def check(self, model, asker: str) -> None:
        """Raise ModelError if the part or field does not exist, or the value is not allowed."""
        replace(model, events=()).changed(self.part, **self.values)  # with its events it would check this one again

    def apply(self, model, series):
        """Return the model with the part changed."""
        return model.changed(self.part, **self.values)
