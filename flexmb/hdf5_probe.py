"""Reads everything in an HDF5 file, in a process of its own: ``python hdf5_probe.py FILE MEMORY``.

The HDF5 library trusts what it reads: one changed byte can make it end the process, loop without end, or ask for all
memory. A file that nobody vouches for is therefore read here first; what this process survives the next one survives.
This file is run by its path and imports nothing of flexmb, which would take longer than the reading.
"""

from __future__ import annotations

import sys

OBJECTS = 100_000
"""Groups and datasets of one file."""
ATTRIBUTE = 64_000_000
"""Bytes of one attribute: the text of a model."""
PER_BYTE, FEW = 100, 100_000_000
"""Bytes of all datasets for a byte of the file, and of any file: gzip gives 1032, but only of zeros."""
PIECE = 16_000_000
"""Bytes that are read at a time."""


class Refused(Exception):
    """The file holds something that no file of flexmb holds."""


def walk(file, size: int) -> None:
    """Read all attributes and datasets of an open file of `size` bytes; Refused, or whatever h5py raises."""
    import h5py

    waiting, seen, total = [file], set(), 0
    while waiting:
        group = waiting.pop()
        attributes(group)
        for name in group:
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                raise Refused(f"'{name}' is a link to another place")
            thing = group[name]
            address = h5py.h5o.get_info(thing.id).addr
            if address in seen:
                raise Refused(f"'{name}' is in the file twice")
            seen.add(address)
            if len(seen) > OBJECTS:
                raise Refused(f"more than {OBJECTS} groups and datasets")
            if isinstance(thing, h5py.Group):
                waiting.append(thing)
            elif isinstance(thing, h5py.Dataset):
                total += thing.size * thing.dtype.itemsize
                if total > FEW + PER_BYTE * size:
                    raise Refused(f"the datasets up to '{name}' {thing.shape} have {total:.3g} bytes, the file {size}")
                attributes(thing)
                dataset(thing, name)
            else:
                raise Refused(f"'{name}' is neither group nor dataset")


def attributes(thing) -> None:
    import h5py

    for name in thing.attrs:
        if h5py.h5a.open(thing.id, name.encode()).get_storage_size() > ATTRIBUTE:
            raise Refused(f"the attribute '{name}' has more than {ATTRIBUTE} bytes")
        thing.attrs[name]


def dataset(data, name: str) -> None:
    """Read a dataset piece by piece."""
    if data.is_virtual or data.external or data.dtype.base.kind not in "fiub":
        raise Refused(f"the dataset '{name}' is stored elsewhere, or holds no numbers ({data.dtype})")
    if data.ndim == 0 or data.size == 0:
        data[()]
        return
    step = max(1, PIECE // max(1, data.nbytes // len(data)))
    for start in range(0, len(data), step):
        data[start : start + step]


def limit_memory(memory: int) -> None:
    try:
        import resource
    except ImportError:  # Windows has no such limits
        return
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def main() -> int:
    import os

    import h5py

    path, memory = sys.argv[1], int(sys.argv[2])
    limit_memory(memory)
    try:
        with h5py.File(path, "r") as file:
            walk(file, os.path.getsize(path))
    except Exception as error:
        print(" ".join(f"{error}".split())[:200] or type(error).__name__)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
