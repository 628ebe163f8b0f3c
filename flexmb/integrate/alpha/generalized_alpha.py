"""`GeneralizedAlpha`: implicit, second order, with numerical damping of high frequencies and error control."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar
from weakref import WeakKeyDictionary

import numpy as np

from flexmb.errors import ModelError
from flexmb.integrate.alpha.added_errors import beside, known, taken_over
from flexmb.integrate.alpha.jump import take_jump
from flexmb.integrate.alpha.large_kernels import LARGE_KERNELS
from flexmb.integrate.alpha.newmark import run_steps
from flexmb.integrate.alpha.powers import SELDOM
from flexmb.integrate.alpha.reasons import reason_of
from flexmb.integrate.alpha.start_rates import acceleration_rate, constrained_part
from flexmb.integrate.alpha.variables import COUNTED, AlphaRun, Controls, Motions, Variables
from flexmb.integrate.alpha.world_translation import frames_in_world_axes, to_body_axes, to_world_axes, turn
from flexmb.integrate.extent import extents, reaches
from flexmb.integrate.runs.added_error import AddedError
from flexmb.integrate.runs.gap import added_error
from flexmb.integrate.runs.memory import floats_of
from flexmb.integrate.runs.outcome import Outcome
from flexmb.integrate.runs.patience import PAUSED, Patience, smallest_step
from flexmb.integrate.runs.reaction_errors import shares_of_reactions
from flexmb.integrate.runs.sample_rows import SampleRows
from flexmb.integrate.runs.spin_axes import new_axes
from flexmb.integrate.runs.switches import part_of_step
from flexmb.integrate.runs.switching import PassedOver, new_switching
from flexmb.integrate.settled import settle_rows
from flexmb.math.direct import direct
from flexmb.math.energies import powers
from flexmb.math.structures import counted
from flexmb.math.weights import no_matrix
from flexmb.model.described import Described, is_number
from flexmb.system.accelerations import is_solved
from flexmb.system.branches import branch_rates
from flexmb.system.program import constraint_velocity, evaluate

__all__ = ["GeneralizedAlpha"]

SLOW = 0.01
"""Per simulated time: rates below this say nothing about the first step."""
TURN = 2e-3
"""rad: largest local error of a rotation. To a small link of a long chain a coarse tolerance for positions, relative to
the whole, would allow turns that give it more energy than it has; the steps that follow such a motion are the shortest
of all. In 192 runs of chains of 10 to 100 links 0.005 let three gain energy, 0.003 none."""

CUT = "cut at contacts"
AXES = 6.0
"""Times the square of the cube root of the tolerance: the part of the motion of a spinning body's axis that local
errors may be. What they add up to is some ten times that."""
IMPACT, SLIP = 3.0, 0.5
"""Change of the speed of an impact in a step, relative to it and to the cube root of the tolerance: the error of the
rebound is of second order. Change of a slip, relative to it: friction that is about to stick, or to break
away, has several solutions in a long step."""

SCRATCH = (
    *("d", "right", "dx", "q1", "u1", "a1", "lam1", "alg1", "signals", "now", "then"),
    *("works", "ended", "worst_steps", "worst_span", "worst_change"),
)
"""Of the variables: what every step writes anew, or follows from the state; and works and counts of contacts that have
ended, which samples and statistics hold already."""
_CONTROLS: WeakKeyDictionary[Any, tuple[Any, Controls]] = WeakKeyDictionary()


@dataclass(frozen=True, kw_only=True)
class GeneralizedAlpha(metaclass=Described):
    """Lie-group generalized-alpha method on the index-3 equations.

    Bodies that joints hold to the ground are integrated in their own axes, in which a rotor is exact at any step; all
    others, which fly or roll, translate in world axes, whatever their spin.

    Parameters
    ----------
    rho_inf : float, -
        Spectral radius at infinite frequency, 0 to 1: 0 removes the highest frequencies in a step, 1 keeps all energy.
        With joints it must stay below 1, or the multipliers grow without bound (Cardona & Géradin 1989).
    step : float, s, optional
        Fixed step size; without it the step follows the error.
    rtol : float, -
        Local error of a step, relative to the assembly's length (positions; rotations as displacements at the body's
        radius of gyration, at least a thousandth of that size, and never more than 0.002 rad), and to the largest
        deflection (flexible coordinates).
    atol : float, m
        Displacement below which errors of flexible coordinates do not matter; default 1e-4 of that length.
    largest : float, s, optional
        Largest step size; default a twentieth of the simulated time.
    follow_errors : bool
        Whether the run tells what the errors of its steps add up to. A second motion without them runs beside, which
        takes a sixth to two fifths more time, of fixed steps more; leave it out where time counts, as in a loop with
        hardware.

    Source: Arnold & Brüls 2007, eqs. 4-9; Brüls, Cardona & Arnold 2012, section 4.
    """

    rho_inf: float = 0.8
    step: float | None = None
    rtol: float = 1e-6
    atol: float | None = None
    largest: float | None = None
    follow_errors: bool = True
    entries: ClassVar[tuple] = (run_steps,)
    """Kernels that a run will call: compiled meanwhile by other processes when they are missing."""
    parts: ClassVar[tuple] = LARGE_KERNELS
    """Large kernels that those call; processes share them."""
    in_kernels: ClassVar[bool] = True
    """No Python runs between samples."""
    eliminates: ClassVar[bool] = True
    """Each step solves with the factorised matrix of all bodies and joints."""
    steps_in_contact: ClassVar[float] = 8.0
    """Within a contact, for 1 % of the change of speed, wherever in a step it begins: mass on a linear spring."""
    remembers: ClassVar[bool] = True
    """Algorithmic accelerations carry the rate of the last step: a kink of a load ends what they know."""

    def __post_init__(self):
        part = "GeneralizedAlpha"
        if not (is_number(self.rho_inf) and 0.0 <= self.rho_inf <= 1.0):
            raise ModelError(
                part,
                found=f"rho_inf = {self.rho_inf!r}",
                expected="0 <= rho_inf <= 1",
                remedy="Use 0.8 for flexible mechanisms, 0.95 for little damping",
            )
        for name in ("step", "rtol", "atol", "largest"):
            value = getattr(self, name)
            if value is not None and not (is_number(value) and value > 0.0):
                raise ModelError(
                    part,
                    found=f"{name} = {value!r}",
                    expected="a positive number",
                    remedy=f"Leave {name} out for its default",
                )

    def controls(self) -> Controls:
        """Return the parameters of the compiled step."""
        rho = self.rho_inf
        alpha_m = (2.0 * rho - 1.0) / (rho + 1.0)
        alpha_f = rho / (rho + 1.0)
        gamma = 0.5 + alpha_f - alpha_m
        beta = 0.25 * (0.5 + gamma) ** 2
        # a fixed step is chosen for its own accuracy: there the iteration must not be seen at all
        newton = 0.02 if self.step is None else 1e-4
        # the error of accelerations and multipliers is of the order h^2, that is rtol^(2/3)
        settled = 0.1 * self.rtol ** (2.0 / 3.0) if self.step is None else 1e-8
        return Controls(
            alpha_m=alpha_m,
            alpha_f=alpha_f,
            beta=beta,
            gamma=gamma,
            tolerance=float(self.rtol),  # kernels know it as a float
            of_axes=AXES * self.rtol ** (2.0 / 3.0),
            newton=newton,
            settled=settled,
            adaptive=self.step is None,
            smallest=0.0,
            iterations=12,
            sweeps=0,
            friction=False,
            trend=1.0,
        )

    def _controls_of(self, system) -> Controls:
        """Return the parameters for a system; they are kept, as runs from outside ask for them in every step."""
        known = _CONTROLS.get(system)
        if known is None or known[0] is not self:
            controls = self.controls()._replace(
                sweeps=0 if system.ng == 0 else 12 if system.redundant else 2,
                friction=system.implicit or any(f.reads_reactions for f in system.model.forces),
                trend=0.0 if system.redundant else 1.0,
            )
            known = _CONTROLS[system] = self, controls
        return known[1]

    def start(self, system, state, work, t_end: float) -> Motions:
        """Return the integration variables at the start: consistent accelerations, first step size."""
        nu, ng, nq = system.nu, system.ng, system.nq
        if ng and self.rho_inf > 0.99:
            raise ModelError(
                "GeneralizedAlpha",
                found=f"rho_inf = {self.rho_inf:g} in a model with joints",
                expected="rho_inf <= 0.99, or the multipliers grow without bound",
                remedy="Use 0.95 for little damping, 0.8 for flexible mechanisms",
            )
        extent, reach = self._extents(system, state, work)
        span = max(t_end - state.t, 1e-300)
        largest = self.largest or span / 20.0
        world = frames_in_world_axes(system)
        first = self.step or min(largest, self._first_step(system, state, work, extent, reach, world, SLOW / span))
        u, a = state.u.copy(), state.a.copy()
        to_world_axes(world, state.q, u, a)
        work.weights[0].wanted = 0
        evaluate(system.program, state, work)
        # across a jump shorter steps would tell nothing but rounding of the accelerations before
        rounding = max(1e-13 * system.lengths.whole, system.lengths.rounding)
        switching = self._switching(system, state, work, span, rounding)
        at_start = powers(work.energy)
        variables = Variables(
            q=state.q.copy(),
            u=u,
            a=a,
            lam=state.lam.copy(),
            alg=a.copy(),
            q1=np.zeros(nq),
            u1=np.zeros(nu),
            a1=np.zeros(nu),
            lam1=np.zeros(ng),
            alg1=np.zeros(nu),
            dx=np.zeros(nu),
            d=np.zeros(nu),
            right=np.zeros(nu + ng),
            a_last=a.copy(),
            lam_last=state.lam.copy(),
            hidden=np.zeros(ng),
            slope=np.zeros(nu),
            curve=np.zeros(ng),
            change=np.zeros(nu),
            extent=extent,
            reach=reach,
            works=np.zeros(3),
            powers=at_start,
            powers_last=np.zeros(3),
            lacking=np.zeros(3),
            signals=state.signals.copy(),
            run=AlphaRun.table(
                t=state.t,
                next_step=first,
                longest_step=self.step or largest,
                span=span,
                first_state=nu - int(np.sum(system.is_state)),
                since_look=SELDOM,
                convergence=0.05,
                rounding=rounding,
            ),
            pace=branch_rates(system, state, work),
            world=world,
            body_u=state.u.copy(),
            body_a=state.a.copy(),
            switching=switching,
            axes=new_axes(system.program),
        )
        self._fit_start(system, state, work, variables, first)
        return beside(system, variables, self.follow_errors)

    def _extents(self, system, state, work) -> tuple[np.ndarray, np.ndarray]:
        """Return (extent, reach) (nu,): with them a displacement is measured, and its error compared."""
        extent, reach = extents(system, state, work, self.atol)
        reach = reaches(system, reach, self.rtol)
        if self.step is None:
            turns = system.program.frames[:, 1:] + np.arange(3, 6)
            extent[turns] = np.maximum(extent[turns], self.rtol * reach[turns] / TURN)
        return extent, reach

    def _switching(self, system, state, work, span: float, rounding: float):
        """Return the contacts and slips whose changes end a step, and what of them is passed over."""
        share = IMPACT * self.rtol ** (1.0 / 3.0)
        floor = self.rtol * system.lengths.whole
        over = PassedOver(floor=floor, impact=share, slip=SLIP, blur=1.0, duration=span, rounding=rounding)
        switching = new_switching(system, state, work, over, fixed=self.step is not None)
        if len(switching.now):
            part_of_step.ready()
        return switching

    def _first_step(self, system, state, work, extent, reach, world, slow: float) -> float:
        """Return a step size well below that whose error is the tolerance, from speed, acceleration and its rate."""
        scale, states = self.rtol ** (1.0 / 3.0), system.is_state
        pace = np.max(np.abs(state.a[states]) / np.maximum(reach[states], np.abs(state.u[states])), initial=slow)
        extent = np.where(states, 0.0, extent)
        u, a = state.u.copy(), state.a.copy()
        to_world_axes(world, state.q, u, a)
        a = np.max(np.abs(a) * extent / reach, initial=0.0)
        u = np.max(np.abs(u) * extent / reach, initial=0.0)
        h = 0.1 * scale / max(np.sqrt(a), u, pace)
        # from rest to a gentle start neither says anything yet; rates over the step found last tell when it is too long
        for _ in range(8):
            rate = np.max(np.abs(acceleration_rate(system, state, work, h, world)) * extent / reach, initial=0.0)
            allowed = 0.5 * scale / max(rate ** (1.0 / 3.0), slow)
            if h <= allowed:
                break
            h = max(0.1 * h, 0.5 * allowed)
        return h

    def _fit_start(self, system, state, work, v: Variables, h: float) -> None:
        """Give algorithmic acceleration and velocities the values of a motion that has been going on with steps h.

        The algorithmic acceleration belongs to the time t + (alpha_m - alpha_f) h. The constraints hold for positions,
        which err by C h^3 a' a step, so the velocities that they determine are off by C h^2 a'. Started from the exact
        values, the multipliers carry an error of order h through the first steps (Arnold, Brüls & Cardona 2015).
        """
        c = self.controls()
        v.run[0].last_step = v.run[0].size = h
        v.extent[system.is_state] = c.gamma / (c.beta * h)
        rate, later = (acceleration_rate(system, state, work, probe, v.world) for probe in (1e-3 * h, h))
        difference = np.max(np.abs(later - rate) * v.extent, initial=0.0)
        # rates that differ over a step belong to frequencies which the step cannot resolve: those are better damped
        if not difference <= 0.5 * np.max(np.abs(rate) * v.extent, initial=0.0):
            return
        v.slope[:] = (c.alpha_m - c.alpha_f) * rate
        v.alg[:] += h * v.slope
        constant = c.beta + 0.5 * (c.alpha_m - c.alpha_f) - 1.0 / 6.0
        rest, scratch, body_rate = np.zeros((3, system.nu))
        to_body_axes(v.world, state.q, rest, rate, scratch, body_rate)
        v.change[:] = constrained_part(system, state, work, -constant * h * h * body_rate)
        constraint_velocity(work, state.u + v.change, v.hidden)
        v.curve[:] = v.hidden / max(h * h, np.finfo(float).tiny)
        turn(v.world, state.q, v.change)
        v.u[:] += v.change

    def run(
        self, system, work, variables: Motions, samples: np.ndarray, first: int, last: int, patience: float = np.inf
    ) -> Outcome:
        """Integrate through samples[first:last] and return the rows and why it ended; after `patience` seconds those
        so far, to be called again from the next."""
        now, whole = variables.own.run["t"], SampleRows.of(system, last - first)
        smallest = smallest_step(float(now[0]), float(samples[last - 1]))
        controls = self._controls_of(system)._replace(smallest=smallest)
        run_on, (reached, reason), pace = direct(system, run_steps), (first, PAUSED), Patience(patience)
        while reason == PAUSED:
            rest, trials = whole.after(reached - first), pace.steps()
            reached, reason = run_on(system.program, work, variables, controls, samples, reached, last, trials, rest)
            if pace.used_up:
                break
        rows = whole.first(reached - first)
        if system.implicit:
            settle_rows(system, work, rows)
        at = float(now[0])
        if reason in (0, PAUSED):
            return Outcome(rows=rows, reached=at)
        outcome = Outcome(rows=rows, failure=reason_of(system, work, variables.own, reason), reached=at)
        shorter = f"Look at the last samples; give a shorter step than {self.step} s, or none: rtol then chooses it"
        return outcome if self.step is None else replace(outcome, remedy=shorter)

    @staticmethod
    def memory(variables: Motions) -> list[np.ndarray]:
        """Return the arrays that make steps after a state the same ones; what is written to them is gone on with."""
        return list(floats_of(variables, SCRATCH))

    def jumped(self, system, work, variables: Motions) -> bool:
        """Go on with accelerations that loads make after a jump, at the present time; return if there are any."""
        found = direct(system, take_jump)(system.program, work, variables, 12 if system.redundant else 2) < 0
        if not found or not system.implicit:
            return found
        v = variables.own
        now = system.state(float(v.run["t"][0]), v.q, v.body_u)._replace(a=v.body_a, lam=v.lam)
        return is_solved(system, now, v.right, work)

    def held(self, system, work, variables: Motions, t: float, q: np.ndarray) -> bool:
        """Go on from the time t with values that blocks hold from then on, the last of q (nq,); return if it can."""
        first = system.program.branches
        for motion in (variables.own, variables.corrected):
            motion.q[first:] = q[first:]
        variables.own.run["t"][0] = t
        return self.jumped(system, work, variables)

    def taken_over(self, system, before: Motions, variables: Motions) -> Motions:
        """Return the variables of a new start with what the errors of the steps before have added up to."""
        return taken_over(system, before, variables, self._controls_of(system))

    def added_error(self, system, variables: Motions) -> AddedError | None:
        """Return what the errors of the steps have added up to so far; None if they are not followed, or not known."""
        if not self.follow_errors or not known(variables):
            return None
        return added_error(system, variables.apart.run[0])

    def reaction_errors(self, system, variables: Motions) -> dict[str, float]:
        """Return by joint the error of its reaction, relative to it, on an average; none if not known."""
        own, gap = variables.own, variables.apart.run[0]
        if not self.follow_errors or gap["blind"]:
            return {}
        state, work = system.state(float(own.run["t"][0]), own.q, own.u), system.workspace()
        no_matrix(work.weights)
        evaluate(system.program, state, work)
        return shares_of_reactions(system, work, variables.apart.reactions)

    @staticmethod
    def statistics(variables: Motions) -> dict[str, Any]:
        """Return the numbers of the run."""
        return counted(variables.own.run, COUNTED)
