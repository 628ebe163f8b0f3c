"""`Implicit`: an L-stable Runge-Kutta method of order four in joint coordinates, for trees with stiff bodies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import CompileError, ModelError
from flexmb.integrate.extent import extents, reaches
from flexmb.integrate.implicit.added_errors import follow
from flexmb.integrate.implicit.beside import carry, known, new_beside, uncertainty
from flexmb.integrate.implicit.stages import COUNTED, THIRD, WEIGHTS, new_stages, run_step
from flexmb.integrate.implicit.through import SHORT, UNSURE, Going, GoingOn, run_through
from flexmb.integrate.motion import Motion
from flexmb.integrate.runs.added_error import AddedError
from flexmb.integrate.runs.gap import added_error
from flexmb.integrate.runs.outcome import Outcome
from flexmb.integrate.runs.patience import PAUSED, Patience
from flexmb.integrate.runs.reaction_errors import shares_of_reactions
from flexmb.integrate.runs.sample_rows import SampleRows
from flexmb.integrate.runs.spin_axes import new_axes
from flexmb.integrate.runs.switching import PassedOver, new_switching
from flexmb.math.direct import direct
from flexmb.math.energies import powers
from flexmb.math.structures import counted
from flexmb.math.weights import no_matrix
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


class _Run:
    """The method between samples."""

    def __init__(self, settings: Implicit, system, state, work, t_end: float):
        system = all_softened(system)
        self.settings, self.system, self.work = settings, system, work
        self.motion = Motion(settings, system, state, work)
        self.unknowns = self.motion.unknowns
        extent, reach = extents(system, state, work, settings.atol)
        reach = reaches(system, reach, settings.rtol)
        span = max(t_end - state.t, 1e-300)
        first_state = system.nu - int(np.sum(system.is_state))
        x, v, a = self.unknowns.of(state)
        self.stages = r = new_stages(
            self.unknowns, system.state(state.t), extent, reach, new_axes(system.program), span, first_state
        )
        r.L[0], r.A[0] = state.lam, a
        self.beside = new_beside(system, self.unknowns, state, settings.follow_errors)
        longest = settings.step or settings.largest or span / 20.0
        self.going = g = self._new_going(x, v, state.t, longest)
        self.motion.sample(state.t, x, v)
        r.W[0] = powers(work.energy)
        coordinate_rates(self.unknowns.chart.rows, g.x, g.v, r.K[0])
        r.V[0] = g.v
        work.weights[0].wanted = 0
        evaluate(system.program, state, work)
        share = IMPACT * settings.rtol**0.25
        floor = settings.rtol * system.lengths.whole
        over = PassedOver(floor=floor, impact=share, slip=SLIP, duration=span)
        self.switching = new_switching(system, state, work, over, fixed=settings.step is not None)
        g.run[0].next_step = settings.step or min(longest, self._first_step(state, extent, reach, SLOW / span))

    def _new_going(self, x: np.ndarray, v: np.ndarray, t: float, longest: float) -> Going:
        """Return what the compiled loop starts from."""
        system, settings, motion = self.system, self.settings, self.motion
        adaptive = settings.step is None
        # lent inertia and friction by reactions are for the formulation to correct
        exact = type(settings.formulation) is Recursive and not motion.friction and not len(system.program.floor)
        return Going(
            x=x.copy(),
            v=v.copy(),
            works=np.zeros(3),
            weights=WEIGHTS.copy(),
            third=THIRD.copy(),
            gaps=system.gaps,
            bounds=motion.bounds,
            lengths=system.lengths.related,
            units=system.units,
            turns=self.unknowns.turns,
            balls=np.array(self.unknowns.balls, np.int64),
            state=system.state(t),
            right=motion.right,
            xs=x.copy(),
            vs=v.copy(),
            second=np.zeros(len(v)),
            run=GoingOn.table(
                t=t,
                goal=t,
                longest_step=longest,
                rtol=settings.rtol,
                newton=NEWTON,
                settled=np.inf if adaptive else SETTLED,
                gravity=float(np.linalg.norm(system.model.gravity)),
                adaptive=int(adaptive),
                driven=int(any(joint.works for joint in system.model.joints)),
                closes=int(self.unknowns.closes),
                exact=int(exact),
                redundant=int(bool(system.redundant)),
            ),
        )

    def jumped(self) -> bool:
        """Write accelerations, reactions and powers after a jump of the loads to the first stage."""
        state = self._state()
        if not np.all(np.isfinite(state.a)):
            return False
        r = self.stages
        r.L[0], r.A[0], r.W[0] = state.lam, self.unknowns.of(state)[2], powers(self.work.energy)
        self.beside.own["before"] = 0.0
        return True

    def _state(self):
        """Return the present state with accelerations and multipliers, by the formulation."""
        return self.motion.sample(float(self.going.run[0].t), self.going.x, self.going.v)

    def _first_step(self, state, extent, reach, slow: float) -> float:
        """Return a step size well below the tolerance's, from speed and acceleration."""
        states = self.system.is_state
        pace = np.max(np.abs(state.a[states]) / np.maximum(reach[states], np.abs(state.u[states])), initial=slow)
        a = np.max(np.abs(state.a) * extent / reach, initial=0.0, where=~states)
        u = np.max(np.abs(state.u) * extent / reach, initial=0.0, where=~states)
        # rates at the end of the range of numbers ask for none: steps that are no longer fail with a reason
        return max(float(0.1 * self.settings.rtol**0.25 / max(np.sqrt(a), u, pace)), float(np.finfo(float).tiny))

    def through(self, samples: np.ndarray, first: int, last: int, patience: float) -> Outcome:
        """Integrate through samples[first:last] in one compiled loop; see `Implicit.run`."""
        system, g, pace = self.system, self.going, Patience(patience)
        rows = SampleRows.of(system, last - first)
        reached, failure, reason = first, "", PAUSED
        while reached < last and not failure:
            reached, reason = direct(self, run_through)(
                self.unknowns.chart,
                system.program,
                self.work,
                self.stages,
                self.beside,
                self.switching,
                g,
                samples,
                reached,
                last,
                pace.steps(used=reason == PAUSED),
                rows.after(reached - first),
            )
            if reason == SHORT:
                failure = self._reason()
            elif reason == UNSURE:
                failure, row = self._sample()
                for name, value in row.items():
                    getattr(rows, name)[reached - first] = value
                reached += 1 if row else 0
            if pace.used_up:
                break
        return Outcome(rows=rows.first(reached - first), failure=failure, reached=float(g.run[0].t))

    def _sample(self) -> tuple[str, dict[str, np.ndarray]]:
        """Return why there is no sample at the present state, or an empty text, and the sample, by the formulation."""
        t = float(self.going.run[0].t)
        try:
            state = self._state()
        except (CompileError, ValueError, np.linalg.LinAlgError) as error:
            why = str(error) if isinstance(error, CompileError) else "the accelerations are not finite"
            return f"{why} at t = {t:.9g} s", {}
        lost = np.flatnonzero(~np.isfinite(state.a))
        if len(lost):
            return f"the accelerations are not finite at t = {t:.9g} s near {self.system.owner(int(lost[0]))}", {}
        works = self.going.works.copy()
        return "", {"t": state.t, "q": state.q, "u": state.u, "a": state.a, "lam": state.lam, "works": works}

    def _reason(self) -> str:
        worst = f"; worst equations: {worst_equations(self.system, self.work)}" if self.system.ng else ""
        r, nu = self.stages, self.system.nu
        where = self.system.owner(int(np.argmax(np.abs(r.right[:nu]) * r.extent)))
        now = self.going.run[0]
        return (
            f"steps fail down to {now.next_step:.3g} s at t = {now.t:.9g} s (dead centre, or stiff "
            f"impact) near {where}{worst}"
        )


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
        Constraint residual, relative to the largest body at the joint, at which the state is projected; for velocities
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
    in_kernels: ClassVar[bool] = True
    """No Python runs between samples."""
    shares_as_samples: ClassVar[bool] = False
    """Where equations depend, steps share multipliers among them otherwise than samples do."""
    eliminates: ClassVar[bool] = True
    """Each step solves with the factorised matrix of all bodies and joints."""
    entries: ClassVar[tuple] = (run_through,)
    parts: ClassVar[tuple] = (run_step, follow)
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
        return variables.through(samples, first, last, patience)

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
        return added_error(system, variables.beside.run[0], uncertainty(variables.beside)) if follows else None

    @staticmethod
    def kinetic(variables: _Run) -> float:
        """Return the largest kinetic energy (J) at the ends of steps."""
        return float(variables.going.run["kinetic"][0])

    @staticmethod
    def reaction_errors(system, variables: _Run) -> dict[str, float]:
        """Return by joint the error of its reaction, relative to it, on an average; none if not known, or if equations
        depend: steps share multipliers among them otherwise than samples do.
        """
        beside = variables.beside
        if system.redundant or beside.run["blind"][0] or not known(beside):
            return {}
        now, work = variables.stages.state, system.workspace()
        no_matrix(work.weights)
        evaluate(system.program, system.state(float(variables.going.run[0].t), now.q, now.u), work)
        return shares_of_reactions(system, work, beside.reactions)

    @staticmethod
    def statistics(variables: _Run) -> dict[str, Any]:
        """Return the numbers of the run."""
        return {
            **counted(variables.stages.run, COUNTED),
            "cut at contacts": int(variables.going.run[0].cut),
            "projections": int(variables.going.run[0].projections),
        }
