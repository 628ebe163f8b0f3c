"""One variant of a study, computed where it is sent to: in a worker process, on a cluster."""

from __future__ import annotations

import threading
import time
import warnings
from collections.abc import Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flexmb.errors import FlexmbError
from flexmb.files import remove_parts
from flexmb.parts.watchers import Count, watching
from flexmb.study.table import DONE, FAILED, Row

__all__ = ["Task", "warnings_by_thread"]


@dataclass(frozen=True)
class Task:
    """What all variants of a study have in common; it is sent to every worker.

    Parameters
    ----------
    source : ModelFile or FunctionSource
    outputs : sequence of str, or None
        See `flexmb.study.outputs.columns`.
    runs : str
        Folder that holds a run folder for every variant; "" keeps none.
    """

    source: Any
    outputs: Sequence[str] | None = None
    runs: str = ""

    def row(self, number: int, parameters: Mapping[str, Any]) -> Row:
        """Compute a variant; an error becomes the row's, whatever it is."""
        began = time.perf_counter()
        status, values, error = FAILED, {}, ""
        count = Count()
        with _noted_warnings() as noted, watching(count):
            try:
                values = self.source.values(parameters, self.outputs, self._folder(number))
                status = DONE
            except FlexmbError as problem:
                error = str(problem)
            except Exception as problem:  # of a user's function, or a defect: the other rows go on
                error = f"{type(problem).__name__}: {problem}"
        seconds = time.perf_counter() - began
        told = "; ".join(dict.fromkeys(noted()))
        return Row(number, parameters, status, values, seconds, error, told, count.reduced, count.reused)

    def _folder(self, number: int) -> Path | None:
        if not self.runs:
            return None
        folder = Path(self.runs) / f"{number:04d}"
        folder.mkdir(parents=True, exist_ok=True)
        remove_parts(folder)  # of a process that was killed over this variant
        return folder


_OWN = threading.local()
"""The texts of the warnings of a thread's variant, while `warnings_by_thread` holds."""


@contextmanager
def warnings_by_thread():
    """Give the warnings of threads to the variants that they compute: filters and display belong to all threads."""
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        shown = warnings.showwarning

        def note(message, *place, **more):
            texts = getattr(_OWN, "texts", None)
            if texts is None:
                shown(message, *place, **more)
            else:
                texts.append(str(message))

        warnings.showwarning = note
        yield


@contextmanager
def _noted_warnings():
    """Give a function that returns the texts of the warnings so far;
    in threads only those that `warnings_by_thread` gives them.
    """
    if threading.current_thread() is not threading.main_thread():
        _OWN.texts = texts = []
        try:
            yield lambda: texts
        finally:
            _OWN.texts = None
        return
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        yield lambda: [str(entry.message) for entry in caught]
