"""Matrices of Nastran: DMIG cards, as punched by EXTSEOUT(DMIGPCH) or PARAM,EXTOUT,DMIGPCH.

Header ``DMIG NAME 0 IFO TIN TOUT``; a column card names grid and component of the column, then of each row
with its value. Fields of 8 or 16 (``DMIG*``) characters or between commas; numbers such as 1.0D+3 and
1.0+3. Symmetric matrices (IFO 6) hold every term once, in either triangle.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.matrices.matrix_files import FileMatrices, by_labels
from flexmb.fem.meshes.nastran_lines import nastran_lines

__all__ = ["nastran_cards", "nastran_float", "read_nastran"]

CONTINUED = re.compile(r"[+*]([A-Za-z]\w*)?")
"""The last field of a line between commas when another line follows."""
STIFFNESS, MASS = ("KAAX", "K2GG", "KGG", "K"), ("MAAX", "M2GG", "MGG", "M")
"""Names by which matrices are taken as stiffness and mass, in this order."""


def read_nastran(path: Path, mass: Path | None) -> FileMatrices:
    """Read the stiffness and the mass matrix, from one file or two, and where its GRID cards are."""
    part = f"Matrix file '{path}'"
    found, headers, has_grids = _dmig(path)
    if mass is not None:
        found, headers = {**_dmig(mass)[0], **found}, {**_dmig(mass)[1], **headers}
    chosen = {}
    for symbol, names in (("K", STIFFNESS), ("M", MASS)):
        name = next((name for name in names if name in found), None)
        if name is None:
            raise MeshError(
                part,
                found=f"the matrices {', '.join(found) or 'none'}",
                expected=f"one of {', '.join(names)}",
                remedy="Punch both with EXTSEOUT(DMIGPCH), or give mass='...'",
            )
        if headers[name][0] not in (1, 6) or headers[name][1] > 2:
            raise MeshError(
                part,
                found=f"{name} with IFO {headers[name][0]}, TIN {headers[name][1]}",
                expected="a real square or symmetric matrix: IFO 1 or 6, TIN 1 or 2",
                remedy="Export real structural matrices",
            )
        table = found[name]
        if (table[:, [1, 3]] < 1).any():
            raise MeshError(
                part,
                found=f"{name} has terms of scalar points (component 0)",
                expected="grid points only",
                remedy="Export physical freedoms: modal coordinates of a superelement have no position",
            )
        chosen[symbol] = table
    matrices = by_labels(part, chosen)
    return FileMatrices(matrices.K, matrices.M, matrices.labels, matrices.directions, path if has_grids else None)


def nastran_cards(path: Path):
    """Yield the fields of every bulk card, continuations joined; the first word without '*', comments left
    out."""
    words: list[str] = []
    per_line = 8
    for line in nastran_lines(path):
        text = line.split("$")[0].rstrip()
        if not text:
            continue
        if "," in text:
            fields = [word.strip() for word in text.split(",")]
            if CONTINUED.fullmatch(fields[-1]):
                fields.pop()
        else:
            width = 16 if "*" in text[:8] else 8
            fields = [text[:8].strip()] + [text[k : k + width].strip() for k in range(8, min(len(text), 72), width)]
        if fields[0][:1] in ("", "+", "*"):
            padding = -(len(words) - 1) % per_line  # blank fields at the end of a line are not written
            words += [""] * padding + fields[1:]
            continue
        if words:
            yield words
        words = [fields[0].rstrip("*").upper(), *fields[1:]]
        per_line = 4 if "*" in fields[0] else 8
    if words:
        yield words


def nastran_float(word: str) -> float:
    """Return 1.0, 1.0E+3, 1.0D+3 or 1.0+3 as a float; a blank is zero."""
    word = word.strip().upper().replace("D", "E")
    if not word:
        return 0.0
    return float(re.sub(r"(?<=[\d.])([+-]\d+)$", r"E\1", word) if "E" not in word else word)


def _dmig(path: Path) -> tuple[dict[str, np.ndarray], dict[str, tuple[int, int]], bool]:
    rows: dict[str, list] = {}
    headers: dict[str, tuple[int, int]] = {}
    has_grids = False
    for words in nastran_cards(path):
        has_grids |= words[0] == "GRID"
        if words[0] != "DMIG":
            continue
        name = words[1].upper()
        if words[2] == "0":
            headers[name] = (int(words[3]), int(words[4]))
            rows[name] = []
            continue
        column = (float(words[2]), float(words[3] or 0))
        for k in range(5, len(words) - 2, 4):  # G, C, A, (B) of every term
            if words[k]:
                rows[name].append((float(words[k]), float(words[k + 1] or 0), *column, nastran_float(words[k + 2])))
    return {name: np.array(found).reshape(-1, 5) for name, found in rows.items()}, headers, has_grids
