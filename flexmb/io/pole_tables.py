"""`write_poles`: poles over a parameter as a table."""

from __future__ import annotations

import csv
from pathlib import Path

from flexmb.files import replacing, without_formulas

__all__ = ["write_poles"]


def write_poles(locus, path: str | Path, name: str = "parameter") -> Path:
    """Write a line for each value of the parameter: real and imaginary part of each pole; return the path.

    Parameters
    ----------
    locus : RootLocus
        The result of ``root_locus(model, values)``.
    path : path
        A .csv file.
    name : str
        Of the parameter, the title of the first column.
    """
    path = Path(path)
    titles = [f"{part} {k + 1} [{unit}]" for k in range(locus.poles.shape[1])
              for part, unit in (("real part", "1/s"), ("imaginary part", "rad/s"))]  # fmt: skip
    with replacing(path, f"Table '{path}'", folder=True) as part, part.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(without_formulas([name, *titles]))
        for value, poles in zip(locus.values, locus.poles, strict=True):
            rows.writerow([repr(float(value)), *(repr(float(x)) for pole in poles for x in (pole.real, pole.imag))])
    return path
