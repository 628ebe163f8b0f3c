"""Units of other programs as files: read, unpacked, and refused where they cannot run here."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from flexmb.errors import DataFileError, FlexmbError, IntegrationError, ModelError
from flexmb.fmi.archive import require_archive
from flexmb.found import no_file_because

__all__ = ["FATAL", "Speaking", "fmpy_package", "load_unit", "read_unit", "require_platform", "what_it_is_for"]

FATAL = 4
"""Status of a unit that may not be called any more."""


def fmpy_package() -> Any:
    """Return the package fmpy with both versions; DataFileError if it is not installed."""
    try:
        import fmpy
        import fmpy.fmi2
        import fmpy.fmi3
    except ImportError:
        raise DataFileError(
            "Fmu",
            found="the package fmpy is not installed",
            expected="fmpy, which loads units",
            remedy='pip install "flexmb[fmi]"',
        ) from None
    return fmpy


def read_unit(path: Path, title: str, folder: str) -> tuple[Any, Any, str]:
    """Return fmpy, the description of a unit, and where it was unpacked; DataFileError if it is none."""
    fmpy = fmpy_package()
    if (found := no_file_because(path, (".fmu",))) is not None:
        remedy = found.remedy or "Correct the path"
        raise DataFileError(title, found=found.what, expected="an .fmu file", remedy=remedy)
    require_archive(path, title)
    try:
        about = fmpy.read_model_description(str(path), validate=False)  # small faults do not matter
        unpacked = fmpy.extract(str(path), folder)
    except Exception as error:  # whatever the reader meets in a foreign file
        raise DataFileError(
            title, found=f"it cannot be read: {error}", expected="a unit of FMI 2 or 3", remedy="Export it again"
        ) from None
    return fmpy, about, str(unpacked)


def what_it_is_for(about: Any, missing: str) -> str:
    """Return the version of a unit in words, with the kind of use that it is not for, and those that it is."""
    kinds = {"coSimulation": "co-simulation", "modelExchange": "model exchange", "scheduledExecution": "clocks"}
    offers = [word for field, word in kinds.items() if getattr(about, field, None) is not None]
    return f"FMI {about.fmiVersion}" + (
        f" without {missing}, for {' and '.join(offers) or 'no use'}" if missing else ""
    )


def require_platform(fmpy: Any, path: Path, title: str) -> None:
    """Raise ModelError if the unit has no binary for this platform."""
    platforms = fmpy.supported_platforms(str(path))
    if fmpy.platform not in platforms and fmpy.platform_tuple not in platforms:
        raise ModelError(
            title,
            found=f"binaries for {', '.join(platforms) or 'no platform'}",
            expected=f"one for {fmpy.platform_tuple}",
            remedy="Export it for this platform",
        )


def load_unit(kind: Any, about: Any, identifier: str, unpacked: str, path: Path, title: str) -> Any:
    """Return a unit with its library loaded, as an object of a class of fmpy; DataFileError if that is not possible.

    The working folder stays: fmpy goes to the library's, and does not come back if it cannot be loaded.
    """
    try:
        here = os.getcwd()
    except OSError:
        raise DataFileError(
            title,
            found="the working folder does not exist any more",
            expected="one to come back to after the library is loaded",
            remedy="Go to another folder",
        ) from None
    try:
        return kind(guid=about.guid, unzipDirectory=unpacked, modelIdentifier=identifier, instanceName=path.stem)
    except Exception as error:  # foreign code, and whatever the file names as its library
        raise DataFileError(
            title,
            found=f"its library cannot be loaded: {error}",
            expected=f"a library '{identifier}' for this platform, with the functions of FMI {about.fmiVersion}",
            remedy="Export it again for this platform; install what its library needs",
        ) from None
    finally:
        os.chdir(here)


class Speaking:
    """Turns what a unit fails with into an error with its name, and keeps its status in `worst` of its owner."""

    def __init__(self, owner: Any, what: str):
        self.owner, self.what = owner, what

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind, error, trace) -> None:
        if not isinstance(error, Exception) or isinstance(error, FlexmbError):
            return
        self.owner.worst = getattr(error, "status", FATAL)  # without a status nothing is known of its state
        raise IntegrationError(
            self.owner.title,
            found=f"the unit {self.what}: {error}",
            expected="a unit that takes the step",
            remedy="Look at its inputs and at its log; try a shorter communication step",
        ) from None
