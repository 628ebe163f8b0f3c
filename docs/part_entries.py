"""The tables of the reference page of parts: fields, units and defaults of every kind, made from the kinds themselves.

The page holds them as text, so that it can be read without being built. After a change of a kind run
``python docs/part_entries.py``; a test compares.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from flexmb import parts, reduction
from flexmb.fem import Section
from flexmb.model.material import Material
from flexmb.model.orthotropic_material import OrthotropicMaterial

PAGE = Path(__file__).parent / "reference" / "parts.md"
BEGIN, END = "<!-- tables of all kinds: begin -->", "<!-- tables of all kinds: end -->"
GROUPS: dict[str, tuple[Any, ...]] = {
    "The part": (parts.Part,),
    "Pieces": (*parts.PIECES.values(), parts.Boss, parts.Bore, parts.Stretch),
    "Ready-made solids": (parts.Extrusion.plate, parts.Extrusion.tube, parts.Extrusion.lug),
    "Sections": (
        Section.rectangle,
        Section.solid_circle,
        Section.tube,
        Section.box,
        Section.i,
        Section.values,
    ),
    "Materials": (Material, OrthotropicMaterial),
    "Links": tuple(parts.LINKS.values()),
    "Masses and springs": tuple(parts.MASSES.values()),
    "Interfaces and stations": (reduction.Rigid, reduction.Averaging, reduction.Nodes, parts.Each),
    "Loads": (*parts.LOADS.values(), reduction.Pressure, reduction.LineLoad, reduction.Track),
    "Bases": (
        reduction.CraigBampton,
        reduction.Rubin,
        reduction.Krylov,
        reduction.CharacteristicModes,
        reduction.Balanced,
        reduction.Pod,
    ),
    "Numbers of modes and damping": (reduction.UpTo, reduction.Rayleigh, reduction.Bands),
}
NOT_IN_FILES = {parts.Part: ("name", "parameters", "model"), reduction.Pod: ("snapshots",)}
"""Fields that files give in their own way: the name is the body's."""
ONLY_IN_FILES = {reduction.Pod: '| `run` | required | str | A run and a body in it, "first.h5#beam": what it did. |'}


class Entry(NamedTuple):
    """What a docstring says of some fields: their names, type with unit, and meaning."""

    names: tuple[str, ...]
    unit: str
    meaning: str


def described(kind: Any) -> tuple[str, list[Entry]]:
    """Return the text of a docstring before its parameters, and what it says of them."""
    if kind == Section.values:  # `Section` itself says what its fields are
        return inspect.getdoc(kind) or "", described(Section)[1]
    text = inspect.getdoc(kind) or ""
    head, _, rest = text.partition("\nParameters\n----------\n")
    rest = re.split(r"\n\n?[A-Z]\w+\n-{4,}\n", rest)[0]
    entries: list[Entry] = []
    for line in rest.splitlines():
        if line and not line.startswith(" "):
            names, _, unit = line.partition(" : ")
            entries.append(Entry(tuple(re.split(r",\s*", names.strip())), unit.strip(), ""))
        elif line.strip() and entries:
            entries[-1] = entries[-1]._replace(meaning=f"{entries[-1].meaning} {line.strip()}".strip())
    return " ".join(head.split()), entries


def default(value: Any) -> str:
    """Return a default as a model file writes it."""
    if value is inspect.Parameter.empty:
        return "required"
    if value is None:
        return ""
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if isinstance(value, str):
        return f'`"{value}"`'
    if isinstance(value, float):
        return f"`{value:.6g}`"
    if isinstance(value, tuple | list):
        return f"`[{', '.join(default(one).strip('`') for one in value)}]`"
    return f"`{value}`" if isinstance(value, int) else "`{}`"


def table(kind: Any) -> str:
    """Return the entry of a kind: its name, what it is, and a row for each field."""
    head, entries = described(kind)
    name = kind.__qualname__
    left_out = NOT_IN_FILES.get(kind, ())
    meanings = {field: entry for entry in entries for field in entry.names}
    rows = [ONLY_IN_FILES[kind]] if kind in ONLY_IN_FILES else []
    for field, parameter in inspect.signature(kind).parameters.items():
        if parameter.kind is inspect.Parameter.VAR_KEYWORD:
            rows.append(f"| others | | | the fields of `{name.partition('.')[0]}` |")
            continue
        if field in left_out or field == "cls":
            continue
        entry = meanings.get(field, Entry((field,), "", ""))
        said = f"`{field}`", default(parameter.default), entry.unit, entry.meaning
        rows.append(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in said)} |".replace("|  |", "| |"))
    first, _, more = head.removeprefix("Return ").partition(". ")
    text = f"{first[:1].upper()}{first[1:].rstrip('.')}." + (f" {more}" if more else "")
    lines = [f"### `{name}`", "", text.replace("``", "`"), ""]
    if rows:
        lines += ["| field | default | type, unit | meaning |", "|---|---|---|---|", *rows, ""]
    return "\n".join(row.replace("``", "`") for row in lines)


def tables() -> str:
    """Return the tables of all kinds."""
    text = []
    for title, kinds in GROUPS.items():
        text += [f"## {title}", "", *map(table, kinds)]
    return "\n".join(_wrapped(text))


def _wrapped(text: Iterable[str]) -> list[str]:
    """Return lines of running text below the width of pages; rows of tables stay whole."""
    from textwrap import wrap

    found: list[str] = []
    for block in text:
        for line in block.split("\n"):
            found += [line] if len(line) < 138 or line.startswith("|") else wrap(line, 136, break_long_words=False)
    return found


def filled(page: str) -> str:
    """Return the page with the tables of today."""
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}\n\n{tables()}\n{END}{after}"


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
