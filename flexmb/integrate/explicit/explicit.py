"""`Explicit`: Runge-Kutta methods of SciPy on the accelerations, with projection onto the constraints."""

from __future__ import annotations

import copy
import types
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexmb.errors import CompileError, ModelError
from flexmb.integrate.explicit import closed_steps
from flexmb.integrate.explicit.compiled_run import AUGMENTED, CAUTIOUS, CompiledRun
from flexmb.integrate.explicit.drift import PATIENCE, VANISHING
from flexmb.integrate.explicit.through import run_through
from flexmb.integrate.explicit.tolerances import tolerances
from flexmb.integrate.motion import Motion, run_samples
from flexmb.integrate.runs.interruption import look_within_step
from flexmb.integrate.runs.kept_switches import keep_switches
from flexmb.integrate.runs.outcome import Outcome
from flexmb.integrate.runs.patience import Patience
from flexmb.integrate.runs.switches import allowed
from flexmb.integrate.runs.switching import PassedOver, new_switching, read_switches
from flexmb.model.described import Described, is_number
from flexmb.model.methods import is_formulation
from flexmb.system.complaints import worst_equations
from flexmb.system.dead_centre import joints_at_dead_centre
from flexmb.system.program import evaluate

__all__ = ["Explicit"]

METHODS = ("DOP853", "RK45", "Radau")
FORMULATIONS = "Augmented(), NullSpace(), UdwadiaPhohomsiri(), Recursive(), Baumgarte()"


LONGEST = 1e-3
"""Differences by which Radau finds its matrix, relative to a coordinate, are no longer: SciPy makes them ten times as
long with every matrix where nothing depends on the coordinate, until it is no number."""
NOWHERE = 1e-30
"""Part of the time of the run below which a trial of a step leads nowhere: near t = 0 SciPy tries shorter ones, down to
1e-323 s, where the state is at the end of the range of numbers."""


DEAD_CENTRE = "Give formulation=Recursive(), or GeneralizedAlpha() or IDA(), which pass dead centres"
"""Accelerations of bodies in absolute coordinates have no unique solution there, however short the steps are."""


NAMED = 8
"""Joints that are named at a dead centre."""


class _Nowhere(Exception):
    """A step is tried that leads nowhere."""


