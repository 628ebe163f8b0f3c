"""`Verification`: how far a solution can be trusted, as a table that can be printed, stored and read again."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

from flexmb.errors import DataFileError
from flexmb.files import check_regular, text_of, write_text

__all__ = ["Answer", "Check", "Verification"]

VERSION = 1


@dataclass(frozen=True, kw_only=True)
class Check:
    """One measure of the solution itself.

    Parameters
    ----------
    name : str
        What was checked: "equations of motion", "energy", "constraints, position" ...
    share : float
        What was found, relative to the scale of its kind.
    limit : float
        Up to which share the solution is sound.
    worst : str
        Where and when it was found.
    """

    name: str
    share: float
    limit: float
    worst: str = ""

    @property
    def holds(self) -> bool:
        """Is it within its limit?"""
        return self.share <= self.limit


@dataclass(frozen=True, kw_only=True)
class Answer:
    """How an answer changes when the problem is solved in other ways.

    Parameters
    ----------
    name, unit : str
        The sensor, and the unit of the columns that were compared.
    largest : float
        Largest magnitude in the run, in this unit.
    course : mapping of rerun to float
        Largest difference over time of any component, relative to what that component varies by, or to its largest
        value where that is smaller.
    peak : mapping of rerun to float
        Largest difference of the greatest magnitudes of a component, relative to the same.
    within : float
        The requested tolerance, as a share.
    component : str
        The column that is furthest apart.
    scale : float
        What its differences are relative to, in this unit; 0: not known.
    """

    name: str
    unit: str
    largest: float
    course: Mapping[str, float]
    peak: Mapping[str, float]
    within: float
    component: str = ""
    scale: float = 0.0

    @property
    def verdict(self) -> str:
        """What may be relied on, in a sentence."""
        if not self.course:
            return "not compared with any other run"
        worst = max(self.course, key=lambda name: self.course[name])
        bound, how = self.course[worst], f"{_percent(self.course[worst])} by {worst}"
        if bound <= self.within:
            return f"holds: {how} at most"
        highest = max(self.peak, key=lambda name: self.peak[name])
        if self.peak_holds:
            return f"its greatest value holds ({_percent(self.peak[highest])} by {highest}), its course does not: {how}"
        return f"DOES NOT HOLD: {how}"

    @property
    def compared_with(self) -> str:
        """What the shares are relative to, and the component that is furthest apart."""
        own = self.component.removeprefix(self.name).strip()
        return (f"{self.scale:.3g}" + (f" ({own})" if own else "")) if self.scale else "-"

    @property
    def title(self) -> str:
        """Name and unit."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name

    @property
    def peak_holds(self) -> bool:
        """Is its greatest value within the share that is asked for?"""
        return bool(self.peak) and max(self.peak.values()) <= self.within

    @property
    def holds(self) -> bool:
        """Is its whole course within the share that is asked for?"""
        return bool(self.course) and max(self.course.values()) <= self.within


