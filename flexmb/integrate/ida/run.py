"""What a run of `IDA` keeps: the solver of SUNDIALS, its residual and Jacobian, and where it stops."""

from __future__ import annotations

import warnings
from typing import Any
from weakref import proxy

import numpy as np

from flexmb.integrate.extent import SLOW, absolute_tolerance, extents
from flexmb.integrate.ida.drive_work import WorkOfDrives
from flexmb.integrate.ida.layout import layout
from flexmb.integrate.ida.solver_output import OUTPUT
from flexmb.integrate.ida.stabilised import FAR, jacobian, kinematics, residual
from flexmb.integrate.matrices import equations_at
from flexmb.integrate.runs.breaks import just_before
from flexmb.integrate.runs.kept_switches import JUMPED, keep_switches
from flexmb.integrate.runs.patience import Patience
from flexmb.integrate.runs.switches import allowed
from flexmb.integrate.runs.switching import PassedOver, new_switching, read_switches
from flexmb.integrate.settled import settle
from flexmb.math.direct import direct
from flexmb.math.energies import powers
from flexmb.math.plain_loops import all_finite
from flexmb.math.switches import CROSSING, DISTANCE, GAP, KINK, PIECE, TURN_GAP
from flexmb.system.accelerations import accelerations, is_solved
from flexmb.system.complaints import without_value, worst_equations
from flexmb.system.mobility import equation_scale
from flexmb.system.program import evaluate

__all__ = ["Run"]

DENSE = 300
"""Up to this number of unknowns a dense factorisation is faster than the sparse one."""
ATOL = 1e-8
"""Usual absolute tolerance: m, rad and per second."""
YIELDING = 1e-11
"""Compliance of the constraints where equations depend on each other, s, relative to G M^-1 G^T."""
CARRIES = 1e-3
"""That of equations which depend on no others, relative to it for the heaviest body. They carry the loads, and what
yields under a load is a damper: beside links of a millionth of a slider's mass it took 19 % of the energy in a dead
centre. Equations that depend on others keep the multiplier of the start, and do no work."""

OPEN = 1e-3
"""The same of the positions, s, where dependent equations contradict each other (see `flexmb.check`: misfits)."""
COUNTED = 0.01
"""Absolute tolerance of turns (rad) and places on curves: they only say which solution is meant, but one that is left
out of the iteration's test would be lost by extrapolation."""

FARTHER, LEAST = 10.0, 1e-7
"""Distance from the origin, in lengths of the model, from which tolerances are closer, and by how much at the most."""
SHORTEST = 1e-15
"""Of the run: no step is shorter. Near a dead centre time would stand still for all steps that are allowed."""
RESOLVED = 1e-9
"""Of the run: times at which the equations of motion end are known to within this part."""
LONGEST = 1e300
"""s: no limit, for a solver that wants a number."""
FRICTION = 1e-3
"""Tolerances of velocities, m/s and relative to 1 m/s, as a part of the slip within which friction turns: errors of a
velocity that is large decide otherwise whether a body sticks."""


TOUCHING = 0.1
"""Tolerance where something may touch, as a part of the given one. Steps begin anew, at order one, at every begin of a
contact, and what they lose there adds up: 1e-5 of the speed at each bounce of an undamped stop, which in thirty bounces
are 1.3 % of the way to and fro, and 0.17 % so."""


class _NotFinite(ArithmeticError):
    """The residual is not a number: IDA itself would continue silently."""


