"""TOML as text: reading with messages that name file and line, and writing what model files need."""

from __future__ import annotations

import json
import math
import os
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flexmb.errors import ModelError
from flexmb.files import resolved
from flexmb.found import Found, no_file_because
from flexmb.io.limits import check_plain, check_size

__all__ = ["inline", "parse_toml", "read_toml", "table_lines"]

_BARE = re.compile(r"[A-Za-z0-9_-]+")
_LONG = 100  # characters of a value from which a mapping gets its own table


_BODIES = 'Reduced bodies (.h5) are named inside a model file: data = "lever.h5"; flexmb show tells what is in them'


def read_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file.

    Raises
    ------
    ModelError
        The file is missing, cannot be read as text, or breaks the grammar of TOML (with the line).
    """
    part = f"Model file '{path}'"
    found = no_file_because(path, (".toml",), "the file does not exist")
    if found is not None and os.path.isdir(path):
        raise ModelError(
            part,
            found=f"it cannot be opened ({found.what.removeprefix('it is ')})",
            expected="a readable text file (.toml)",
            remedy=found.remedy or "Give the path of a .toml file",
        )
    try:
        check_size(path, part)
        text = path.read_bytes().decode("utf-8")
    except FileNotFoundError:
        near = sorted(p.name for p in path.parent.glob("*.toml")) if os.path.isdir(path.parent) else []
        where = f"The folder holds: {', '.join(near[:8])}" if near else f"Folder: {resolved(path.parent)}"
        found = found or Found("the file does not exist")
        meant = f"Correct the path. {found.remedy}" if "?" in found.remedy else found.remedy or "Correct the path"
        raise ModelError(part, found=found.what, expected=where, remedy=meant) from None
    except (OSError, ValueError) as error:
        if isinstance(error, UnicodeDecodeError):
            raise ModelError(
                part,
                found="it is not text in UTF-8",
                expected="a TOML file",
                remedy=_BODIES if path.suffix.lower() == ".h5" else "Give the path of a .toml file",
            ) from None
        raise ModelError(
            part,
            found=f"it cannot be opened ({getattr(error, 'strerror', None) or error})",
            expected="a readable text file",
            remedy="Give the path of a .toml file",
        ) from None
    _require_no_deck(path, part)
    if not text.removeprefix("\ufeff").strip():
        raise ModelError(
            part,
            found="the file is empty",
            expected="a model: tables [[body]], [[joint]], [[force]], ...",
            remedy="Write one, or copy it again if it was lost; flexmb demo makes one to begin with",
        )
    return parse_toml(text, part)


def _require_no_deck(path: Path, part: str) -> None:
    """Raise ModelError for a deck: it is text too, but what TOML says of it helps nobody."""
    from flexmb.fem import DECK_READERS

    if path.suffix.lower() in DECK_READERS:
        raise ModelError(
            part,
            found="its ending says that it is a deck of finite elements",
            expected="a model file (.toml), which may name decks",
            remedy=f"Look at it with flexmb show {path}; as a body of a model: "
            f'data = {{ deck = "{path.name}", units = "mm, t, s", interfaces = "all", modes = 8 }}',
        )


def parse_toml(text: str, part: str) -> dict[str, Any]:
    """Return the tables of a TOML text; `part` names it in messages."""
    try:
        tables = tomllib.loads(text.removeprefix("\ufeff"))  # a mark that editors of Windows put first
        check_plain(tables, part)
        return tables
    except RecursionError:
        raise ModelError(
            part,
            found="brackets inside each other without end",
            expected="lists and tables that are nested a few times",
            remedy="Nest less deeply",
        ) from None
    except ValueError as error:  # of the grammar, or an integer of thousands of digits
        raise ModelError(
            part,
            found=_syntax(str(error), text),
            expected="TOML 1.0",
            remedy="Write text in quotes, lists in [ ], tables of fields in { } on one line",
        ) from None


def _syntax(message: str, text: str) -> str:
    """Return the parser's message with the line it speaks of."""
    number = re.search(r"line (\d+)", message)
    if number is None:
        return message
    line = text.splitlines()[int(number[1]) - 1].strip() if int(number[1]) <= len(text.splitlines()) else ""
    return f"{message}: `{line[:80]}`" if line else message


def inline(value: Any) -> str:
    """Return a value on one line; ValueError for a value TOML does not have."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            return "nan" if math.isnan(value) else "inf" if value > 0 else "-inf"
        return repr(value)  # the shortest text that reads back as the same number
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list | tuple):
        return "[" + ", ".join(inline(entry) for entry in value) + "]"
    if isinstance(value, Mapping):
        return (
            "{ " + ", ".join(f"{key(name)} = {inline(entry)}" for name, entry in value.items()) + " }"
            if value
            else "{}"
        )
    raise ValueError(f"{type(value).__name__} {value!r:.60}")


def key(name: str) -> str:
    """Return a key, quoted if it must be."""
    return name if _BARE.fullmatch(name) else json.dumps(name, ensure_ascii=False)


def table_lines(header: str, values: Mapping[str, Any]) -> list[str]:
    """Return the lines of a table ``[name]`` or ``[[name]]``; long mappings become tables of their own below it."""
    lines, below = [header], []
    for name, value in values.items():
        text = inline(value)
        if isinstance(value, Mapping) and len(text) > _LONG and header:
            own = f"[{header.strip('[]')}.{key(name)}]"
            below += [own, *(f"{key(k)} = {inline(v)}" for k, v in value.items())]
        else:
            lines.append(f"{key(name)} = {text}")
    return [*(line for line in lines if line), *below, ""]
