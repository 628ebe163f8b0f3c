"""Files that a verb is asked to write with ``-o``: what lies there already is not lost for a slip of the pen."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from flexmb.errors import ModelError

__all__ = ["WRITTEN", "add_overwrite", "refuse_to_lose"]

PICTURES = (".png", ".svg", ".pdf")


class Written(NamedTuple):
    """Endings of the file that a verb writes with an option, and of those that it writes beside it."""

    endings: tuple[str, ...]
    beside: tuple[str, ...] = ()
    option: str = "out"


WRITTEN: dict[str, tuple[Written, ...]] = {
    "bode": (Written(PICTURES, (".csv",)),),
    "campbell": (Written(PICTURES, (".csv",)),),
    "fmu": (Written((".fmu",)),),
    "linearize": (Written((".mat",)),),
    "locus": (Written(PICTURES, (".csv",)),),
    "plot": (Written(PICTURES),),
    "psd": (Written(PICTURES, (".csv",)),),
    "render": (Written((".png", ".jpg", ".gif", ".mp4")),),
    "report": (Written((".html",)),),
    "show": (Written((*PICTURES, ".jpg")),),
    "statics": (Written((".csv",)), Written((".pvd", ".vtkhdf"), option="vtk")),
    "reduce": (Written((".h5",), (".html", ".json")),),
}
"""By verb. A file of the verb's own kind is written anew; others are kept."""
READ = ("model", "run", "others", "data", "mesh", "density", "source")
"""Arguments that name what a verb reads."""
ARRAYS = b"\x89HDF\r\n\x1a\n"
"""The first bytes of bodies and runs, whatever their names."""


def add_overwrite(verb: str, parser: argparse.ArgumentParser) -> None:
    """Add ``--overwrite`` to a verb that writes a file and has none of its own."""
    if verb in WRITTEN and "--overwrite" not in parser._option_string_actions:
        parser.add_argument("--overwrite", action="store_true", help="replace a file of another kind")


def refuse_to_lose(given: argparse.Namespace) -> None:
    """Raise ModelError where a verb would write over what it reads, or, unasked, over a file of another kind."""
    for written in WRITTEN.get(given.verb, ()):
        text = getattr(given, written.option, None)
        if not isinstance(text, str):
            continue
        target = Path(text)
        beside = [target.with_suffix(ending) for ending in written.beside]
        if getattr(given, "no_report", False):
            beside = []
        for path in (target, *beside):
            if path.is_file():
                _look(given, path, path is target, written)


def _look(given: argparse.Namespace, path: Path, asked: bool, written: Written) -> None:
    option = "-o" if written.option == "out" else f"--{written.option}"
    if any(_is_read(path, other, written) for other in _inputs(given)):
        raise ModelError(
            f"File '{path}'",
            found=f"flexmb {given.verb} reads it, and is asked to write over it",
            expected="a file of its own",
            remedy=f"Give another name with {option}",
        )
    if given.overwrite:
        return
    foreign = _is_used(given, path)
    if asked:
        foreign |= path.suffix.lower() not in written.endings
        foreign |= given.verb != "reduce" and _begins(path, ARRAYS)  # its own bodies it refuses in words of its own
    if foreign:
        kind = " or ".join(written.endings)
        raise ModelError(
            f"File '{path}'",
            found="the file exists already, and something else may be in it"
            if asked
            else "the file exists already, and would be written beside the other",
            expected=f"a new file ({kind})",
            remedy=f"Give another one with {option}, or --overwrite to replace it",
        )


def _inputs(given: argparse.Namespace) -> Iterator[Path]:
    """Yield the files and folders that the arguments name as read."""
    for name in READ:
        value = getattr(given, name, None)
        for text in value if isinstance(value, list) else [value]:
            if isinstance(text, str) and text:
                yield Path(text)


def _is_read(path: Path, other: Path, written: Written) -> bool:
    """Is a file what the verb reads, or in a run folder that it reads and none of the verb's own kind?"""
    if other.is_dir():
        return path.suffix.lower() not in written.endings and path.parent.samefile(other)
    return other.exists() and path.samefile(other)


def _is_used(given: argparse.Namespace, path: Path) -> bool:
    """Does the model file name it; of what stands beside a body: is the body missing whose report it would be?"""
    if given.verb == "reduce":
        return path.suffix.lower() != ".h5" and not path.with_suffix(".h5").exists()
    model = getattr(given, "model", None)
    if not isinstance(model, str) or not Path(model).is_file():
        return False
    named = rb"[\"'/\\]" + re.escape(path.name.encode()) + rb"[\"']"  # a whole quoted name, or the end of a quoted path
    return re.search(named, Path(model).read_bytes()) is not None


def _begins(path: Path, first: bytes) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(len(first)) == first
    except OSError:
        return False
