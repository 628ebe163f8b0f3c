"""Units as products of the base units of SI, as FMI has them."""

from __future__ import annotations

import re

__all__ = ["base_units"]

DERIVED = {
    "m": {"m": 1},
    "s": {"s": 1},
    "kg": {"kg": 1},
    "rad": {"rad": 1},
    "Hz": {"s": -1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "1": {},
    "-": {},
}


def base_units(unit: str) -> dict[str, int] | None:
    """Return the exponents of the base units of a text like "N m", "m/s2"; None if it is not understood.

    Examples
    --------
    >>> base_units("N m")
    {'kg': 1, 'm': 2, 's': -2}
    >>> base_units("rad/s2")
    {'rad': 1, 's': -2}
    """
    found: dict[str, int] = {}
    above, _, below = unit.partition("/")
    for text, sign in ((above, 1), (below, -1)):
        for part in text.split():
            parsed = re.fullmatch(r"([A-Za-z]+|1|-)(\d?)", part)
            if parsed is None or parsed[1] not in DERIVED:
                return None
            for base, exponent in DERIVED[parsed[1]].items():
                found[base] = found.get(base, 0) + sign * exponent * int(parsed[2] or 1)
    return {base: exponent for base, exponent in found.items() if exponent}
