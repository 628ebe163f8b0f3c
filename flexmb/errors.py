"""The one exception tree of flexmb, and the form of its messages.

A message has four parts: which part of the model, what was found, what was expected, what to do.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import get_close_matches

__all__ = [
    "YEAR",
    "CompileError",
    "DataFileError",
    "FlexmbError",
    "IntegrationError",
    "MeshError",
    "ModelError",
    "ReductionError",
    "SlowRunWarning",
    "ValidityWarning",
    "caused_by_interrupt",
    "did_you_mean",
    "duration",
    "listed",
]


class FlexmbError(Exception):
    """Something is wrong with the input or the computation; the message says what to do.

    Parameters
    ----------
    part : str
        The thing concerned, with its kind and name: ``"Joint 'strut_2'"``.
    found : str
        What was found, with number, unit and shape.
    expected : str
        What was expected instead.
    remedy : str
        What the user can do now.
    """

    def __init__(self, part: str, *, found: str, expected: str = "", remedy: str = ""):
        self.part, self.found, self.expected, self.remedy = part, found, expected, remedy
        # a fragment such as "a number > 0" is introduced: it would begin in lower case after a full stop
        wanted = expected if not expected or (expected[0].isupper() and ": " in expected) else f"Expected: {expected}"
        sentences = (text.strip().rstrip(".") for text in (found, wanted, remedy))
        body = " ".join(_in_words(text) + ("" if text.endswith("?") else ".") for text in sentences if text)
        super().__init__(f"{_in_words(part)}: {body}")


_NUMBER = re.compile(r"\bnp\.\w+\(([^()]*)\)|\bnp\.(True|False)_")
_ARRAY = re.compile(r"\b(?:array|matrix)\((\[.*?\])(?:, (?:dtype|shape)=(?:[^()]|\([^()]*\))*)?\)", re.DOTALL)
_SINGLE = re.compile(r"\barray\(('[^']*'|[^()\[\],]+)(?:, dtype=[^()]*)?\)")
_CUT = re.compile(r"\barray\((?=[\['])|, dtype=[\w'<>]*")
"""What is left of an array whose text was cut off."""
_OBJECT = re.compile(
    r"<(?:function|built-in function|bound method) (?:\S*\.)?([\w<>]+)(?: of [^<>]*<[^<>]*>| at 0x\w+)?>"
)
_THING = re.compile(r"<(?:\w+\.)*(\w+) object at 0x\w+>")
_CLASS = re.compile(r"<class '(?:\w+\.)*(\w+)'>")


def _in_words(text: str) -> str:
    """Return a text without Python's own way of writing values: what the user gave may be of any kind."""
    if "(" not in text and "<" not in text and "np." not in text:
        return text
    text = _NUMBER.sub(lambda found: found[1] or found[2] or "", text)
    text = _ARRAY.sub(lambda found: " ".join(found[1].split()), text)
    text = _CUT.sub("", _SINGLE.sub(r"\1", text))
    text = _OBJECT.sub(r"the function \1", text).replace("the function <lambda>", "a lambda function")
    return _CLASS.sub(r"the class \1", _THING.sub(r"an object of the class \1", text))


class MeshError(FlexmbError):
    """A mesh or an FE model cannot be used."""


class ReductionError(FlexmbError):
    """An FE model cannot be reduced as asked."""


class DataFileError(FlexmbError):
    """A data file (modal neutral data, solution) is damaged, foreign or of another schema version."""


class ModelError(FlexmbError):
    """A part of the multibody model is described wrongly."""


class CompileError(FlexmbError):
    """The parts are right one by one, but do not fit together: assembly, mobility, drives."""


class IntegrationError(FlexmbError):
    """The integration stopped early; ``solution`` holds what had been computed, or None."""

    def __init__(self, part: str, *, found: str, expected: str = "", remedy: str = "", solution=None):
        super().__init__(part, found=found, expected=expected, remedy=remedy)
        self.solution = solution


class SlowRunWarning(UserWarning):
    """A run will take long; the message says how far it is, how short its steps are, and what is left."""


class ValidityWarning(UserWarning):
    """A result lies outside what the model holds for; the message has numbers and a remedy."""


MOST = 24
"""Longest list of names that a message shows in full."""


def caused_by_interrupt(error: BaseException | None) -> bool:
    """Is there a KeyboardInterrupt among the causes of an error?

    What is raised while an interrupted run is stored is an error of its own: only what Python itself makes of an
    interrupt without a cause, SystemError, is followed through its context.
    """
    while error is not None and not isinstance(error, KeyboardInterrupt):
        apart = isinstance(error, (RuntimeError, ImportError))
        error = error.__cause__ if apart else error.__cause__ or error.__context__
    return error is not None


def listed(name: str, known: Iterable[str]) -> str:
    """Return the known names separated by commas, of very many the dozen that are most like `name`; "none" of none."""
    names = list(known)
    if len(names) <= MOST:
        return ", ".join(names) or "none"
    near = get_close_matches(str(name), names, n=MOST // 2, cutoff=0.0)
    return f"{', '.join(near)}, ... ({len(names)} in all)"


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return "Did you mean 'x'?" for the known name nearest to `name`, or "" if none is near."""
    near = get_close_matches(str(name), [str(one) for one in known], n=1, cutoff=0.6)
    return f"Did you mean '{near[0]}'?" if near else ""


YEAR = 3.15e7
"""s"""


def duration(seconds: float) -> str:
    """Return "0.52 s", "40 s", "3 min 20 s", "2 h 5 min", "3.2 days", "14 years", "countless years" (infinite)."""
    if not seconds < 1e6 * YEAR:
        return "countless years"
    for unit, size in (("years", YEAR), ("days", 86400.0)):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.3g} {unit}"
    whole = round(seconds)
    if whole < 120:
        return f"{seconds:.2g} s" if seconds < 10.0 else f"{whole} s"
    return f"{whole // 60} min {whole % 60} s" if whole < 3600 else f"{whole // 3600} h {whole % 3600 // 60} min"
