"""Matrices of Nastran in OUTPUT4 files (.op4), read by pyYeti: stiffness and mass of all grid points.

An OUTPUT4 file holds names and numbers only. Rows are the six freedoms of every grid point in ascending order of the
numbers (g-size), as ``OUTPUT4 KGG,MGG`` writes them. For a reduced set the caller must give the freedoms.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy import sparse

from flexmb.errors import MeshError
from flexmb.fem.matrices.matrix_files import FileMatrices
from flexmb.fem.matrices.nastran import MASS, STIFFNESS

__all__ = ["read_op4", "stiffness_and_mass"]


def read_op4(path: Path, mass: Path | None) -> FileMatrices:
    """Return the stiffness and the mass matrix, from one file or two."""
    part = f"Matrix file '{path}'"
    try:
        with np.printoptions():  # pyYeti changes how all arrays are printed
            from pyyeti.nastran import op4
    except ImportError:
        raise MeshError(
            part,
            found="no package that reads OUTPUT4 files",
            expected="pyYeti",
            remedy="pip install 'flexmb[op4]', or punch the matrices as DMIG",
        ) from None
    found = {name.upper(): matrix for name, matrix in op4.read(str(path), sparse=True).items()}
    if mass is not None:
        found = {**{name.upper(): matrix for name, matrix in op4.read(str(mass), sparse=True).items()}, **found}
    return stiffness_and_mass(part, found, "OUTPUT4 KGG,MGG//0/11")


def stiffness_and_mass(part: str, found: dict, statement: str) -> FileMatrices:
    """Choose stiffness and mass by their names among the matrices of a file; `statement` writes them in Nastran."""
    chosen = []
    for names in (STIFFNESS, MASS):
        name = next((name for name in names if name in found), None)
        if name is None:
            raise MeshError(
                part,
                found=f"the matrices {', '.join(found) or 'none'}",
                expected=f"one of {', '.join(names)}",
                remedy=f"Write both: {statement}, or give mass='...'",
            )
        matrix = sparse.csr_matrix(found[name])
        if matrix.shape[0] != matrix.shape[1] or np.iscomplexobj(matrix.data):
            raise MeshError(
                part,
                found=f"{name} with the shape {matrix.shape} and entries of the kind {matrix.dtype}",
                expected="a real square matrix",
                remedy="Export real structural matrices",
            )
        chosen.append(matrix)
    return FileMatrices(*chosen)