class _Run:
    """The solver between samples, and the storage of its callback."""

    def __init__(self, settings: Explicit, motion: Motion, state, t_end: float):
        import scipy.integrate

        self.settings, self.motion, self.system, self.work = settings, motion, motion.system, motion.work
        self.counts = {"steps": 0, "evaluations": 0, "projections": 0}
        self.complaint = ""
        self.goal, self.left, self.short = -np.inf, settings.most_steps, 0
        self.solver: Any = None
        x, v, _ = self.motion.unknowns.of(state)
        self.method = getattr(scipy.integrate, settings.method)
        self.t_end = max(t_end, state.t + 1e-12)
        self.span = self.t_end - state.t
        self.nx, self.end = len(x), len(x) + len(v)
        self.atol = tolerances(settings, motion, state, self.span)
        self.work.weights[0].wanted = 0
        evaluate(self.system.program, state, self.work)
        floor = settings.rtol * self.system.lengths.whole
        self.switching = new_switching(self.system, state, self.work, PassedOver(floor=floor))
        self.solver = self._solver(state.t, np.concatenate([x, v, np.zeros(3)]))

    def __deepcopy__(self, memo: dict) -> _Run:
        """Return a run that goes on by itself: SciPy's solvers hold functions, which a copy would share."""
        run = object.__new__(_Run)
        memo[id(self)] = run
        vars(run).update({name: copy.deepcopy(x, memo) for name, x in vars(self).items() if name != "solver"})
        called: list[Any] = [lambda t, y: np.zeros(len(y))]  # nothing is evaluated while the solver is made
        run.solver = run._solver(self.solver.t, self.solver.y, None, lambda t, y: called[0](t, y))
        for name, value in vars(self.solver).items():
            if not isinstance(value, types.FunctionType | types.MethodType):
                setattr(run.solver, name, copy.deepcopy(value, memo))
        called[0] = run.rates
        return run

    def _solver(self, t: float, y: np.ndarray, first: float | None = None, rates: Any = None):
        """Return the solver at a state, with a first step or one of its own choice."""
        with np.errstate(over="ignore", invalid="ignore"):
            solver = self.method(
                rates or self.rates,
                t,
                y,
                self.t_end,
                rtol=self.settings.rtol,
                atol=self.atol,
                max_step=self.settings.largest or np.inf,
                first_step=first,
            )
        if not np.isfinite(solver.h_abs):  # rates or positions at the end of the range of numbers
            # shortened or not, it would stay no number, and SciPy would try it for ever within one step
            solver.h_abs = min(CAUTIOUS, abs(solver.t_bound - t))
        return solver

    def _cut(self, before: tuple[float, np.ndarray]) -> bool:
        """Was the step too long for a contact? Then it is taken back, and a shorter one will be tried."""
        sw, (t, y) = self.switching, before
        h = self.solver.t - t
        if not len(sw.now) or not h > 1e-11 * self.span or not np.all(np.isfinite(self.solver.y)):
            return False
        x, v = self.solver.y[: self.nx].copy(), self.solver.y[self.nx : self.end].copy()
        state = self.motion.unknowns.state(self.solver.t, x, v)
        self.work.weights[0].wanted = 0
        evaluate(self.system.program, state, self.work)
        read_switches(self.system.program, sw, state, self.work)
        part = allowed(self.system.program, sw, h, True)
        if part < 1.0:
            bound = self.solver.t_bound
            self.solver = self._solver(t, y, part * h)
            self.solver.t_bound = bound
            return True
        keep_switches(sw, h)
        return False

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        """Callback of the solver: rates of the unknowns and of the works."""
        look_within_step()
        if self.solver is not None and 0.0 < t - self.solver.t < NOWHERE * self.span:
            raise _Nowhere
        self.counts["evaluations"] += 1
        try:
            return np.concatenate(self.motion.unknowns.rates(t, y[: self.nx], y[self.nx : self.end], self.motion.solve))
        except (CompileError, ValueError, np.linalg.LinAlgError) as error:
            # a trial state may lie anywhere: the solver takes a shorter step where rates are not numbers
            self.complaint = str(error) if isinstance(error, CompileError) else "the state is not finite"
            if self.solver is None:
                raise
            return np.full(len(y), np.nan)

    def accept(self) -> None:
        """Take over the solver's present state, back on the constraints if it has drifted off."""
        solver = self.solver
        x, v, projected = self.motion.accepted(solver.t, solver.y[: self.nx], solver.y[self.nx : self.end])
        self.counts["projections"] += projected
        y = np.concatenate([x, v, solver.y[-3:]])
        if hasattr(solver, "f") and not np.array_equal(y, solver.y):
            solver.f = self.rates(solver.t, y)
        solver.y = y

    @property
    def reached(self) -> float:
        """Time of the present state."""
        return self.solver.t

    def state(self):
        """Return the present state, without accelerations."""
        y = self.solver.y
        return self.motion.unknowns.state(self.solver.t, y[: self.nx].copy(), y[self.nx : self.end].copy())

    def advance(self, t: float, pace: Patience) -> str:
        """Integrate to `t`, or until the patience is used up; return what went wrong, or an empty text."""
        solver = self.solver
        if t > solver.t and t != self.goal:
            self.goal, self.left, self.short = t, self.settings.most_steps, 0
        solver.t_bound = t
        solver.status = "running" if solver.t < t else "finished"
        while self.solver.status == "running":
            solver = self.solver
            before = solver.t, solver.y.copy()
            lengths = getattr(solver, "jac_factor", None)  # of Radau alone
            if lengths is not None:
                np.minimum(lengths, LONGEST, out=lengths)
            try:
                with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is seen below
                    message = solver.step()
            except ValueError:  # Radau: a matrix that is not finite
                solver.status, message = "failed", "the iteration of the method met numbers that are not finite"
            except _Nowhere:
                why = f"; {self.complaint}" if self.complaint else ""
                return f"no step can be taken at t = {solver.t:.9g} s, however short{why}{self._worst()}"
            self.counts["steps"] += 1
            self.left -= 1
            # one short step may end at a sample; many in a row get nowhere
            vanishing = solver.step_size is not None and solver.step_size < VANISHING * self.span
            self.short = self.short + 1 if vanishing else 0
            if self.short > PATIENCE and solver.status == "running":
                return f"the step size fell below {VANISHING * self.span:.3g} s at t = {solver.t:.9g} s{self._worst()}"
            if self.left == 0 and solver.status == "running":
                return (
                    f"{self.settings.most_steps} steps between two samples reached only t = {solver.t:.9g} s: the "
                    "motion is stiff or very fast"
                )
            if solver.status == "failed" or not np.all(np.isfinite(solver.y)):
                why = "; ".join(text for text in (message, self.complaint) if text) or "the state is not finite"
                return f"{why} at t = {solver.t:.9g} s{self._worst()}"
            if not self._cut(before):
                self.accept()
            if pace.used_up:
                break
        return ""

    def _worst(self) -> str:
        return f"; worst equations: {worst_equations(self.system, self.work)}" if self.system.ng else ""

    def sample(self):
        """Return t, q, u, a, lam, works."""
        y = self.solver.y
        state = self.motion.sample(self.solver.t, y[: self.nx], y[self.nx : self.end])
        return state.t, state.q, state.u, state.a, state.lam, y[-3:].copy()


def _with_cause(outcome: Outcome, system, state) -> Outcome:
    """Return how a run failed, with the dead centre at its end, if it came to one."""
    joints = joints_at_dead_centre(system, state, system.workspace())
    if not joints:
        return outcome
    named = ", ".join(joints[:NAMED]) + (f", ... ({len(joints)} in all)" if len(joints) > NAMED else "")
    found = (
        f"a dead centre near t = {state.t:.6g} s, where equations of joints ({named}) depend on each other that do not "
        "at the start"
    )
    return replace(outcome, failure=f"{found}; {outcome.failure}", remedy=DEAD_CENTRE)


