"""Numbers of an integrator over several starts: counts add up, the largest and most are the greatest."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["together"]

GREATEST = ("most ", "largest ")


def together(before: Mapping[str, Any], after: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers of two parts of a run as those of one."""
    found = dict(before)
    for name, number in after.items():
        known = before.get(name, 0)
        found[name] = max(known, number) if name.startswith(GREATEST) else known + number
    return found
