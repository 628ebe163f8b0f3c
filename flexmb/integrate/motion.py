"""A motion as an ordinary differential equation: its unknowns, their rates, and the way back onto the constraints."""

from __future__ import annotations

import numpy as np

from flexmb.errors import CompileError
from flexmb.integrate.explicit.drift import drifted
from flexmb.integrate.ida.stabilised import kinematics
from flexmb.integrate.runs.outcome import Outcome
from flexmb.integrate.runs.patience import Patience
from flexmb.math.energies import powers
from flexmb.system.branches import Followed
from flexmb.system.program import evaluate, keep_branches
from flexmb.system.projection import project

__all__ = ["Motion", "run_samples"]


class AbsoluteUnknowns:
    """The coordinates and velocities of all bodies as unknowns; all joints have to be closed by projection."""

    closes = True
    links = None
    recursion = ""

    def __init__(self, system, state, work):
        self.system, self.work = system, work
        self.followed = Followed(system, state, work)
        self.euler = system.program.frames[:, :1] + np.arange(3, 7)

    def vectors(self) -> list[tuple[int, int, int, int]]:
        """Return (coordinate, rate, velocity of the system, count) of vectors: the first of so many of each."""
        return [(int(iq), int(iu), int(iu), int(count)) for iq, iu, count, _ in self.system.program.vectors]

    def of(self, state) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return coordinates, velocities and accelerations of a state."""
        return state.q, state.u, state.a

    def state(self, t: float, x: np.ndarray, v: np.ndarray):
        """Return the state of the unknowns, Euler parameters normalised."""
        state = self.system.state(t, x, v)
        state.q[self.system.program.branches :] = self.followed.at(t)
        parameters = state.q[self.euler]
        state.q[self.euler] = parameters / np.sqrt(np.sum(parameters**2, axis=1, keepdims=True))
        return state

    def reached(self, state, x: np.ndarray, v: np.ndarray, drifted: bool) -> tuple[np.ndarray, np.ndarray]:
        """Return the unknowns of a state that has been reached, and count turns from it; it has just been evaluated."""
        keep_branches(self.system.program, self.work, state.q)
        self.followed.reached(state.t, self.work.branches)
        return state.q, state.u

    def rates(self, t: float, x: np.ndarray, v: np.ndarray, solve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return x', v' and the powers (3,) of loads and drives; `solve` writes the accelerations of a state."""
        state = self.state(t, x, v)
        solve(state)
        change = np.zeros(len(x))
        kinematics(self.system.program, 0.0, np.ascontiguousarray(x), state.u, change)
        return change, state.a, powers(self.work.energy)


class Motion:
    """What explicit and implicit methods share: accelerations by a formulation, in the unknowns it offers.

    `settings` have the formulation, and the drift at which states are projected.
    """

    def __init__(self, settings, system, state, work):
        self.formulation, self.drift = settings.formulation, settings.drift
        self.system, self.work = system, work
        self.bounds = system.drift_bounds(self.drift)
        self.friction = system.implicit or any(force.reads_reactions for force in system.model.forces)
        self.right = np.zeros(system.nu + system.ng)
        offered = self.formulation.unknowns or AbsoluteUnknowns
        self.unknowns = offered(system, state, work)

    def solve(self, state) -> None:
        """Fill in accelerations and multipliers by the formulation, and the powers of work.energy."""
        work = self.work
        state.a[:], state.lam[:] = self.formulation.accelerate(self.system, state, work)
        if self.friction:
            work.weights[0].wanted = 0
            evaluate(self.system.program, state, work)
        else:  # the evaluation of the formulation holds, but for the power of the drives at its own multipliers
            with np.errstate(over="ignore", invalid="ignore"):  # whoever asked looks for numbers that are not finite
                work.energy[0].drive_power -= (state.lam - work.equations["force"]) @ work.equations["rate"]

    def sample(self, t: float, x: np.ndarray, v: np.ndarray):
        """Return the state of the unknowns with accelerations and multipliers."""
        state = self.unknowns.state(t, x.copy(), v.copy())
        self.solve(state)
        return state

    def accepted(self, t: float, x: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool]:
        """Return x and v at the end of a step, back on the constraints, and whether they had drifted off."""
        if not self.unknowns.closes:
            return x, v, False
        system, x, v = self.system, x.copy(), v.copy()
        state = self.unknowns.state(t, x, v)
        self.work.weights[0].wanted = 0
        evaluate(system.program, state, self.work)
        off = bool(system.ng) and drifted(self.work, state.u, self.bounds, system.lengths.related)
        if off:
            bounds, gaps = 0.01 * self.bounds, system.gaps
            project(system.program, state, self.work, self.right, state.q, bounds, gaps, system.units, 10)
            self.work.weights[0].wanted = 0
            evaluate(system.program, state, self.work)
        x, v = self.unknowns.reached(state, x, v, off)
        return x, v, off


def run_samples(run, system, samples: np.ndarray, first: int, last: int, patience: float = np.inf) -> Outcome:
    """Advance a run through samples[first:last]; return the rows and why it ended.

    The run has `advance(t, pace)`, which returns the failure or an empty text; `reached`, its present time (before t if
    the patience was used up); and `sample()` (t, q, u, a, lam, works).
    """
    kept: list[tuple] = []
    failure, pace = "", Patience(patience)
    for k in range(first, last):
        failure = run.advance(float(samples[k]), pace)
        if failure or run.reached < samples[k]:
            break
        try:
            row = run.sample()
        except (CompileError, ValueError, np.linalg.LinAlgError) as error:
            why = str(error) if isinstance(error, CompileError) else "the accelerations are not finite"
            failure = f"{why} at t = {float(samples[k]):.9g} s"
            break
        lost = np.flatnonzero(~np.isfinite(row[3]))
        if len(lost):
            failure = f"the accelerations are not finite at t = {row[0]:.9g} s near {system.owner(int(lost[0]))}"
            break
        kept.append(row)
    widths = (0, system.nq, system.nu, system.nu, system.ng, 3)
    rows = {
        name: np.array([row[i] for row in kept]).reshape((len(kept), width) if i else (len(kept),))
        for i, (name, width) in enumerate(zip(("t", "q", "u", "a", "lam", "works"), widths, strict=True))
    }
    return Outcome(rows=rows, failure=failure, reached=float(run.reached))
