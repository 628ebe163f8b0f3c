"""The compiled steps of the explicit method of order eight, DOP853.

Its unknowns are the coordinates of all bodies, with accelerations from the compiled factorisation; or, for rigid bodies,
those of the joints, with accelerations from the passes in link axes.

The same method as SciPy's (Hairer, Nørsett & Wanner 1993, II.10): twelve stages, error estimate of orders five and three;
its coefficients are taken from there. Between two samples no Python runs.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable
from typing import Any

import numpy as np

from flexmb.errors import CompileError
from flexmb.integrate.extent import model_size
from flexmb.integrate.formulations import Augmented
from flexmb.integrate.stabilised import kinematics
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.tables import State
from flexmb.system.branches import branch_rates
from flexmb.system.program import accelerations, constraint_velocity, keep_branches, project
from flexmb.tree.link_motion import close_links, link_rates, loops_are_open
from flexmb.tree.settle import coordinate_rates, unit_length

__all__ = ["AUGMENTED", "CompiledRun"]

AUGMENTED = Augmented()

STAGES = 12
GROWTH, DECAY, SAFETY = 10.0, 0.2, 0.9
SETTLED = 1e-10
"""Last correction of accelerations or multipliers, relative, above which the factorisation is not trusted."""
VANISHING, PATIENCE = 1e-9, 30
"""So many steps in a row that are shorter than this part of the run: the method has come to a singular configuration."""
PASSED, PASSES = 0.8, 6
"""A step that ends in a singular position is shortened by this factor, so many times in a row."""
SHORT, MANY, UNSETTLED = 1, 2, 3

Steps = namedtuple("Steps", "y y1 K q u a lam right rate signals pace gaps counts times limits sweeps A B C E3 E5")
"""Storage of the steps.

