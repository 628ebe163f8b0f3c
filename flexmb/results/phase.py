"""`Phase`: the samples of one model between two events, and `Instant`: one of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.results.memory import Memory

__all__ = ["INPUTS", "MOST_SAMPLES", "Instant", "Phase"]

INPUTS = "inputs set from outside"
"""The table of a solution file that holds them, by the titles of its columns."""

MOST_SAMPLES = 50_000_000
"""Samples of one run: all of them are kept in memory."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Instant:
    """The state at one time.

    Parameters
    ----------
    t : float, s
    q : (nq,)
        Configuration: per body position (m), Euler parameters, flexible coordinates (m).
    u, a : (nu,)
        Velocity and acceleration, in body axes.
    lam : (ng,)
        Multipliers.
    works : (3,), J
        Work of loads, of drives and dissipated energy since the start.
    model : Model
        The model it belongs to.
    """

    t: float
    q: np.ndarray
    u: np.ndarray
    a: np.ndarray
    lam: np.ndarray
    works: np.ndarray
    model: Any = None

    def __repr__(self):
        return f"Instant(t = {self.t:.6g} s, {len(self.q)} coordinates, {len(self.u)} velocities)"


@dataclass(frozen=True, kw_only=True, eq=False)
class Phase:
    """The samples of one model from the start, or an event, to the next event or the end.

    Parameters
    ----------
    model : Model
    t : (nt,), s
        Not decreasing.
    q : (nt, nq)
    u, a : (nt, nu)
    lam : (nt, ng)
    works : (nt, 3), J
        Work of loads, of drives, and dissipated energy since the start of the simulation.
    ended : str
        Why the phase ended: "finished", or the name of the event.
    system : System, optional
        The compiled model; it is compiled again when it is needed and not given.
    tables : mapping of sensor name to (nt, ...) array
        Values that are known already (read from a file); other sensors are evaluated when they are asked for.
    cut_off : bool
        The last row is no sample, but how far the run had come when it was cut off.
    memory : Memory, optional
        What the integrator knew beside the last row, where the run was cut off.
    inputs : (nt, n), optional
        Values of the inputs of `system`, in its order, that led to each sample; None: as they are.
    """

    model: Any
    t: np.ndarray
    q: np.ndarray
    u: np.ndarray
    a: np.ndarray
    lam: np.ndarray
    works: np.ndarray
    ended: str = "finished"
    system: Any = field(default=None, repr=False)
    tables: Mapping[str, np.ndarray] = field(default_factory=dict, repr=False)
    cut_off: bool = False
    memory: Memory | None = field(default=None, repr=False)
    inputs: np.ndarray | None = field(default=None, repr=False)

    def __post_init__(self):
        nt = len(self.t)
        for name in ("q", "u", "a", "lam", "works"):
            found = np.shape(getattr(self, name))
            if len(found) != 2 or found[0] != nt:
                raise FlexmbError(
                    "Phase",
                    found=f"{name} has the shape {found}",
                    expected=f"({nt}, ...): one row per time",
                    remedy="Give one row per sample",
                )

    def __repr__(self):
        span = f"t = {self.t[0]:.6g} to {self.t[-1]:.6g} s" if len(self.t) else "no samples"
        return f"Phase({len(self.t)} samples, {span}, {self.ended})"

    def instant(self, k: int) -> Instant:
        """Return sample `k` (negative from the end)."""
        return Instant(
            t=float(self.t[k]),
            q=self.q[k].copy(),
            u=self.u[k].copy(),
            a=self.a[k].copy(),
            lam=self.lam[k].copy(),
            works=self.works[k].copy(),
            model=self.model,
        )
