"""Reduced parts on disk by what they are made from: each is reduced once, by whichever process comes first."""

from __future__ import annotations

import hashlib
import json
import os
import time
import warnings
from collections.abc import Callable
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from flexmb.errors import DataFileError, ValidityWarning
from flexmb.fem.meshes.mesh import MeshWarning
from flexmb.files import remove_parts
from flexmb.lock import Lock
from flexmb.math.kernel_cache import user_cache
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.model.modal_neutral_file import kept_as, load_kept, save
from flexmb.parts.watchers import tell_made, tell_progress, tell_taken, tell_trouble
from flexmb.told import Told, listening, repeat

__all__ = ["BodyCache", "body_folder", "clear_bodies", "kept", "kept_bodies"]

ROOMS = ("fem", "math", "model", "parts", "reduction")
"""Rooms whose code decides what a reduction gives."""
BYTES = 10_000_000_000
"""What the folder may hold; those that were not used for longest go."""
CATEGORIES: dict[str, type[Warning]] = {kind.__name__: kind for kind in (MeshWarning, ValidityWarning)}
"""Warnings that are given as parts are made; others are UserWarnings."""
LOOK = 0.1
"""s between two looks whether another process is done."""


class BodyCache(NamedTuple):
    """An entry of the cache: name of the part, file, bytes, and time of its last use (s since 1970).

    The name is that of the body in the file; where it cannot be read, that of the file. `wrong` says what is damaged,
    or belongs to another name, and is not taken; empty for a good entry. `current` is False for one of other code.
    """

    name: str
    path: Path
    size: int
    used: float
    wrong: str = ""
    current: bool = True

    @property
    def names(self) -> set[str]:
        """The names of what is in the file and of the file; they differ where something is wrong."""
        return {self.name, _named(self.path)}


def body_folder() -> Path:
    """Return the folder of reduced parts: ``FLEXMB_BODIES`` if it is set, else in the user's cache folder."""
    given = os.environ.get("FLEXMB_BODIES")
    return Path(given).expanduser() if given else user_cache() / "flexmb" / "bodies"


@cache
def release() -> str:
    """Return a digest of the code that reduces: data of other code are not taken."""
    digest = hashlib.sha256()
    for room in ROOMS:
        for path in sorted((Path(__file__).parents[1] / room).rglob("*.py")):
            digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def kept(name: str, recipe: dict[str, Any], make: Callable[[], ModalNeutralData]) -> ModalNeutralData:
    """Return the data of a recipe from the cache, or make and keep them.

    Of several processes that want the same part one makes it, the others wait. Warnings that were given as it was made
    are given again whenever it is taken. The file holds the whole recipe: an entry of another one, and a damaged entry,
    are made again. Where nothing can be kept, because the disk is full or the folder may not be written, the data are
    made and used.
    """
    recipe["release"] = release()
    key = json.dumps(recipe, sort_keys=True)
    path = body_folder() / _file_name(name, key)
    found = _stored(name, path, key)
    if found is not None:
        tell_taken(name)
        return found
    with _turn(name, path) as may_write:
        found = _stored(name, path, key)  # made by another one meanwhile
        if found is not None:
            tell_taken(name)
            return found
        began = time.perf_counter()
        with listening() as told:
            data = make()
        if may_write:
            try:
                save(data, path, [(category.__name__, text) for category, text in dict.fromkeys(told)], key)
                _trim(path)
            except (DataFileError, OSError) as error:
                why = error.found if isinstance(error, DataFileError) else str(error)
                tell_trouble(
                    name,
                    f"it could not be kept for the next time in {path.parent}: {why}. Free space, for one by flexmb "
                    "cache --clear, or let FLEXMB_BODIES name another folder",
                )
        tell_made(name, time.perf_counter() - began)
    return data


def kept_bodies() -> list[BodyCache]:
    """Return what the cache holds, last used first; every file is read for what it is, whatever its name says."""
    return [entry._replace(**_looked_at(entry)) for entry in _entries()]


