"""`write_plant`: a linear plant as a MATLAB file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexmb.errors import DataFileError
from flexmb.files import replacing

__all__ = ["plant_path", "write_plant"]


def write_plant(plant, path: str | Path) -> Path:
    """Write A, B, C, D, the names and the units of a plant to a MATLAB file and return the path.

    In MATLAB: ``p = load('plant.mat'); sys = ss(p.A, p.B, p.C, p.D, 'InputName', p.inputs, 'OutputName', p.outputs)``.

    Parameters
    ----------
    plant : Plant
        The result of ``linearize(model, inputs=..., outputs=...)``.
    path : path
        With the ending .mat.

    Raises
    ------
    ModelError
        An output follows the rates of an input.
    """
    from scipy.io import savemat

    plant.require_proper()
    path = plant_path(path)
    content = {name: getattr(plant, name) for name in "ABCD"}
    content |= {name: np.array(getattr(plant, name), object).reshape(-1, 1) for name in ("inputs", "outputs", "units")}
    with replacing(path, f"MATLAB file '{path}'", folder=True) as file:
        savemat(file, content, appendmat=False, oned_as="column")
    return path


def plant_path(path: str | Path) -> Path:
    """Return where a plant is written; DataFileError for another ending than .mat."""
    path = Path(path)
    if path.suffix != ".mat":
        raise DataFileError(
            f"MATLAB file '{path}'", found=f"the ending '{path.suffix}'", expected=".mat", remedy="Write plant.mat"
        )
    return path
