"""Matrices of Abaqus: ``*MATRIX GENERATE`` with ``*MATRIX OUTPUT, FORMAT=MATRIX INPUT`` or ``LABELS``.

Lines ``row node, row freedom, column node, column freedom, value``; one triangle. Files ``job_STIF1.mtx``,
``job_MASS1.mtx``.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.matrix_files import FileMatrices, by_labels

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
    return by_labels(f"Matrix file '{path}'", {"K": _entries(path), "M": _entries(mass)})


def _entries(path: Path) -> np.ndarray:
    rows = []
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), start=1):
        text = line.strip()
        if not text or text.startswith("*"):  # keyword and comment lines
            continue
        words = text.replace(",", " ").replace("D", "E").replace("d", "e").split()
        if len(words) != 5:
            raise MeshError(
                f"Matrix file '{path}'",
                found=f"{len(words)} words in line {number}",
                expected="node, freedom, node, freedom, value",
                remedy="Write *MATRIX OUTPUT, FORMAT=MATRIX INPUT; FORMAT=COORDINATE has no node numbers",
            )
        rows.append([float(word) for word in words])
    return np.array(rows).reshape(-1, 5)
