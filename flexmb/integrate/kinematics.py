"""`kinematics`: the motion that drives alone determine; `inverse_dynamics`: the drive forces for a wanted motion."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from flexmb.errors import CompileError, IntegrationError, ModelError, ValidityWarning
from flexmb.integrate.impulsive import refuse_impulses
from flexmb.integrate.runs.interruption import Interruption
from flexmb.integrate.runs.patience import Patience
from flexmb.integrate.runs.prescribed_jumps import require_no_jumps, sentences_about
from flexmb.integrate.runs.sample_rows import SampleRows
from flexmb.integrate.runs.shared_readers import shared_reactions_act
from flexmb.integrate.runs.simulate import sample_times
from flexmb.integrate.runs.unknown_value import REMEDY, unknown_value
from flexmb.integrate.runs.validity import WARNINGS
from flexmb.math.energies import powers
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.tables import State
from flexmb.model.model import Model
from flexmb.model.orbit import require_orbit
from flexmb.results import SHARED, Phase, Solution, Status
from flexmb.system import assemble_as_drawn
from flexmb.system.accelerations import accelerations
from flexmb.system.complaints import worst_equations
from flexmb.system.given_state import refuse_states
from flexmb.system.holds import refuse_holds
from flexmb.system.mobility import shared_reactions
from flexmb.system.program import advance, evaluate, keep_branches
from flexmb.system.projection import project

__all__ = ["inverse_dynamics", "kinematics"]

CLOSED = 1e-11
"""Residual of the constraints at a sample, relative to the largest body of an equation, or rad."""


@inner_kernel
def _walk(program, state, work, h, here):
    """Advance `here` by uniformly accelerated motion over `h`, in pieces of less than a radian: turns are counted."""
    fastest = 0.0
    for n in range(len(program.frames)):
        for i in range(3):
            k = program.frames[n, 1] + 3 + i
            fastest = max(fastest, abs(state.u[k]) + abs(h * state.a[k]))
    pieces = min(int(np.ceil(2.0 * fastest * h)), 10_000) if len(work.branches) > 0 else 0
    start = state.q.copy()
    work.weights[0].wanted = 0
    for n in range(1, pieces):
        part = h * n / pieces
        start[program.branches :] = here[program.branches :]
        advance(program, start, state.u + 0.5 * part * state.a, part, here)
        evaluate(program, State(state.t + part, here, state.u, state.a, state.lam, state.signals), work)
        keep_branches(program, work, here)
    start[program.branches :] = here[program.branches :]
    advance(program, start, state.u + 0.5 * h * state.a, h, here)


@kernel
def _follow(program, work, rows, first, last, state, power, right, bounds, gaps, units, sweeps):
    """Project, for rows.t[first:last], from the extrapolated motion onto g(q, t) = 0 with derivatives; return the rows
    that are done. Rows before `first` and the `power` (3,) of the last of them are those of an earlier call."""
    here, speed, acceleration, multipliers = state.q.copy(), state.u.copy(), state.a.copy(), state.lam.copy()
    for k in range(first, last):
        t = rows.t[k]
        h = t - rows.t[k - 1] if k > 0 else 0.0
        if k > 0:
            before = State(rows.t[k - 1], rows.q[k - 1], speed, acceleration, multipliers, state.signals)
            _walk(program, before, work, h, here)
            speed += h * acceleration
        now = State(t, here, speed, acceleration, multipliers, state.signals)
        if project(program, now, work, right, here, bounds, gaps, units, 60) < 0:
            return k
        if accelerations(program, now, work, right, sweeps) >= 0:
            return k
        keep_branches(program, work, here)
        rows.q[k], rows.u[k], rows.a[k], rows.lam[k] = here, speed, acceleration, multipliers
        if k > 0:
            rows.works[k] = rows.works[k - 1] + 0.5 * h * (power + powers(work.energy))
        power[:] = powers(work.energy)
    return last


def _followed(system, start: State, rows: SampleRows) -> tuple[int, bool, Any]:
    """Fill the rows, in calls so short that Ctrl-C is heard soon; return those done, whether they end by Ctrl-C, and
    the workspace."""
    work, right, power = system.workspace(), np.zeros(system.nu + system.ng), np.zeros(3)
    state = start._replace(a=np.zeros(system.nu), lam=np.zeros(system.ng))
    settings = right, system.drift_bounds(CLOSED), system.gaps, system.units, 12 if system.redundant else 2
    reached, pace = 0, Patience(0.0)
    try:
        with Interruption() as interruption:
            while reached < len(rows.t):
                first, last = reached, min(reached + pace.steps(), len(rows.t))
                reached = _follow(system.program, work, rows, first, last, state, power, *settings)
                if reached < last:
                    break
                k = reached - 1
                state = state._replace(q=rows.q[k], u=rows.u[k], a=rows.a[k], lam=rows.lam[k])
                interruption.look()
    except KeyboardInterrupt:
        if not reached:
            raise
        return reached, reached < len(rows.t), work
    return reached, False, work


def _require_no_freedoms(model: Model, system) -> None:
    """Raise CompileError if freedoms are left that no drive determines."""
    free = system.nu - system.ng + len(system.redundant)
    if free:
        flexible = [b.name for b in model.bodies if b.has_frame and b.n_vector]
        raise CompileError(
            f"Model '{model.name}'",
            found=f"{free} freedoms that no drive determines",
            expected="mobility 0 for kinematics",
            remedy=f"Set rigid=True on {', '.join(flexible)}"
            if flexible
            else "Add drives, or use simulate for free motions",
        )


def _require_start(model: Model, reached: int) -> None:
    """Raise CompileError unless at least the first sample is reached."""
    if reached == 0:
        raise CompileError(
            f"Model '{model.name}'",
            found="the start does not satisfy the constraints",
            expected="an assembled start",
            remedy="Look at flexmb.check(model)",
        )


def kinematics(model: Model, t_end: float, *, samples: Any = 201, t_start: float = 0.0) -> Solution:
    """Compute positions, velocities, accelerations and reactions of a mechanism whose drives determine its motion.

    Every sample satisfies the constraints at position, velocity and acceleration level; reactions and drive forces
    follow from the equations of motion (inverse dynamics), so loads and inertia count in full.

    Parameters
    ----------
    model : Model
        With mobility 0: as many independent drives as freedoms, no flexible coordinates.
    t_end, samples, t_start
        As in `simulate`.

    Raises
    ------
    CompileError
        If freedoms are left that no drive determines.
    IntegrationError
        If the mechanism cannot follow its drives (lock-up); ``error.solution`` holds all samples before.

    Ctrl-C ends it with status "interrupted" and all samples until then.
    """
    times = sample_times(t_start, t_end, samples)
    require_orbit(model, float(times[-1]))
    refuse_impulses(model, "kinematics")
    system, start = assemble_as_drawn(model, t=t_start)
    refuse_states(system, "kinematics")
    refuse_holds(system, "kinematics")
    jumps = require_no_jumps(system, start, float(times[-1]))
    _require_no_freedoms(model, system)
    nt = len(times)
    whole = SampleRows.of(system, nt)
    whole.t[:] = times
    reached, interrupted, work = _followed(system, start, whole)
    rows: dict[str, Any] = whole.first(reached)
    _require_start(model, reached)
    found = f"the mechanism cannot follow its drives at t = {times[min(reached, nt - 1)]:.6g} s"
    unknown = None
    if reached < nt and not interrupted:
        ends = float(times[reached - 1]), float(times[reached])
        unknown = unknown_value(system, rows["q"][-1], rows["u"][-1], *ends)
    status = (
        Status.finished(t_end)
        if reached == nt
        else Status.interrupted(float(times[reached - 1]))
        if interrupted
        else Status.failed(unknown or found, REMEDY if unknown else "Look for a dead centre at that time")
    )
    phase = Phase(model=model, system=system, ended=status.kind, **rows)
    shared = shared_reactions(system)
    known = {SHARED: shared} if shared else {}
    jumping = sentences_about(jumps)
    for sentence in jumping:
        warnings.warn(sentence, ValidityWarning, stacklevel=2)
    last = system.state(float(times[reached - 1]), rows["q"][-1], rows["u"][-1])
    if told := [*jumping, *shared_reactions_act(system, last, rows["lam"])]:
        known |= {WARNINGS: told}
    solution = Solution(phases=(phase,), status=status, statistics={"samples": reached, **known})
    if status.kind == "failed":
        worst = worst_equations(system, work)
        raise IntegrationError(
            f"Model '{model.name}'",
            found=unknown or f"{found}; worst equations: {worst}",
            expected="a position that satisfies all joints",
            solution=solution,
            remedy=REMEDY if unknown else "Shorten the drive's range, or change the lengths of the linkage",
        )
    return solution


def inverse_dynamics(model: Model, drives: Sequence[Any], t_end: float, *, samples: Any = 201) -> Solution:
    """Compute the forces of drives that move a mechanism as wanted.

    Parameters
    ----------
    model : Model
        Without drives of these joints.
    drives : sequence of Drive
        The wanted motion of each joint; together they determine the motion.
    t_end, samples
        As in `simulate`.

    Returns
    -------
    Solution
        ``solution[flexmb.Reaction("torque", joint="motor")]`` is what the drive "motor" exerts, (nt, 6).
    """
    driven = {getattr(j, "joint", ""): j.name for j in model.joints if j.prescribes}
    for drive in drives:
        if drive.joint in driven:
            other = driven[drive.joint]
            raise ModelError(
                "inverse_dynamics",
                found=f"joint '{drive.joint}' already has the drive '{other}'",
                expected="a free joint",
                remedy=f"Leave '{drive.name}' or '{other}' out",
            )
    return kinematics(model.with_parts(joints=drives), t_end, samples=samples)
