"""`Implicit`: an L-stable Runge-Kutta method of order four in joint coordinates, for trees with stiff bodies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.integrate.extent import extents, reaches
from flexmb.integrate.implicit.added_errors import follow
from flexmb.integrate.implicit.beside import carry, known, new_beside
from flexmb.integrate.implicit.stages import COUNTED, STAGES, THIRD, WEIGHTS, new_stages, run_step
from flexmb.integrate.motion import Motion, run_samples
from flexmb.integrate.runs.added_error import AddedError
from flexmb.integrate.runs.gap import added_error
from flexmb.integrate.runs.kept_switches import keep_switches
from flexmb.integrate.runs.outcome import Outcome
from flexmb.integrate.runs.patience import UNCUT, Patience, smallest_step
from flexmb.integrate.runs.spin_axes import keep_axes, new_axes
from flexmb.integrate.runs.switches import allowed
from flexmb.integrate.runs.switching import PassedOver, new_switching, read_switches
from flexmb.math.energies import powers
from flexmb.math.structures import counted
from flexmb.math.tables import INTEGRALS
from flexmb.model.described import Described, is_number
from flexmb.model.methods import is_formulation
from flexmb.system.assembly import all_softened
from flexmb.system.complaints import worst_equations
from flexmb.system.program import evaluate
from flexmb.tree import Recursive
from flexmb.tree.coordinates.settle import coordinate_rates

__all__ = ["Implicit"]

RECURSIVE = Recursive()
NEWTON = 1e-4
"""What the iteration may leave, relative to the tolerance of a step."""
SETTLED = 1e-12
"""The same of a fixed step at least, relative to the accelerations:
rounding, since small steps divide it by their size.
"""
IMPACT, SLIP = 5.0, 0.5
"""Change of the speed of an impact in a step, relative to it and to the fourth root of the tolerance, and of a slip."""
SLOW = 0.01
"""Per simulated time: rates below this say nothing about the first step."""
BEGUN = 0.01
"""Part of the longest step in which the work of drives may begin to grow."""
TOLD = 2.0 / 3.0
"""Power of the tolerance to which the work of drives is known in a step, relative to the largest so far."""


class _Run:
    """The method between samples."""

    def __init__(self, settings: Implicit, system, state, work, t_end: float):
        system = all_softened(system)
        self.settings, self.system, self.work = settings, system, work
        self.motion = Motion(settings, system, state, work)
        self.unknowns = self.motion.unknowns
        extent, reach = extents(system, state, work, settings.atol)
        reach = reaches(system, reach, settings.rtol)
        self.t, self.works, self.projections = state.t, np.zeros(3), 0
        self.driven = any(joint.works for joint in system.model.joints)
        self.turned = 0.0
        self.goal, self.span = state.t, 0.0
        self.x, self.v, a = self.unknowns.of(state)
        span = max(t_end - state.t, 1e-300)
        first_state = system.nu - int(np.sum(system.is_state))
        self.stages = r = new_stages(
            self.unknowns, system.state(state.t), extent, reach, new_axes(system.program), span, first_state
        )
        r.L[0], r.A[0] = state.lam, a
        self.beside = new_beside(system, self.unknowns, state, settings.follow_errors)
        self.motion.sample(self.t, self.x, self.v)
        r.W[0] = powers(work.energy)
        self._begin()
        work.weights[0].wanted = 0
        evaluate(system.program, state, work)
        share = IMPACT * settings.rtol**0.25
        floor = settings.rtol * system.lengths.whole
        over = PassedOver(floor=floor, impact=share, slip=SLIP, duration=span)
        self.switching = new_switching(system, state, work, over)
        self.cut = 0
        self.largest = settings.step or settings.largest or span / 20.0
        self.next = settings.step or min(self.largest, self._first_step(state, extent, reach, SLOW / span))

    def jumped(self) -> bool:
        """Write accelerations, reactions and powers after a jump of the loads to the first stage."""
        state = self.motion.sample(self.t, self.x, self.v)
        if not np.all(np.isfinite(state.a)):
            return False
        r = self.stages
        r.L[0], r.A[0], r.W[0] = state.lam, self.unknowns.of(state)[2], powers(self.work.energy)
        return True

    def _begin(self) -> None:
        """Write the rates at the start of a step to the first stage."""
        coordinate_rates(self.unknowns.chart.rows, self.x, self.v, self.stages.K[0])
        self.stages.V[0] = self.v

    def _first_step(self, state, extent, reach, slow: float) -> float:
        """Return a step size well below the tolerance's, from speed and acceleration."""
        states = self.system.is_state
        pace = np.max(np.abs(state.a[states]) / np.maximum(reach[states], np.abs(state.u[states])), initial=slow)
        a = np.max(np.abs(state.a) * extent / reach, initial=0.0, where=~states)
        u = np.max(np.abs(state.u) * extent / reach, initial=0.0, where=~states)
        # rates at the end of the range of numbers ask for none: steps that are no longer fail with a reason
        return max(float(0.1 * self.settings.rtol**0.25 / max(np.sqrt(a), u, pace)), float(np.finfo(float).tiny))

    def _step(self, h: float) -> None:
        """Take a step, or shorten the next one."""
        r, adaptive, planned = self.stages, self.settings.step is None, self.next
        solved = run_step(
            self.unknowns.chart,
            self.system.program,
            self.work,
            r,
            self.x,
            self.v,
            self.t,
            h,
            WEIGHTS,
            THIRD,
            self.settings.rtol,
            NEWTON,
            np.inf if adaptive else SETTLED,
        )
        if not solved:
            r.run[0].rejected_by_iteration += 1
            self.next = 0.25 * h
            return
        error = max(float(r.run[0].error), self._error_of_work(h))
        if adaptive and not error <= 1.0:
            r.run[0].rejected_by_error += 1
            self.next = h * max(0.2, 0.85 * error**-0.25)
            return
        part = 2.0
        if len(self.switching.now) and h > UNCUT * smallest_step(self.t, self.goal):
            state = self.motion.unknowns.state(self.t + h, r.y.copy(), r.v.copy())
            self.work.weights[0].wanted = 0
            evaluate(self.system.program, state, self.work)
            read_switches(self.system.program, self.switching, state, self.work)
            part = allowed(self.system.program, self.switching, h, adaptive)
        if part < 1.0:
            self.cut += 1
            self.next = part * h
            return
        keep_switches(self.switching, h)
        keep_axes(self.system.program.frames, r.axes, r.state.u, h)
        self._follow(h)
        self.t += h
        self.works += h * WEIGHTS[-1] @ r.W
        self.turned = max(self.turned, abs(float(self.works[1])))
        self.x, self.v, projected = self.motion.accepted(self.t, r.y.copy(), r.v.copy())
        self.projections += projected
        r.A[0], r.W[0], r.L[0] = r.A[STAGES - 1], r.W[STAGES - 1], r.lam
        self._begin()
        r.run[0].steps += 1
        for iq, iu, size, flexible in self.system.program.vectors:
            if flexible == INTEGRALS:
                r.reach[iu : iu + size] = np.maximum(r.reach[iu : iu + size], np.abs(r.state.u[iu : iu + size]))
                continue
            if not flexible:  # positions in W: how far the origin is says nothing about a tolerance
                continue
            # tolerances of flexible coordinates are relative to the largest displacement they have reached
            largest = np.max(np.abs(r.state.q[iq : iq + size]) * r.extent[iu : iu + size], initial=0.0)
            r.reach[iu : iu + size] = np.maximum(r.reach[iu : iu + size], largest)
        self.next = self.largest
        if adaptive:
            growth = min(2.0, 0.85 * max(error, 1e-6) ** -0.25)
            self.next = min(self.largest, h * growth if growth < 1.0 else max(planned, h * growth))
            self.next = min(self.next, part * h) if part < 2.0 else self.next

    def _follow(self, h: float) -> None:
        """Take the motion without known errors over the step that has just been accepted."""
        if self.beside.run["followed"][0] and h * h > 0.0:  # it divides by this square
            touched = len(self.switching.now) > 0 and int(self.switching.limits["closed"][0])
            follow(
                self.unknowns.chart,
                self.system.program,
                self.work,
                self.stages,
                self.beside,
                self.x,
                self.v,
                self.t,
                h,
                WEIGHTS,
                THIRD,
                int(touched),
            )

    def _error_of_work(self, h: float) -> float:
        """Return the error of the work of drives in a step, relative to its tolerance: coordinates that are driven have
        no error, however long a step is.

        The tolerance is never less than that of what the power does in a part of the longest step: work that begins to
        grow, as t^5, has the same relative error in every first step, however short.
        """
        powers = self.stages.W[:, 1]
        if not self.driven or not np.any(powers):
            return 0.0
        turned = max(self.turned, max(h, BEGUN * self.largest) * float(np.max(np.abs(powers))))
        return abs(h * float((WEIGHTS[-1] - THIRD) @ powers)) / (self.settings.rtol**TOLD * turned)

    @property
    def reached(self) -> float:
        """Time of the present state."""
        return self.t

    def advance(self, t: float, pace: Patience) -> str:
        """Integrate to `t`, or until the patience is used up; return what went wrong, or an empty text."""
        if t > self.t and t != self.goal:
            self.goal, self.span = t, t - self.t
        while t - self.t > 1e-12 * max(abs(t), self.span):
            left = t - self.t
            h = left / max(1.0, np.ceil(left / min(self.next, self.largest) * (1.0 - 1e-9)))
            self._step(h)
            if self.next < smallest_step(self.t, t):
                return self._reason()
            if pace.used_up:
                return ""
        self.t = t
        return ""

    def _reason(self) -> str:
        worst = f"; worst equations: {worst_equations(self.system, self.work)}" if self.system.ng else ""
        r, nu = self.stages, self.system.nu
        where = self.system.owner(int(np.argmax(np.abs(r.right[:nu]) * r.extent)))
        return (
            f"steps fail down to {self.next:.3g} s at t = {self.t:.9g} s (dead centre, or stiff "
            f"impact) near {where}{worst}"
        )

    def sample(self):
        """Return t, q, u, a, lam, works."""
        state = self.motion.sample(self.t, self.x, self.v)
        return state.t, state.q, state.u, state.a, state.lam, self.works.copy()


