"""Matrices of Abaqus: ``*MATRIX GENERATE`` with ``*MATRIX OUTPUT, FORMAT=MATRIX INPUT``, ``LABELS`` or ``COORDINATE``.

Lines ``row node, row freedom, column node, column freedom, value``, or ``row, column, value``; one triangle. Files
``job_STIF1.mtx``, ``job_MASS1.mtx``.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.foreign_files import understood_matrix, whole_numbers
from flexmb.fem.matrices.matrix_files import FileMatrices, by_labels, symmetric_from_entries

__all__ = ["read_abaqus"]


def read_abaqus(path: Path, mass: Path | None) -> FileMatrices:
    """Read the stiffness file and the mass file beside it."""
    if mass is None:
        mass = path.with_name(re.sub("STIF", "MASS", path.name, flags=re.IGNORECASE))
        if mass == path or not mass.is_file():
            raise MeshError(
                f"Matrix file '{path}'",
                found="no mass matrix beside it",
                expected="job_STIF1.mtx and job_MASS1.mtx",
                remedy="Give mass='...'",
            )
    with understood_matrix(mass):
        M = _entries(mass)
    K = _entries(path)
    if K.shape[1] != M.shape[1]:
        raise MeshError(
            f"Matrix file '{path}'",
            found=f"{K.shape[1]} words in line 1 of its entries, but {M.shape[1]} in '{mass.name}'",
            expected="both files in one format",
            remedy="Write both matrices by one *MATRIX OUTPUT, FORMAT=MATRIX INPUT",
        )
    if K.shape[1] == 3:
        return _coordinates(path, mass, K, M)
    return by_labels(f"Matrix file '{path}'", {"K": K, "M": M})


def _coordinates(path: Path, mass: Path, K: np.ndarray, M: np.ndarray) -> FileMatrices:
    """Return matrices of rows and columns: freedoms of the nodes by increasing number, as the file says no more."""
    size = int(max(K[:, :2].max(initial=0), M[:, :2].max(initial=0)))
    found = []
    for file, table in ((path, K), (mass, M)):
        part = f"Matrix file '{file}'"
        i, j = whole_numbers(part, "the row or column", table[:, :2], 1, 2**31).T - 1
        found.append(symmetric_from_entries(part, i, j, table[:, 2], size))
    return FileMatrices(*found)


def _entries(path: Path) -> np.ndarray:
    """Return the table of a file, (ne, 5) in the formats MATRIX INPUT and LABELS, (ne, 3) in COORDINATE."""
    rows: list[list[float]] = []
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), start=1):
        text = line.strip()
        if not text or text.startswith("*"):  # keyword and comment lines
            continue
        words = text.replace(",", " ").replace("D", "E").replace("d", "e").split()
        if len(words) not in (3, 5) or (rows and len(words) != len(rows[0])):
            raise MeshError(
                f"Matrix file '{path}'",
                found=f"{len(words)} words in line {number}",
                expected="node, freedom, node, freedom, value in every line, or row, column, value",
                remedy="Write *MATRIX OUTPUT, FORMAT=MATRIX INPUT",
            )
        rows.append([float(word) for word in words])
    return np.array(rows).reshape(-1, len(rows[0]) if rows else 5)
