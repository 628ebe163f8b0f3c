"""`statics`: equilibrium with joints and large rotations."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from flexmb.errors import IntegrationError
from flexmb.integrate.extent import extents, model_size
from flexmb.integrate.matrices import tangent_at
from flexmb.model.model import Model
from flexmb.results import Phase, Solution, Status
from flexmb.system import assemble
from flexmb.system.program import advance, evaluate

__all__ = ["statics"]


def _rates_of_drives(system, state, work) -> np.ndarray:
    """Return the velocity (nu,) of least kinetic energy that the drives ask for, without deformation rates.

    Deformation is made heavy for that: a reduced body then turns with its drive instead of bending at the hub.
    """
    work.coefficients[3] = 0.0
    evaluate(system.program, state, work)
    rate = work.equations["rate"].copy()
    if not np.any(rate):
        return np.zeros(system.nu)
    tangent = tangent_at(system, state, work)
    heavy = np.zeros(system.nu)
    for body in system.model.bodies:
        if body.has_frame and body.n_vector:
            span = system.body_slices[body.name][1]
            heavy[span.start + 6 : span.stop] = 1e8 * tangent.M.diagonal()[span.start + 6 : span.stop]
    matrix = _saddle(tangent.M + sparse.diags(heavy), tangent, 1e-18)
    return splu(matrix).solve(np.concatenate([np.zeros(system.nu), -rate]))[: system.nu]


def _saddle(block, tangent, epsilon: float) -> sparse.csc_matrix:
    scale = epsilon * max(1e-300, abs(block).max())
    return sparse.bmat([[block, -tangent.L], [tangent.G, -scale * sparse.identity(tangent.G.shape[0])]], format="csc")


def statics(model: Model, *, t: float = 0.0, tolerance: float = 1e-9, iterations: int = 400,
            state: Any = None) -> Solution:
    """Find the equilibrium at time `t`: all accelerations zero, loads and drives at their values of that time.

    Drives that move (a rotor at constant speed) keep their rates: the result then is the steady motion, at rest in the
    body frames. The iteration is Newton's method with an artificial inertia that fades as the forces come into balance
    (pseudo-transient continuation, Kelley & Keyes 1998): it follows the damped motion of the mechanism downhill, so it
    finds a stable equilibrium through large rotations, also where some freedoms have no stiffness.

    Parameters
    ----------
    model : Model
    t : float, s
    tolerance : float
        Largest unbalanced force relative to the largest applied or elastic one.
    iterations : int
    state : Instant, optional
        Where to begin; by default the assembled start.

    Returns
    -------
    Solution
        Its last sample is the equilibrium, the others are the path of the iteration.

    Raises
    ------
    IntegrationError
        If no equilibrium is found; ``error.solution`` holds the path.
    """
    system, start = assemble(model, t=t)
    q = start.q.copy() if state is None else np.array(state.q, float)
    work = system.workspace()
    size = model_size(system)
    extent, _ = extents(system, start, work, size, 1e-4 * size)
    lam = np.zeros(system.ng)
    path: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    step, before, largest = None, np.inf, 0.0
    ended, found = "failed", False
    for iteration in range(iterations):
        now = system.state(t, q, lam=lam)
        now.u[:] = _rates_of_drives(system, now, work)
        tangent = tangent_at(system, now, work)
        force, g = work.residual.copy(), work.equations["g"].copy()
        lam_force = np.abs(tangent.L) @ np.abs(lam) if system.ng else 0.0
        largest = max(largest, float(np.max(np.abs(force / extent), initial=0.0)) if iteration == 0 else 0.0,
                      float(np.max(lam_force / extent, initial=0.0)))
        unbalanced = float(np.max(np.abs(force / extent), initial=0.0))
        path.append((q.copy(), now.u.copy(), lam.copy()))
        if unbalanced <= tolerance * max(largest, 1e-30) and np.max(np.abs(g), initial=0.0) <= 1e-9 * size:
            ended, found = "finished", True
            break
        if step is None:
            # first pseudo time: the unbalanced forces may move the model by a hundredth of its size
            pull = np.abs(force) * extent / np.maximum(tangent.M.diagonal(), 1e-300)
            step = np.sqrt(0.02 * size / max(np.max(pull, initial=0.0), 1e-30))
        elif np.isfinite(unbalanced):
            step *= min(4.0, max(0.3, (before / max(unbalanced, 1e-300)) ** 0.7))
        before = unbalanced
        block = tangent.M / step**2 + tangent.K
        try:
            x = splu(_saddle(block, tangent, 1e-13)).solve(-np.concatenate([force, g]))
        except RuntimeError:
            step *= 0.5
            continue
        stride = np.max(np.abs(x[: system.nu]) * extent, initial=0.0) / size
        if stride > 0.2:
            step *= 0.5
        advanced = np.zeros(system.nq)
        scale = min(1.0, 0.3 / stride) if stride > 0.0 else 1.0
        advance(system.program, q, x[: system.nu], scale, advanced)
        q = advanced
        lam = lam + scale * x[system.nu :]
    status = Status.finished(t) if found else Status.failed(
        f"no equilibrium after {iterations} iterations; unbalanced force {before:.3g} N",
        "Begin nearer to the equilibrium, add supports to free motions, or raise iterations")
    solution = _solution(model, system, t, path, status, ended)
    if not found:
        raise IntegrationError(f"Model '{model.name}'", found=status.message, expected="a stable equilibrium",
                               remedy=status.remedy, solution=solution)
    return solution


def _solution(model, system, t, path, status, ended) -> Solution:
    q, u, lam = (np.array([row[k] for row in path]) for k in range(3))
    n = len(path)
    phase = Phase(model=model, system=system, t=np.full(n, t), q=q, u=u, a=np.zeros((n, system.nu)),
                  lam=lam.reshape(n, system.ng), works=np.zeros((n, 3)), ended=ended)
    return Solution(phases=(phase,), status=status, statistics={"iterations": n})
