"""Matrices of Nastran in OUTPUT2 files (.op2), read by pyYeti: stiffness and mass of all grid points.

Rows are as in OUTPUT4 files: the six freedoms of every grid point in ascending order of the numbers. The tables of the
file (geometry, results) are passed over.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.matrices.matrix_files import FileMatrices
from flexmb.fem.matrices.nastran import MASS, STIFFNESS
from flexmb.fem.matrices.op4 import stiffness_and_mass

__all__ = ["read_op2"]

MOST = 30_000
"""Rows of a matrix; pyYeti makes it full, which is 7 GB here."""


def read_op2(path: Path, mass: Path | None) -> FileMatrices:
    """Return the stiffness and the mass matrix, from one file or two."""
    found = _matrices(path, (*STIFFNESS, *MASS))
    if mass is not None:
        found = {**_matrices(mass, MASS), **found}
    return stiffness_and_mass(f"Matrix file '{path}'", found, "OUTPUT2 KGG,MGG//0/11")


def _matrices(path: Path, wanted: tuple[str, ...]) -> dict[str, np.ndarray | None]:
    """Return the wanted matrices of a file by name; others have a name only."""
    part = f"Matrix file '{path}'"
    try:
        with np.printoptions():  # pyYeti changes how all arrays are printed
            from pyyeti.nastran.op2 import OP2
    except ImportError:
        raise MeshError(
            part,
            found="no package that reads OUTPUT2 files",
            expected="pyYeti",
            remedy="pip install 'flexmb[op2]', or punch the matrices as DMIG",
        ) from None
    _check_records(part, path)
    with OP2(str(path)) as file:
        matrices = [block for block in file.dblist if block.dbtype > 0]
        if not matrices:
            tables = ", ".join(dict.fromkeys(block.name for block in file.dblist)) or "nothing"
            raise MeshError(
                part,
                found=f"no matrices, only tables: {tables[:200]}",
                expected="stiffness and mass matrices, such as KGG and MGG",
                remedy="Add OUTPUT2 KGG,MGG//0/11 by DMAP, or punch the matrices with EXTSEOUT(DMIGPCH)",
            )
        names = [block.name.upper() for block in matrices]
        for name in wanted:
            if names.count(name) > 1:
                raise MeshError(
                    part,
                    found=f"{names.count(name)} matrices named {name}",
                    expected="one of each name",
                    remedy="Write the matrices of every superelement to a file of its own",
                )
        found: dict[str, np.ndarray | None] = {}
        for name, block in zip(names, matrices):
            if name in wanted and max(block.size) > MOST:
                raise MeshError(
                    part,
                    found=f"{name} with {block.size[0]} rows and {block.size[1]} columns",
                    expected=f"at most {MOST}: the matrix is made full while it is read",
                    remedy="Write large matrices with OUTPUT4, which are read as sparse ones",
                )
            found[name] = file.rdop2mats([name])[name] if name in wanted else None
    return found


def _check_records(part: str, path: Path) -> None:
    """Raise MeshError unless the records follow each other to the end of the file, each between its lengths in bytes.

    In a damaged file pyYeti may go back to a place where it was before, without end.
    """
    with path.open("rb") as file:
        data, place = file.read(4), 0
        length = struct.Struct("<i" if data in (b"\4\0\0\0", b"\10\0\0\0") else ">i")
        size = file.seek(0, 2)
        while place < size:
            file.seek(place)
            head = file.read(4)
            count = length.unpack(head)[0] if len(head) == 4 else -1
            file.seek(max(count, 0), 1)
            if count < 0 or file.read(4) != head:
                raise MeshError(
                    part,
                    found=f"a record at byte {place} of {size} that does not end where it should",
                    expected="an OUTPUT2 file, unformatted and complete",
                    remedy="Copy it in binary mode, or write it again: it is damaged, cut off or of another kind",
                )
            place += count + 8
