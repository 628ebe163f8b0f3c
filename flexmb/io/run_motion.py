"""What a reduced body did in a stored run, for the basis `Pod`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.reduction import Motion
from flexmb.results import Solution, stored_body

__all__ = ["motion_of"]


def motion_of(path: str | Path, body: str, read_model: Callable[..., Any] | None) -> Motion:
    """Return the motion of a reduced body in all phases of a solution file; DataFileError where there is none.

    read_model : makes the model of the run from its text, as for `Solution.load`
    """
    data = stored_body(path, body)
    solution = Solution.load(path, read_model=read_model)
    flexible = [solution.series(k).modal_coordinates(body) for k in range(len(solution.phases))]
    return Motion(data, np.vstack(flexible))
