"""Frequency responses of a test: dataset 58 of universal files.

The description of the dataset is public (Structural Dynamics Research Lab, University of Cincinnati).
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.foreign_files import require_file
from flexmb.fem.meshes.universal_datasets import damaged, datasets

__all__ = ["MeasuredResponse", "read_measured_responses"]

RESPONSE = 4
"""Function type of a frequency response."""
FREQUENCY, FORCE = 18, 13
RATES = {8: 0, 11: 1, 12: 2}
"""How often the displacement is differentiated, by type of the ordinate: displacement, velocity, acceleration."""
REAL, COMPLEX = (2, 4), (5, 6)
"""Single and double precision."""
MOST = 10_000_000
"""Lines of a spectrum."""
HEAD = re.compile(r"(.{5})(.{10})(.{5})(.{10}) (.{10})(.{10})(.{4}) (.{10})(.{10})(.{4})")
"""Line 6 of the dataset, whose names of entities may be blank or hold blanks."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredResponse:
    """A frequency response of a test: the motion of one point per force at another.

    Parameters
    ----------
    point, direction : int
        Number of the point that moves; 1 to 3 for x, y, z, 4 to 6 for turns about them, negative against the axis.
    force_point, force_direction : int
        Likewise of the force or moment.
    frequencies : (n,), Hz
    receptance : (n,), m/N
        Displacement per force, complex, in the units of the file; where the file holds velocities or accelerations they
        are divided by i w or (i w)^2, and the value at f = 0 is nan.
    measured : str
        "displacement", "velocity" or "acceleration", as the file has it.
    """

    point: int
    direction: int
    force_point: int
    force_direction: int
    frequencies: np.ndarray
    receptance: np.ndarray
    measured: str


def read_measured_responses(path: str | Path) -> tuple[MeasuredResponse, ...]:
    """Return the frequency responses in the datasets 58 of a universal file (.unv, .uff), in the order of the file.

    Other functions (coherence, spectra, time series) are passed over.

    Raises
    ------
    MeshError
        No file, no frequency response of a motion per force in it, binary datasets, or data that are damaged.
    """
    path = Path(path)
    part = f"Universal file '{path}'"
    require_file(part, path, "an existing file", "Check its name", (".unv", ".uff"))
    found, others = [], set()
    for number, lines in datasets(path, part):
        response = None
        if number == 58:
            if not lines:
                raise MeshError(
                    part,
                    found="a binary dataset 58b",
                    expected="text",
                    remedy="Write the responses as universal file in ASCII",
                )
            response = _response(part, lines)
        if response is None:
            others.add(number)
        else:
            found.append(response)
    if not found:
        raise MeshError(
            part,
            found=f"no frequency responses; its datasets are {', '.join(map(str, sorted(others))) or 'none'}",
            expected="datasets 58 of a motion per force",
            remedy="Write the responses of the test as dataset 58 (function type 4)",
        )
    return tuple(found)


def _response(part: str, lines: list[str]) -> MeasuredResponse | None:
    """Return the response of a dataset 58; None if it holds another function."""
    if len(lines) < 12:
        raise damaged(part, f"a dataset 58 of {len(lines)} lines", "12 or more")
    match = HEAD.match(lines[5].ljust(80))
    words = [match[k].strip() for k in (1, 6, 7, 9, 10)] if match else []
    if not all(re.fullmatch(r"[+-]?\d+", word) for word in words) or not words:
        raise damaged(part, f"the line '{lines[5].strip()[:90]}' in dataset 58", "function, points and directions")
    function, point, direction, force_point, force_direction = map(int, words)
    if function != RESPONSE:
        return None
    kinds = [int(_numbers(part, lines[k][:10], 1)[0]) for k in (7, 8, 9)]
    if kinds[0] != FREQUENCY or kinds[1] not in RATES or kinds[2] != FORCE:
        return None
    if not (1 <= abs(direction) <= 6 and 1 <= abs(force_direction) <= 6):
        raise damaged(part, f"directions {direction} and {force_direction} in dataset 58", "1 to 6, or their negatives")
    kind, count, even, first, step = _numbers(part, lines[6], 5)
    if kind not in (*REAL, *COMPLEX) or not 1 <= count <= MOST or count % 1.0:
        raise damaged(part, f"{count:g} values of type {kind:g} in dataset 58", "type 2, 4, 5 or 6")
    frequencies, values = _spectrum(part, lines[11:], int(kind), int(count), even == 1, first, step)
    rate = RATES[kinds[1]]
    with np.errstate(divide="ignore", invalid="ignore"):
        receptance = values / (2j * np.pi * frequencies) ** rate if rate else values
    return MeasuredResponse(
        point=point,
        direction=direction,
        force_point=force_point,
        force_direction=force_direction,
        frequencies=frequencies,
        receptance=np.where(frequencies == 0.0, np.nan, receptance) if rate else receptance,
        measured=("displacement", "velocity", "acceleration")[rate],
    )


def _spectrum(
    part: str, lines: list[str], kind: int, count: int, even: bool, first: float, step: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies and values (count,)."""
    per_value = (2 if kind in COMPLEX else 1) + (not even)
    double = kind in (4, 6)
    if not double:
        widths = [13] * 6
    elif even:
        widths = [20] * 4
    else:
        widths = [13, 20, 20] if kind in COMPLEX else [13, 20, 13, 20]
    numbers: list[float] = []
    for line in lines:
        if len(numbers) >= count * per_value:
            break
        numbers += _numbers(part, line, min(len(widths), count * per_value - len(numbers)), widths).tolist()
    if len(numbers) < count * per_value:
        raise damaged(part, f"{len(numbers)} numbers in dataset 58", f"{count * per_value}")
    table = np.array(numbers).reshape(count, per_value)
    frequencies = first + step * np.arange(count) if even else table[:, 0]
    if (frequencies < 0.0).any() or (np.diff(frequencies) <= 0.0).any():
        raise damaged(part, "frequencies that do not rise from 0 in dataset 58", "rising frequencies")
    own = table[:, -2:] if kind in COMPLEX else table[:, -1:]
    return frequencies, own[:, 0] + 1j * own[:, 1] if kind in COMPLEX else own[:, 0].astype(complex)


def _numbers(part: str, line: str, count: int, widths: list[int] | None = None) -> np.ndarray:
    """Return the first numbers of a line, split at blanks, or by widths where fields touch."""
    words = line.split()
    if len(words) < count:
        edges = np.concatenate([[0], np.cumsum(widths or [10, 10, 10, 13, 13, 13])])
        words = [line[a:b].strip() for a, b in pairwise(edges.tolist())]
    try:
        found = np.array([float(word.upper().replace("D", "E")) for word in words[:count]])
    except ValueError:
        found = np.zeros(0)
    if len(found) < count or not np.isfinite(found).all():
        raise damaged(part, f"the line '{line.strip()[:90]}' in dataset 58", f"{count} numbers")
    return found
