"""The one door to HDF5: files are opened, created and checked here, and nowhere else.

Every flexmb file carries two root attributes, ``schema`` (what it is) and ``schema_version`` (int). A file that is
missing, foreign, truncated or of another version is refused with a message that says what to do. A file that is being
written replaces the old one only when it is complete.
"""

from __future__ import annotations

import errno
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from flexmb.drain import Drain
from flexmb.errors import DataFileError, FlexmbError
from flexmb.files import complaints, on_disk, replacing
from flexmb.found import no_file_because
from flexmb.hdf5_parity import Mended, MendedStream, Rows, described, mend, rows_of
from flexmb.hdf5_seal import BROKEN, WHOLE, end_of, probe, seal, state_of
from flexmb.lock import locked_by_other
from flexmb.told import tell

if TYPE_CHECKING:
    import h5py

__all__ = ["end_of", "is_damaged", "lost_rows", "reading", "reading_foreign", "require_whole", "writing"]

_PURPOSES = {
    "flexmb.solution": "It is the solution of a run: give its folder to flexmb report, view, plot or export",
    "flexmb.modal_neutral_data": "It is a reduced body: flexmb show tells what is in it",
}
"""What to do with a good file of ours that is of another kind than the one wanted."""
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_lost: ContextVar[Mapping[str, tuple[int, int]]] = ContextVar("lost", default=MappingProxyType({}))
"""Rows that damage has cost the file that is being read, by dataset."""
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
    mended: Mended | None = None
    try:
        _check_signature(path, part, schema)
    except DataFileError:
        with suppress(OSError):  # it is not there, or may not be read
            mended = mend(path)  # its first bytes may be what is damaged
        if mended is None or not mended.damaged:
            raise
    with ExitStack() as stack:
        try:
            mended = mended or _check_seal(path, part)
            if mended is not None:
                _require_readable(mended, part)
            source = path if mended is None else stack.enter_context(MendedStream(path, mended))
            file = stack.enter_context(h5py.File(source, "r"))
        except OSError as error:
            raise _unreadable(part, error) from error
        lost = _lost.set({} if mended is None else mended.lost_rows() or {})
        stack.callback(_lost.reset, lost)
        try:
            _check_schema(file, part, schema, version)
            yield file
        except FlexmbError:
            raise
        except Exception as error:  # h5py raises whatever its library says, and what is read may have any shape
            raise _damaged(part, " ".join(str(error).strip("'\"").split()) or type(error).__name__) from error


def lost_rows(dataset: h5py.Dataset) -> tuple[int, int] | None:
    """Return the first and the last row of a dataset that damage has cost; None if it is whole."""
    return _lost.get().get(dataset.name.lstrip("/"))


def require_whole(group: h5py.Group, part: str) -> None:
    """Raise DataFileError if damage has cost anything in a group of the file that is being read."""
    within = group.name.lstrip("/")
    lost = {name: rows for name, rows in _lost.get().items() if not within or name.startswith(f"{within}/")}
    if lost:
        raise DataFileError(
            part,
            found=f"the file is damaged: lost are {described(lost)}",
            expected="the file as it was written",
            remedy="Copy it once more from where it was written, or make it again",
        )


def is_damaged(path: str | Path) -> bool:
    """Was a file changed after it was written, as far as its parity tells?"""
    if not Path(path).is_file() or state_of(path) == WHOLE:
        return False
    mended = mend(path)
    return mended is not None and bool(mended.damaged)


def _require_readable(mended: Mended, part: str) -> None:
    """Say what was damaged and restored; DataFileError if what is lost is more than rows of numbers."""
    count = sum(last - first for first, last in mended.damaged)
    places = ", ".join(f"{first} to {last - 1}" for first, last in mended.damaged[:4])
    where = f"it was changed after it was written, among bytes {places}{', ...' if len(mended.damaged) > 4 else ''}"
    lost = mended.lost_rows()
    if lost is None:
        raise DataFileError(
            part,
            found=f"the file is damaged: {where} ({count} bytes in all), more than can be restored",
            expected="the file as it was written",
            remedy="Copy it once more from where it was written, or make it again",
        )
    told = f"lost are {described(lost)}; all else" if lost else "all of it"
    tell(
        f"{part}: {where}; {told} was restored from its parity. Load it and save it again, or copy it once more, "
        "before more of it is damaged; look after the disk.",
        UserWarning,
    )


@contextmanager
def reading_foreign(path: str | Path, kind: str, part: str) -> Iterator[h5py.File]:
    """Open the HDF5 file of another program for reading, after a child process has read all of it.

    Raises
    ------
    DataFileError
        The file is missing, is not HDF5, is truncated or damaged, links to other files, or is larger than it may be.
    """
    import h5py

    path = Path(path)
    _check_signature(path, part, kind)
    try:
        reason = probe(path)
        if reason:
            raise _unreadable(part, OSError(reason))
        file = h5py.File(path, "r")
    except OSError as error:
        raise _unreadable(part, error) from error
    with file:
        yield file


