"""How many modes: a number, or as many as an accuracy up to a frequency needs."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from flexmb.errors import ReductionError
from flexmb.model.described import Described, is_number, whole
from flexmb.reduction.basis import NormalModes, available_modes, free_modes, normal_modes, orthonormal_basis
from flexmb.reduction.statics import HeldBody

__all__ = ["HIGHEST", "USUAL", "UpTo", "choose_modes", "parse_modes"]

_NUMBER = r"((?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)"
_PATTERN = re.compile(
    rf"\s*up to\s+{_NUMBER}\s*(k?hz)(?:,?\s+within\s+{_NUMBER}\s*(?:%|percent))?"
    r"(?:\s+of\s+(?:the\s+)?(response|frequencies))?\s*",
    re.IGNORECASE,
)
_UNITS = {"hz": 1.0, "khz": 1e3}
_DEFAULT_ACCURACY = 0.01
HIGHEST = 1e12
"""Hz: no part vibrates at more, and squares of what is far above are no numbers."""
USUAL = "usual"
"""The number of modes that a basis has unless another is given: 12 normal modes."""


@dataclass(frozen=True)
class UpTo(metaclass=Described):
    """Modes as many as an accuracy asks for: of the response, or of the free-free frequencies of the full model.

    Parameters
    ----------
    frequency : float, Hz
        Up to here the accuracy is met.
    accuracy : float, -
        Relative error.
    response : bool
        The response to the loads of the body is met, whatever the basis is. False, for Craig & Bampton's only: the
        free-free frequencies are.
    """

    frequency: float
    accuracy: float = _DEFAULT_ACCURACY
    response: bool = True

    def __post_init__(self):
        if not (is_number(self.frequency) and 0.0 < self.frequency <= HIGHEST):
            raise ReductionError(
                "UpTo",
                found=f"frequency = {self.frequency!r:.80} Hz",
                expected=f"a frequency above 0 and up to {HIGHEST:.0e} Hz",
                remedy="Write UpTo(200.0, 0.01), or modes='up to 200 Hz within 1 %'",
            )
        if not (is_number(self.accuracy) and 0.0 < self.accuracy < 1.0):
            raise ReductionError(
                "UpTo",
                found=f"accuracy = {self.accuracy!r:.80}",
                expected="a relative error above 0 and below 1, which is all of the response: 0.01 for 1 %",
                remedy="Write UpTo(200.0, 0.01), or modes='up to 200 Hz within 1 %'",
            )


def parse_modes(modes: int | str | UpTo) -> int | UpTo | None:
    """Read a mode choice: a count, or text such as ``"up to 200 Hz within 1 %"``; None for the usual number.

    The accuracy is one of the response, unless the text ends with ``"of the frequencies"``.
    """
    modes = whole(modes)
    if isinstance(modes, str) and modes.strip() == USUAL:
        return None
    if isinstance(modes, UpTo):
        return modes
    if isinstance(modes, str):
        match = _PATTERN.fullmatch(modes)
        if match:
            accuracy = float(match[3]) / 100.0 if match[3] else _DEFAULT_ACCURACY
            return UpTo(float(match[1]) * _UNITS[match[2].lower()], accuracy, (match[4] or "").lower() != "frequencies")
    elif isinstance(modes, (int, np.integer)) and not isinstance(modes, bool) and modes >= 0:
        return int(modes)
    raise ReductionError(
        "Reduction",
        found=f"modes = {modes!r}",
        expected="a count, or a text like 'up to 200 Hz within 1 %', or '... within 1 % of the frequencies'",
        remedy="Write modes=12, or modes='up to 200 Hz within 0.5 %'; decimals have a point",
    )


def choose_modes(body: HeldBody, choice: int | UpTo) -> tuple[NormalModes, NormalModes | None]:
    """Return the fixed-interface modes of the choice, and the free-free modes of the full model if they were needed.

    An accuracy is that of the frequencies here.
    """
    if isinstance(choice, int):
        return normal_modes(body, choice), None
    limit = (2.0 * np.pi * choice.frequency) ** 2
    exact = _modes_up_to(lambda count: free_modes(body, count), limit, body.fe.ndof)
    wanted = exact.w2[exact.w2 <= limit]
    count = max(2 * len(wanted), 4)
    while True:
        modes = available_modes(body, count)
        enough = _fewest(body, modes, wanted, choice.accuracy)
        if enough is not None:
            return enough, exact
        if len(modes.w2) < count:  # all there are: exact up to rounding
            return modes, exact
        count *= 2


def _modes_up_to(compute, limit: float, most: int) -> NormalModes:
    count = 8
    while True:
        modes = compute(min(count, most))
        if not len(modes.w2) or modes.w2[-1] > limit or len(modes.w2) < min(count, most) or count >= most:
            return modes
        count *= 2


def _fewest(body: HeldBody, modes: NormalModes, wanted: np.ndarray, accuracy: float) -> NormalModes | None:
    """Return the shortest list of modes that meets the accuracy (bisection: the errors fall with every mode)."""

    def good(count: int) -> bool:
        cut = NormalModes(modes.vectors[:, :count], modes.w2[:count])
        w2 = orthonormal_basis(body, cut, None).w2[: len(wanted)]
        return len(w2) == len(wanted) and bool(np.all(np.sqrt(w2 / wanted) - 1.0 <= accuracy))

    low, high = 0, len(modes.w2)
    if not good(high):
        return None
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if good(middle) else (middle + 1, high)
    return NormalModes(modes.vectors[:, :high], modes.w2[:high])
