"""`Outcome`: the rows that an integrator has added, and the reason if it could not continue."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

__all__ = ["Outcome"]


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """Rows of samples and the reason of a failure.

    Parameters
    ----------
    rows : dict of arrays
        t (n,), q (n, nq), u, a (n, nu), lam (n, ng), works (n, 3).
    failure : str
        What went wrong, where and when; empty if all samples were reached.
    remedy : str
        What to try.
    reached : float, s
        Time of the state at which the integrator stands: the last row's, or later if it was called back in between.
    """

    rows: dict[str, np.ndarray] = field(repr=False)
    failure: str = ""
    remedy: str = "Look at the last samples; try a smaller rtol, a fixed small step, or damping where it is stiff"
    reached: float = -np.inf
