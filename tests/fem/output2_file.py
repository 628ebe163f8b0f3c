"""Writes matrices to an OUTPUT2 file of Nastran, 32-bit words, as NX Nastran 9.1 lays them out.

Every record stands between its lengths in bytes; a record of one word before it is a key: the number of its words, 0
or a negative counter at an end. Columns are strings of values that are not zero, each with the row of its first value.
"""

import struct

import numpy as np

LABEL = b"NASTRAN FORT TAPE ID CODE - "


def record(data: bytes) -> bytes:
    return struct.pack("<i", len(data)) + data + struct.pack("<i", len(data))


def keys(*numbers: int) -> bytes:
    return b"".join(record(struct.pack("<i", number)) for number in numbers)


def head() -> bytes:
    date = struct.pack("<3i", 6, 10, 15)
    return keys(3) + record(date) + keys(7) + record(LABEL) + keys(2) + record(b"NX9.1   ") + keys(-1, 0)


def matrix(name: str, values: np.ndarray, trailer=None, second: bytes | None = None) -> bytes:
    """Return the data block of a real matrix of double precision."""
    word = f"{name:8}".encode()
    numbers = trailer or (101, values.shape[1], values.shape[0], 6, 2, 2, 0)
    text = keys(2) + record(word) + keys(-1, 7) + record(struct.pack("<7i", *numbers)) + keys(-2, 1, 0, 4)
    text += record(second or word + bytes(8)) + keys(-3, 1, 1)
    for number, column in enumerate(values.T):
        rows = np.flatnonzero(column)
        for string in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1):
            if len(string):
                text += keys(len(string) + 1)
                text += record(struct.pack("<i", string[0] + 1) + column[string].astype("<f8").tobytes())
        text += keys(-4 - number, 1, int(number + 1 < values.shape[1]))
    return text + keys(0)


def table(name: str) -> bytes:
    """Return the data block of a table of one record."""
    word = f"{name:8}".encode()
    text = keys(2) + record(word) + keys(-1, 7) + record(struct.pack("<7i", 101, 1, 0, 0, 0, 0, 0)) + keys(-2, 1, 0, 2)
    return text + record(word) + keys(-3, 1, 0, 3) + record(struct.pack("<3i", 1, 2, 3)) + keys(-4, 1, 0, 0)


def output2(*blocks: bytes) -> bytes:
    return head() + b"".join(blocks) + keys(0)
