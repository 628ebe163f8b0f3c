"""What a model file may ask for: regular files, numbers that fit, so much depth, so many values and assemblies.

Far beyond what a machine needs, and low enough that a damaged or hostile file ends with a message, not with the memory.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path
from typing import Any

from flexmb.errors import ModelError

__all__ = ["ASSEMBLIES", "CHAIN", "NESTED", "check_extent", "check_plain", "check_size", "is_file", "named_file"]

BYTES = 64_000_000
"""Size of a model file."""
DEEPEST = 60
"""Lists in lists, or tables in tables."""
VALUES = 100_000
"""Numbers of one list of lists."""
INTEGER = 2**63
"""Integers of TOML 1.0 are smaller."""
CHAIN = 100
"""Parameters that need each other one after another; base files that build on each other."""
NESTED = 20
"""Assemblies in assemblies."""
ASSEMBLIES = 2000
"""Assemblies of one model in all."""


def is_file(path: Path) -> bool:
    """Is there a file of this name? False for names that no system can have."""
    try:
        return path.is_file()
    except (OSError, ValueError):  # too long, or with a zero byte
        return False


def check_size(path: Path, part: str) -> None:
    """Raise ModelError unless a file that exists is a regular one of sensible size; a pipe is not even opened."""
    info = os.stat(path)
    regular = stat.S_ISREG(info.st_mode)
    if not regular or info.st_size > BYTES:
        why = f"{info.st_size} bytes" if regular else "a folder" if stat.S_ISDIR(info.st_mode) else "a device or pipe"
        raise ModelError(
            part,
            found=f"it cannot be opened ({why})",
            expected=f"a readable text file of at most {BYTES} bytes",
            remedy="Give the path of a .toml file",
        )


def named_file(folder: Path, name: str, where: str) -> Path:
    """Return the path of a file that a model file names; ModelError for a text that cannot be a name of a file."""
    if "\0" in name or len(name) > 1000 or any(len(part.encode()) > 255 for part in name.split("/")):
        raise ModelError(
            where,
            found=f"{name[:40]!r}{'...' if len(name) > 40 else ''}, {len(name)} characters",
            expected="the name of a file",
            remedy="Correct the name",
        )
    return folder / name


def check_plain(tables: Any, part: str) -> None:
    """Raise ModelError if values of a TOML text are nested too deeply or have integers that TOML does not know."""
    waiting: list[tuple[Any, str, int]] = [(tables, "", 0)]
    while waiting:
        value, place, depth = waiting.pop()
        if depth > DEEPEST:
            raise ModelError(
                part,
                found=f"values nested more than {DEEPEST} deep in '{place[:60]}'",
                expected=f"at most {DEEPEST} lists or tables inside each other",
                remedy="Nest less deeply",
            )
        if isinstance(value, dict):
            waiting += [(entry, place or str(name), depth + 1) for name, entry in value.items()]
        elif isinstance(value, list):
            waiting += [(entry, place, depth + 1) for entry in value]
        elif isinstance(value, int) and not -INTEGER <= value < INTEGER:
            raise ModelError(
                part,
                found=f"an integer of {len(hex(value)) - 2} hexadecimal digits in '{place[:60]}'",
                expected="integers of 64 bits",
                remedy="Write large numbers with a decimal point or an exponent: 1e30",
            )


def check_extent(value: Any, where: str) -> None:
    """Raise ModelError if lists that hold each other make more than `VALUES` values, or are nested too deeply."""
    count, waiting = 0, [(value, 0)]
    while waiting:
        entry, depth = waiting.pop()
        if isinstance(entry, list | tuple):
            waiting += [(inner, depth + 1) for inner in entry]
        else:
            count += 1
        if len(waiting) + count > VALUES or depth > DEEPEST:
            raise ModelError(
                where,
                found=f"more than {VALUES} values" if depth <= DEEPEST else f"lists nested more than {DEEPEST} deep",
                expected=f"at most {VALUES} values in one list, {DEEPEST} lists inside each other",
                remedy="Put large data into separate files: meshes, reduced bodies",
            )
