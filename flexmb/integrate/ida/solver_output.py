"""Standard output without what the solver of SUNDIALS prints about its failures."""

from __future__ import annotations

import sys
import threading
from typing import Any

__all__ = ["OUTPUT", "WithoutErrors"]


class WithoutErrors:
    """While a solver steps, standard output without what it prints about its failures: `Outcome` says it, with the
    part's name. The output is one for all threads, so it is filtered while any solver steps.
    """

    def __init__(self):
        self._lock, self._steps, self._target = threading.Lock(), 0, sys.stdout
        self._own = threading.local()

    def __enter__(self) -> None:
        with self._lock:
            if sys.stdout is not self:
                self._target, sys.stdout = sys.stdout, self
            self._steps += 1

    def __exit__(self, *error: object) -> None:
        with self._lock:
            self._steps -= 1
            if self._steps == 0 and sys.stdout is self:
                sys.stdout = self._target

    def write(self, text: str) -> int:
        begins = text.startswith("\n[IDA")
        if not (begins or (getattr(self._own, "ends", False) and text == "\n")):
            self._target.write(text)
        self._own.ends = begins  # print() writes the end of the line by itself
        return len(text)

    def flush(self) -> None:
        self._target.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._target, name)


OUTPUT = WithoutErrors()
"""Of this process."""
