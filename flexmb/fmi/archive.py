"""The door of foreign units: an .fmu file is an archive, and is looked at before anything of it is unpacked."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path, PurePosixPath

from flexmb.errors import DataFileError

__all__ = ["require_archive"]

DESCRIPTION = "modelDescription.xml"
MOST_FILES = 50_000
LARGEST = 4_000_000_000
"""bytes, of all files unpacked: a small archive may ask for a full disk."""
LONGEST = 64_000_000
"""bytes, of the description, as of a model file."""


def require_archive(path: Path, title: str) -> None:
    """Raise DataFileError unless a file is an archive of reasonable size with a description that asks for no more.

    Files outside the folder into which it is unpacked, encrypted ones, and entities in the description (which may
    double again and again, or name other files) are refused.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            found = _complaint(archive)
    except (zipfile.BadZipFile, zlib.error, OSError, ValueError, EOFError, RuntimeError) as error:
        found = f"it cannot be read: {error or type(error).__name__}"
    if found:
        raise DataFileError(title, found=found, expected="a unit of FMI 2 or 3", remedy="Export it again")


def _complaint(archive: zipfile.ZipFile) -> str:
    """Return what is wrong with an archive, or ""."""
    files = archive.infolist()
    size = sum(file.file_size for file in files)
    if len(files) > MOST_FILES or size > LARGEST:
        return f"{len(files)} files of {size / 1e6:.4g} MB; at most {MOST_FILES} of {LARGEST / 1e6:.4g} MB are unpacked"
    for file in files:
        name = file.filename.replace("\\", "/")
        if name.startswith("/") or ":" in name or ".." in PurePosixPath(name).parts:
            return f"a file called '{file.filename[:80]}', outside the archive"
        if file.flag_bits & 1:
            return f"the file '{file.filename[:80]}' is encrypted"
    about = next((file for file in files if file.filename == DESCRIPTION), None)
    if about is None or about.file_size > LONGEST:
        return f"no {DESCRIPTION}" if about is None else f"{DESCRIPTION} has {about.file_size / 1e6:.4g} MB"
    with archive.open(about) as stream:  # the size in the directory may lie: reading all at once unpacks all
        text = stream.read(LONGEST)
    if b"<!DOCTYPE" in text or b"<!ENTITY" in text:
        return f"{DESCRIPTION} defines entities"
    return ""