@contextmanager
def writing(
    path: str | Path, *, schema: str | None = None, version: int | None = None, part: str = "", doing: str = "write"
) -> Iterator[h5py.File]:
    """Write a file beside its final place and move it there when it is complete.

    An exception inside the ``with`` block, or a killed process, leaves the old file as it was. Without `schema`
    the file gets no flexmb attributes (VTKHDF). Messages name the `part` and what was `doing`.

    Raises
    ------
    DataFileError
        The folder cannot be written, or the disk is full.
    """
    import h5py

    part = part or f"Data file '{path}'"
    with complaints(part, doing), replacing(path, part, doing) as temporary:
        rows: list[Rows] = []
        with Drain(temporary) as drain:
            try:
                with h5py.File(drain, "w", libver=_LIBVER) as file:
                    _stamp(file, schema, version)
                    yield file
                    rows = rows_of(file) if schema is not None else []
            finally:
                drain.complain()
        if schema is not None:
            seal(temporary, rows)
        on_disk(temporary)  # content and seal, before the name: a power cut leaves the old file or the new one


def _stamp(file: h5py.File, schema: str | None, version: int | None) -> None:
    if schema is not None:
        file.attrs["schema"] = schema
        file.attrs["schema_version"] = version


def _check_signature(path: Path, part: str, schema: str) -> None:
    if (found := no_file_because(path, (".h5",), "the file does not exist")) is not None:
        near = sorted(p.name for p in path.parent.glob(f"*{path.suffix}"))[:5] if path.parent.is_dir() else []
        there = f"The folder has: {', '.join(near)}" if near and "does not exist" in found.what else "Check the path"
        raise DataFileError(part, found=found.what, expected=f"a file of kind '{schema}'", remedy=found.remedy or there)
    try:
        with path.open("rb") as stream:
            head = stream.read(len(_SIGNATURE))
    except OSError as error:
        raise _unreadable(part, error) from error
    if head != _SIGNATURE:
        raise DataFileError(
            part,
            found=f"this is not an HDF5 file (it {f'begins with {head!r}' if head else 'is empty'})",
            expected=f"an HDF5 file of kind '{schema}'",
            remedy="Give the .h5 file that flexmb wrote; flexmb reduce makes one of a mesh"
            if schema.startswith("flexmb.")
            else "Write the file again, or give it the suffix of its format",
        )


def _check_seal(path: Path, part: str) -> Mended | None:
    """Return None if the file is what was written, else what of it can be restored; DataFileError if nothing can.

    A file without a seal must be read by a child first.
    """
    state = state_of(path)
    if state == WHOLE:
        return None
    mended = mend(path) if state == BROKEN else None
    if mended is not None and mended.damaged:
        if locked_by_other(path):  # who has opened it to write has marked it so
            raise _unreadable(part, OSError(errno.EAGAIN, "locked"))
        return mended
    reason = probe(path)
    if "unable to lock file" in reason:  # who has opened it to write has marked it so
        raise _unreadable(part, OSError(reason))
    if state == BROKEN:
        raise DataFileError(
            part,
            found="the file is damaged: its checksum does not match its content",
            expected="the file as it was written",
            remedy="Write or copy it again: bytes were changed after it was written",
        )
    if reason:
        raise _damaged(part, reason)
    return None


def _check_schema(file: h5py.File, part: str, schema: str, version: int) -> None:
    found = file.attrs.get("schema")
    if found != schema:
        what = "no schema attribute" if found is None else f"the schema '{found}'"
        right = _PURPOSES.get(str(found), "The file belongs to another purpose or program: give the right file")
        raise DataFileError(
            part,
            found=f"{what}",
            expected=f"the schema '{schema}'",
            remedy=right,
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


def _unreadable(part: str, error: OSError) -> DataFileError:
    """Return what to say of a file that cannot be opened: it may be all right, but in use, or private."""
    if error.errno in (errno.EAGAIN, errno.EWOULDBLOCK) or "unable to lock file" in str(error):
        return DataFileError(
            part,
            found="another program has locked it",
            expected="a file that may be read",
            remedy="Close it there, or wait until it has been written; set HDF5_USE_FILE_LOCKING=FALSE to read it all "
            "the same",
        )
    if error.errno in (errno.EACCES, errno.EPERM):
        return DataFileError(
            part,
            found=f"it may not be read ({error.strerror or error})",
            expected="a file with the permission to read it",
            remedy="Ask its owner, or copy it",
        )
    return _damaged(part, str(error))


def _damaged(part: str, reason: str) -> DataFileError:
    return DataFileError(
        part,
        found=f"the file is truncated or damaged ({reason})",
        expected="a complete file",
        remedy="Write or copy it again: it was cut off while it was written or copied",
    )
