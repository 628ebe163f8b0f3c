"""`IDA`: SUNDIALS' variable-order backward differentiation formulas on the stabilised index-2 equations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.integrate.ida.run import Run
from flexmb.integrate.runs.outcome import Outcome
from flexmb.integrate.runs.patience import Patience
from flexmb.model.described import Described, is_number

__all__ = ["IDA"]


@dataclass(frozen=True, kw_only=True)
class IDA(metaclass=Described):
    """SUNDIALS' IDA: backward differentiation of order 1 to 5 on the stabilised index-2 equations.

    Accelerations and multipliers of the samples follow from the equations of motion at the sample's positions and
    velocities; the solver's own multipliers have no controlled accuracy. Where equations depend on each other, the
    constraints yield a little, so that the multipliers have a unique value.

    In models of many unknowns the solver warns that it takes our Jacobian: a filter of Python's warnings for this
    sentence of `sksundae.ida` stays in the process.

    Parameters
    ----------
    rtol : float, -
        Relative tolerance of every coordinate and velocity; a tenth of it counts while something may touch, because
        steps begin anew at every begin of a contact.
    atol : float, m, rad and per second, optional
        Absolute tolerance of every coordinate and velocity; default 1e-8, times the length of models below 1 m
        where it is one of displacements, and of velocities 100 s by the simulated time where that is longer.
    max_order : int
        Highest order, 1 to 5; 2 for lightly damped high frequencies, which higher orders cannot damp.
    largest : float, s, optional
        Largest step size.
    most_steps : int
        Steps between two samples after which the run fails.

    Source: Hindmarsh et al. 2005; Gear, Gupta & Leimkuhler 1985.
    """

    rtol: float = 1e-6
    atol: float | None = None
    max_order: int = 5
    largest: float | None = None
    most_steps: int = 100_000
    in_threads: ClassVar[bool] = True
    """Several threads may run it; the solver asks for residuals through Python, so one of them goes on at a time."""

    def __post_init__(self):
        for name in ("rtol", "atol", "largest"):
            value = getattr(self, name)
            if value is not None and not (is_number(value) and value > 0.0):
                raise ModelError(
                    "IDA",
                    found=f"{name} = {value!r}",
                    expected="a positive number",
                    remedy=f"Leave {name} out for its default",
                )
        if self.max_order not in range(1, 6):
            raise ModelError(
                "IDA",
                found=f"max_order = {self.max_order!r}",
                expected="1, 2, 3, 4 or 5",
                remedy="Leave max_order out for 5",
            )
        if not is_number(self.most_steps) or self.most_steps <= 0:
            raise ModelError(
                "IDA",
                found=f"most_steps = {self.most_steps!r}",
                expected="a positive count",
                remedy="Leave most_steps out for its default",
            )

    def start(self, system, state, work, t_end: float) -> Run:
        """Return the solver at the start."""
        return Run(self, system, state, work, t_end)

    def run(
        self, system, work, variables: Run, samples: np.ndarray, first: int, last: int, patience: float = np.inf
    ) -> Outcome:
        """Integrate through samples[first:last] and return the rows and why it ended; after `patience` seconds those
        so far, to be called again from the next."""
        pace, variables.counted = Patience(patience), variables.counted[-1:]
        rows = {"t": np.zeros(last - first)}
        for name, size in (("q", system.nq), ("u", system.nu), ("a", system.nu), ("lam", system.ng), ("works", 3)):
            rows[name] = np.zeros((last - first, size))
        for k in range(first, last):
            failure = variables.advance(float(samples[k]), pace)
            if failure or variables.t < samples[k]:
                done = {name: array[: k - first] for name, array in rows.items()}
                return Outcome(rows=done, failure=failure, reached=variables.t)
            # what began just after a jump has its values
            values = variables.sample(max(float(samples[k]), variables.t))
            for name, value in zip(rows, values, strict=True):
                rows[name][k - first] = value
            variables.counted.append(variables.told())
        return Outcome(rows=rows, reached=variables.t)

    @staticmethod
    def may_go_back(variables: Run) -> None:
        """Keep from now on what `taken_back` needs."""
        if not variables.goes_back:
            variables.goes_back = True
            variables.counted[-1] = variables.told()

    @staticmethod
    def taken_back(variables: Run, n: int) -> Run:
        """Return the solver with the numbers of the run, and what has touched, as they were n rows after the last call
        began; it keeps what it knows to itself, and only begins anew from there.
        """
        variables.tell_again(variables.counted[n])
        return variables

    @staticmethod
    def statistics(variables: Run) -> dict[str, Any]:
        """Return the numbers of the run."""
        return dict(variables.counts)
