"""Compiled kernels kept on disk, one file each, named by all that its machine code depends on.

A file is found by its name alone, so no index can be out of date. An existing file fits: other code, other constants,
other types, another processor or another numba have another name. Copies of the package at several places, and several
versions of it, share one folder. A file that is cut off or damaged is removed and made again; where nothing can be
written, kernels are compiled in every process.
"""

from __future__ import annotations

import os
import pickle
import sys
import tempfile
import time
import warnings
from contextlib import suppress
from functools import cache
from hashlib import blake2b
from pathlib import Path
from types import FunctionType

import numba
from numba.core import config
from numba.core.caching import _Cache
from numba.core.runtime import rtsys
from numba.core.serialize import dumps
from numba.core.typing import Signature

from flexmb.math.kernel_claims import claim, is_claimed, release
from flexmb.math.kernel_content import UnknownContent, code_digest, type_text
from flexmb.math.kernel_library import rebuilt, reduced
from flexmb.math.shipped_kernels import BASELINES, SHIPPED, lacking, why_unused

__all__ = ["KernelCache", "kernel_folder"]

FORMAT = b"flexmb kernel 3\n"
COMPILER = (
    "borrowing",
    "own_room",
    "element_lowering",
    "kernel_library",
    "remembered_types",
    "spared_passes",
    "structure_lowering",
    "structure_type",
)
"""Files beside this one that make machine code of kernels, with numba."""
CHECK = 32  # bytes of the checksum that follows
UNUSED_DAYS = 60  # after which a file of the same kernel is removed


def kernel_folder() -> Path:
    """Return the folder of compiled kernels: below ``NUMBA_CACHE_DIR`` if it is set, else the user's cache folder."""
    return Path(config.CACHE_DIR) / "flexmb" if config.CACHE_DIR else user_cache() / "flexmb" / "kernels"


def user_cache() -> Path:
    """Return the folder in which programs of this user keep what they can make again."""
    if sys.platform == "win32":
        home = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
    elif sys.platform == "darwin":
        home = Path.home() / "Library" / "Caches"
    else:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(home)


class KernelCache(_Cache):
    """The compiled versions of one function; numba asks it before compiling and hands it what was compiled."""

    def __init__(self, function: FunctionType, options: dict):
        self._function = function
        self._options = sorted((name, repr(value)) for name, value in options.items())
        self._enabled = True
        self._claimed: dict = {}  # paths of what is being compiled: numba may read its settings anew meanwhile

    @property
    def cache_path(self) -> str:
        """The folder of this function's files."""
        return str(kernel_folder() / self._function.__module__)

    def enable(self) -> None:
        self._enabled = True

    def disable(self) -> None:
        self._enabled = False

    def flush(self) -> None:
        """Remove all compiled versions of this function."""
        for path in Path(self.cache_path).glob(f"{_file_stem(self._function)}-*"):
            path.unlink(missing_ok=True)

    def load_overload(self, sig, target_context):
        """Return what was compiled for these argument types, or None: here for this processor, or with the package."""
        rtsys.initialize(target_context)  # compiling makes the rest ready: types, operators and functions of numba
        if not self._enabled:
            return None
        paths = self._paths(sig, target_context)
        for path in paths:
            found = self._loaded(path, target_context)
            if found is not None:
                return found
        own = paths[0] if paths else None
        self._claimed[sig] = own
        if own is not None and claim(own):
            found = self._loaded(own, target_context)
            if found is not None:
                return found
        if self._function.__module__.startswith("flexmb."):
            announce_compiling()
        return None

    def holds(self, sig, target_context) -> bool:
        """Is there a file for these argument types?"""
        return any(path.exists() for path in self._paths(sig, target_context))

    def is_being_compiled(self, sig, target_context) -> bool:
        """Is a process compiling for these argument types?"""
        return any(map(is_claimed, self._paths(sig, target_context)[:1]))

    def _paths(self, sig, target_context) -> list[Path]:
        """Return where machine code may be: made for this processor, and come with the package; none if it is not
        kept."""
        native = target_context.codegen().magic_tuple()
        baseline = _baseline(*native)
        places = [(kernel_folder(), native)] + ([(SHIPPED, baseline)] if baseline else [])
        found = [self._path(folder, sig, target) for folder, target in places]
        return [path for path in found if path is not None]

    @staticmethod
    def _loaded(path: Path, target_context):
        """Return the machine code of a file, or None; a file that does not fit is removed."""
        content = _read(path)
        if content is None:
            return None
        try:
            return rebuilt(target_context, *pickle.loads(content))
        except Exception:  # whatever unpickling finds in a file of a release that wrote it otherwise
            _remove(path)
            return None

    def save_overload(self, sig, data) -> None:
        """Keep what was compiled for these argument types."""
        path = self._claimed.pop(sig, None)
        if path is None:
            return
        try:
            if data.library.has_dynamic_globals or any(not part.can_cache for part in data.lifted):
                return
            _write(path, dumps(reduced(data)))
            _remove_unused(path.parent, f"{_file_stem(self._function)}-*")
        except OSError as error:
            _warn_once(path.parent, error)
        finally:
            release(path)

    def _path(self, folder: Path, sig, target: tuple) -> Path | None:
        """Return the file of one version compiled for a target, None if its content cannot be told."""
        arguments, result = (sig.args, sig.return_type) if isinstance(sig, Signature) else (sig, None)
        settings = config.OPT, config.BOUNDSCHECK, config.USING_SVML
        try:
            name = [
                f"{FORMAT!r}, numba {numba.__version__}, Python {sys.version_info[:2]}, {settings}",
                compiler_digest(),
                repr(target),
                code_digest(self._function),
                repr(self._options),
                *map(type_text, arguments),
                "" if result is None else type_text(result),
            ]
        except UnknownContent:
            return None
        digest = blake2b("\n".join(name).encode(), digest_size=16).hexdigest()
        return folder / self._function.__module__ / f"{_file_stem(self._function)}-{digest}"


