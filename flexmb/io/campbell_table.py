"""`write_campbell`: frequencies and damping over the speed as a table."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from flexmb.files import replacing

__all__ = ["write_campbell"]


def write_campbell(diagram, path: str | Path) -> Path:
    """Write a line for each speed: frequency and damping ratio of each mode; return the path.

    Parameters
    ----------
    diagram : Campbell
        The result of ``campbell(model, speeds)``.
    path : path
        A .csv file.
    """
    path = Path(path)
    count = diagram.frequencies.shape[1]
    titles = [title for k in range(count) for title in (f"frequency {k + 1} [Hz]", f"damping ratio {k + 1}")]
    both = np.stack([diagram.frequencies, diagram.damping_ratios], axis=2).reshape(len(diagram.speeds), 2 * count)
    with replacing(path, f"Table '{path}'", folder=True) as part, part.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["speed [rad/s]", *titles])
        rows.writerows([repr(float(x)) for x in (speed, *row)] for speed, row in zip(diagram.speeds, both, strict=True))
    return path
