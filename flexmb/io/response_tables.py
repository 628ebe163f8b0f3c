"""`write_response`, `write_spectra`: what stands over the frequency as a table."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from flexmb.files import replacing, without_formulas

__all__ = ["write_response", "write_spectra"]


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
    return _written(path, titles, columns)


def write_spectra(plant, frequencies, densities, path: str | Path) -> Path:
    """Write the power spectral densities of the outputs of a plant to a CSV file and return the path.

    The first column is the frequency in Hz, each output has one more: "psd tip z [(m)^2/Hz]".

    Parameters
    ----------
    plant : Plant
    frequencies : (nf,), Hz
    densities : (nf, p)
        The diagonals of `flexmb.spectral_response`.
    path : path
    """
    titles = [f"psd {name} [({unit})^2/Hz]" for name, unit in zip(plant.outputs, plant.units, strict=True)]
    return _written(Path(path), ["f [Hz]", *titles], [np.asarray(frequencies, float), *np.asarray(densities, float).T])


def _written(path: Path, titles: list[str], columns: list[np.ndarray]) -> Path:
    with replacing(path, f"Table '{path}'", folder=True) as part, part.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(without_formulas(titles))
        table.writerows([repr(float(x)) for x in row] for row in zip(*columns))
    return path
