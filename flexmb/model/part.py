"""What every part of a model has: a name, fields that can be replaced, and a check against the model."""

from __future__ import annotations

import re
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar

from flexmb.errors import ModelError, did_you_mean
from flexmb.model.described import Described, check_flags, is_number

__all__ = ["LONGEST", "Part"]

LONGEST = 1000
"""Characters of a name: it is in messages, tables and files."""
CONTROLS = re.compile(r"[\x00-\x1f\x7f-\x9f]")
"""Characters that end a line or steer a terminal."""


@dataclass(frozen=True, eq=False)
class Part(metaclass=Described):
    """Anything with a name in a model."""

    name: str

    family: ClassVar[str] = "Part"

    @property
    def title(self) -> str:
        """Family and name, as messages use them: "Joint 'strut_2'"."""
        return f"{self.family} '{self.name}'"

    def __post_init__(self):
        if not isinstance(self.name, str) or not self.name or "." in self.name:
            raise ModelError(
                self.family,
                found=f"name {self.name!r}",
                expected="a non-empty text without dots",
                remedy="Dots separate body and marker: 'crank.A'",
            )
        if len(self.name) > LONGEST or CONTROLS.search(self.name):
            raise ModelError(
                self.family,
                found=f"name {self.name!r:.60}{'...' * (len(self.name) > LONGEST)}",
                expected=f"at most {LONGEST} characters, none that ends a line or steers a terminal",
                remedy="Leave out line ends, tabs and control characters, or choose a shorter name",
            )
        check_flags(self)

    def require_positive(self, *names: str, zero: bool = False) -> None:
        """Raise ModelError if a field is not a positive (or, with `zero`, non-negative) finite number."""
        for name in names:
            value = getattr(self, name)
            if not is_number(value) or value < 0.0 or (value == 0.0 and not zero):
                raise ModelError(
                    self.title,
                    found=f"{name} = {value!r}",
                    expected="a number " + (">= 0" if zero else "> 0") + " in SI units",
                    remedy=f"Give {name} a value in kg, m, s, N",
                )

    def fields(self) -> dict[str, Any]:
        """Return the fields by name, as given."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def replaced(self, **values: Any):
        """Return the part with fields replaced; ModelError for an unknown field."""
        known = self.fields()
        for name in values:
            if name not in known:
                raise ModelError(
                    self.title,
                    found=f"there is no field '{name}'",
                    expected=f"{type(self).__name__} has: {', '.join(known)}",
                    remedy=did_you_mean(name, known) or "Correct the field's name",
                )
        return replace(self, **values)

    def check(self, model) -> None:
        """Raise ModelError if the part refers to something that `model` does not have."""