def clear_bodies(names: tuple[str, ...] = ()) -> list[BodyCache]:
    """Remove all entries, or the entries of parts with these names, and return what was removed.

    A file whose content is another part than its name says goes by both names.
    """
    removed = []
    for entry in kept_bodies() if names else _entries():
        if not names or entry.names & set(names):
            with suppress(IsADirectoryError, PermissionError):  # no file of ours
                entry.path.unlink(missing_ok=True)
                removed.append(entry)
    if not names and body_folder().is_dir():
        remove_parts(body_folder())
    return removed


def _entries() -> list[BodyCache]:
    """Return the files of the cache by their names, last used first; none is opened."""
    entries = []
    for path in body_folder().glob("*-*.h5"):
        with suppress(OSError):  # removed meanwhile
            info = path.stat()
            entries.append(BodyCache(_named(path), path, info.st_size, info.st_mtime))
    return sorted(entries, key=lambda entry: -entry.used)


def _looked_at(entry: BodyCache) -> dict[str, Any]:
    """Return name and state of an entry by its content."""
    try:
        with warnings.catch_warnings():  # what was restored is restored again on use, and told there
            warnings.simplefilter("ignore", UserWarning)
            name, key = kept_as(entry.path)
    except (DataFileError, OSError) as error:
        found = error.found if isinstance(error, DataFileError) else error
        return {"wrong": f"damaged: {found}"}
    if not key:
        return {"name": name, "wrong": "foreign: a reduced body that the cache did not keep"}
    if entry.path.name != _file_name(name, key):
        whose = f"under the name of another entry, '{entry.name}'" if _safe(name) != entry.name else "of another recipe"
        return {"name": name, "wrong": f"foreign: part '{name}' {whose}"}
    return {"name": name, "current": json.loads(key).get("release") == release()}


def _stored(name: str, path: Path, key: str) -> ModalNeutralData | None:
    """Return the data of an entry; one that is damaged, or of another key, is dropped."""
    if not path.is_file():
        return None
    try:
        found = load_kept(path, ModalNeutralData)
        if found.key != key:
            what = f"holds part '{found.data.name}' of another description" if found.key else "was not kept by it"
            _drop(name, path, f"its entry in the cache {what}, and is made again ({path})")
            return None
    except (DataFileError, OSError) as error:
        _drop(name, path, f"its entry in the cache was damaged and is made again ({error})")
        return None
    with suppress(OSError):
        os.utime(path)
    repeat(Told(CATEGORIES.get(category, UserWarning), text) for category, text in found.told)
    return found.data


def _drop(name: str, path: Path, why: str) -> None:
    """Remove an entry that is not what it should be, and tell."""
    with suppress(OSError):
        path.unlink(missing_ok=True)
    tell_trouble(name, why)


@contextmanager
def _turn(name: str, path: Path):
    """Wait until no other process makes the same entry; give whether the folder can be written."""
    lock = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        while lock is None:
            try:
                lock = Lock(path, f"Part '{name}'")
            except DataFileError:  # held
                tell_progress(name, "waiting for another process that reduces it", 0.0)
                time.sleep(LOOK)
    except OSError as error:
        tell_trouble(name, f"it cannot be kept for the next time ({path.parent}: {error.strerror or error})")
    try:
        yield lock is not None
    finally:
        if lock is not None:
            lock.release()


def _trim(newest: Path) -> None:
    """Remove what was not used for longest until the folder holds no more than it may."""
    total = 0
    for entry in _entries():
        total += entry.size
        if total > BYTES and entry.path != newest:
            entry.path.unlink(missing_ok=True)


def _file_name(name: str, key: str) -> str:
    """Return the file of a part and a key."""
    return f"{_safe(name)}-{hashlib.sha256(key.encode()).hexdigest()[:32]}.h5"


def _named(path: Path) -> str:
    """Return the part that the name of a file says."""
    return path.stem.rpartition("-")[0]


def _safe(name: str) -> str:
    """Return a name as part of a file name."""
    return "".join(c if c.isascii() and (c.isalnum() or c == "_") else "_" for c in name)[:60] or "part"
