"""Sensor values as tables of text: one CSV file with a column per number."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from flexmb.files import replacing, without_formulas

__all__ = ["labels", "write_table"]


def labels(solution, name: str) -> list[str]:
    """Return the names of a sensor's columns, "C force fx [N]"; one number has the name of the sensor and its unit."""
    titles = [str(title) for title in solution.column_titles(name)]
    if len(titles) == 1:
        unit = titles[0][titles[0].find("[") :] if titles[0].endswith("]") else ""
        return [f"{name} {unit}".strip()]
    return [f"{name} {title}".strip() for title in titles]


def write_table(solution, path: str | Path) -> Path:
    """Write the values of all sensors over time to a CSV file and return the path.

    The first column is the time; a sensor with several numbers has a column for each, "C force fx [N]" (see `labels`).
    """
    path = Path(path)
    titles, columns = ["t [s]"], [solution.t]
    for name in solution.sensor_names:
        values = np.asarray(solution[name], float)
        values = values.reshape(len(values), -1)
        titles += labels(solution, name)
        columns += list(values.T)
    with replacing(path, f"Table '{path}'") as part, part.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(without_formulas(titles))
        table.writerows([repr(float(x)) for x in row] for row in zip(*columns))
    return path
