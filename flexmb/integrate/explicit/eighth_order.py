"""The compiled steps of the explicit method of order eight, DOP853.

Its unknowns are the coordinates of all bodies, with accelerations from the compiled factorisation; or, for rigid
bodies, the coordinates of the joints, with accelerations from the passes in link axes.

The same method as SciPy's (Hairer, Nørsett & Wanner 1993, II.10): twelve stages, error estimate of orders five and
three; its coefficients are taken from there. Between two samples no Python runs.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from flexmb.errors import CompileError
from flexmb.integrate.explicit import body_steps, closed_steps, joint_steps
from flexmb.integrate.explicit.drift import PATIENCE, VANISHING
from flexmb.integrate.explicit.steps import STAGES, STEPS, ExplicitRun, Steps, call_accepting, call_rates
from flexmb.integrate.extent import absolute_tolerance
from flexmb.integrate.formulations import Augmented
from flexmb.integrate.runs.patience import PAUSED, Patience
from flexmb.integrate.runs.switches import Switching, allowed, keep_switches, new_switching, read_switches
from flexmb.math.kernel import entry_kernel, inner_kernel, kernel
from flexmb.math.program import PROGRAM
from flexmb.math.structures import counted, numba_type
from flexmb.math.tables import COUNT, NUMBER, WORK, State
from flexmb.system.branches import branch_rates
from flexmb.system.program import evaluate
from flexmb.tree.rigid.link_tree import LINK_TREE, no_links

__all__ = ["AUGMENTED", "CompiledRun"]

AUGMENTED = Augmented()

GROWTH, DECAY, SAFETY = 10.0, 0.2, 0.9
ATOL = 1e-10
"""Usual absolute tolerance: m, rad and per second."""
CUT = 1e-11
"""Steps shorter than this part of the run are not cut at contacts."""
PASSED, PASSES = 0.8, 6
"""A step that ends in a singular position is shortened by this factor, so many times in a row."""
SHORT, MANY, UNSETTLED = 1, 2, 3


@inner_kernel
def _rates(program, work, tree, s, t, stage):
    """Write the rates of s.y1 to s.K[stage]; return if they are numbers."""
    s.run[0].evaluations += 1
    call_rates(s.run[0].rates, program, work, tree, s, t, stage)
    return s.run[0].finite == 1 and np.all(np.isfinite(s.K[stage]))


@kernel
def ask(program, work, tree, s, t, stage):
    """Write the rates of s.y1 to s.K[stage]; return if they are numbers, and settled."""
    return _rates(program, work, tree, s, t, stage) and s.run[0].settled == 1


@inner_kernel
def _error(s, h):
    """Return the error of a step relative to its tolerance, from the estimates of orders five and three."""
    n = len(s.y)
    fifth, third = 0.0, 0.0
    for i in range(n):
        scale = s.run[0].atol + s.run[0].rtol * max(abs(s.y[i]), abs(s.y1[i]))
        x, y = 0.0, 0.0
        for k in range(STAGES + 1):
            x += s.E5[k] * s.K[k, i]
            y += s.E3[k] * s.K[k, i]
        fifth += (x / scale) ** 2
        third += (y / scale) ** 2
    both = fifth + 0.01 * third
    return abs(h) * fifth / np.sqrt(both * n) if both > 0.0 else 0.0


@inner_kernel
def _try(program, work, tree, s, h):
    """Write the end of a step to y1, the rates there to the last of K; return its error, infinite if there is none."""
    t, n = s.run[0].t, len(s.y)
    for stage in range(1, STAGES + 1):
        weights = s.A[stage] if stage < STAGES else s.B
        s.y1[:] = s.y
        for k in range(stage):
            x = h * weights[k]
            if x != 0.0:
                for i in range(n):
                    s.y1[i] += x * s.K[k, i]
        at = t + (s.C[stage] * h if stage < STAGES else h)
        if not _rates(program, work, tree, s, at, stage):
            return np.inf
    return _error(s, h)


@inner_kernel
def _accept(program, work, tree, s, h):
    """Make the end of a step the start of the next, on the constraints; return if its rates are numbers and settled."""
    s.run[0].t += h
    call_accepting(s.run[0].accepting, program, work, tree, s, h)
    return s.run[0].finite == 1 and s.run[0].settled == 1 and np.all(np.isfinite(s.K[0]))


@inner_kernel
def _part(program, work, tree, s, sw, h):
    """Return the part of a step that ends where a contact begins or ends, 1.0 if none does inside."""
    if len(sw.now) == 0 or h < CUT * s.run[0].span:
        return 1.0
    read_switches(
        program, sw, State(s.run[0].t + h, tree.q if len(tree.links) > 0 else s.q, s.u, s.a, s.lam, s.signals), work
    )
    return allowed(program, sw, h, True)


@entry_kernel(PROGRAM, WORK, LINK_TREE, STEPS, numba_type(Switching), NUMBER, COUNT, COUNT)
def run_to(program, work, tree, s, sw, goal, most, pause):
    """Integrate to the time `goal` in at most so many steps; return 0 or why it ends before.

    Having tried `pause` steps it returns PAUSED after the next one that is accepted, and goes on when it is called
    again.
    """
    rejected, done, singular, tried = False, 0, 0, 0
    while goal > s.run[0].t:
        if tried >= pause and not rejected and singular == 0:
            return PAUSED
        tried += 1
        left = goal - s.run[0].t
        h = left / max(1.0, np.ceil(left / min(s.run[0].next_step, s.run[0].longest_step) * (1.0 - 1e-9)))
        s.run[0].short_steps = s.run[0].short_steps + 1 if h < VANISHING * s.run[0].span and h < left else 0
        if s.run[0].short_steps > PATIENCE or not s.run[0].t + h > s.run[0].t:
            return SHORT
        if done >= most:
            return MANY
        error = _try(program, work, tree, s, h)
        if not error <= 1.0:
            s.run[0].next_step = h * (max(DECAY, SAFETY * error**-0.125) if np.isfinite(error) else DECAY)
            rejected = True
            continue
        if s.run[0].settled == 0 and singular < PASSES:
            # singular positions are single points: a step that ends elsewhere passes them
            s.run[0].next_step = PASSED * h
            singular += 1
            continue
        part = _part(program, work, tree, s, sw, h)
        if part < 1.0:
            s.run[0].next_step = part * h
            continue
        keep_switches(sw, h)
        done, singular = done + 1, 0
        s.run[0].steps += 1
        growth = min(GROWTH, SAFETY * max(error, 1e-30) ** -0.125)
        growth = min(growth, 1.0) if rejected else growth
        # a step that only was short to end at a sample says little about longer ones
        s.run[0].next_step = max(s.run[0].next_step, h * growth) if growth >= GROWTH else h * growth
        rejected = False
        if not _accept(program, work, tree, s, h):
            return UNSETTLED
        if goal - s.run[0].t <= 1e-12 * max(abs(goal), h):
            s.run[0].t = goal
    return 0


class CompiledRun:
    """A run between samples.

    Parameters
    ----------
    settings : Explicit
    motion : Motion
        Its unknowns are the coordinates of all bodies, or of the joints of rigid links.
    other : callable (state) -> run
        Makes the run that continues where the compiled accelerations cannot (singular positions).
    """

    def __init__(self, settings, motion, state, t_end: float, other: Callable[[Any], Any]):
        from scipy.integrate import DOP853

        self.motion, system, work = motion, motion.system, motion.work
        links = motion.unknowns.links
        self.tree = no_links(system, state) if links is None else links
        closed = links is None and not settings.formulation.compiled
        own = closed_steps if closed else body_steps if links is None else joint_steps
        self.settings, self.system, self.work, self.make_other = settings, system, work, other
        self.closed = closed
        self.other: Any = None
        self.goal, self.begun = -np.inf, 0
        nu, ng, span = system.nu, system.ng, max(t_end - state.t, 1e-12)
        friction = any(force.reads_reactions for force in system.model.forces)
        sweeps = (12, 12) if friction else (2, 12) if system.implicit else (3, 12) if system.redundant else (1, 2)
        x, v, _ = motion.unknowns.of(state)
        self.nx, self.end = len(x), len(x) + len(v)
        y = np.concatenate([x, v, np.zeros(3)])
        tables = {name: np.ascontiguousarray(getattr(DOP853, name), float) for name in ("A", "B", "C", "E3", "E5")}
        self.steps = s = Steps(
            y=y,
            y1=y.copy(),
            K=np.zeros((STAGES + 1, len(y))),
            q=state.q.copy(),
            u=state.u.copy(),
            a=np.zeros(nu),
            lam=np.zeros(ng),
            right=np.zeros(nu + ng),
            rate=np.zeros(ng),
            signals=state.signals.copy(),
            pace=branch_rates(system, state, work),
            gaps=system.gaps,
            bounds=system.bounds(settings.drift),
            units=system.units,
            dense=closed_steps.dense_of(system, work) if closed else closed_steps.no_dense(),
            run=ExplicitRun.table(
                t=state.t,
                next_step=span,
                longest_step=settings.largest or span,
                span=span,
                rtol=settings.rtol,
                atol=absolute_tolerance(settings.atol, ATOL, system),
                length=system.lengths.whole,
                sweeps=sweeps[0],
                last_sweeps=sweeps[1],
                rates=own.rates.compiled.address,
                accepting=(body_steps if closed else own).accepting.compiled.address,
            ),
            **tables,
        )
        work.weights[0].wanted = 0
        evaluate(system.program, state, work)
        self.switching = new_switching(system, state, work, floor=settings.rtol * system.lengths.whole)
        self.trusted = self._found(state.t, 0)
        s.run[0].next_step = min(self._first_step(), s.run[0].longest_step)

    def _found(self, t: float, stage: int) -> bool:
        """Write the rates of steps.y1 to steps.K[stage]; return if they are numbers, and settled."""
        return bool(ask(self.system.program, self.work, self.tree, self.steps, t, stage))

    def _first_step(self) -> float:
        """Return the first step size, by the rates at the start and a little later (Hairer, Nørsett & Wanner, II.4)."""
        s = self.steps
        scale = s.run[0].atol + s.run[0].rtol * np.abs(s.y)

        def size(x):
            return float(np.sqrt(np.mean((x / scale) ** 2)))

        d0, d1 = size(s.y), size(s.K[0])
        h = 1e-6 if min(d0, d1) < 1e-5 else 0.01 * d0 / d1
        if not (h > 0.0 and np.isfinite(h)):  # rates or positions at the end of the range of numbers
            return 1e-6
        s.y1[:] = s.y + h * s.K[0]
        if not self._found(s.run[0].t + h, 1):
            return h
        d2 = size(s.K[1] - s.K[0]) / h
        most = max(1e-6, 1e-3 * h) if max(d1, d2) <= 1e-15 else (0.01 / max(d1, d2)) ** 0.125
        return float(min(100.0 * h, most))

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of steps, evaluations and projections."""
        own = counted(self.steps.run, ("steps", "evaluations", "projections"))
        return own if self.other is None else {name: n + self.other.counts[name] for name, n in own.items()}

    def _reached(self) -> tuple[float, np.ndarray, np.ndarray]:
        """Return the present time and unknowns."""
        s = self.steps
        if not len(self.tree.links):
            self.motion.unknowns.followed.reached(s.run[0].t, s.y[self.system.program.branches : self.nx])
        return float(s.run[0].t), s.y[: self.nx], s.y[self.nx : self.end]

    def _state(self):
        """Return the present state, without accelerations."""
        t, x, v = self._reached()
        return self.motion.unknowns.state(t, x.copy(), v.copy())

    def jumped(self) -> bool:
        """Write the rates after a jump of the loads to the first stage; return if there are any."""
        if self.other is not None:
            return False
        self.steps.y1[:] = self.steps.y
        self.trusted = self._found(float(self.steps.run[0].t), 0)
        return self.trusted

    def held(self, t: float, values: np.ndarray) -> bool:
        """Go on from the time t with other branches; return if rates are found."""
        if self.other is not None or len(self.tree.links):
            return False
        s, first = self.steps, self.system.program.branches
        for array in (s.y, s.q):
            array[first : first + len(values)] = values
        s.run[0].t = t
        return self.jumped()

    @property
    def reached(self) -> float:
        """Time of the present state."""
        return float(self.steps.run[0].t) if self.other is None else self.other.reached

    def advance(self, t: float, pace: Patience) -> str:
        """Integrate to `t`, or until the patience is used up; return what went wrong, or an empty text."""
        s, reason = self.steps, 0
        if self.other is None:
            reason = self._run(t, pace) if self.trusted else UNSETTLED
        if reason == PAUSED:
            return ""
        if reason == MANY:
            return (
                f"{self.settings.most_steps} steps between two samples reached only t = {s.run[0].t:.9g} s: the "
                "motion is stiff or very fast"
            )
        if reason != 0:
            # the other run finds accelerations also where the matrix is singular, or says why there are none
            try:
                self.other = self.make_other(self._state())
            except (CompileError, ValueError, np.linalg.LinAlgError) as error:
                why = str(error) if isinstance(error, CompileError) else "the state is not finite"
                return f"{why} at t = {s.run[0].t:.9g} s"
            self.other.solver.y[-3:] = s.y[-3:]
        if self.other is None:
            return ""
        return self.other.advance(t, pace)

    def _run(self, t: float, pace: Patience) -> int:
        """Let the compiled steps continue to `t`, or until the patience is used up; return 0 or why they ended."""
        s = self.steps
        if t > s.run[0].t and t != self.goal:
            self.goal, self.begun, s.run[0].short_steps = t, int(s.run[0].steps), 0
        reason = PAUSED
        while reason == PAUSED:
            most = self.settings.most_steps - (int(s.run[0].steps) - self.begun)
            reason = run_to(self.system.program, self.work, self.tree, s, self.switching, t, most, pace.steps())
            if pace.used_up:
                break
        return reason

    def sample(self):
        """Return t, q, u, a, lam, works."""
        if self.other is not None:
            return self.other.sample()
        state = self._state()
        # the sparse solution knows the reactions of joints of the tree as well
        own = self.motion.formulation if self.closed else AUGMENTED
        state.a[:], state.lam[:] = own.accelerate(self.system, state, self.work)
        return state.t, state.q, state.u, state.a, state.lam, self.steps.y[-3:].copy()