@dataclass(frozen=True, kw_only=True)
class Explicit(metaclass=Described):
    """Accelerations from any formulation, integrated by a Runge-Kutta method, projected onto g = 0 and G u = -dg/dt.

    For rigid or soft systems and high accuracy; stiff ones (bushings, short springs, many modes) need small steps here:
    use `GeneralizedAlpha`, `Implicit`, `IDA`, or the method "Radau". With `Recursive` the unknowns are joint
    coordinates.

    Parameters
    ----------
    method : "DOP853", "RK45" or "Radau"
        Of scipy.integrate.
    rtol, atol : float
        Relative and absolute tolerance of every coordinate and velocity (m, rad, per s); the absolute one is 1e-10 by
        default, times the length of models below 1 m. That default counts displacements of the material for flexible
        coordinates; for rates in runs of more than 100 s it is less, by the length of the run.
    drift : float
        Constraint residual, relative to the largest body at the joint, at which the state is projected; for velocities
        relative to the fastest marker.
    formulation : Augmented, NullSpace, UdwadiaPhohomsiri, Recursive or Baumgarte
        How accelerations are found.
    largest : float, s, optional
        Largest step size.
    most_steps : int
        Largest number of steps from sample to sample.

    Source: Hairer, Nørsett & Wanner 1993 (methods); Eich 1993 (projection).
    """

    method: str = "DOP853"
    rtol: float = 1e-8
    atol: float | None = None
    drift: float = 1e-10
    formulation: Any = AUGMENTED
    largest: float | None = None
    most_steps: int = 100_000

    def __post_init__(self):
        if self.method not in METHODS:
            raise ModelError(
                "Explicit",
                found=f"method = {self.method!r}",
                expected=f"one of {', '.join(METHODS)}",
                remedy="DOP853 for smooth motions, Radau for stiff ones",
            )
        if not is_formulation(self.formulation):
            raise ModelError(
                "Explicit",
                found=f"formulation = {self.formulation!r}",
                expected=f"one of {FORMULATIONS}",
                remedy="Give an object: Explicit(formulation=Recursive())",
            )
        for name in ("rtol", "atol", "drift", "largest", "most_steps"):
            value = getattr(self, name)
            if value is not None and not (is_number(value) and value > 0.0):
                raise ModelError(
                    "Explicit",
                    found=f"{name} = {value!r}",
                    expected="a positive number",
                    remedy=f"Leave {name} out for its default",
                )

    @property
    def entries(self) -> tuple:
        """Kernels that a run will call: compiled meanwhile by other processes when they are missing."""
        return (run_through,) if self.in_kernels or (self.method == "DOP853" and self.formulation.closed) else ()

    @property
    def in_kernels(self) -> bool:
        """Does no Python run between samples?"""
        return self.method == "DOP853" and (self.formulation.compiled or self.formulation.unknowns is not None)

    def start(self, system, state, work, t_end: float) -> _Run | CompiledRun:
        """Return the solver at the start: compiled where method and formulation are."""
        motion = Motion(self, system, state, work)
        closed = self.formulation.closed and closed_steps.applies(system)
        compiled = self.formulation.compiled or closed or motion.unknowns.links is not None
        if self.method != "DOP853" or not compiled:
            return _Run(self, motion, state, t_end)
        return CompiledRun(
            self, motion, state, t_end, lambda now: _Run(self, Motion(self, system, now, work), now, t_end)
        )

    def run(
        self, system, work, variables, samples: np.ndarray, first: int, last: int, patience: float = np.inf
    ) -> Outcome:
        """Integrate through samples[first:last] and return the rows and why it ended; after `patience` seconds those
        so far, to be called again from the next."""
        if isinstance(variables, CompiledRun):
            outcome = variables.through(samples, first, last, patience)
        else:
            outcome = run_samples(variables, system, samples, first, last, patience)
        return _with_cause(outcome, system, variables.state()) if outcome.failure else outcome

    def jumped(self, system, work, variables) -> bool:
        """Go on with accelerations that loads make after a jump, at the present time; return if there are any."""
        return isinstance(variables, CompiledRun) and variables.jumped()

    def held(self, system, work, variables, t: float, q: np.ndarray) -> bool:
        """Go on from the time t with values that blocks hold from then on, the last of q (nq,); return if it can."""
        return isinstance(variables, CompiledRun) and variables.held(t, q[system.program.branches :])

    @staticmethod
    def statistics(variables) -> dict[str, Any]:
        """Return the numbers of the run, by which recursion accelerations are found, if by one, and which steps are
        Python's.
        """
        chosen, compiled = variables.motion.unknowns.recursion, isinstance(variables, CompiledRun)
        told = {"recursion": chosen} if chosen else {}
        if chosen and not compiled and variables.settings.method == "DOP853":
            told["recursion"] = f"{chosen}; its steps are Python's, some tens of times slower than those of Implicit()"
        if compiled and variables.handed_over:
            told["steps handed over"] = variables.handed_over
        return {**variables.counts, **told}
