"""The compiled library that PythonFMU3 and PythonFMU put into a unit, kept from releasing its state twice.

The library holds a shared object from its first instance on. When the process ends, the object is released by its own
destructor and once more by the library's (PythonFMU3 0.3.4, PythonFMU 0.7.0: ``onLibraryUnload`` runs after the
destructors of static objects, and the library is never unloaded before because it has unique symbols). The second
release writes into freed memory: "corrupted double-linked list", or signal 11. Released once before, it is empty then.
"""

from __future__ import annotations

import atexit
import ctypes
import os
from pathlib import Path

__all__ = ["release", "release_at_exit"]


def release(library: ctypes.CDLL) -> None:
    """Release what the library of a unit holds for all its instances, if it is one of PythonFMU3 or PythonFMU.

    Instances that live hold it, too, and go on.
    """
    if os.name == "posix" and hasattr(library, "finalizePythonInterpreter"):
        library.finalizePythonInterpreter()


def release_at_exit(resources: str | Path) -> None:
    """Release the state of the library of this unit when Python ends; nothing while the unit is built.

    Parameters
    ----------
    resources : path
        The unit's folder of resources; its libraries lie beside it.
    """
    if os.name != "posix":
        return
    for path in Path(resources).resolve().parent.glob("binaries/*/*"):
        try:
            library = ctypes.CDLL(str(path), mode=os.RTLD_NOLOAD | os.RTLD_LAZY)  # only the one that has been loaded
        except OSError:
            continue
        atexit.register(release, library)
