"""The door of foreign units: an .fmu file is an archive, and is looked at before anything of it is unpacked."""

from __future__ import annotations

import codecs
import re
import stat
import zipfile
import zlib
from pathlib import Path, PurePosixPath

from flexmb.errors import DataFileError

__all__ = ["require_archive"]

DESCRIPTION = "modelDescription.xml"
MOST_FILES = 50_000
LARGEST = 4_000_000_000
"""bytes, of all files unpacked: a small archive may ask for a full disk."""
FEW, PER_BYTE = 1_000_000_000, 100
"""bytes, of all files unpacked from an archive of any size, and for each byte of it: text packs ten to one."""
LONGEST = 64_000_000
"""bytes, of the description, as of a model file."""
ENCODINGS = re.compile(r"utf-8|ascii|iso8859-\d+|cp125\d")
"""FMI asks for UTF-8; in these, as Python calls them, the letters of ASCII are what they look like, so that no
definition hides."""
ENCODING = re.compile(rb"[A-Za-z][A-Za-z0-9._-]{0,39}")
"""How a declaration may call them."""


def require_archive(path: Path, title: str) -> None:
    """Raise DataFileError unless a file is an archive of reasonable size with a description that asks for no more.

    Files outside the folder into which it is unpacked, links, names that come twice (of which readers take one or the
    other), encrypted files, and entities in the description (which may double again and again, or name other files)
    are refused.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            found = _complaint(archive, path.stat().st_size)
    except (zipfile.BadZipFile, zlib.error, OSError, ValueError, EOFError, RuntimeError) as error:
        found = f"it cannot be read: {error or type(error).__name__}"
    if found:
        raise DataFileError(title, found=found, expected="a unit of FMI 2 or 3", remedy="Export it again")


def _complaint(archive: zipfile.ZipFile, packed: int) -> str:
    """Return what is wrong with an archive of so many bytes, or ""."""
    files = archive.infolist()
    size, most = sum(file.file_size for file in files), min(LARGEST, FEW + PER_BYTE * packed)
    if len(files) > MOST_FILES or size > most:
        return f"{len(files)} files of {size / 1e6:.4g} MB; at most {MOST_FILES} of {most / 1e6:.4g} MB are unpacked"
    places: set[tuple[str, ...]] = set()
    for file in files:
        name, said = file.filename.replace("\\", "/"), f"'{file.filename[:80]}'"
        place = PurePosixPath(name).parts
        if name.startswith("/") or ":" in name or ".." in place:
            return f"a file called {said}, outside the archive"
        if stat.S_ISLNK(file.external_attr >> 16):
            return f"a link called {said}, not a file"
        if file.flag_bits & 1:
            return f"the file {said} is encrypted"
        if place in places and not file.is_dir():
            return f"two files called {said}"
        places.add(place)
    about = next((file for file in files if file.filename == DESCRIPTION), None)
    if about is None or about.file_size > LONGEST:
        return f"no {DESCRIPTION}" if about is None else f"{DESCRIPTION} has {about.file_size / 1e6:.4g} MB"
    with archive.open(about) as stream:  # the size in the directory may lie: reading all at once unpacks all
        return _hidden(stream.read(LONGEST))


def _hidden(text: bytes) -> str:
    """Return what a description holds that its reader would follow or multiply, or that cannot be looked for, or ""."""
    text = text.removeprefix(b"\xef\xbb\xbf").lstrip()
    declared = re.match(rb"<\?xml[^>]*?encoding\s*=\s*[\"']([^\"']*)", text)
    if b"\0" in text or text[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return f"{DESCRIPTION} is not written in UTF-8"
    if declared is not None and not _extends_ascii(declared[1]):
        return f"{DESCRIPTION} is written in {declared[1][:40].decode('ascii', 'replace')}, not in UTF-8"
    if text[:1] != b"<":
        return f"{DESCRIPTION} is no text of XML"
    return f"{DESCRIPTION} defines entities" if b"<!DOCTYPE" in text or b"<!ENTITY" in text else ""


def _extends_ascii(encoding: bytes) -> bool:
    """Whether a declared encoding, by any of its names (UTF8, latin-1), is one in which ASCII is itself."""
    try:
        known = codecs.lookup(encoding.decode("ascii")).name if ENCODING.fullmatch(encoding) else ""
    except LookupError:
        return False
    return ENCODINGS.fullmatch(known) is not None