y, y1 (n,) : coordinates (of bodies with branches), velocities and works, at the start and the end of a step; K (13, n): rates
of stages
q, u, a, lam, right, rate, signals : the state of a stage; scratch
pace (nb,) : rate of the branches over the last step; gaps (ng,): see `project`
counts (3,) : steps, evaluations, projections; times (4,): t, next step, longest step, length of the run
limits (4,) : rtol, atol, residual of the positions and, relative, of the velocities at which the state is projected
sweeps (2,) : of the accelerations in a stage, and at the end of a step, where their convergence is looked at
"""


@kernel
def _rates(program, work, tree, s, y, t, out, sweeps):
    """Write the rates of `y` to `out`; return if they are numbers. `tree` has the links, in joint coordinates, or is None."""
    s.counts[1] += 1
    if tree is None:
        found = _body_rates(program, work, s, y, t, out, sweeps)
    else:
        found = _joint_rates(work, tree, y, t, out)
    return found and np.all(np.isfinite(out))


@inner_kernel
def _joint_rates(work, tree, y, t, out):
    """The same for joint coordinates: drives have their rates, whatever y says."""
    nx, nv = len(tree.x), len(tree.v)
    found = link_rates(tree, work, t, y[:nx], y[nx : nx + nv]) < 0
    coordinate_rates(tree.chart.rows, tree.x, tree.v, out)
    out[nx : nx + nv] = tree.a
    out[nx + nv :] = tree.powers
    return found


@inner_kernel
def _body_rates(program, work, s, y, t, out, sweeps):
    """The same for the coordinates of all bodies."""
    nq, nu = len(s.q), len(s.u)
    for i in range(nq):
        s.q[i] = y[i]
    for n in range(len(program.frames)):
        p = s.q[program.frames[n, 0] + 3 : program.frames[n, 0] + 7]
        length = (p[0] ** 2 + p[1] ** 2 + p[2] ** 2 + p[3] ** 2) ** 0.5
        for i in range(4):
            p[i] /= length
    for i in range(nu):
        s.u[i] = y[nq + i]
    failed = accelerations(program, State(t, s.q, s.u, s.a, s.lam, s.signals), work, s.right, sweeps)
    kinematics(program, 0.0, y, s.u, out)
    for k in range(len(s.pace)):
        out[program.branches + k] = s.pace[k]
    for i in range(nu):
        out[nq + i] = s.a[i]
    for i in range(3):
        out[nq + nu + i] = work.energy[3 + i]
    out[nq + nu + 1] = 0.0  # of the drives: with the multipliers found last
    for i in range(len(s.lam)):
        out[nq + nu + 1] -= s.lam[i] * work.equations[i].rate
    return failed < 0


@kernel
def _settled(s):
    """Was the last correction of accelerations and multipliers small?"""
    largest, change, force, correction = 1.0, 0.0, 1.0, 0.0
    nu = len(s.u)
    for i in range(nu):
        largest, change = max(largest, abs(s.a[i])), max(change, abs(s.right[i]))
    for i in range(len(s.lam)):
        force, correction = max(force, abs(s.lam[i])), max(correction, abs(s.right[nu + i]))
    return change <= SETTLED * largest and correction <= SETTLED * force


@inner_kernel
def _error(s, h):
    """Return the error of a step relative to its tolerance, from the estimates of orders five and three."""
    n = len(s.y)
    fifth, third = 0.0, 0.0
    for i in range(n):
        scale = s.limits[1] + s.limits[0] * max(abs(s.y[i]), abs(s.y1[i]))
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
    t, n = s.times[0], len(s.y)
    for stage in range(1, STAGES + 1):
        weights = s.A[stage] if stage < STAGES else s.B
        s.y1[:] = s.y
        for k in range(stage):
            x = h * weights[k]
            if x != 0.0:
                for i in range(n):
                    s.y1[i] += x * s.K[k, i]
        at = t + (s.C[stage] * h if stage < STAGES else h)
        if not _rates(program, work, tree, s, s.y1, at, s.K[stage], s.sweeps[1 if stage == STAGES else 0]):
            return np.inf
    return _error(s, h)


@inner_kernel
def _drifted(work, s):
    """Has the state evaluated last left the constraints, at the level of position or of velocity?"""
    constraint_velocity(work, s.u, s.rate)
    fastest, open_by, speed = 1.0, 0.0, 0.0
    for m in range(len(work.markers)):
        for i in range(3):
            fastest = max(fastest, abs(work.markers[m].v[i]), abs(work.markers[m].w[i]))
    for n in range(len(s.lam)):
        open_by, speed = max(open_by, abs(work.equations[n].g)), max(speed, abs(s.rate[n]))
    return open_by > s.limits[2] or speed > s.limits[3] * fastest


@inner_kernel
def _accept(program, work, tree, s, h):
    """Make the end of a step the start of the next, on the constraints; return if its rates are numbers and settled."""
    s.times[0] += h
    s.y[:] = s.y1
    s.K[0] = s.K[STAGES]
    if tree is None:
        return _accept_bodies(program, work, s, h)
    return _accept_joints(program, work, tree, s, h)


@inner_kernel
def _accept_bodies(program, work, s, h):
    """The same for the coordinates of all bodies."""
    nq = len(s.q)
    for k in range(len(s.pace)):
        s.pace[k] = (work.branches[k] - s.y[program.branches + k]) / h
        s.K[0, program.branches + k] = s.pace[k]  # the same through all stages: branches have no error
    keep_branches(program, work, s.y)
    settled = _settled(s)
    if len(s.lam) == 0 or not _drifted(work, s):
        return settled
    s.counts[2] += 1
    keep_branches(program, work, s.q)
    state = State(s.times[0], s.q, s.u, s.a, s.lam, s.signals)
    project(program, state, work, s.right, s.q, 0.01 * s.limits[2], s.gaps, 10)
    s.y[:nq] = s.q
    s.y[nq : nq + len(s.u)] = s.u
    return _rates(program, work, None, s, s.y, s.times[0], s.K[0], s.sweeps[1]) and _settled(s)


@inner_kernel
def _accept_joints(program, work, tree, s, h):
    """The same for joint coordinates: only loops can have come open."""
    chart, nx = tree.chart, len(tree.x)
    for k in range(len(chart.branches)):
        chart.pace[k] = (work.branches[k] - chart.branches[k]) / h
        chart.branches[k] = work.branches[k]
    chart.clock[0] = s.times[0]
    if len(tree.closing.equations) == 0 or not loops_are_open(tree, work, s.limits[2], s.limits[3]):
        return True
    s.counts[2] += 1
    if not close_links(tree, work, s.times[0], 0.01 * s.limits[2], s.gaps, program.equation_level):
        return False
    s.y[:nx], s.y[nx : nx + len(tree.v)] = tree.x, tree.v
    unit_length(chart.rows, s.y)
    return _rates(program, work, tree, s, s.y, s.times[0], s.K[0], 0)


@kernel
def _run(program, work, tree, s, goal, most):
    """Integrate to the time `goal` in at most so many steps; return 0 or why it ends before."""
    short, rejected, done, singular = 0, False, 0, 0
    while goal > s.times[0]:
        left = goal - s.times[0]
        h = left / max(1.0, np.ceil(left / min(s.times[1], s.times[2]) * (1.0 - 1e-9)))
        short = short + 1 if h < VANISHING * s.times[3] and h < left else 0
        if short > PATIENCE or not s.times[0] + h > s.times[0]:
            return SHORT
        if done >= most:
            return MANY
        error = _try(program, work, tree, s, h)
        if not error <= 1.0:
            s.times[1] = h * (max(DECAY, SAFETY * error**-0.125) if np.isfinite(error) else DECAY)
            rejected = True
            continue
        if tree is None and not _settled(s) and singular < PASSES:
            # singular positions are single points: a step that ends elsewhere passes them
            s.times[1] = PASSED * h
            singular += 1
            continue
        done, singular = done + 1, 0
        s.counts[0] += 1
        growth = min(GROWTH, SAFETY * max(error, 1e-30) ** -0.125)
        growth = min(growth, 1.0) if rejected else growth
        # a step that only was short to end at a sample says little about longer ones
        s.times[1] = max(s.times[1], h * growth) if growth >= GROWTH else h * growth
        rejected = False
        if not _accept(program, work, tree, s, h):
            return UNSETTLED
        if goal - s.times[0] <= 1e-12 * max(abs(goal), h):
            s.times[0] = goal
    return 0


class CompiledRun:
    """A run between samples.

    Parameters
    ----------
    settings : Explicit
    motion : Motion
        With the coordinates of all bodies as unknowns, or with those of the joints of rigid links.
    other : callable (state) -> run
        Makes the run that goes on where the compiled accelerations cannot (singular positions).
    """

    def __init__(self, settings, motion, state, t_end: float, other: Callable[[Any], Any]):
        from scipy.integrate import DOP853

        self.motion, system, work = motion, motion.system, motion.work
        self.tree = getattr(motion.unknowns, "links", None)
        self.settings, self.system, self.work, self.make_other = settings, system, work, other
        self.other: Any = None
        nu, ng, span = system.nu, system.ng, max(t_end - state.t, 1e-12)
        friction = any(force.reads_reactions for force in system.model.forces)
        sweeps = (12, 12) if friction else (3, 12) if system.redundant else (1, 2)
        x, v, _ = motion.unknowns.of(state)
        self.nx, self.end = len(x), len(x) + len(v)
        y = np.concatenate([x, v, np.zeros(3)])
        limits = (settings.rtol, settings.atol, settings.drift * model_size(system), settings.drift)
        tables = {name: np.ascontiguousarray(getattr(DOP853, name), float) for name in ("A", "B", "C", "E3", "E5")}
        self.steps = s = Steps(
            y=y, y1=y.copy(), K=np.zeros((STAGES + 1, len(y))), q=state.q.copy(), u=state.u.copy(), a=np.zeros(nu),
            lam=np.zeros(ng), right=np.zeros(nu + ng), rate=np.zeros(ng), signals=state.signals.copy(),
            pace=branch_rates(system, state, work), gaps=system.gaps, counts=np.zeros(3, np.int64),
            times=np.array([state.t, span, settings.largest or span, span]), limits=np.array(limits),
            sweeps=np.array(sweeps, np.int64), **tables)
        self.trusted = self._found(s.y, state.t, s.K[0], 1) and _settled(s)
        s.times[1] = min(self._first_step(), s.times[2])

    def _found(self, y: np.ndarray, t: float, out: np.ndarray, last: int) -> bool:
        """Write the rates of y to `out`; return if they are numbers. `last`: 1 at the end of a step."""
        s = self.steps
        return bool(_rates(self.system.program, self.work, self.tree, s, y, t, out, int(s.sweeps[last])))

    def _first_step(self) -> float:
        """Return the first step size, by the rates at the start and a little later (Hairer, Nørsett & Wanner, II.4)."""
        s = self.steps
        scale = self.settings.atol + self.settings.rtol * np.abs(s.y)

        def size(x):
            return float(np.sqrt(np.mean((x / scale) ** 2)))

        d0, d1 = size(s.y), size(s.K[0])
        h = 1e-6 if min(d0, d1) < 1e-5 else 0.01 * d0 / d1
        s.y1[:] = s.y + h * s.K[0]
        if not self._found(s.y1, s.times[0] + h, s.K[1], 0):
            return h
        d2 = size(s.K[1] - s.K[0]) / h
        most = max(1e-6, 1e-3 * h) if max(d1, d2) <= 1e-15 else (0.01 / max(d1, d2)) ** 0.125
        return float(min(100.0 * h, most))

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of steps, evaluations and projections."""
        own = dict(zip(("steps", "evaluations", "projections"), map(int, self.steps.counts), strict=True))
        return own if self.other is None else {name: n + self.other.counts[name] for name, n in own.items()}

    def _reached(self) -> tuple[float, np.ndarray, np.ndarray]:
        """Return the present time and unknowns."""
        s = self.steps
        if self.tree is None:
            self.motion.unknowns.followed.reached(s.times[0], s.y[self.system.program.branches : self.nx])
        return float(s.times[0]), s.y[: self.nx], s.y[self.nx : self.end]

    def _state(self):
        """Return the present state, without accelerations."""
        t, x, v = self._reached()
        return self.motion.unknowns.state(t, x.copy(), v.copy())

    def advance(self, t: float) -> str:
        """Integrate to `t`; return what went wrong, or an empty text."""
        s, reason = self.steps, 0
        if self.other is None:
            reason = _run(self.system.program, self.work, self.tree, s, t, self.settings.most_steps) if self.trusted else UNSETTLED
        if reason == MANY:
            return (f"{self.settings.most_steps} steps between two samples reached only t = {s.times[0]:.9g} s: the "
                    "motion is stiff or very fast")
        if reason != 0:
            # the other run finds accelerations also where the matrix is singular, or says why there are none
            try:
                self.other = self.make_other(self._state())
            except (CompileError, ValueError, np.linalg.LinAlgError) as error:
                why = str(error) if isinstance(error, CompileError) else "the state is not finite"
                return f"{why} at t = {s.times[0]:.9g} s"
            self.other.solver.y[-3:] = s.y[-3:]
        if self.other is None:
            return ""
        return self.other.advance(t)

    def sample(self):
        """Return t, q, u, a, lam, works."""
        if self.other is not None:
            return self.other.sample()
        state = self._state()
        # the sparse solution knows the reactions of joints of the tree as well
        state.a[:], state.lam[:] = AUGMENTED.accelerate(self.system, state, self.work)
        return state.t, state.q, state.u, state.a, state.lam, self.steps.y[-3:].copy()
