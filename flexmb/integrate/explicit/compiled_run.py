"""A run by the compiled explicit steps: its start, its samples, and where it hands over to SciPy's."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from flexmb.errors import CompileError
from flexmb.integrate.explicit import body_steps, closed_steps, joint_steps
from flexmb.integrate.explicit.eighth_order import MANY, UNSETTLED, ask, run_to
from flexmb.integrate.explicit.steps import STAGES, ExplicitRun, Steps
from flexmb.integrate.explicit.through import UNSURE, run_through
from flexmb.integrate.explicit.tolerances import tolerances
from flexmb.integrate.formulations import Augmented
from flexmb.integrate.motion import run_samples
from flexmb.integrate.runs.outcome import Outcome
from flexmb.integrate.runs.patience import PAUSED, Patience
from flexmb.integrate.runs.sample_rows import SampleRows
from flexmb.integrate.runs.switching import PassedOver, new_switching
from flexmb.math.direct import direct
from flexmb.math.structures import counted
from flexmb.system.accelerations import ready_for
from flexmb.system.branches import branch_rates
from flexmb.system.complaints import without_value
from flexmb.system.program import evaluate
from flexmb.tree.rigid.link_tree import no_links

__all__ = ["AUGMENTED", "CAUTIOUS", "CompiledRun"]

AUGMENTED = Augmented()
CAUTIOUS = 1e-6
"""s, first step where rates say nothing about its size."""


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
        self.handed_over = ""
        self.goal, self.begun = -np.inf, 0
        ready_for(system)
        nu, ng, span = system.nu, system.ng, max(t_end - state.t, 1e-12)
        friction = any(force.reads_reactions for force in system.model.forces)
        one = 1 if not system.redundant or closed_steps.applies(system) else 3  # stiffening follows all multipliers
        last = 12 if system.redundant else 2
        sweeps = (12, 12) if friction else (2, 12) if system.implicit else (one, last)
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
            bounds=system.drift_bounds(settings.drift),
            lengths=system.lengths.related,
            units=system.units,
            dense=closed_steps.dense_of(system, work) if closed else closed_steps.no_dense(),
            atol=tolerances(settings, motion, state, span),
            run=ExplicitRun.table(
                t=state.t,
                next_step=span,
                longest_step=settings.largest or span,
                span=span,
                rtol=settings.rtol,
                sweeps=sweeps[0],
                last_sweeps=sweeps[1],
                rates=own.rates.compiled.address,
                accepting=(body_steps if closed else own).accepting.compiled.address,
            ),
            **tables,
        )
        work.weights[0].wanted = 0
        evaluate(system.program, state, work)
        self.switching = new_switching(system, state, work, PassedOver(floor=settings.rtol * system.lengths.whole))
        self.trusted = self._found(state.t, 0)
        s.run[0].next_step = min(self._first_step(), s.run[0].longest_step)

    def _found(self, t: float, stage: int) -> bool:
        """Write the rates of steps.y1 to steps.K[stage]; return if they are numbers, and settled."""
        return bool(direct(self, ask)(self.system.program, self.work, self.tree, self.steps, t, stage))

    def _first_step(self) -> float:
        """Return the first step size, by the rates at the start and a little later (Hairer, Nørsett & Wanner, II.4)."""
        s = self.steps
        scale = s.atol + s.run[0].rtol * np.abs(s.y)

        def size(x):
            return float(np.sqrt(np.mean((x / scale) ** 2)))

        d0, d1 = size(s.y), size(s.K[0])
        h = CAUTIOUS if min(d0, d1) < 1e-5 else 0.01 * d0 / d1
        if not (h > 0.0 and np.isfinite(h)):  # rates or positions at the end of the range of numbers
            return CAUTIOUS
        s.y1[:] = s.y + h * s.K[0]
        if not self._found(s.run[0].t + h, 1):
            return h
        d2 = size(s.K[1] - s.K[0]) / h
        most = max(CAUTIOUS, 1e-3 * h) if max(d1, d2) <= 1e-15 else (0.01 / max(d1, d2)) ** 0.125
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

    def state(self):
        """Return the present state, without accelerations."""
        if self.other is not None:
            return self.other.state()
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
            state = self.state()
            try:
                self.other = self.make_other(state)
            except (CompileError, ValueError, np.linalg.LinAlgError) as error:
                why = str(error) if isinstance(error, CompileError) else "the state is not finite"
                cause = without_value(self.system, self.work, state.q, state.u)
                return f"{why} at t = {s.run[0].t:.9g} s{cause}"
            self.other.solver.y[-3:] = s.y[-3:]
            why = "compiled accelerations do not settle" if reason == UNSETTLED else "steps become too short"
            self.handed_over = f"from t = {s.run[0].t:.6g} s on, where {why}, by SciPy: some tens of times slower"
        if self.other is None:
            return ""
        return self.other.advance(t, pace)

    def _run(self, t: float, pace: Patience) -> int:
        """Let the compiled steps continue to `t`, or until the patience is used up; return 0 or why they ended."""
        s = self.steps
        if t > s.run[0].t and t != self.goal:
            self.goal, self.begun, s.run[0].short_steps = t, int(s.run[0].steps), 0
        reason, called = PAUSED, False
        while reason == PAUSED:
            most = self.settings.most_steps - (int(s.run[0].steps) - self.begun)
            parts = self.system.program, self.work, self.tree, s, self.switching
            # the call before the first of these ended at a sample
            reason, called = direct(self, run_to)(*parts, t, most, pace.steps(used=called)), True
            if pace.used_up:
                break
        return reason

    def sample(self):
        """Return t, q, u, a, lam, works."""
        if self.other is not None:
            return self.other.sample()
        state = self.state()
        # the sparse solution knows the reactions of joints of the tree as well
        own = self.motion.formulation if self.closed else AUGMENTED
        state.a[:], state.lam[:] = own.accelerate(self.system, state, self.work)
        return state.t, state.q, state.u, state.a, state.lam, self.steps.y[-3:].copy()

    def through(self, samples: np.ndarray, first: int, last: int, patience: float) -> Outcome:
        """Integrate through samples[first:last]: in one compiled loop, as far as that goes; see `Explicit.run`."""
        if self.other is not None or self.closed or not self.trusted:
            return run_samples(self, self.system, samples, first, last, patience)
        system, s = self.system, self.steps
        whole = SampleRows.of(system, last - first)
        gravity, pace = float(np.linalg.norm(system.model.gravity)), Patience(patience)
        reached, reason = first, PAUSED
        while reason == PAUSED:
            most, trials, redundant = self.settings.most_steps, pace.steps(), int(bool(system.redundant))
            reached, reason, self.goal, self.begun = direct(self, run_through)(
                system.program,
                self.motion.work,
                self.tree,
                s,
                self.switching,
                samples,
                reached,
                last,
                most,
                trials,
                self.begun,
                redundant,
                float(self.goal),
                gravity,
                whole.after(reached - first),
            )
            if pace.used_up:
                break
        rows = whole.first(reached - first)
        sound = np.all(np.isfinite(rows["a"]), axis=1)
        if not np.all(sound):
            k = int(np.argmin(sound))
            owner = system.owner(int(np.argmin(np.isfinite(rows["a"][k]))))
            failure = f"the accelerations are not finite at t = {rows['t'][k]:.9g} s near {owner}"
            return Outcome(rows={name: array[:k] for name, array in rows.items()}, failure=failure)
        if reason in (0, PAUSED):
            return Outcome(rows=rows, reached=self.reached)
        # the step that fails, or the sample whose accelerations need more care, is taken once more by itself
        others = run_samples(self, system, samples, reached, reached + 1 if reason == UNSURE else last, patience)
        joined = {name: np.concatenate([array, others.rows[name]]) for name, array in rows.items()}
        return Outcome(rows=joined, failure=others.failure, reached=others.reached)
