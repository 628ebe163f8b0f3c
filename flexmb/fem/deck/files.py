"""The files of a deck: read as bytes, result files and circles of includes refused; limits of numbers in them."""

from __future__ import annotations

import re
from pathlib import Path

from flexmb.errors import MeshError
from flexmb.files import resolved

__all__ = ["HUGE", "beside", "deck_bytes"]

DEEPEST = 20
"""Files within files."""
FILES = 10_000
"""Files of one deck, each as often as it is included: files that include the next one twice are soon a million."""
HUGE = 1e60
"""No length, modulus or mass in any unit is that large; powers of it stay finite."""
NO_TEXT = re.compile(rb"[\x00-\x08\x0e-\x19\x1b-\x1f]")
"""Control characters of no text; tabs, ends of lines and pages, and DOS' end of a file are text."""


def deck_bytes(path: Path, above: tuple[Path, ...], read: list[Path]) -> bytes:
    """Return the content of a file of a deck and note it among those that were `read`.

    `above` are the files that include it, each by the one before.
    """
    read.append(path)
    if len(read) > FILES:
        raise MeshError(
            f"Deck '{path}'",
            found=f"more than {FILES} INCLUDE in one deck",
            expected="files that are included a few times",
            remedy="Remove the INCLUDE that repeat each other",
        )
    if resolved(path) in above or len(above) > DEEPEST:
        raise MeshError(
            f"Deck '{path}'",
            found=f"files that include each other: {' -> '.join(each.name for each in (*above, path))}"
            if resolved(path) in above
            else f"more than {DEEPEST} files deep",
            expected="INCLUDE files that end",
            remedy="Remove the INCLUDE that leads back",
        )
    try:
        data = path.read_bytes()
    except OSError as error:
        raise MeshError(
            f"Deck '{path}'",
            found=f"cannot read it ({error.strerror})",
            expected="a readable file",
            remedy="Check the name and the permissions",
        ) from None
    if junk := NO_TEXT.search(data):
        line = data.count(b"\n", 0, junk.start()) + 1
        raise MeshError(
            f"Deck '{path}', line {line}",
            found="bytes of a binary file",
            expected="the text of a deck",
            remedy="Give the input deck (.bdf, .dat, .inp), not a result file",
        )
    return data


def beside(name: str, main: Path, including: Path) -> Path | None:
    """Return an included file, looked for beside the main deck (a folder) and beside the file that includes it."""
    for folder in (main, including.parent):
        try:
            if (folder / name).is_file():
                return folder / name
        except (OSError, ValueError):
            return None
    return None
