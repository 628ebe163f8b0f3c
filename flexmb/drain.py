"""`Drain`: a file for HDF5 to write to that never fails, but says afterwards that it did.

HDF5 does not survive a write that fails. It keeps the data as still to be written, fails once more when the file is
closed, and ends the process when the program ends. So what cannot be written is taken and dropped, small pieces (what
HDF5 notes about its data, and reads again) are kept in memory, and the error is raised in the end.
"""

from __future__ import annotations

import os
import signal
from pathlib import Path
from types import FrameType
from typing import Any

__all__ = ["Drain"]

_SMALL = 1 << 16
"""Bytes of what is still remembered when it cannot be written."""
_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Drain:
    """A file object for h5py; use it in a ``with`` block and call `complain` when HDF5 has closed it.

    Signals that come while HDF5 writes wait until it has: an exception of their handlers would be a write that fails.
    """

    def __init__(self, path: str | Path):
        self._file = Path(path).open("w+b", buffering=0)  # noqa: SIM115 - open until the end of the block
        self._error: OSError | None = None
        self._kept: dict[int, bytes] = {}
        self._place = self._size = 0
        self._before: dict[int, Any] = {}
        self._waiting: list[int] = []

    def __enter__(self) -> Drain:
        try:
            for number in _SIGNALS:
                before = signal.getsignal(number)
                if callable(before):
                    signal.signal(number, self._signalled)
                    self._before[number] = before
        except ValueError:  # not the main thread: no handler runs in this one
            self._before = {}
        return self

    def __exit__(self, *exception) -> None:
        self._file.close()
        for number, before in self._before.items():
            signal.signal(number, before)
        for number in self._waiting:
            signal.raise_signal(number)

    def _signalled(self, number: int, frame: FrameType | None) -> None:
        """Hand a signal on, unless it has come inside of a write."""
        if frame is not None and frame.f_code in _CODES:
            self._waiting.append(number)
        else:
            self._before[number](number, frame)

    def complain(self) -> None:
        """Raise the error of the first write that failed, if one did."""
        if self._error is not None:
            raise self._error

    def write(self, data) -> int:
        """Write all of `data` at the present place, or make a note that it is not there."""
        data = memoryview(data).cast("B")
        place, end = self._place, self._place + len(data)
        if self._error is None:
            try:
                self._file.seek(place)
                done = 0
                while done < len(data):  # near the end of the space a write may take a part only
                    done += self._file.write(data[done:]) or 0
            except OSError as error:
                self._error = error
        if self._error is not None and len(data) <= _SMALL:
            self._kept[place] = bytes(data)
        self._place, self._size = end, max(self._size, end)
        return len(data)

    def readinto(self, buffer) -> int:
        """Read what has been written at the present place."""
        whole = memoryview(buffer).cast("B")
        whole[:] = bytes(len(whole))
        place, end = self._place, self._place + len(whole)
        try:
            self._file.seek(place)
            self._file.readinto(whole)
        except OSError as error:
            self._error = self._error or error
        for start, data in self._kept.items():
            first, last = max(start, place), min(start + len(data), end)
            if first < last:
                whole[first - place : last - place] = data[first - start : last - start]
        self._place = end
        return len(whole)

    def read(self, count: int = -1) -> bytes:
        """Return so many bytes from the present place, by default all."""
        buffer = bytearray(max(self._size - self._place, 0) if count < 0 else count)
        self.readinto(buffer)
        return bytes(buffer)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Go to a place."""
        self._place = offset + (0, self._place, self._size)[whence]
        return self._place

    def tell(self) -> int:
        """Return the present place."""
        return self._place

    def truncate(self, size: int | None = None) -> int:
        """Give the file a size."""
        size = self._place if size is None else size
        if self._error is None:
            try:
                self._file.truncate(size)
            except OSError as error:
                self._error = error
        self._size = size
        return size

    def flush(self) -> None:
        """Do nothing: there is no buffer."""


_CODES = {
    function.__code__
    for function in (Drain.write, Drain.readinto, Drain.read, Drain.seek, Drain.tell, Drain.truncate, Drain.flush)
}
