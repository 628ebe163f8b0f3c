"""The lines of a Nastran file, with the lines of its INCLUDE files in their places."""

from __future__ import annotations

import re
from pathlib import Path

from flexmb.errors import MeshError

__all__ = ["nastran_lines"]

INCLUDE = re.compile(r"""^\s*INCLUDE\s+(['"]?)(.+?)\1\s*(\$.*)?$""", re.IGNORECASE)
DEEPEST = 10
"""Files within files; more are a file that includes itself."""


def nastran_lines(path: Path, depth: int = 0) -> list[str]:
    """Return all lines, tabs expanded; names of included files are relative to the file that includes them.

    Raises
    ------
    MeshError
        An included file does not exist, or files include each other without end.
    """
    lines: list[str] = []
    for line in path.read_text(encoding="utf-8", errors="replace").expandtabs(8).splitlines():
        match = INCLUDE.match(line)
        if match is None:
            lines.append(line)
            continue
        included = path.parent / match[2].strip()
        if not included.is_file() or depth == DEEPEST:
            why = "files include each other" if included.is_file() else "no such file"
            raise MeshError(
                f"Mesh file '{path}'",
                found=f"INCLUDE '{match[2].strip()}': {why}",
                expected="an existing file beside this one",
                remedy="Put the included files beside it, or write one flat file",
            )
        lines += nastran_lines(included, depth + 1)
    return lines
