"""`write_modes`: mode shapes and stress modes of a reduced body for ParaView, one step of the series per mode."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import DataFileError
from flexmb.io.vtu import VtuSeries, write_collection
from flexmb.results import recover

__all__ = ["mode_amplitude", "write_modes"]

AMPLITUDE = 0.1  # largest displacement in a picture, in sizes of the body


def mode_amplitude(data, mode: int) -> float:
    """Return the modal coordinate at which the largest displacement is a tenth of the body's size."""
    size = float(np.linalg.norm(np.ptp(data.nodes, axis=0))) or 1.0
    largest = float(np.linalg.norm(data.shapes[:, :, mode], axis=1).max(initial=0.0))
    return AMPLITUDE * size / largest if largest > 0.0 else 0.0


def write_modes(data, path: str | Path, *, modes: int | Iterable[int] | None = None) -> Path:
    """Write mode shapes and stress modes as a series for ParaView and return the file to open.

    Step n of the series ("time" n) is mode n, counted from 1. Points are displaced, at most by a tenth of the body's
    size; ``displacement`` (m) undoes that with *Warp By Vector* and factor -1. ``stress`` (Pa; xx, yy, zz, xy, yz, zx)
    and ``von_mises`` (Pa) belong to the same displacement, NaN where no element gives stress; ``rotation`` (rad) is
    there for frames and shells.

    Parameters
    ----------
    data : ModalNeutralData
    path : path
        ``out/name.pvd`` writes the collection and ``out/name/mode_<n>.vtu``.
    modes : int or sequence of int, optional
        The first so many, or these (from 0); all by default.
    """
    path = Path(path)
    if path.suffix != ".pvd":
        raise DataFileError(
            f"VTK output '{path}'",
            found=f"the ending '{path.suffix}'",
            expected=".pvd",
            remedy="Modes are written as a PVD series",
        )
    if not data.cells:
        raise DataFileError(
            f"Modes of '{data.name}'",
            found="the data has no cells",
            expected="a mesh to draw",
            remedy="Reduce an FE model with elements; matrices alone have no shape",
        )
    chosen = _chosen(data, modes)
    folder = path.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    own = data.numbering
    numbers = ({}, {}) if own is None else ({"node": own.nodes}, {"element": np.concatenate(own.cells)})
    series, digits, entries = VtuSeries(data.cells, *numbers), len(str(data.n_modes)), []
    for j in chosen:
        points, fields = _frame(data, j)
        file = folder / f"mode_{j + 1:0{digits}d}.vtu"
        series.write(file, float(j + 1), points, fields)
        entries.append((float(j + 1), 0, data.name, f"{folder.name}/{file.name}"))
    write_collection(path, entries)
    return path


def _chosen(data, modes) -> list[int]:
    chosen = list(range(data.n_modes)) if modes is None else modes
    chosen = list(range(min(modes, data.n_modes))) if isinstance(modes, int) else [int(j) for j in chosen]
    if not chosen or min(chosen) < 0 or max(chosen) >= data.n_modes:
        raise DataFileError(
            f"Modes of '{data.name}'",
            found=f"modes {modes!r}",
            expected=f"some of 0 to {data.n_modes - 1}",
            remedy="Choose among data.frequencies",
        )
    return chosen


def _frame(data, j: int) -> tuple[np.ndarray, dict[str, Any]]:
    """Return displaced points and fields of one mode as float32."""
    amplitude = mode_amplitude(data, j)
    displacement = amplitude * data.shapes[:, :, j]
    fields = {}
    if data.has_stress:
        stress = np.where(data.stressed[:, None], amplitude * data.stress_modes[:, :, j], np.nan)
        fields |= {"von_mises": recover.von_mises(stress), "stress": stress}
    fields["displacement"] = displacement
    if data.rotation_shapes is not None:
        fields["rotation"] = amplitude * data.rotation_shapes[:, :, j]
    points = (data.nodes + displacement).astype(np.float32)
    return points, {name: np.ascontiguousarray(values, np.float32) for name, values in fields.items()}
