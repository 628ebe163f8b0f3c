"""The one door to HDF5: files are opened, created and checked here, and nowhere else.

Every flexmb file carries two root attributes, ``schema`` (what it is) and ``schema_version`` (int). A file that is
missing, foreign, truncated or of another version is refused with a message that says what to do; a file that is
being written replaces the old one only when it is complete.
"""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from flexmb.errors import DataFileError

if TYPE_CHECKING:
    import h5py

__all__ = ["appending", "reading", "reserve", "shorten", "streaming", "writing"]

_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_LIBVER = ("earliest", "v110")  # 'latest' of a new HDF5 writes objects that the HDF5 inside VTK cannot read


@contextmanager
def reading(path: str | Path, *, schema: str, version: int) -> Iterator[h5py.File]:
    """Open a flexmb file for reading; check signature, schema and version first.

    Parameters
    ----------
    path : path
        File to read.
    schema : str
        Expected value of the root attribute ``schema``, e.g. ``"flexmb.modal_neutral_data"``.
    version : int
        Expected ``schema_version``.

    Raises
    ------
    DataFileError
        The file is missing, is not HDF5, is truncated or damaged, or has another schema or version. A dataset that
        is asked for inside the ``with`` block but not there counts as damage too.
    """
    import h5py

    path = Path(path)
    part = f"Data file '{path}'"
    _check_signature(path, part, schema)
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        raise _damaged(part, str(error)) from error
    with file:
        _check_schema(file, part, schema, version)
        try:
            yield file
        except (KeyError, OSError) as error:
            raise _damaged(part, str(error).strip("'\"")) from error


@contextmanager
def writing(path: str | Path, *, schema: str | None = None, version: int | None = None) -> Iterator[h5py.File]:
    """Write a file beside its final place and move it there when it is complete.

    An exception inside the ``with`` block, or a killed process, leaves the old file as it was. Without `schema`
    the file gets no flexmb attributes (VTKHDF).
    """
    import h5py

    path = Path(path)
    _check_folder(path)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".part")
    os.close(handle)
    try:
        with h5py.File(temporary, "w", libver=_LIBVER) as file:
            _stamp(file, schema, version)
            yield file
        os.chmod(temporary, 0o666 & ~_umask())  # mkstemp makes private files, a result file is as open as any other
        os.replace(temporary, path)
    finally:
        Path(temporary).unlink(missing_ok=True)


def streaming(path: str | Path, *, schema: str | None = None, version: int | None = None) -> h5py.File:
    """Create a file to which data is appended while it comes; flush it to keep what has been written so far."""
    import h5py

    path = Path(path)
    _check_folder(path)
    file = h5py.File(path, "w", libver=_LIBVER)
    _stamp(file, schema, version)
    file.flush()
    return file


def appending(path: str | Path, *, schema: str, version: int) -> h5py.File:
    """Open a flexmb file, complete or cut off, to write more into it; refuse what `reading` refuses."""
    import h5py

    path = Path(path)
    with reading(path, schema=schema, version=version):
        pass
    return h5py.File(path, "r+", libver=_LIBVER)


def reserve(path: str | Path, size: int) -> None:
    """Make sure that a file can grow by `size` bytes; raise OSError if it cannot.

    HDF5 does not survive a full disk: it has noted the new size of the file before the data fail to arrive, and then
    nothing can be read any more. So the space is taken before HDF5 is asked to write; it does not mind a longer file.
    """
    if hasattr(os, "posix_fallocate"):
        with Path(path).open("r+b") as stream:
            os.posix_fallocate(stream.fileno(), os.fstat(stream.fileno()).st_size, size)
    elif shutil.disk_usage(Path(path).parent).free < size:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def shorten(path: str | Path) -> None:
    """Give back what `reserve` took and a closed file does not use: its superblock says where it ends."""
    with Path(path).open("r+b") as stream:
        head = stream.read(48)
        start = 40 if head[8] < 2 else 28  # by the version of the superblock
        end = int.from_bytes(head[start : start + 8], "little")
        if 0 < end < os.fstat(stream.fileno()).st_size:
            stream.truncate(end)


def _stamp(file: h5py.File, schema: str | None, version: int | None) -> None:
    if schema is not None:
        file.attrs["schema"] = schema
        file.attrs["schema_version"] = version


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _check_folder(path: Path) -> None:
    if not path.parent.is_dir():
        raise DataFileError(
            f"Data file '{path}'",
            found=f"the folder '{path.parent}' does not exist",
            expected="an existing folder",
            remedy="Create the folder or give another path",
        )


def _check_signature(path: Path, part: str, schema: str) -> None:
    if not path.is_file():
        near = sorted(p.name for p in path.parent.glob(f"*{path.suffix}"))[:5] if path.parent.is_dir() else []
        there = f"The folder has: {', '.join(near)}" if near else "Check the path"
        raise DataFileError(part, found="the file does not exist", expected=f"a file of kind '{schema}'", remedy=there)
    with path.open("rb") as stream:
        head = stream.read(len(_SIGNATURE))
    if head != _SIGNATURE:
        raise DataFileError(
            part,
            found=f"this is not an HDF5 file (it begins with {head!r})",
            expected=f"an HDF5 file of kind '{schema}'",
            remedy="Give the .h5 file that flexmb wrote; meshes are read with fem.read_mesh",
        )


def _check_schema(file: h5py.File, part: str, schema: str, version: int) -> None:
    found = file.attrs.get("schema")
    if found != schema:
        what = "no schema attribute" if found is None else f"the schema '{found}'"
        raise DataFileError(
            part,
            found=f"{what}",
            expected=f"the schema '{schema}'",
            remedy="The file belongs to another purpose or program: give the right file",
        )
    number = int(file.attrs.get("schema_version", -1))
    if number != version:
        remedy = (
            "Update flexmb: the file was written by a newer release"
            if number > version
            else "Make the file again with this release: it was written by an older one"
        )
        raise DataFileError(
            part, found=f"schema version {number} of '{schema}'", expected=f"version {version}", remedy=remedy
        )


def _damaged(part: str, reason: str) -> DataFileError:
    return DataFileError(
        part,
        found=f"the file is truncated or damaged ({reason})",
        expected="a complete file",
        remedy="Write or copy it again: it was cut off while it was written or copied",
    )
