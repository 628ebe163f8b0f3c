"""`Explicit`: Runge-Kutta methods of SciPy on the accelerations, with projection onto the constraints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import CompileError, ModelError
from flexmb.integrate.extent import model_size
from flexmb.integrate.formulations import Augmented
from flexmb.integrate.outcome import Outcome
from flexmb.integrate.stabilised import kinematics
from flexmb.model.described import Described, is_number
from flexmb.system.complaints import worst_equations
from flexmb.system.program import constraint_velocity, evaluate, project

__all__ = ["Explicit"]

AUGMENTED = Augmented()
VANISHING, PATIENCE = 1e-9, 30
"""So many steps in a row that are shorter than this part of the run: the method has come to a singular configuration."""
METHODS = ("DOP853", "RK45", "Radau")
FORMULATIONS = "Augmented(), NullSpace(), UdwadiaPhohomsiri(), Recursive(), Baumgarte()"


class _Run:
    """The solver between samples, and the storage of its callback."""

    def __init__(self, settings: Explicit, system, state, work, t_end: float):
        import scipy.integrate

        self.settings, self.system, self.work = settings, system, work
        self.right = np.zeros(system.nu + system.ng)
        self.tolerance = settings.drift * model_size(system)
        self.counts = {"steps": 0, "evaluations": 0, "projections": 0}
        self.complaint = ""
        self.solver: Any = None
        y = np.concatenate([state.q, state.u, np.zeros(3)])
        method = getattr(scipy.integrate, settings.method)
        end = max(t_end, state.t + 1e-12)
        self.span = end - state.t
        self.solver = method(self.rates, state.t, y, end, rtol=settings.rtol, atol=settings.atol,
                             max_step=settings.largest or np.inf)

    def state(self, t: float, y: np.ndarray):
        """Return the state of a vector of unknowns, Euler parameters normalised."""
        system = self.system
        state = system.state(t, y[: system.nq], y[system.nq : system.nq + system.nu])
        for iq, _ in system.program.frames:
            state.q[iq + 3 : iq + 7] /= np.linalg.norm(state.q[iq + 3 : iq + 7])
        return state

    def solve(self, state) -> None:
        """Fill in accelerations and multipliers by the formulation, and the powers of work.energy."""
        state.a[:], state.lam[:] = self.settings.formulation.accelerate(self.system, state, self.work)
        self.work.coefficients[3] = 0.0
        evaluate(self.system.program, state, self.work)

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        """Callback of the solver: q', u' and the rates of work."""
        system = self.system
        self.counts["evaluations"] += 1
        state = self.state(t, y)
        try:
            self.solve(state)
        except (CompileError, ValueError, np.linalg.LinAlgError) as error:
            # a trial state may lie anywhere: the solver takes a shorter step where rates are not numbers
            self.complaint = str(error) if isinstance(error, CompileError) else "the state is not finite"
            if self.solver is None:
                raise
            return np.full(len(y), np.nan)
        out = np.zeros(len(y))
        kinematics(system.program, 0.0, np.ascontiguousarray(y), state.u, out)
        out[system.nq : system.nq + system.nu] = state.a
        out[-3:] = self.work.energy[3:6]
        return out

    def drifted(self, state) -> bool:
        """Has the state left the constraints, at the level of position or of velocity?"""
        rate = np.zeros(self.system.ng)
        constraint_velocity(self.work, state.u, rate)
        fastest = max(np.max(np.abs(self.work.markers[name])) for name in ("v", "w"))
        return (np.max(np.abs(self.work.equations["g"])) > self.tolerance
                or np.max(np.abs(rate)) > self.settings.drift * max(1.0, float(fastest)))

    def project(self) -> None:
        """Put the solver's present state back onto the constraints if it has drifted off."""
        system, solver = self.system, self.solver
        state = self.state(solver.t, solver.y)
        self.work.coefficients[3] = 0.0
        evaluate(system.program, state, self.work)
        if system.ng and self.drifted(state):
            self.counts["projections"] += 1
            project(system.program, state, self.work, self.right, state.q, 0.01 * self.tolerance,
                    system.gaps, 10)
        solver.y = np.concatenate([state.q, state.u, solver.y[-3:]])
        if hasattr(solver, "f"):
            solver.f = self.rates(solver.t, solver.y)

    def advance(self, t: float) -> str:
        """Integrate to `t`; return what went wrong, or an empty text."""
        solver, left, short = self.solver, self.settings.most_steps, 0
        solver.t_bound = t
        solver.status = "running" if solver.t < t else "finished"
        while solver.status == "running":
            try:
                message = solver.step()
            except ValueError:  # Radau: a matrix that is not finite
                solver.status, message = "failed", "the iteration of the method met numbers that are not finite"
            self.counts["steps"] += 1
            left -= 1
            # one short step may end at a sample; many in a row get nowhere
            short = short + 1 if solver.step_size is not None and solver.step_size < VANISHING * self.span else 0
            if short > PATIENCE and solver.status == "running":
                worst = f"; worst equations: {worst_equations(self.system, self.work)}" if self.system.ng else ""
                return f"the step size fell below {VANISHING * self.span:.3g} s at t = {solver.t:.9g} s{worst}"
            if left == 0 and solver.status == "running":
                return (f"{self.settings.most_steps} steps between two samples reached only t = {solver.t:.9g} s: the "
                        "motion is stiff or very fast")
            if solver.status == "failed" or not np.all(np.isfinite(solver.y)):
                worst = f"; worst equations: {worst_equations(self.system, self.work)}" if self.system.ng else ""
                why = "; ".join(text for text in (message, self.complaint) if text) or "the state is not finite"
                return f"{why} at t = {solver.t:.9g} s{worst}"
            self.project()
        return ""

    def sample(self):
        """Return t, q, u, a, lam, works."""
        state = self.state(self.solver.t, self.solver.y)
        self.solve(state)
        return state.t, state.q, state.u, state.a, state.lam, self.solver.y[-3:].copy()


