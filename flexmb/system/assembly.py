"""`assemble`: from the drawing to a configuration that satisfies all constraints, with least motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmb.errors import CompileError
from flexmb.math.block_lu import lu_factor
from flexmb.math.tables import State
from flexmb.model.model import Model
from flexmb.system.compile import compile
from flexmb.system.mobility import constraint_matrix, dependent_equations, equation_scale
from flexmb.system.program import accelerations, evaluate, project
from flexmb.system.system import System

__all__ = ["assemble", "consistent_start", "worst_equations"]

REGULARISATION = 1e-9
"""Added to the diagonal of the multipliers, relative to G M^-1 G^T, where equations depend on each other."""


def worst_equations(system: System, work, count: int = 3) -> str:
    """Return the names and residuals of the equations that are satisfied worst."""
    g = work.equations["g"]
    order = np.argsort(-np.where(np.isfinite(g), np.abs(g), np.inf), kind="stable")[:count]
    return ", ".join(f"{system.equation_names[k]} = {g[k]:.3g}" for k in order)


def assemble(model: Model, *, t: float = 0.0, state=None, tolerance: float = 1e-11) -> tuple[System, State]:
    """Compile a model, find dependent equations and assemble its initial configuration and velocity.

    Parameters
    ----------
    model : Model
    t : float, s
        Time of the start.
    state : dict of body name to (q, u), optional
        Where bodies are and how they move, instead of what is described; ("branch", name) gives that of a branch.
    tolerance : float, m or rad
        Largest residual of the constraints.

    Returns
    -------
    System, State
        The system (with its dependent equations known) and the consistent start: q, u, accelerations, multipliers.

    Raises
    ------
    CompileError
        If the constraints contradict each other at the described configuration, or a matrix is singular.
    """
    system = compile(model)
    work = system.workspace()
    given, state = state or {}, system.state(t)
    for name, (iq, iu) in system.body_slices.items():
        if name in given:
            state.q[iq], state.u[iu] = given[name]
    for k, branch in enumerate(system.branch_names):
        state.q[system.program.branches + k] = given.get(("branch", branch), state.q[system.program.branches + k])
    system = _regularised(system, state, work, tolerance)
    right = np.zeros(system.nu + system.ng)
    scale = max(1.0, _size(system))
    done = project(system.program, state, work, right, state.q, tolerance * scale, 60)
    if done == -2:
        work.coefficients[:] = (1.0, 0.0, 0.0, 1.0, 0.0)
        evaluate(system.program, state, work)
        raise _singular(system, lu_factor(work.S, system.program.pattern))
    if done < 0:
        g = np.abs(work.equations["g"])
        if not np.all(np.isfinite(g)) or g.max() > tolerance * scale:
            raise CompileError(
                f"Model '{model.name}'",
                found=f"the mechanism cannot be assembled; worst equations: {worst_equations(system, work)}",
                expected="positions that satisfy all joints near the described ones",
                remedy="Check lengths and marker positions of these joints, or move the parts nearer to their places")
    # the dependent equations may be others in the assembled configuration
    system = _regularised(system, state, work, tolerance)
    return system, consistent_start(system, state, work)


def consistent_start(system: System, state: State, work) -> State:
    """Return the state with consistent accelerations and multipliers."""
    right = np.zeros(system.nu + system.ng)
    sweeps = 12 if system.redundant else 2
    failed = accelerations(system.program, state, work, right, sweeps)
    if failed >= 0 or not np.all(np.isfinite(state.a)):
        raise _singular(system, failed)
    residual = np.zeros(system.ng)
    _acceleration_error(system, state, work, residual)
    return state


def _singular(system: System, place: int) -> CompileError:
    """Return the error that names the body or equation at whose place the factorisation found no pivot."""
    unknown = int(system.program.pattern.order[max(place, 0)])
    return CompileError(
        system.owner(unknown), found="the equations of motion are singular here",
        expected="inertia in every freedom of every body, and equations that do not contradict each other",
        remedy="Give the body mass and inertia about all axes, or look at flexmb.check(model) for dependent equations")


def _acceleration_error(system, state, work, residual):
    from flexmb.system.program import constraint_acceleration

    constraint_acceleration(work, state.a, residual)
    worst = float(np.abs(residual).max(initial=0.0))
    largest = float(np.abs(state.a).max(initial=0.0))
    if worst > 1e-5 * (1.0 + largest):
        k = int(np.argmax(np.abs(residual)))
        raise CompileError(
            f"Equation '{system.equation_names[k]}'", found=f"its second derivative misses zero by {worst:.3g}",
            expected="equations that can be satisfied together, in position, velocity and acceleration",
            remedy="Two drives or joints contradict each other: remove one, or make their signals agree")


def _size(system: System) -> float:
    r = system.tables["markers"]["r"]
    return float(np.linalg.norm(r.max(axis=0) - r.min(axis=0))) if len(r) else 1.0


def _equations_of_forces(system: System, work) -> np.ndarray:
    """Return which equations have forces as multipliers, (ng,): those whose gradients have translations."""
    forces = np.zeros(system.ng, bool)
    for leg in work.legs:
        forces[leg["equation"]] |= bool(np.any(leg["gradient"][:3]))
    return forces


def _regularised(system: System, state: State, work, tolerance: float) -> System:
    """Return the system with its dependent equations found at `state`, and its multipliers regularised then."""
    if system.ng == 0:
        return system
    work.coefficients[:] = (1.0, 0.0, 0.0, 1.0, 0.0)
    evaluate(system.program._replace(regularisation=np.zeros(system.ng)), state, work)
    M, G = constraint_matrix(system, work)
    dependent = dependent_equations(M, G)
    scale = equation_scale(M, G)
    # one number for all forces and one for all moments gives those of least norm, unless inertias differ by many orders
    forces = _equations_of_forces(system, work)
    for family in (forces, ~forces):
        scale[family] = np.minimum(scale[family].max(initial=0.0), 1e4 * scale[family])
    scale *= REGULARISATION if len(dependent) else 0.0
    program = system.program._replace(regularisation=scale)
    return replace(system, program=program, redundant=tuple(int(k) for k in dependent))
