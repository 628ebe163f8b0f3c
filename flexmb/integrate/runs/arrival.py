"""Rows of an integrator whose last step has ended within rounding of the time that was asked for.

Steps become ever shorter before a time at which a load has no value, 1/(t - 1) at one second, until they end a rounding
before it: behind it they would go on as if nothing had been there. And a row of another time is no sample.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from flexmb.integrate.runs.outcome import Outcome
from flexmb.math.weights import no_matrix
from flexmb.system.program import evaluate

__all__ = ["arrived", "is_as_asked"]


def arrived(system: Any, outcome: Outcome, marks: np.ndarray) -> Outcome:
    """Return an outcome whose rows have the times `marks`, s, that were asked for, with a failure at the first of those
    at which the equations of motion have no value.
    """
    rows = outcome.rows
    known = np.isfinite(rows["a"]).all(axis=1)
    for k in np.flatnonzero((rows["t"] < marks[: len(known)]) | ~known):
        t = float(marks[k])
        if not known[k] or not _has_value(system, t, rows["q"][k].copy(), rows["u"][k].copy()):
            before = {name: array[:k] for name, array in rows.items()}
            wrong = f"the equations of motion are not finite at t = {t:.9g} s, and steps only came near it"
            return replace(outcome, rows=before, failure=outcome.failure or wrong, reached=t)
        rows["t"][k] = t
    return outcome


def is_as_asked(rows: dict[str, np.ndarray], mark: float) -> bool:
    """Is a single row, if there is one, at the time `mark`, s, with accelerations? Then there is nothing to look at."""
    if not len(rows["t"]):
        return True
    a = rows["a"][0]
    return bool(rows["t"][0] == mark) and math.isfinite(a.dot(a))  # overflow: then they are looked at one by one


def _has_value(system: Any, t: float, q: np.ndarray, u: np.ndarray) -> bool:
    work = system.workspace()
    no_matrix(work.weights)
    evaluate(system.program, system.state(t, q, u), work)
    return bool(np.all(np.isfinite(work.residual)))
