"""Files that appear whole or not at all: written beside their place, and moved there when they are complete."""

from __future__ import annotations

import errno
import os
import stat
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from flexmb.errors import DataFileError

__all__ = [
    "check_folder",
    "check_regular",
    "complaints",
    "on_disk",
    "remove_parts",
    "replacing",
    "resolved",
    "text_of",
    "without_formulas",
    "write_all",
    "write_text",
]

_PREFIX, _SUFFIX = ".flexmb.", ".part"
_FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""With these a text begins that a spreadsheet takes for a formula."""


@contextmanager
def replacing(path: str | Path, part: str = "", doing: str = "write", *, folder: bool = False) -> Iterator[Path]:
    """Give a path beside `path` to write to; the file is moved to its place when the block ends.

    After an exception inside the block, or a kill at any moment, the old file is as it was. A target that is not an
    ordinary file (a device, a pipe) is written directly; a link stays a link.

    Parameters
    ----------
    path : path
    part : str
        How messages call the file; "File 'path'" unless given.
    doing : str
        What messages say that cannot be done to it.
    folder : bool
        Make the folder if it does not exist.

    Raises
    ------
    DataFileError
        The folder does not exist or cannot be written, or the disk is full.
    """
    path = Path(path)
    _check_name(path, part or f"File '{path}'")
    with complaints(part or f"File '{path}'", doing):
        if path.exists() and not path.is_file() and not path.is_dir():
            yield path
            return
        place = Path(os.path.realpath(path)) if path.is_symlink() else path
        if folder:
            place.parent.mkdir(parents=True, exist_ok=True)
        check_folder(place, part or f"File '{path}'")
        handle, name = tempfile.mkstemp(dir=place.parent, prefix=_PREFIX, suffix=_SUFFIX + place.suffix)
        temporary = Path(name)
        try:
            os.close(handle)
            yield temporary
            os.chmod(temporary, 0o666 & ~_umask())  # mkstemp makes private files, a result is as open as any other
            os.replace(temporary, place)
        finally:
            temporary.unlink(missing_ok=True)


def write_text(
    path: str | Path, text: str, *, encoding: str = "utf-8", errors: str = "surrogateescape", part: str = ""
) -> Path:
    """Write a text file that appears whole or not at all, in a folder that is made for it; return its path.

    Names of files that are no text are written as the bytes they are.
    """
    with (
        replacing(path, part, folder=True) as temporary,
        temporary.open("w", encoding=encoding, errors=errors) as stream,
    ):
        stream.write(text)
    return Path(path)


def write_all(stream: BinaryIO, data: bytes | memoryview) -> None:
    """Write all of `data` to an unbuffered stream: near the end of the space a write may take a part only."""
    done = 0
    while done < len(data):
        done += stream.write(data[done:]) or 0


def without_formulas(cells: Iterable[Any]) -> list[Any]:
    """Return the cells of a row of a CSV table, with an apostrophe before texts that a spreadsheet would compute.

    Names, texts of parameters and messages come from files of other people, and a formula can start programs
    (CWE-1236). Numbers stay as they are, also as text.
    """
    return [f"'{cell}" if isinstance(cell, str) and _is_formula(cell) else cell for cell in cells]


def _is_formula(cell: str) -> bool:
    if not cell.startswith(_FORMULA):
        return False
    try:
        float(cell)
    except ValueError:
        return True
    return False


def resolved(path: str | Path) -> Path:
    """Return the absolute path behind all links; of links that lead in a circle the first, which cannot be opened."""
    return Path(os.path.realpath(path))


def on_disk(path: str | Path) -> None:
    """Come back when the disk has the content of a file."""
    with Path(path).open("r+b") as stream:
        os.fsync(stream.fileno())


def text_of(path: str | Path, most: int = 64_000_000) -> str:
    """Return the text of a small file; OSError for a pipe or a device, which would never end, and for a larger file."""
    info = os.stat(path)
    if not stat.S_ISREG(info.st_mode) or info.st_size > most:
        raise OSError(errno.EINVAL, f"no regular file of at most {most} bytes")
    return Path(path).read_text(encoding="utf-8")


def remove_parts(folder: str | Path) -> None:
    """Remove the unfinished files that killed processes have left in a folder."""
    for pattern in (f"{_PREFIX}*{_SUFFIX}*", f".{_PREFIX}*{_SUFFIX}*.lock"):
        for left in Path(folder).glob(pattern):
            left.unlink(missing_ok=True)


@contextmanager
def complaints(part: str, doing: str, kept: str = "") -> Iterator[None]:
    """Turn errors of the file system into a DataFileError that says what to do."""
    try:
        yield
    except OSError as error:
        raise DataFileError(
            part,
            found=f"cannot {doing} it ({error.strerror or error})",
            expected="a writable folder with free space" + kept,
            remedy="Free space, or choose another folder for the results",
        ) from error


def check_folder(path: Path, part: str) -> None:
    """Raise DataFileError if there is no folder for a file."""
    _check_name(path, part)
    if not path.parent.is_dir():
        raise DataFileError(
            part,
            found=f"the folder '{path.parent}' does not exist",
            expected="an existing folder",
            remedy="Create the folder or give another path",
        )


def check_regular(path: str | Path, part: str) -> None:
    """Raise DataFileError if something else than a regular file has the name: writing to a pipe waits for a reader."""
    path = Path(path)
    if path.exists() and not path.is_file():
        kind = "a folder" if path.is_dir() else "a pipe or a device"
        raise DataFileError(
            part,
            found=f"{path.name} is {kind}",
            expected="a regular file of this name, or none",
            remedy="Remove it, or move it elsewhere",
        )


def _check_name(path: Path, part: str) -> None:
    """Raise DataFileError for a name that no system can have."""
    if "\0" in str(path):
        raise DataFileError(
            part.replace("\0", "\\0"),
            found="its name holds a zero byte",
            expected="a name without one",
            remedy="Correct the name",
        )


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