@cache
def compiler_digest() -> str:
    """Return a digest of our part of the compiler: other machine code has another name."""
    found = blake2b(digest_size=16)
    for name in COMPILER:
        found.update(Path(__file__).with_name(f"{name}.py").read_bytes())
    return found.hexdigest()


@cache
def _baseline(triple: str, processor: str, features: str) -> tuple[str, str, str] | None:
    """Return what shipped kernels are compiled for, None if this processor lacks a feature or was not the host's."""
    name, needed = BASELINES.get(triple.partition("-")[0], ("", ""))
    if not name or not SHIPPED.is_dir() or config.CPU_NAME or config.CPU_FEATURES:
        return None
    return None if lacking(needed) else (triple, name, "")


def _file_stem(function: FunctionType) -> str:
    return function.__qualname__.replace("<", "").replace(">", "")


def _read(path: Path) -> bytes | None:
    """Return the content of a file, None if there is none or it is damaged (then it is removed)."""
    try:
        raw = path.read_bytes()
    except OSError:
        return None
    start = len(FORMAT) + CHECK
    content = raw[start:]
    if raw[:start] == FORMAT + blake2b(content, digest_size=CHECK).digest():
        _note_use(path)
        return content
    _remove(path)
    return None


def _write(path: Path, content: bytes) -> None:
    """Write a file so that other processes see all of it or nothing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=".", suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(FORMAT + blake2b(content, digest_size=CHECK).digest() + content)
        os.replace(name, path)
    except BaseException:
        _remove(Path(name))
        raise


def _remove(path: Path) -> None:
    with suppress(OSError):  # of a folder that may only be read: the file is passed over each time
        path.unlink(missing_ok=True)


def _note_use(path: Path) -> None:
    with suppress(OSError):  # of a folder that may only be read
        if time.time() - path.stat().st_mtime > 86400.0:
            os.utime(path)


def _remove_unused(folder: Path, pattern: str) -> None:
    oldest = time.time() - UNUSED_DAYS * 86400.0
    for path in folder.glob(pattern):
        with suppress(OSError):  # another process removed it meanwhile: nothing to warn of
            if path.stat().st_mtime < oldest:
                path.unlink(missing_ok=True)


@cache
def announce_compiling() -> None:
    """Say once in a process that it takes long because kernels are compiled, unless FLEXMB_QUIET is set."""
    if not os.environ.get("FLEXMB_QUIET"):
        reason = why_unused(SHIPPED)
        print(
            f"flexmb: compiling kernels{reason and f', as {reason}'} (once on this machine, "
            f"kept in {kernel_folder()}; `flexmb warm` compiles all)",
            file=sys.stderr,
            flush=True,
        )


_warned: set[Path] = set()


def _warn_once(folder: Path, error: OSError) -> None:
    if kernel_folder() not in _warned:
        _warned.add(kernel_folder())
        warnings.warn(
            f"Compiled kernels cannot be kept in '{folder}' ({error.strerror}): every process compiles them again. "
            "Set NUMBA_CACHE_DIR to a folder that can be written to.",
            RuntimeWarning,
            stacklevel=2,
        )
