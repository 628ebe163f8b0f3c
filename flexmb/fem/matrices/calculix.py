"""Matrices of CalculiX: ``*FREQUENCY, SOLVER=MATRIXSTORAGE`` writes job.sti (K), job.mas (M) and job.dof.

Lines ``row column value``, numbers from 1, upper triangle; job.dof has one line ``node.direction`` per row.
Freedoms that are held or depend on others are not there: supports are gone, so export free parts.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.foreign_files import understood_matrix, whole_numbers
from flexmb.fem.matrices.matrix_files import FileMatrices, symmetric_from_entries

__all__ = ["read_calculix"]


def read_calculix(path: Path, mass: Path | None) -> FileMatrices:
    """Read job.sti and the files of the same name with .mas, .dof and .inp."""
    mass = path.with_suffix(".mas") if mass is None else mass
    for needed in (mass, path.with_suffix(".dof")):
        if not needed.is_file():
            raise MeshError(
                f"Matrix file '{path}'",
                found=f"no file '{needed.name}' beside it",
                expected="the .sti, .mas and .dof of one run",
                remedy="Run *FREQUENCY, SOLVER=MATRIXSTORAGE",
            )
    with understood_matrix(path.with_suffix(".dof")):
        words = path.with_suffix(".dof").read_text().split()
        labels, directions = (np.array(column, int) for column in zip(*(word.split(".") for word in words)))
    matrices = []
    for file in (path, mass):
        with understood_matrix(file):
            entries = np.loadtxt(file, ndmin=2)
        if entries.shape[1] != 3 or entries[:, :2].max() > len(words):
            raise MeshError(
                f"Matrix file '{file}'",
                found=f"rows up to {entries[:, :2].max():.0f} in {entries.shape[1]} columns",
                expected=f"row, column, value with rows up to {len(words)}, the lines of the .dof file",
                remedy="Use files of one run",
            )
        i, j = whole_numbers(f"Matrix file '{file}'", "the row or column", entries[:, :2], 1, len(words)).T - 1
        matrices.append(symmetric_from_entries(f"Matrix file '{file}'", i, j, entries[:, 2], len(words)))
    mesh = path.with_suffix(".inp")
    K, M = matrices
    return FileMatrices(K, M, labels=labels, directions=directions - 1, nodes=mesh if mesh.is_file() else None)
