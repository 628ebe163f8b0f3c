"""What lies at a path where a file of some kind was expected, in words, and what to do about it.

"No such file" of a folder that is there sends its owner looking in the wrong place.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Collection
from pathlib import Path
from typing import NamedTuple

from flexmb.errors import did_you_mean

__all__ = ["Found", "folder_in_words", "near_name", "no_file_because", "runs_below"]

RUN, STUDY, TABLE = "solution.h5", "study.json", "results.csv"
"""By which a run folder and the folder of a sweep are known."""
SHOWN = 4
"""Names in a message."""


class Found(NamedTuple):
    """What was found at a path, and what to do; an empty remedy where the reader knows better."""

    what: str
    remedy: str = ""


def no_file_because(path: Path, endings: Collection[str] = (), missing: str = "no such file") -> Found | None:
    """Return why a path cannot be read as a file that holds something; None if it can.

    Parameters
    ----------
    path : path
    endings : of str
        Of the files that are wanted, as ".toml": those a folder holds are proposed, one that is empty is refused.
    missing : str
        What is said if nothing is there.
    """
    try:
        info = os.stat(path)
    except FileNotFoundError:
        if path.is_symlink():
            return Found(f"it is a link to '{os.readlink(path)}', which does not exist", "Correct the link")
        return Found(missing, near_name(path, endings))
    except NotADirectoryError:
        first = next((p for p in reversed(path.parents) if os.path.isfile(p)), path.parent)
        return Found(f"'{first}' on the way to it is a file", "Correct the path")
    except PermissionError:
        return Found("the folder it lies in may not be entered", "Ask its owner, or copy the file")
    except (OSError, ValueError) as error:  # longer than a name can be, links in a circle
        return Found(f"it cannot be opened ({getattr(error, 'strerror', None) or error})", "Correct the path")
    if stat.S_ISDIR(info.st_mode):
        return _instead_of_file(path, endings)
    if not stat.S_ISREG(info.st_mode):
        return Found("it cannot be opened (a device or pipe)", "Write its content into a file, and name that")
    if not os.access(path, os.R_OK):
        return Found("it may not be read (Permission denied)", "Ask its owner, or copy it")
    if info.st_size == 0 and path.suffix.lower() in endings:
        return Found("the file is empty", "Write or copy it again")
    return None


def near_name(path: Path, endings: Collection[str] = ()) -> str:
    """Return "Did you mean 'x'?" for a file beside `path` of the same name in other letters or with another ending, or
    one that is near; "" if there is none.
    """
    names = _names(path.parent)
    wanted = [name for name in names if not endings or Path(name).suffix.lower() in endings]
    same = [name for name in wanted if name.casefold() == path.name.casefold()]
    same += [name for name in wanted if Path(name).stem.casefold() == path.stem.casefold()]
    return f"Did you mean '{same[0]}'?" if same else did_you_mean(path.name, wanted)


def runs_below(folder: Path) -> list[str]:
    """Return the run folders in a folder, or in the folder ``runs`` in it."""
    found = [p.parent for pattern in (f"*/{RUN}", f"runs/*/{RUN}") for p in folder.glob(pattern)]
    return [str(p) for p in sorted(found)]


def folder_in_words(folder: Path) -> str:
    """Return what a folder is: "a run folder", "the folder of a sweep", "an empty folder", "a folder"."""
    names = _names(folder, files=False)
    if RUN in names:
        return "a run folder"
    if STUDY in names and TABLE in names:
        return "the folder of a sweep"
    return "a folder" if names else "an empty folder"


def _instead_of_file(folder: Path, endings: Collection[str]) -> Found:
    """Return what is said of a folder where a file was wanted."""
    what = folder_in_words(folder)
    fitting = [name for name in _names(folder) if Path(name).suffix.lower() in endings and name != RUN]
    if fitting:
        more = ", ..." if len(fitting) > SHOWN else ""
        remedy = f"Name a file in it: {', '.join(str(folder / name) for name in fitting[:SHOWN])}{more}"
    elif what == "a run folder":
        remedy = f"For a run: flexmb report {folder}, flexmb view {folder}, flexmb export {folder}"
    elif what == "the folder of a sweep":
        remedy = f"Its table is {folder / TABLE}"
    else:
        remedy = ""
    return Found(f"it is {what}", remedy)


def _names(folder: Path, *, files: bool = True) -> list[str]:
    """Return the names in a folder, of files only or of all; none of a folder that cannot be read."""
    try:
        with os.scandir(folder) as entries:
            return sorted(entry.name for entry in entries if not files or entry.is_file())
    except OSError:
        return []