@dataclass(frozen=True, kw_only=True)
class Verification:
    """How far a solution can be trusted: ``print(flexmb.verify(solution))``.

    Parameters
    ----------
    model : str
        Name of the model.
    within : float
        The requested tolerance of the answers, as a share.
    checks : tuple of Check
        Of the solution itself, by methods that the integrator did not use.
    answers : tuple of Answer
        Every sensor, by unit.
    runs : tuple of str
        What the answers were compared with.
    notes : tuple of str
        What could not be checked, and why.
    """

    model: str
    within: float
    checks: tuple[Check, ...] = ()
    answers: tuple[Answer, ...] = ()
    runs: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Do all checks and all answers hold?"""
        return all(check.holds for check in self.checks) and all(answer.holds for answer in self.answers)

    @property
    def verdict(self) -> str:
        """The whole in a sentence."""
        if not self.checks and not self.answers:
            return "nothing could be checked"
        wrong = [check.name for check in self.checks if not check.holds]
        weak = [answer.title for answer in self.answers if not answer.peak_holds]
        part = [answer.title for answer in self.answers if answer.peak_holds and not answer.holds]
        if self.ok:
            held = f"all {len(self.answers)} answers hold within {_percent(self.within)}"
            told = held if self.answers else "the equations hold; the answers were not compared with other runs"
            return f"{told}. Not covered: what the model omits, and wrong input"
        parts = [f"do not rely on this run: {', '.join(wrong)}"] if wrong else []
        parts += [f"within {_percent(self.within)} do not hold: {', '.join(weak)}"] if weak else []
        parts += [f"only the greatest values hold of: {', '.join(part)}"] if part else []
        return "; ".join(parts)

    def __str__(self) -> str:
        names = list(dict.fromkeys(name for answer in self.answers for name in answer.course))
        lines = [f"How far model '{self.model}' can be trusted: {self.verdict}."]
        if self.checks:
            rows = [["the solution itself", "found", "limit", "", "where"]]
            rows += [
                [c.name, f"{c.share:.1e}", f"{c.limit:.1e}", "holds" if c.holds else "DOES NOT", c.worst]
                for c in self.checks
            ]
            lines += ["", *_aligned(rows, left=(0, 3, 4))]
        if self.answers:
            rows = [["answer", "unit", "largest", "relative to", *names, "verdict"]]
            rows += [
                [
                    *(a.name, a.unit, f"{a.largest:.5g}", a.compared_with),
                    *(_percent(a.course.get(n)) for n in names),
                    a.verdict,
                ]
                for a in self.answers
            ]
            lines += ["", *_aligned(rows, left=(0, 1, 3, len(names) + 4))]
        lines += ["", *(f"Compared with: {text}" for text in self.runs)] if self.runs else []
        lines += [f"Note: {text}" for text in self.notes]
        return "\n".join(lines)

    def save(self, path: str | Path) -> Path:
        """Write it to a JSON file and return the path; DataFileError where that is a pipe or a device."""
        check_regular(path, f"Verification '{path}'")
        text = json.dumps({"version": VERSION, **asdict(self)}, indent=1)
        return write_text(path, text, part=f"Verification '{path}'")

    @staticmethod
    def load(path: str | Path) -> Verification:
        """Read what `save` wrote."""
        try:
            raw = json.loads(text_of(path))
            if raw.pop("version") != VERSION:
                raise ValueError("another version")
            checks = tuple(_read(Check, entry) for entry in raw.pop("checks"))
            answers = tuple(_read(Answer, entry) for entry in raw.pop("answers"))
            if any(answer.peak.keys() != answer.course.keys() for answer in answers):
                raise ValueError("other runs in 'peak' than in 'course'")
            texts = {name: tuple(_of_kind("str", text, name) for text in raw.pop(name)) for name in ("runs", "notes")}
            return replace(_read(Verification, raw), checks=checks, answers=answers, **texts)
        except (OSError, ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError) as error:
            raise DataFileError(
                f"Verification '{path}'",
                found=f"it cannot be read ({error})",
                expected=f"a file of version {VERSION} written by `flexmb verify`",
                remedy="Verify the run again",
            ) from error


def _read(kind: type, entry: Mapping[str, Any]) -> Any:
    """Return a description from what JSON says of its fields; ValueError or TypeError if one is of another kind."""
    known = {field.name: str(field.type) for field in fields(kind)}
    return kind(**{name: _of_kind(known.get(name, ""), value, name) for name, value in entry.items()})


def _of_kind(kind: str, value: Any, name: str) -> Any:
    """Return a text, a number, or a mapping of numbers, whichever the type of a field asks for."""
    if kind == "str" and isinstance(value, str):
        return value
    if kind == "float" and isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    if kind == "Mapping[str, float]" and isinstance(value, dict):
        return {key: _of_kind("float", x, name) for key, x in value.items()}
    raise ValueError(f"{name} = {str(value)[:60]}")


def _percent(share: float | None) -> str:
    """Return a share as text, two digits."""
    if share is None:
        return "-"
    return f"{100.0 * share:.2g} %" if share >= 1e-5 or share == 0.0 else "< 0.001 %"


def _aligned(rows: Sequence[Sequence[Any]], left: tuple[int, ...]) -> list[str]:
    """Return rows of cells as lines of columns; the columns `left` are aligned left."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return [
        "  ".join(
            cell.ljust(w) if k in left else cell.rjust(w) for k, (cell, w) in enumerate(zip(row, widths))
        ).rstrip()
        for row in rows
    ]