class Run:
    """What a run of IDA keeps between samples: the solver and the storage of its callbacks."""

    def __init__(self, settings: Any, system, state, work, t_end: float):
        self.system, self.work = system, work
        self.extent, _ = extents(system, state, work)
        # the attraction to unit length only has to beat the drift over the whole run
        self.form = layout(system, self.extent, 20.0 / max(t_end - state.t, 1e-300), self._yielding(state))
        if not system.misfits:  # what contradicts itself has multipliers because it yields
            self.form.usual[:] = state.lam
        self.y, self.yp = self._start(state)
        self.given, self.left = (self.y.copy(), self.yp.copy()), np.zeros(len(self.y))
        self.t = self.beyond = self.goal = state.t
        self.steps, self.most_steps = 0, settings.most_steps
        times = system.signal_times.between(state.t, max(state.t, t_end))
        self.stops = np.unique(np.concatenate([just_before(times.breaks), times.fine]))
        self.latest = state.t, self.y.copy(), self.yp.copy()
        self.cause = ""
        self.counts = {"steps": 0, "rejected": 0, "residuals": 0, "factorisations": 0}
        self.goes_back = False
        """Is what has touched among what is `told`? It takes memory."""
        self.counted: list[tuple[dict[str, int], list[np.ndarray]]] = [(dict(self.counts), [])]
        """Told before the latest call of `IDA.run`, and at each of its rows."""
        self.tried = state.t
        self.span = max(t_end - state.t, 1e-300)
        work.weights[0].wanted = 0
        evaluate(system.program, state, work)
        self.switching = new_switching(system, state, work, PassedOver(floor=settings.rtol * system.lengths.whole))
        self.meeting = self._touching() or bool(np.any(np.isin(self.switching.now[:, 0], (CROSSING, KINK, PIECE))))
        self.landing: float | None = None
        self.before = {"residuals": 0, "factorisations": 0}
        self.drives = WorkOfDrives(system, state, work)
        self._structure()
        self.solver = self._solver(settings)
        self.solver.init_step(state.t, self.y, self.yp)

    def told(self) -> tuple[dict[str, int], list[np.ndarray]]:
        """Return a copy of what a run tells at its end: numbers, and what has touched."""
        return dict(self.counts), [array.copy() for array in self.switching[1:]] if self.goes_back else []

    def tell_again(self, told: tuple[dict[str, int], list[np.ndarray]]) -> None:
        """Forget what came after it was `told`."""
        self.counts = dict(told[0])
        for array, kept in zip(self.switching[1:], told[1], strict=bool(told[1])):
            array[...] = kept

    def __deepcopy__(self, memo):
        raise TypeError("the solver keeps what it knows to itself: a copy of it knows nothing")

    def _yielding(self, state) -> np.ndarray:
        """Return the compliance of the constraints (2, ng), s: zero unless equations depend on each other."""
        system = self.system
        yielding = np.zeros((2, system.ng))
        if system.redundant:
            equations = equations_at(system, state, self.work)
            # equations that contradict each other yield more: what they leave open must not become a large multiplier
            misfit = max((max(gap) for gap in system.misfits.values()), default=0.0)
            motion, position = max(YIELDING, 0.01 * misfit), OPEN if misfit else YIELDING
            scale = equation_scale(equations.M, equations.G, system.least_inertia)
            yielding[0] = motion * scale
            if not system.misfits:
                carry = np.setdiff1d(np.arange(system.ng), system.redundant)
                yielding[0, carry] = CARRIES * motion * np.min(scale)
            yielding[1] = position * (equations.G.multiply(equations.G) @ self.extent**-2.0)
        return yielding

    def _start(self, state):
        """Return consistent values and rates."""
        system, nq, nu, ng = self.system, self.system.nq, self.system.nu, self.system.ng
        y, yp = np.zeros(nq + nu + 2 * ng + 3), np.zeros(nq + nu + 2 * ng + 3)
        y[:nq], y[nq : nq + nu], y[nq + nu : nq + nu + ng] = state.q, state.u, state.lam
        kinematics(system.program, 0.0, y, state.u, yp)
        yp[nq : nq + nu] = state.a
        self.work.weights[0].wanted = 0
        evaluate(system.program, state, self.work)
        yp[-3:] = powers(self.work.energy)
        if system.misfits:
            y[nq + nu + ng : nq + nu + 2 * ng] = -self.work.equations["g"] / self.form.yielding[1]
        return y, yp

    def _structure(self) -> None:
        """Find the pattern of the Jacobian from one evaluation."""
        form = self.form
        most = 33 * len(self.system.program.frames) + 40 * len(form.own) + 40
        most = most * 2 + 2 * len(self.y) + 16 * len(form.gradient) + len(form.transposed)
        self.rows, self.columns, self.values = np.zeros(most, np.int64), np.zeros(most, np.int64), np.zeros(most)
        count = jacobian(
            self.system.program, self.work, form, 0.0, 1.0, self.y, self.yp, self.rows, self.columns, self.values
        )
        self.rows, self.columns, self.values = self.rows[:count], self.columns[:count], self.values[:count]
        keys, self.address = np.unique(self.columns * len(self.y) + self.rows, return_inverse=True)
        self.keys = keys

    def _solver(self, settings: Any):
        from scipy import sparse
        from sksundae.ida import IDA as Solver

        n, ng = len(self.y), self.system.ng
        turns = self.switching.now[:, 8]
        finest = FRICTION * float(np.min(turns[turns > 0.0], initial=np.inf))
        atol = np.full(n, FAR)
        free = n - 2 * ng - 3
        atol[:free] = min(absolute_tolerance(settings.atol, ATOL, self.system), finest)
        for iq, iu in self.system.program.frames[:, :2]:  # angles are not smaller in a model below 1 m
            atol[iq + 3 : iq + 7] = min(settings.atol or ATOL, finest)
            atol[self.system.nq + iu + 3 : self.system.nq + iu + 6] = min(settings.atol or ATOL, finest)
        for iq, iu, size, _ in self.system.program.vectors:
            atol[iq : iq + size] /= self.extent[iu : iu + size]
            atol[self.system.nq + iu : self.system.nq + iu + size] /= self.extent[iu : iu + size]
        if settings.atol is None:  # speeds of motions that take hours are small
            atol[self.system.nq : self.system.nq + self.system.nu] *= min(1.0, SLOW / self.span)
        for (iq, iu), group in zip(self.system.state_slices.values(), self.system.states, strict=True):
            atol[iq] = FAR  # nothing reads the integrals of states
            atol[self.system.nq + iu.start : self.system.nq + iu.stop] = (settings.atol or ATOL) * np.array(group.size)
        branches = list(range(self.system.program.branches, self.system.nq))
        atol[branches] = COUNTED
        options: dict[str, Any] = {"linsolver": "lapackdense"}
        if n > DENSE:
            columns = np.searchsorted(self.keys, np.arange(n + 1) * n)
            pattern = sparse.csc_matrix((np.ones(len(self.keys)), self.keys % n, columns), shape=(n, n))
            options = {"linsolver": "sparse", "sparsity": pattern}
            # the solver could find the Jacobian from the pattern by differences, and says that it will not; this filter
            # of what it says, and of nothing else, stays: filters belong to all threads, and to take it back while
            # another thread has set some would take those back
            said = r"Custom sparse Jacobian approximation will be ignored"
            warnings.filterwarnings("ignore", said, UserWarning, module=r"sksundae\.ida\.")
        own = proxy(self)  # no circle with the solver, which would keep all arrays until garbage is searched for

        def residual_of(t, y, yp, res):
            own.residual(t, y, yp, res)

        def jacobian_of(t, y, yp, res, cj, JJ):
            own.jacobian(t, y, yp, res, cj, JJ)

        return Solver(
            residual_of,
            jacfn=jacobian_of,
            rtol=min(settings.rtol * self._closeness(), finest),
            atol=atol,
            algebraic_idx=[*branches, *range(free, n - 3)],
            max_order=settings.max_order,
            max_step=settings.largest or LONGEST,
            min_step=min(SHORTEST * max(self.span, abs(self.t)), settings.largest or LONGEST),
            max_num_steps=settings.most_steps,
            **options,
        )

    def _touching(self) -> bool:
        """May something touch? A crowd has no gaps of its own, but follows its surfaces through the steps."""
        gaps = np.isin(self.switching.now[:, 0], (GAP, TURN_GAP, DISTANCE))
        return bool(np.any(gaps) or np.any(self.switching.kinds[:, 4]))

    def _closeness(self) -> float:
        """Return the share of `rtol` that counts."""
        return _closeness(self.system) * (TOUCHING if self._touching() else 1.0)

    def _given(self, y, yp) -> None:
        """Copy what the solver gives: its arrays have a type of their own at each call, which takes long to look at."""
        self.given[0][:], self.given[1][:] = y, yp

    def residual(self, t, y, yp, res) -> None:
        """Callback of the solver."""
        self._given(y, yp)
        direct(self, residual)(self.system.program, self.work, self.form, t, *self.given, self.left)
        res[:] = self.left
        if not all_finite(self.left):
            self.cause = without_value(self.system, self.work, y)
            raise _NotFinite(t)
        self.latest = t, y, yp
        # the solver does not tell its steps: a new one is evaluated later than the one before, a repeated one earlier
        self.counts["steps"] += t > self.tried
        self.counts["rejected"] += t < self.tried
        self.tried = t

    def jacobian(self, t, y, yp, res, cj, JJ) -> None:
        """Callback of the solver."""
        self._given(y, yp)
        direct(self, jacobian)(
            self.system.program, self.work, self.form, t, cj, *self.given, self.rows, self.columns, self.values
        )
        summed = np.bincount(self.address, weights=self.values, minlength=len(self.keys))
        if JJ.ndim == 1:
            JJ[:] = summed
        else:
            JJ[:] = 0.0
            JJ[self.keys % len(self.y), self.keys // len(self.y)] = summed

    def advance(self, t: float, pace: Patience) -> str:
        """Integrate to `t`, or until the patience is used up; return what went wrong, or an empty text.

        The solver steps on past `t`, and what it returns there lies between its steps.
        """
        if t > self.t and t != self.goal:
            self.goal, self.steps = t, 0
        while t > self.t:
            # single steps until one has come past `t`: it can be called back between them
            failure = self._step(t, "onestep" if self.beyond < t else "normal")
            if failure:
                return failure
            if pace.used_up and self.beyond < t:
                break
        return ""

    def _step(self, t: float, how: str) -> str:
        """Take a step towards `t`, or return to it from beyond; return what went wrong, or an empty text."""
        before, stop = (self.t, self.y, self.yp), self._stop(t)
        if self.meeting or self.landing is not None:  # such steps stay before a sample, and can be taken back
            stop = min(x for x in (t, stop, self.landing) if x is not None)
        try:
            with OUTPUT:
                result = self.solver.step(t, method=how, tstop=stop)
        except _NotFinite as error:
            if self._shortened(error.args[0], before):
                return ""
            where = f" at t = {error.args[0]:.9g} s{self.cause}" if self.cause else self._where()
            return f"the equations of motion are not finite{where}"
        for name, count in (("residuals", result.nfev), ("factorisations", result.njev)):
            self.counts[name] = self.before[name] + int(count)
        self.steps += 1
        if not result.success:
            reason = str(result.message).strip().rstrip(".")
            return f"IDA stopped ({reason}){self._where()}"
        if self.steps > self.most_steps:
            return f"IDA stopped ({self.most_steps} steps between two samples){self._where()}"
        self.beyond = max(self.beyond, float(np.ravel(result.t)[-1]))
        if self.beyond <= t or how == "normal":
            self.t = min(self.beyond, t)
            self.y, self.yp = np.array(result.y).ravel(), np.array(result.yp).ravel()
            if self.landing is not None and self.t >= self.landing and not len(self.switching.now):
                self.landing = None
            if len(self.switching.now):
                self._meet(before)
            if self.drives.act and self.t > self.drives.t:
                self.drives.go_on(self._state(self.t))
        return ""

    def _shortened(self, failed: float, before: tuple[float, np.ndarray, np.ndarray]) -> bool:
        """Go back to where the equations of motion had values, half way to a time without; False where both are one.

        The solver gives up at the first trial that has none, however long its step.
        """
        t, y, yp = before
        if not failed - t > RESOLVED * max(self.span, abs(t)):
            return False
        self.landing = t + 0.5 * (failed - t)
        self.before, self.beyond, self.tried = dict(self.counts), t, t
        self.solver.init_step(t, y, yp)
        return True

    def _meet(self, before: tuple[float, np.ndarray, np.ndarray]) -> None:
        """Go back to the start of a step that went over the begin or end of a contact, to land there."""
        sw, (t, y, yp) = self.switching, before
        h = self.t - t
        state = self.system.state(self.t, self.y[: self.system.nq], self.y[self.system.nq :][: self.system.nu])
        self.work.weights[0].wanted = 0
        evaluate(self.system.program, state, self.work)
        read_switches(self.system.program, sw, state, self.work)
        part = allowed(self.system.program, sw, h, True) if self.meeting and h > 1e-11 * self.span else 1.0
        if part < 1.0:
            self.t, self.y, self.yp, self.landing = t, y, yp, t + part * h
            self.before, self.beyond, self.tried = dict(self.counts), t, t
            self.solver.init_step(t, y, yp)
            return
        if keep_switches(sw, h) == JUMPED:
            self._jumped()
        if self.landing is not None and self.t >= self.landing:
            self.landing = None

    def _jumped(self) -> None:
        """Begin anew with the accelerations behind a jump, of which the rates of the steps before know nothing."""
        works = self.y[-3:].copy()
        t, q, u, a, lam, _ = self.sample(self.t)
        self.y, self.yp = self._start(self.system.state(t, q, u)._replace(a=a, lam=lam))
        self.y[-3:] = works
        self.before, self.beyond, self.tried = dict(self.counts), t, t
        self.solver.init_step(t, self.y, self.yp)

    def _stop(self, t: float) -> float | None:
        """Return the time from `t` on that steps must not pass: the next at which a signal is not smooth."""
        later = self.stops[self.stops >= t]
        return float(later[0]) if len(later) else None

    def _where(self) -> str:
        """Return time, part and equations at which the latest evaluation was worst."""
        t, y, yp = self.latest
        system = self.system
        out = np.zeros(len(y))
        residual(system.program, self.work, self.form, t, y, yp, out)
        size = np.abs(yp[system.nq : system.nq + system.nu]) * self.extent
        worst = int(np.argmax(np.where(np.isfinite(size), size, np.inf)))
        equations = f"; worst equations: {worst_equations(system, self.work)}" if system.ng else ""
        return f" at t = {t:.9g} s near {system.owner(worst)}{equations}"

    def sample(self, t: float):
        """Return t, q, u, a, lam, works; accelerations and multipliers from the equations of motion at q and u."""
        system, state, works = self.system, self._state(t), self.y[-3:].copy()
        right = np.zeros(system.nu + system.ng)
        accelerations(system.program, state, self.work, right, 12 if system.redundant else 2)
        if system.implicit and not is_solved(system, state, right, self.work):
            end = system.nq + system.nu
            settle(system, state, self.work, self.yp[system.nq : end].copy(), self.y[end : end + system.ng].copy())
        if self.drives.act:
            works[1] = self.drives.work
        return t, state.q, state.u, state.a, state.lam, works

    def _state(self, t: float):
        """Return positions and velocities that have been reached, Euler parameters of unit length."""
        system, q = self.system, self.y[: self.system.nq].copy()
        for iq, _ in system.program.frames:
            q[iq + 3 : iq + 7] /= np.linalg.norm(q[iq + 3 : iq + 7])
        return system.state(t, q, self.y[system.nq : system.nq + system.nu])


def _closeness(system) -> float:
    """Return the share of `rtol` that counts where coordinates are many times as large as what bodies do to each other.

    The solver relates errors to the coordinates themselves: 7 m at a millionth of a low orbit.
    """
    farthest = float(np.max(system.lengths.coordinates, initial=0.0))
    return max(min(1.0, FARTHER * system.lengths.whole / farthest), LEAST) if farthest > 0.0 else 1.0
