"""The steps of `MoreauJean`: from one state to the next, with all contacts."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.integrate.alpha.world_translation import to_body_axes, to_world_axes, turn
from flexmb.integrate.nonsmooth.apart import TOUCHING, require_apart
from flexmb.integrate.nonsmooth.closing import Closing, in_body_axes, place
from flexmb.integrate.nonsmooth.course import LEAST, Course
from flexmb.integrate.nonsmooth.doubled import Doubled
from flexmb.integrate.nonsmooth.lateness import Lateness
from flexmb.integrate.nonsmooth.points import Touching
from flexmb.integrate.nonsmooth.problem import POINT, new_problem, write_problem
from flexmb.integrate.nonsmooth.restitution import solve_impulses
from flexmb.integrate.nonsmooth.stepping import (
    UNTOLD,
    carry_impulses,
    end_positions,
    evaluate_middle,
    give_back,
    given_by_impacts,
    resultants,
    set_shifts,
    works_of,
)
from flexmb.integrate.runs.kept_switches import keep_switches
from flexmb.integrate.runs.patience import UNCUT, Patience, smallest_step
from flexmb.integrate.runs.switches import part_of_step
from flexmb.integrate.runs.switching import PassedOver, new_switching
from flexmb.math.block_lu import lu_factor
from flexmb.math.block_parts import parts_of
from flexmb.math.block_substitution import lu_solve
from flexmb.math.energies import powers
from flexmb.math.weights import weigh
from flexmb.surfaces.records import FAR
from flexmb.system.complaints import without_value
from flexmb.system.program import keep_branches

__all__ = ["Stepper"]

HALF = 0.5
"""Penetration, relative to the reach of the smallest surface, that a step never exceeds: thin surfaces shorten it."""
SHORTEST = 1e-9
"""Share of the given step to which thin surfaces may shorten one."""
FLOOR = 1e-9
"""Way, relative to the length of the model, that steps may go into a compliant contact before they are divided."""
IMPACT = 0.1
"""Change of the speed of an impact on a compliant contact in a step, relative to it."""
CUT, DIVERGED = "cut at contacts", "rejected by iteration"
EFFORT = "iterations", "sweeps", "steps of Newton over contacts"
"""Statistics that count steps which are taken back, too."""
LOOSE = 1e-2
"""Tolerance of contacts up to which one is named that would take a step: more would change the motion."""
LEFT = "largest residual of contacts [m/s]"
"""Name of what the worst contact of all steps was left off its laws, in the statistics."""


class Stepper:
    """The state of a run, and its steps."""

    def __init__(self, settings, system, state, work, world, duration: float):
        self.settings, self.system, self.work, self.world = settings, system, work, world
        self.parts = parts_of(system.program.pattern)
        self.touching = Touching(system)
        self.t, self.q, self.u, self.lam = state.t, state.q.copy(), state.u.copy(), state.lam.copy()
        self.a = np.zeros(system.nu)
        to_world_axes(world, self.q, self.u, state.a.copy())
        self.signals = np.zeros_like(state.signals)
        self.works = np.zeros(3)
        self.made_by_impacts = np.zeros(len(system.model.forces))  # J, by force: energy that laws of impacts have made
        self.points, self.P, self.h = np.zeros(0, POINT), np.zeros((0, 6)), settings.step
        self.counts: dict = {"steps": 0, "iterations": 0, "sweeps": 0, "steps of Newton over contacts": 0}
        self.counts["impacts without a rebound by Newton's law"] = 0
        self.counts[LEFT] = 0.0
        self.counts[CUT] = self.counts[DIVERGED] = 0
        self.small = self.touching.small
        self.lever = max(1.0, self.touching.large)  # m, of what accelerations may close
        # springs and modes are implicit; without any, the gravity of turning bodies would only disturb the matrix
        self.stiff = len(self.touching.forces) < len(system.model.forces) or not _rigid(system)
        self.direct = not system.ng and not self.stiff
        self.thin = int(np.sum(self.touching.thickness < FAR)) > 1
        self.closed = np.zeros(0, np.int64)
        self.closing = Closing(system, work, self.parts, world, self.touching)
        self.kept, self.rows_of = _places_of_wrenches(system, self.touching)
        self.wrenches = np.zeros(self.kept.shape)
        self.complaint, self.gained, self.diverged = "", 0.0, False
        self.refused: tuple[float, str, bool] | None = None
        self.goal, self.span, self.most = state.t, 0.0, settings.step
        self._clear_wrenches(self.q)
        place(self.system, self.work, self.world, self.t, self.q, self.u)
        over = PassedOver(floor=FLOOR * system.lengths.whole, impact=IMPACT, blur=1.0, duration=duration, unfelt=1.0)
        self.switching = new_switching(system, self.present(), work, over)
        self.switches = len(self.switching.now) > 0
        if self.touching.forces:  # what goes on may stand within a rebound
            require_apart(system, self.touching, self.work, settings.step, HALF * self.small)
        self.lateness = Lateness(system, not _rigid(system) or _has_springs(system.model.forces))
        self._first_forces()
        self.doubled = Doubled(self, settings.follow_errors)

    def present(self):
        """Return the present state, velocities in body axes."""
        return self.system.state(self.t, self.q, in_body_axes(self.world, self.q, self.u))

    def _first_forces(self) -> None:
        """Find the forces at the start by a step that is not taken: samples have the forces of the step before."""
        before = self.t, self.q, self.u, self.lam, self.works.copy(), self.made_by_impacts.copy(), dict(self.counts)
        if not self._step(self.settings.step):  # said if the run does need this step, and not solved once more then
            self.refused, self.complaint = (self.t, self.complaint, self.diverged), ""
        a, P, points, lam = self.a, self.P, self.points, self.lam
        self.t, self.q, self.u, _, self.works, self.made_by_impacts, self.counts = before
        self.lam, self.a, self.P, self.points = lam, a, P, points

    def _step(self, h: float) -> bool:
        """Take a step; return False, with a complaint, if there is none."""
        if self.refused and self.t == self.refused[0] and abs(h - self.settings.step) <= 1e-9 * h:
            self.diverged = self.refused[2]
            return self._fail(self.refused[1])
        nu, ng = self.system.nu, self.system.ng
        mid, ub, ab = middle = self.q.copy(), np.zeros(nu), np.zeros(nu)
        u1, lam, right = self.u.copy(), self.lam.copy(), np.zeros(nu + ng)
        problem, v, speed, size = None, np.zeros(nu + ng), 0.0, 0.0
        course = Course(nu, self.system.implicit)
        self.diverged = False
        for iteration in range(course.most):
            fresh = course.wants_matrix(iteration)
            if complaint := self._free_change(h, (u1, lam), middle, right, fresh):
                return self._fail(complaint)
            end = in_body_axes(self.world, mid, u1)
            v[:nu] = end + right[:nu]
            v[nu:] = right[nu:]
            if iteration == 0:
                problem, speed = self._touched(h, mid, right, v)
            elif fresh and problem is not None:
                write_problem(problem, self.work, self.work.S, self.system.program.pattern, self.parts)
            if problem is not None and (complaint := self._solve_contacts(problem, v, speed)):
                return self._fail(complaint)
            self.counts["iterations"] += 1
            if iteration == 0:
                size = max(float(np.max(np.abs(x), initial=0.0)) for x in (end, right[:nu], v[:nu]))
            share = course.take(v[:nu] - end, size)
            u1 = v[:nu].copy() if share == 1.0 else end + share * course.correction
            turn(self.world, mid, u1)
            lam = lam + share * v[nu:] / h
            if self.direct:  # linear but for gyroscopic terms, of which one iteration keeps the order of the method
                course.change = 0.0
            if course.is_lost(iteration) or course.is_settled(iteration):
                break
        if not course.change <= LEAST:
            self.diverged = True
            return self._fail(f"the iteration does not converge at t = {self.t:.9g} s (change {course.change:.2g})")
        return self._accept(h, u1, lam, problem, ub, ab, mid)

    def _free_change(self, h: float, end, middle, right: np.ndarray, fresh: bool) -> str:
        """Write what the equations without contacts change at an iterate (u1, lam) to `right`; or return a complaint.

        Writes configuration, velocities and accelerations of the middle; the matrix where it is `fresh`.
        """
        program, work = self.system.program, self.work
        stiffness = 0.25 * h * h if self.stiff else 0.0
        weigh(work.weights, 1.0, 0.5 * h, stiffness, world_axes=1 if len(self.world) else 0)
        now = self.t, h, self.q, self.u
        evaluate_middle(program, work, self.world, *now, *end, *middle, self.signals, 1 if fresh else 0, right)
        if fresh and lu_factor(work.S, program.pattern) >= 0:
            if np.all(np.isfinite(work.residual)):
                return f"the iteration matrix is singular at t = {self.t:.9g} s"
            return self._not_finite(self.t + 0.5 * h, *middle[:2])
        lu_solve(work.S, program.pattern, right)
        return "" if np.isfinite(right.sum()) else self._not_finite(self.t + 0.5 * h, *middle[:2])

    def _touched(self, h: float, mid: np.ndarray, right: np.ndarray, v: np.ndarray) -> tuple[Any, float]:
        """Return the problem of the contacts that the first iterate meets, or None, and the largest speed there."""
        nu, tiny = self.system.nu, TOUCHING * self.small
        self.gained = self.lever * float(np.abs(right[:nu]).max(initial=0.0))
        points = self.touching.found(self.work, h, 2.0 * h * self.gained + tiny)
        if not len(points):
            return None, 0.0
        problem = new_problem(points, self.work, self.parts, False)
        write_problem(problem, self.work, self.work.S, self.system.program.pattern, self.parts)
        carry_impulses(problem, self.points, self.P * (h / self.h), len(self.points))
        free, tolerance = v[:nu].copy(), self.settings.tolerance
        return problem, set_shifts(problem, self.parts, self.world, mid, self.u, free, h, tiny, tolerance)

    def _solve_contacts(self, problem, v: np.ndarray, speed: float) -> str:
        """Add the impulses of contacts to `v`; return a complaint if there are none that obey their laws."""
        goal = self.settings.tolerance * speed + 1e-15 * float(np.max(np.abs(self.u), initial=0.0))
        solved, turned = solve_impulses(problem, self.parts, v, goal, self.settings.sweeps)
        self.counts["impacts without a rebound by Newton's law"] += turned
        self.counts["sweeps"] += solved.sweeps
        self.counts["steps of Newton over contacts"] += solved.newton
        self.counts[LEFT] = max(self.counts[LEFT], solved.residual)
        return "" if solved.residual <= goal else self._unsolved(problem, solved, goal)

    def _not_finite(self, t: float, *state: np.ndarray) -> str:
        """Say that the evaluation of a state at the time t is not finite, and because of what."""
        cause = without_value(self.system, self.work, *state)
        return f"the equations of motion are not finite at t = {t:.9g} s{cause}"

    def _accept(self, h, u1, lam, problem, ub, ab, mid) -> bool:
        """Make the end of the step the state: positions, joints closed, works."""
        program, work = self.system.program, self.work
        self.works += h * powers(work.energy)
        if problem is not None:
            mean = in_body_axes(self.world, mid, 0.5 * (self.u + u1))
            self.works[2] += works_of(problem, mean)
            if np.any(problem.points["strikes"]):
                given_by_impacts(problem, mean, self.made_by_impacts)
            kept = problem.active > 0
            P = np.zeros((len(problem.points), 6))
            give_back(problem, P)
            self.points, self.P = problem.points[kept].copy(), np.ascontiguousarray(P[kept])
            # what has struck needs its penetration, to come out by itself with the energy it has
            self.closed = np.unique(problem.points["key"][(problem.active == 1) & (problem.P[:, 0] > 0.0)])
            self.counts["most contacts"] = max(self.counts.get("most contacts", 0), int(np.sum(kept)))
        else:
            self.points, self.P, self.closed = np.zeros(0, POINT), np.zeros((0, 6)), np.zeros(0, np.int64)
        self.wrenches = np.zeros(self.kept.shape)  # at the markers where they act, in the middle of the step
        resultants(self.points, self.P / h, work.markers, self.rows_of, self.wrenches)
        rate = (u1 - self.u) / h
        end = self.q.copy()
        end_positions(program, self.world, self.q, self.u, u1, h, end)
        deep = TOUCHING * self.small + UNTOLD * self.settings.tolerance * self.gained * self.h
        end, u1 = self.closing.closed(self.t + h, end, u1, self.closed, deep)
        if not np.all(np.isfinite(end)) or not np.all(np.isfinite(u1)):
            return self._fail(
                f"the state is not finite at t = {self.t + h:.9g} s{without_value(self.system, work, end)}"
            )
        keep_branches(program, work, end)
        self._clear_wrenches(end)
        self.a, self.q, self.u, self.lam, self.h = rate, end, u1, lam, h
        self.t += h
        self.counts["steps"] += 1
        return True

    def _unsolved(self, problem, solved, goal: float) -> str:
        point = problem.points[solved.worst]
        names = [self._marker_name(int(point[side])) for side in "ab"]
        force = self.system.model.forces[point["owner"]]
        missed = self.settings.tolerance * solved.residual / goal if goal > 0.0 else np.inf
        enough = f"; tolerance = {10.0 ** np.ceil(np.log10(missed)):.0e} would take this step" if missed < LOOSE else ""
        return (
            f"{force.title}: the laws of contact between '{names[0]}' and '{names[1]}' are missed by "
            f"{solved.residual:.3g} m/s after {solved.sweeps} sweeps and {solved.newton} steps of Newton's method "
            f"at t = {self.t:.9g} s; expected: {goal:.3g} m/s{enough}"
        )

    def _marker_name(self, number: int) -> str:
        return next((name for name, k in self.system.marker_index.items() if k == number), str(number))

    def _fail(self, complaint: str) -> bool:
        self.complaint = complaint
        return False

    @property
    def reached(self) -> float:
        """Time of the present state."""
        return self.t

    def advance(self, t: float, pace: Patience) -> str:
        """Integrate to `t`, or until the patience is used up; return what went wrong, or an empty text."""
        if t > self.t and t != self.goal:
            self.goal, self.span = t, t - self.t
        # a run that was interrupted just before a jump goes on with it: nothing moves in so short a time
        same = max(1e-12 * max(abs(t), self.span), SHORTEST * self.settings.step)
        while t - self.t > same:
            left = t - self.t
            h = left / max(1.0, np.ceil(left / self.most * (1.0 - 1e-9)))
            if self.thin:
                place(self.system, self.work, self.world, self.t, self.q, self.u)
                h = self.touching.longest(self.work, h, h * h * self.lever * float(np.max(np.abs(self.a), initial=0.0)))
                if h < SHORTEST * self.settings.step:
                    return (
                        f"surfaces meet so fast at t = {self.t:.9g} s that a step must not be longer than {h:.2g} s, "
                        f"for the thinner not to be passed through; expected: {SHORTEST:.0e} of the step, at least"
                    )
            before = self.t
            if not self._tried(h):
                return self.complaint
            if self.t > before:
                touched = bool(self.P.any()) or self._pressed()
                self.lateness.add(self.lam, touched, self.h)
                self.doubled.add(self, self.t - before, touched)
            if pace.used_up:
                return ""
        if t > self.t or abs(t - self.t) <= same:
            self.t = t
        return ""

    def _tried(self, h: float) -> bool:
        """Take a step, or take it back for a shorter one; return False, with a complaint, if there is none.

        Compliant contacts are no unknowns of the step. It ends where one begins, is divided where it would change the
        speed of an impact too much, and where a contact keeps the iteration from converging.
        """
        if not self.switches:
            return self._step(h)
        arrays = self.q, self.u, self.lam, self.a, self.points, self.P, self.closed, self.wrenches
        t, length, works, counts = self.t, self.h, self.works.copy(), dict(self.counts)
        made = self.made_by_impacts.copy()
        shortest = max(SHORTEST * self.settings.step, UNCUT * smallest_step(t, self.goal))
        if not self._step(h):
            if not self.diverged or 0.25 * h < shortest:
                return False
            self.complaint, self.most = "", 0.25 * h
            self.counts[DIVERGED] += 1
            return True
        part = part_of_step(self.system.program, self.switching, self.present(), self.work, h, True)
        self.most = min(self.settings.step, max(part, shortest / h) * h)
        if part < 1.0 and h > shortest:
            self.q, self.u, self.lam, self.a, self.points, self.P, self.closed, self.wrenches = arrays
            self.t, self.h, self.works, self.made_by_impacts = t, length, works, made
            effort = {name: self.counts[name] for name in EFFORT}
            self.counts |= counts | effort
            self.counts[CUT] += 1
        else:
            keep_switches(self.switching, h)
        return True

    def _pressed(self) -> bool:
        """Does a compliant contact press?"""
        return self.switches and bool(self.switching.limits["closed"][0] == 1)

    def _clear_wrenches(self, q: np.ndarray) -> None:
        """Let the evaluation of a step see no contact forces: they are its unknowns."""
        q[self.system.program.branches + self.kept.ravel()] = 0.0

    def sample(self):
        """Return t, q, u, a, lam, works; contact forces are kept in the last coordinates."""
        q, body, a = self.q.copy(), np.zeros(self.system.nu), np.zeros(self.system.nu)
        to_body_axes(self.world, q, self.u, self.a, body, a)
        q[self.system.program.branches + self.kept] = self.wrenches
        return self.t, q, body, a, self.lam, self.works.copy()


def _rigid(system) -> bool:
    """Have bodies no coordinates of deformation, and forces no states?"""
    return all(flexible == 0 and size <= 3 for _, _, size, flexible in system.program.vectors)


def _has_springs(forces) -> bool:
    """Is there a force with a stiffness, on which rigid bodies may swing?"""
    return any(np.any(getattr(force, "stiffness", None)) for force in forces)


def _places_of_wrenches(system, touching) -> tuple[np.ndarray, np.ndarray]:
    """Return the branches (n, 6) that keep contact wrenches, and their rows by force and marker."""
    names = {name: k for k, name in enumerate(system.branch_names)}
    rows, found = np.zeros((len(system.model.forces), len(system.tables["markers"])), np.int64), []
    for owner, force in touching.forces:
        for name in force.touching_markers(system.model):
            rows[owner, system.marker_index[name]] = len(found)
            found.append([names[title] for title in force.kept_names(name)])
    return np.array(found, np.int64).reshape(-1, 6), rows
