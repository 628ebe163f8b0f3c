"""Draw the power spectral densities with which a model answers stationary random loads, and write their table.

Examples:
  flexmb psd car.toml --statics --input profile --output "body z" --density 1e-6 --from 0.1 --to 50
  flexmb psd car.toml --density road.csv
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np

from flexmb.cli.state_arguments import add_band, add_ports, add_state_arguments, band, plant
from flexmb.errors import DataFileError, ModelError
from flexmb.found import no_file_because

NAME = "psd"
REACH, STEP = 20.0, 0.05
"""Around a resonance: so many steps of the frequencies asked for, and the step of asinh(distance / half its width)."""
SUMMARY = "draw the answer to stationary random loads as spectral densities, and write their table"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_state_arguments(parser)
    add_ports(parser)
    add_band(parser)
    parser.add_argument(
        "--density",
        action="append",
        required=True,
        metavar="VALUE|FILE.csv",
        help="one-sided density of each input in turn, (unit of the input)^2/Hz: a number (white), or a table of "
        "frequency, Hz, and density; between its rows lines on logarithmic axes, outside zero",
    )
    parser.add_argument(
        "-o", "--out", metavar="FILE", help=".png, .svg or .pdf, the table beside it as .csv; default: <model>_psd.png"
    )


def execute(arguments: argparse.Namespace) -> int:
    import flexmb as fmb
    from flexmb import io, view

    frequencies = band(arguments, "flexmb psd")
    given = [_density(text) for text in arguments.density]
    found = plant(arguments)
    if len(given) != len(found.inputs):
        raise ModelError(
            "flexmb psd",
            found=f"{len(given)} densities, and the inputs {', '.join(found.inputs)}",
            expected="one --density for each input, in their order",
            remedy="Name the inputs that are random by --input, and give each a --density",
        )
    fine = _with_resonances(frequencies, found.poles)
    densities = np.column_stack([one(fine) for one in given])
    spectra = np.real(np.einsum("fii->fi", fmb.spectral_response(found, fine, densities)))
    target = Path(arguments.out) if arguments.out else Path(f"{Path(arguments.model).stem}_psd.png")
    for output, unit, spectrum in zip(found.outputs, found.units, spectra.T, strict=True):
        root = math.sqrt(float(np.trapezoid(spectrum, fine)))
        print(f"{output}: {root:.6g} {unit} root mean square between {frequencies[0]:g} and {frequencies[-1]:g} Hz")
    asked = np.searchsorted(fine, frequencies)
    print(f"Table: {io.write_spectra(found, frequencies, spectra[asked], target.with_suffix('.csv'))}")
    print(f"Spectra: {view.spectra(found, fine, spectra, target)}")
    return 0


def _with_resonances(frequencies: np.ndarray, poles: np.ndarray) -> np.ndarray:
    """Return frequencies, Hz, and more of them around resonances, which may be narrower than their steps.

    There the density is a Lorentzian, 1 / (1 + x^2) of the distance x in half widths: even steps of asinh(x).
    """
    found = [frequencies]
    for pole in poles[(poles.imag > 0.0) & (poles.real < 0.0)]:
        peak, half = pole.imag / (2.0 * np.pi), -pole.real / (2.0 * np.pi)
        at = min(max(int(np.searchsorted(frequencies, peak)), 1), len(frequencies) - 1)
        count = math.ceil(math.asinh(REACH * (frequencies[at] - frequencies[at - 1]) / half) / STEP)
        found.append(peak + half * np.sinh(STEP * np.arange(-count, count + 1)))
    every = np.unique(np.concatenate(found))
    return every[(every >= frequencies[0]) & (every <= frequencies[-1])]


def _density(text: str):
    """Return the function of frequencies (nf,) that a number or a file gives."""
    try:
        value = float(text)
    except ValueError:
        return _table(Path(text))
    if not (math.isfinite(value) and value >= 0.0):
        raise ModelError(
            f"--density {text}",
            found=f"{value!r}",
            expected="a density >= 0",
            remedy="Write --density 1e-6, or a file of two columns",
        )
    return lambda f: np.full(len(f), value)


def _table(path: Path):
    """Return the function through the rows of a file: frequency, Hz, and density."""
    if (lacking := no_file_because(path, (".csv", ".txt"))) is not None:
        raise DataFileError(
            f"--density {path}",
            found=lacking.what,
            expected="a number, or a file with rows of frequency, density",
            remedy=lacking.remedy or "Correct the number, or the path",
        )
    try:
        rows = np.loadtxt(path, delimiter=",", ndmin=2, comments=("#", "f", '"'))
    except (OSError, ValueError, UnicodeDecodeError) as error:
        raise DataFileError(
            f"--density {path}",
            found=str(error),
            expected="a number, or a file with rows of frequency, density",
            remedy="Write rows as 0.1,1e-6; a title begins with f or #",
        ) from None
    if rows.shape[0] < 2 or rows.shape[1] != 2 or not np.all(rows > 0.0) or not np.all(np.diff(rows[:, 0]) > 0.0):
        raise DataFileError(
            f"--density {path}",
            found=f"{rows.shape[0]} rows of {rows.shape[1]} numbers",
            expected="two or more rows of an increasing frequency, Hz, and a density, both above zero and finite",
            remedy="Correct the table",
        )
    f, G = np.log(rows).T
    return lambda at: np.exp(np.interp(np.log(at), f, G, left=-np.inf, right=-np.inf))