@dataclass(frozen=True, kw_only=True)
class Explicit(metaclass=Described):
    """Accelerations from any formulation, integrated by a Runge-Kutta method, projected onto g = 0 and G u = -dg/dt.

    For rigid or soft systems and high accuracy; stiff ones (bushings, short springs, many modes) need small steps here:
    use `GeneralizedAlpha`, `IDA`, or the method "Radau".

    Parameters
    ----------
    method : "DOP853", "RK45" or "Radau"
        Of scipy.integrate.
    rtol, atol : float
        Relative and absolute tolerance of every coordinate and velocity (m, rad, per s).
    drift : float
        Constraint residual, relative to the size of the model, at which the state is projected; that of the velocities
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
    atol: float = 1e-10
    drift: float = 1e-10
    formulation: Any = AUGMENTED
    largest: float | None = None
    most_steps: int = 100_000

    def __post_init__(self):
        if self.method not in METHODS:
            raise ModelError("Explicit", found=f"method = {self.method!r}", expected=f"one of {', '.join(METHODS)}",
                             remedy="DOP853 for smooth motions, Radau for stiff ones")
        if isinstance(self.formulation, type) or not hasattr(self.formulation, "accelerate"):
            raise ModelError("Explicit", found=f"formulation = {self.formulation!r}", expected=f"one of {FORMULATIONS}",
                             remedy="Give an object: Explicit(formulation=Recursive())")
        for name in ("rtol", "atol", "drift", "largest", "most_steps"):
            value = getattr(self, name)
            if value is not None and not (is_number(value) and value > 0.0):
                raise ModelError("Explicit", found=f"{name} = {value!r}", expected="a positive number",
                                 remedy=f"Leave {name} out for its default")

    def start(self, system, state, work, t_end: float) -> _Run:
        """Return the solver at the start."""
        return _Run(self, system, state, work, t_end)

    def run(self, system, work, variables: _Run, samples: np.ndarray, first: int, last: int) -> Outcome:
        """Integrate through samples[first:last] and return the rows and why it ended."""
        kept: list[tuple] = []
        failure = ""
        for k in range(first, last):
            failure = variables.advance(float(samples[k]))
            if failure:
                break
            kept.append(variables.sample())
        widths = (0, system.nq, system.nu, system.nu, system.ng, 3)
        rows = {name: np.array([row[i] for row in kept]).reshape((len(kept), width) if i else (len(kept),))
                for i, (name, width) in enumerate(zip(("t", "q", "u", "a", "lam", "works"), widths, strict=True))}
        return Outcome(rows=rows, failure=failure)

    @staticmethod
    def statistics(variables: _Run) -> dict[str, Any]:
        """Return the numbers of the run."""
        return dict(variables.counts)
