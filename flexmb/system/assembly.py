"""`assemble`: from the drawing to a configuration that satisfies all constraints, with least motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse

from flexmb.errors import CompileError
from flexmb.math.block_lu import lu_factor
from flexmb.math.tables import State
from flexmb.math.weights import no_matrix, weigh_mass
from flexmb.model.model import Model
from flexmb.model.orbit import require_orbit
from flexmb.system.accelerations import accelerations, settled_accelerations
from flexmb.system.compile import compile
from flexmb.system.complaints import (
    equations_of_forces,
    flat_equation,
    gaps,
    idle_equation,
    open_joint,
    singular,
    without_inertia,
)
from flexmb.system.damped_accelerations import unsolved
from flexmb.system.lengths import described_lengths, velocity_units, warn_of_lost_digits
from flexmb.system.massless import inertia_floor
from flexmb.system.mobility import (
    constraint_matrix,
    dependent_equations,
    equation_scale,
    indeterminate_equations,
    mass_diagonal,
    mass_metric,
)
from flexmb.system.needles import least_inertia, warn_of_needles
from flexmb.system.program import constraint_acceleration, constraint_velocity, evaluate, increment
from flexmb.system.projection import project
from flexmb.system.stations import warn_of_stations
from flexmb.system.system import System

__all__ = ["all_softened", "assemble", "consistent_start", "softened"]

REGULARISATION = 1e-9
"""Added to the diagonal of the multipliers, relative to G M^-1 G^T, where equations depend on each other."""
MESH_TOLERANCE = 1e-6
"""Gap that equations which depend on each other may leave, relative to the model's size (lengths) or in rad (angles):
the digits of a mesh file."""
OPEN_RATE = 1e-5
"""Of the terms of a derivative of an equation: what a consistent start may leave open."""
FAINT = 1.0
"""Share of the largest motion that counts as a term of every equation: rounding in it is everywhere."""
STANDING = 1e-7
"""Lengths, or rad, per second (and per second squared): slower motion counts as rest, and its residual as rounding."""
MEETS = 1e-9
"""Gap, relative to the assembly (lengths) or in rad, that is rounding of a drawing."""
ROUNDS = 3
"""Times that assembly looks for dependent equations: the drawing and the mechanism may have different ones."""


def assemble(
    model: Model, *, t: float = 0.0, state=None, tolerance: float = 1e-11, stuck: list[CompileError] | None = None
) -> tuple[System, State]:
    """Compile a model, find dependent equations and assemble its initial configuration and velocity.

    Parameters
    ----------
    model : Model
    t : float, s
        Time of the start.
    state : dict of body name to (q, u), optional
        Where bodies are and how they move, instead of what is described; ("branch", name) gives the value of a branch.
    tolerance : float, m or rad
        Largest residual of the constraints.
    stuck : list, optional
        Takes the error about a start that no motion has, which is raised without it; accelerations are zero then.

    Returns
    -------
    System, State
        The system (with its dependent equations known) and the consistent start: q, u, accelerations, multipliers.

    Raises
    ------
    CompileError
        If the constraints contradict each other at the described configuration, or a matrix is singular.
    """
    require_orbit(model, t)
    system = compile(model)
    work = system.workspace()
    given, state = state or {}, system.state(t)
    for name, (iq, iu) in system.slices.items():
        if name in given:
            state.q[iq], state.u[iu] = given[name]
    for k, branch in enumerate(system.branch_names):
        state.q[system.program.branches + k] = given.get(("branch", branch), state.q[system.program.branches + k])
    system = _with_lengths(system, state, work)
    drawn = state._replace(q=state.q.copy(), u=state.u.copy())
    opened = np.any(np.abs(work.equations["g"]) > MEETS * system.lengths.equations)
    system = _assemble(system, state, work, tolerance)
    if opened:
        _straighten(system, state, work, drawn, tolerance)
    flat = flat_equation(system, state, work)
    if flat is not None:
        raise flat
    system = replace(system, misfits=_misfits(system, work, tolerance))
    try:
        residual = np.zeros(system.ng)
        constraint_velocity(work, state.u, residual)
        fastest = np.maximum(np.abs(state.u), np.abs(system.u0))
        _require_motion(system, state, work, residual, np.abs(work.equations["rate"]), fastest, "first")
        return system, consistent_start(system, state, work)
    except CompileError as error:
        if stuck is None:
            raise
        stuck.append(error)
    state.a[:], state.lam[:] = 0.0, 0.0
    return system, state


def _assemble(system: System, state: State, work, tolerance: float) -> System:
    """Move `state` onto the constraints and return the system with its dependent equations known there."""
    right = np.zeros(system.nu + system.ng)
    bounds = system.bounds(tolerance)
    system, moved = _regularised(system, state, work), np.zeros(system.nu)
    for _ in range(ROUNDS):
        drawn = state.q.copy()
        done = project(system.program, state, work, right, state.q, bounds, system.gaps, system.units, 60)
        if done == -2:
            weigh_mass(work.weights)
            evaluate(system.program, state, work)
            if not np.all(np.isfinite(work.equations["g"])):
                raise _runaway(system, state, work)
            place = lu_factor(work.S, system.program.pattern)
            raise idle_equation(system, state, work) or singular(system, state, work, place)
        g = np.abs(work.equations["g"])
        if not np.all(np.isfinite(g)):
            break
        increment(system.program, drawn, state.q, moved)
        if np.all(np.abs(moved * system.units) <= tolerance):  # all gradients are as they were
            break
        before, system = system.redundant, _regularised(system, state, work)
        if system.redundant == before:
            break
    if not np.all(np.isfinite(g)):
        raise _runaway(system, state, work)
    if done < 0 and np.any(g > bounds):
        raise idle_equation(system, state, work) or open_joint(system, work, state.t)
    return system


def _straighten(system: System, state: State, work, drawn: State, tolerance: float) -> None:
    """Take out of `state` what assembly has bent needlessly.

    `project` prefers motion to deformation by a factor. A millimetre in the drawing still bends a stiff body by a
    tenth of a micron, which is a force, and it rings. From where the bodies have been moved to, hardly any gap is left.
    """
    elastic = np.zeros(len(state.q), bool)
    for body in system.model.bodies:
        if body.has_frame and body.n_vector:
            end = system.slices[body.name][0].stop
            elastic[end - body.n_vector : end] = True
    if np.array_equal(state.q[elastic], drawn.q[elastic]):
        return
    right, bounds = np.zeros(system.nu + system.ng), system.bounds(tolerance)
    for _ in range(ROUNDS):
        before = state.q.copy(), state.u.copy()
        state.q[elastic], state.u[:] = drawn.q[elastic], drawn.u
        done = project(system.program, state, work, right, state.q, bounds, system.gaps, system.units, 60) >= 0
        bent = [float(np.linalg.norm(q[elastic] - drawn.q[elastic])) for q in (before[0], state.q)]
        if not (done and bent[1] <= bent[0]):
            state.q[:], state.u[:] = before
            project(system.program, state, work, right, state.q, bounds, system.gaps, system.units, 60)  # of what stays
            return
        if bent[1] > 0.1 * bent[0]:  # something must bend, or only rounding is left
            return


def _runaway(system: System, state: State, work) -> CompileError:
    """Return the error about a search that left all bounds: the described positions tell where it began."""
    evaluate(system.program, system.state(state.t), work)
    return open_joint(system, work, state.t)


def _misfits(system: System, work, tolerance: float) -> dict[str, tuple[float, float]]:
    """Return what dependent equations leave open, (m, rad) by joint; joints that are satisfied are not named."""
    if not system.redundant:
        return {}
    opened = np.abs(work.equations["g"]) > system.bounds(tolerance)
    return {name: gap for name, gap in gaps(system, work).items() if np.any(opened[system.joint_equations[name]])}


def consistent_start(system: System, state: State, work) -> State:
    """Return the state with consistent accelerations and multipliers.

    Raises
    ------
    CompileError
        There are none, or forces follow accelerations that are not found.
    """
    right = np.zeros(system.nu + system.ng)
    sweeps = 12 if system.redundant else 2
    failed = accelerations(system.program, state, work, right, sweeps)
    if failed >= 0 or not np.all(np.isfinite(state.a)):
        raise singular(system, state, work, failed)
    if not settled_accelerations(system, state, work, right):
        raise unsolved(system, "Accelerations")
    if system.implicit:
        no_matrix(work.weights)
        evaluate(system.program, state, work)
    residual, drift = np.zeros((2, system.ng))
    constraint_acceleration(work, state.a, residual)
    constraint_acceleration(work, np.zeros(system.nu), drift)
    weigh_mass(work.weights)
    evaluate(system.program, state._replace(a=np.zeros(system.nu), lam=np.zeros(system.ng)), work)
    # what the loads would do to free bodies: where all is held, accelerations are rounding
    free = np.abs(work.residual) / mass_metric(constraint_matrix(system, work)[0])
    _require_motion(system, state, work, residual, np.abs(drift), np.maximum(np.abs(state.a), free), "second")
    return state


def _require_motion(system: System, state, work, residual, given: np.ndarray, motion, derivative: str) -> None:
    """Raise CompileError if velocities or accelerations of the size `motion` (nu,) leave a derivative (ng,) open.

    It is compared with the terms that it is the sum of: what is `given` (ng,) by drives and velocities, and what the
    bodies do, and with the largest motion.
    """
    weigh_mass(work.weights)
    evaluate(system.program, state, work)
    G = constraint_matrix(system, work)[1]
    terms, left = given + abs(G) @ np.abs(motion), np.abs(residual)
    fastest = np.max(np.abs(motion) * system.units, initial=STANDING)
    terms += FAINT * system.lengths.equations * fastest
    shares = left / np.where(terms > 0.0, terms, 1.0)
    if np.any(shares > OPEN_RATE):
        left = np.where(shares > OPEN_RATE, left / system.lengths.equations, 0.0)
        # of those that are equally open the first that is driven: it asks for what the others forbid
        k = int(np.argmax(np.where(left >= (1.0 - OPEN_RATE) * left.max(), 1.0 + (given > 0.0), 0.0)))
        worst = float(abs(residual[k]))
        if system.redundant:
            names = ", ".join(system.equation_names[n] for n in system.redundant[:5])
            raise CompileError(
                f"Equation '{system.equation_names[k]}'",
                found=f"its {derivative} derivative misses zero by {worst:.3g} in a singular "
                f"configuration: {names} depend on "
                "other equations here",
                expected="a start from which all joints and drives can be followed",
                remedy="Start away from the dead centre (or drive another joint there); if nothing "
                "is at a dead centre, "
                "two drives contradict each other: remove one, or make their signals agree",
            )
        raise CompileError(
            f"Equation '{system.equation_names[k]}'",
            found=f"its {derivative} derivative misses zero by {worst:.3g}",
            expected="equations that can be satisfied together, in position, velocity and acceleration",
            remedy="Two drives or joints contradict each other: remove one, or make their signals agree",
        )


def _with_lengths(system: System, state: State, work) -> System:
    """Return the system with the lengths that count in it; warn where coordinates are so large that digits are lost."""
    weigh_mass(work.weights)
    bare = system.program._replace(floor=np.zeros(len(system.program.floor)))
    evaluate(bare, state, work)
    inertia = np.abs(mass_diagonal(system, work))
    lengths = described_lengths(system, inertia, equations_of_forces(system, work))
    warn_of_lost_digits(system.model, lengths)
    warn_of_stations(system.model)
    units = velocity_units(system, lengths, inertia)
    least = least_inertia(system)
    warn_of_needles(system, least)
    return replace(system, lengths=lengths, units=units, least_inertia=least)


def all_softened(system: System) -> System:
    """Return the system with all its equations softened, where some depend on each other.

    In a dead centre of a redundant mechanism more of them do than where it was put together, and the stages of an
    implicit Runge-Kutta method land there as near as rounding allows: hard equations then have no solution.
    """
    if system.sizes is None:
        return system
    scale = REGULARISATION * system.sizes
    softness = np.concatenate([np.zeros(system.nu), scale])
    pattern = system.program.pattern._replace(softness=softness)
    return replace(system, program=system.program._replace(regularisation=scale, pattern=pattern))


def _regularised(system: System, state: State, work) -> System:
    """Return the system with its dependent equations found at `state`, and its multipliers regularised then, and an
    inertia for the factorisation where bodies have none."""
    if system.ng == 0:
        return system
    weigh_mass(work.weights)
    bare = system.program._replace(regularisation=np.zeros(system.ng), floor=np.zeros(len(system.program.floor)))
    evaluate(bare, state, work)
    M, G = constraint_matrix(system, work)
    places, values, loose = inertia_floor(system, M, G)
    if loose >= 0:
        raise without_inertia(system, state, work, loose)
    dependent = dependent_equations(system, M, G)
    program = system.program._replace(floor_at=places, floor=values)
    return softened(replace(system, program=program), work, M, G, dependent, indeterminate_equations(M, G, dependent))


def softened(system: System, work, M, G, dependent, indeterminate) -> System:
    """Return the system with the multipliers of its dependent equations regularised.

    Parameters
    ----------
    M, G : (nu, nu), (ng, nu) csr
        Mass matrix and gradients where they were evaluated last.
    dependent, indeterminate : of int
        Equations that depend on others there, and those whose multipliers are not unique.
    """
    lent, at = system.program.floor, system.program.floor_at[:, 0]
    # pivots of equations between bodies without inertia are as large as what they are lent is small
    scale = equation_scale(M + sparse.csr_matrix((lent, (at, at)), shape=M.shape), G, system.least_inertia)
    # one number for all forces and one for all moments gives least norm, unless inertias differ by many orders
    forces = equations_of_forces(system, work)
    for family in (forces, ~forces):
        scale[family] = np.minimum(scale[family].max(initial=0.0), 1e4 * scale[family])
    sizes = scale.copy()
    # others are hard: near a singular position they hardly move anything, and soft ones would not converge
    shared = np.zeros(system.ng, bool)
    shared[np.asarray(indeterminate, int)] = True
    scale = np.where(shared, REGULARISATION * scale, 0.0)
    softness = np.concatenate([np.zeros(system.nu), scale]) if len(dependent) else np.zeros(0)
    pattern = system.program.pattern._replace(softness=softness)
    return replace(
        system,
        program=system.program._replace(regularisation=scale, pattern=pattern),
        redundant=tuple(int(k) for k in dependent),
        indeterminate=tuple(int(k) for k in indeterminate),
        sizes=sizes if len(dependent) else None,
        gaps=system.lengths.equations * (MESH_TOLERANCE if len(dependent) else 0.0),
    )
