"""`Memory`: what an integrator knows beside the state where a run was cut off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

__all__ = ["Memory"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Memory:
    """Numbers with which an integrator goes on as if it had not been cut off.

    Parameters
    ----------
    of : str
        The integrator, with its settings, whose they are.
    numbers : (n,)
        In an order that it knows.
    """

    of: str
    numbers: np.ndarray
