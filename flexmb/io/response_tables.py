"""`write_response`: a frequency response as a table."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from flexmb.files import replacing

__all__ = ["write_response"]


def write_response(plant, frequencies, path: str | Path) -> Path:
    """Write gain and phase of a plant over the frequency to a CSV file and return the path.

    The first column is the frequency in Hz. Each pair of output and input has two more: the amplitude of the output per
    unit of the input, "gain tip z / push.force.z [m]" with the unit of the output, and the phase in degrees, between
    -180 and 180.

    Parameters
    ----------
    plant : Plant
        The result of ``linearize(model, inputs=..., outputs=...)``.
    frequencies : (nf,), Hz
    path : path
    """
    path, f = Path(path), np.atleast_1d(np.asarray(frequencies, float))
    H = plant.frequency_response(f)
    titles, columns = ["f [Hz]"], [f]
    for j, source in enumerate(plant.inputs):
        for i, (output, unit) in enumerate(zip(plant.outputs, plant.units, strict=True)):
            titles += [f"gain {output} / {source} [{unit}]", f"phase {output} / {source} [deg]"]
            columns += [np.abs(H[:, i, j]), np.degrees(np.angle(H[:, i, j]))]
    with replacing(path, f"Table '{path}'", folder=True) as part, part.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(titles)
        table.writerows([repr(float(x)) for x in row] for row in zip(*columns))
    return path
