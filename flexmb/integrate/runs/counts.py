"""Numbers of an integrator over several starts: counts add up, the largest and most are the greatest, the fewest least.

How matrices are factorised is told of every model between events, each way once. Any other word in the place of a
number, of what is not known of one part, holds for all.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flexmb.math.block_pattern import elimination

__all__ = ["numbers_of", "together"]

GREATEST, LEAST = ("most ", "largest "), ("fewest ",)
WAYS, THEN = "elimination", "; then "
"""Name of the ways in which matrices are factorised, and what joins them."""


def together(before: Mapping[str, Any], after: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers of two parts of a run added up."""
    found = dict(before)
    for name, number in after.items():
        known = before.get(name, 0)
        if isinstance(number, Mapping):  # by part: the largest
            known = before.get(name, {})
            found[name] = {**known, **{part: max(share, known.get(part, 0.0)) for part, share in number.items()}}
            continue
        if name == WAYS:
            ways = list(dict.fromkeys([*(known.split(THEN) if isinstance(known, str) else []), *number.split(THEN)]))
            found[name] = THEN.join(ways)
            continue
        if isinstance(known, str) or isinstance(number, str):
            found[name] = known if isinstance(known, str) else number
            continue
        if name.startswith(LEAST):
            found[name] = min(before.get(name, number), number)
            continue
        found[name] = max(known, number) if name.startswith(GREATEST) else known + number
    return found


def numbers_of(integrator: Any, system: Any, variables: Any) -> dict[str, Any]:
    """Return the numbers of an integrator, and how it factorises the matrix of a step, if it does."""
    pattern = system.program.pattern
    eliminates = getattr(integrator, "eliminates", False) and len(pattern.order)
    return {**integrator.statistics(variables), **({WAYS: elimination(pattern)} if eliminates else {})}