@dataclass(frozen=True, kw_only=True)
class Implicit(metaclass=Described):
    """Implicit Runge-Kutta method of order four in the joint coordinates of the tree.

    For stiff flexible bodies at high accuracy: steps follow the motion, however high the frequencies of the modes, and
    joints of the tree cannot open. L-stable: what a step cannot resolve is gone after it. A step costs six stages with
    some three iterations each, one factorisation, linear in the number of bodies.
    Theory: recursive.

    Parameters
    ----------
    rtol : float, -
        Local error of a step, relative to the length of the assembly (positions), to a radian (rotations), and to the
        largest deflection (flexible coordinates).
    atol : float, m
        Displacement below which errors of flexible coordinates do not matter; default 1e-4 of that length.
    step : float, s, optional
        Fixed step size; without it the step follows the error.
    largest : float, s, optional
        Largest step size; default a twentieth of the simulated time.
    drift : float
        Constraint residual, relative to the length of the assembly, at which the state is projected; for velocities
        relative to the fastest marker.
    formulation : Recursive
        The tree, and by which joints loops are opened.
    follow_errors : bool
        Whether the run tells what the errors of its steps add up to, by a second motion without them.

    Source: Kennedy & Carpenter 2003 (ESDIRK4(3)6L[2]SA).
    """

    rtol: float = 1e-6
    atol: float | None = None
    step: float | None = None
    largest: float | None = None
    drift: float = 1e-10
    formulation: Any = RECURSIVE
    follow_errors: bool = True
    steps_in_contact: ClassVar[float] = 5.0
    """Within a contact, for 1 % of the change of speed, wherever in a step it begins: mass on a linear spring."""
    entries: ClassVar[tuple] = (run_step, follow)
    """Kernels that a run will call: compiled meanwhile by other processes when they are missing."""

    def __post_init__(self):
        if not is_formulation(self.formulation) or self.formulation.unknowns is None:
            raise ModelError(
                "Implicit",
                found=f"formulation = {self.formulation!r}",
                expected="Recursive(...)",
                remedy="GeneralizedAlpha and IDA integrate absolute coordinates implicitly",
            )
        for name in ("rtol", "atol", "step", "largest", "drift"):
            value = getattr(self, name)
            if not (value is None and name not in ("rtol", "drift")) and not (is_number(value) and value > 0.0):
                raise ModelError(
                    "Implicit",
                    found=f"{name} = {value!r}",
                    expected="a positive number",
                    remedy=f"Leave {name} out for its default",
                )

    def start(self, system, state, work, t_end: float) -> _Run:
        """Return the method at the start."""
        return _Run(self, system, state, work, t_end)

    def run(
        self, system, work, variables: _Run, samples: np.ndarray, first: int, last: int, patience: float = np.inf
    ) -> Outcome:
        """Integrate through samples[first:last] and return the rows and why it ended; after `patience` seconds those
        so far, to be called again from the next."""
        return run_samples(variables, system, samples, first, last, patience)

    def jumped(self, system, work, variables: _Run) -> bool:
        """Go on with accelerations that loads make after a jump, at the present time; return if there are any."""
        return variables.jumped()

    @staticmethod
    def taken_over(system, before: _Run, variables: _Run) -> _Run:
        """Return the variables of a new start with what the errors of the steps before have added up to."""
        carry(before.beside, variables.beside)
        return variables

    def added_error(self, system, variables: _Run) -> AddedError | None:
        """Return what the errors of the steps have added up to so far; None if they are not followed."""
        follows = self.follow_errors and known(variables.beside)
        return added_error(system, variables.beside.run[0]) if follows else None

    @staticmethod
    def statistics(variables: _Run) -> dict[str, Any]:
        """Return the numbers of the run."""
        return {
            **counted(variables.stages.run, COUNTED),
            "cut at contacts": variables.cut,
            "projections": variables.projections,
        }
