"""`statics`: equilibrium with joints and large rotations."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse.linalg import splu

from flexmb.errors import IntegrationError, ModelError
from flexmb.integrate.extent import extents, model_size
from flexmb.integrate.inversion import EXPECTED, REMEDY, first_inversion
from flexmb.integrate.load_path import ArcLength, LoadSteps, follow
from flexmb.integrate.matrices import tangent_at
from flexmb.integrate.steady import saddle, steady_motion, unsteady_equation
from flexmb.model.described import is_number
from flexmb.model.model import Model
from flexmb.results import SHARED, Phase, Solution, Status
from flexmb.system import assemble
from flexmb.system.given_state import given_state
from flexmb.system.mobility import mass_metric, shared_reactions
from flexmb.system.program import advance, evaluate, keep_branches

__all__ = ["statics"]


def statics(
    model: Model,
    *,
    t: float = 0.0,
    path: ArcLength | LoadSteps | None = None,
    tolerance: float = 1e-9,
    iterations: int = 400,
    state: Any = None,
) -> Solution:
    """Find the equilibrium at time `t`: all accelerations zero, loads and drives at their values of that time.

    Drives that move (a rotor at constant speed) keep their rates: the result then is the steady motion. Every body
    turns at constant speed about an axis, with what springs and undriven joints attach to it; points and nodes have the
    accelerations of that. A mechanism that cannot go on steadily (a crank and its coupler) is refused. The iteration is
    Newton's method with an artificial inertia that fades as the forces come into balance (pseudo-transient
    continuation, Kelley & Keyes 1998): it follows the damped motion of the mechanism downhill, so it finds a stable
    equilibrium through large rotations, also where some freedoms have no stiffness. In a model with contacts or stops a
    step that runs far into one of them is taken back; if that leads nowhere, all steps stand.

    With a `path`, time is a load factor, and the equilibrium is followed from the one at `path.start` to `t`: loads
    that are functions of time, as ``force=(0, 0, fmb.expression("-500*t"))``, grow, stay or fall with it. All is at
    rest then.

    Parameters
    ----------
    model : Model
    t : float, s
    path : ArcLength or LoadSteps, optional
        By arc length past limit points, or in equal load steps up to the first of them.
    tolerance : float
        Largest unbalanced force relative to the largest applied, elastic or (of a steady motion) inertia force.
    iterations : int
    state : Solution or Instant, optional
        Where to begin; by default the assembled start.

    Returns
    -------
    Solution
        Its last sample is the equilibrium, the others are the path of the iteration. With a `path` a LoadPath: the
        equilibria on it, with the load factors as times, and its limit points.

    Raises
    ------
    ModelError
        If `t`, `tolerance` or `iterations` are no numbers, or `state` is none of this model.
    IntegrationError
        If no equilibrium is found, or no steady motion; ``error.solution`` holds the path. If loads grow with time, the
        message says up to which of them there is an equilibrium.
    """
    _check_numbers(t, tolerance, iterations)
    if path is None:
        return _descend(model, t, tolerance, iterations, state)
    if not isinstance(path, ArcLength | LoadSteps):
        raise ModelError(
            "statics",
            found=f"path = {path!r}",
            expected="an ArcLength or LoadSteps object",
            remedy="Write path=flexmb.ArcLength()",
        )
    first = _descend(model, path.start, tolerance, iterations, state, on_path=True)
    system = first.phases[0].system
    start = system.state(path.start, first.final.q, lam=first.final.lam)
    return follow(model, system, start, path, t, tolerance)


def _check_numbers(t, tolerance, iterations) -> None:
    if not is_number(t):
        raise ModelError("statics", found=f"t = {t!r}", expected="a time, s, or a load factor", remedy="Write t=1.0")
    for name, value, least in (("tolerance", tolerance, 0.0), ("iterations", iterations, 1)):
        whole = isinstance(least, float) or isinstance(value, int | np.integer)
        if not is_number(value) or value < least or not whole:
            raise ModelError(
                "statics",
                found=f"{name} = {value!r}",
                expected="a whole number >= 1" if least else "a number >= 0",
                remedy=f"Leave {name} out",
            )


def _descend(model, t, tolerance, iterations, state, on_path: bool = False) -> Solution:
    """Return the path downhill to the equilibrium at time t."""
    system, start = assemble(model, t=t)
    work = system.workspace()
    q = start.q.copy() if state is None else given_state(state, system, "statics").q
    for wary in (True, False) if any(force.strikes for force in model.forces) else (False,):
        iteration = _Descent(system, start, work, t, q, at_rest=on_path, wary=wary)
        if found := any(iteration.balanced(tolerance) or iteration.advance() for _ in range(iterations)):
            break
    status = (
        Status.finished(t)
        if found
        else Status.failed(
            f"no equilibrium after {iterations} iterations; unbalanced force {iteration.unbalanced:.3g} N on "
            f"{iteration.most_unbalanced()}{'' if on_path else _limit_below(model, t)}",
            "Begin nearer to the equilibrium, add supports to free motions, or raise iterations; "
            "follow a structure that "
            "buckles with path=flexmb.ArcLength()",
        )
    )
    solution = _solution(model, system, t, iteration.path, status)
    wrong = first_inversion(system, iteration.q[None]) if found else None
    if wrong is not None:
        raise IntegrationError(
            wrong.title, found=f"in equilibrium {wrong.found}", expected=EXPECTED, remedy=REMEDY, solution=solution
        )
    if not found:
        raise IntegrationError(
            f"Model '{model.name}'",
            found=status.message,
            expected="a stable equilibrium",
            remedy=status.remedy,
            solution=solution,
        )
    unsteady = unsteady_equation(system, iteration.now, work)
    if unsteady is not None:
        raise IntegrationError(
            f"Model '{model.name}'",
            found="its drives move it, but not steadily: going on with constant speeds, "
            f"'{system.equation_names[unsteady]}' would be violated",
            expected="drives at rest, or a steady rotation",
            remedy="Use kinematics, or simulate, for a moving mechanism; for its equilibrium at "
            "rest give the drive a number",
            solution=solution,
        )
    return solution


def _limit_below(model, t: float) -> str:
    """Say at which load on the way from zero to time t the equilibrium ends, if that is why none was found."""
    if t == 0.0:
        return ""
    try:
        statics(model, t=t, path=LoadSteps(steps=1))
    except IntegrationError as error:
        return f"; on the way from t = 0: {error.found}"
    return ""


_PLACE = ("q", "lam", "now", "motion", "tangent", "force", "g", "unbalanced")


class _Descent:
    """Newton's method with an artificial inertia M / step^2 that fades with the unbalanced forces."""

    def __init__(self, system, start, work, t: float, q: np.ndarray, at_rest: bool, wary: bool):
        self.at_rest, self.wary = at_rest, wary
        self.system, self.work, self.t, self.q = system, work, t, q
        self.size = model_size(system)
        self.extent, _ = extents(system, start, work, self.size, 1e-4 * self.size)
        self.lam = np.zeros(system.ng)
        self.path: list[tuple[np.ndarray, ...]] = []
        self.step, self.first, self.unbalanced, self.largest = 0.0, 0.0, np.inf, 0.0
        self.before: dict[str, Any] = {}

    def balanced(self, tolerance: float) -> bool:
        """Evaluate the forces at the present configuration; are they in balance, and the constraints satisfied?"""
        now = self.system.state(self.t, self.q, u=np.zeros(self.system.nu), lam=self.lam)
        self.now, self.motion = now, steady_motion(self.system, now, self.work, known=self.at_rest)
        now.u[:], now.a[:] = self.motion.u, self.motion.a
        self.tangent = tangent_at(self.system, now, self.work)
        keep_branches(self.system.program, self.work, self.q)
        self.force, self.g = self.work.residual.copy(), self.work.equations["g"].copy()
        before, self.unbalanced = self.unbalanced, self._greatest(self.force / self.extent)
        if self.wary and self.path and not self.unbalanced <= max(30.0 * before, self.largest):
            self.__dict__.update(self.before)
            self.step *= 0.1
            self.wary = self.step > 1e-9 * self.first
            return False
        reactions = abs(self.tangent.L) @ np.abs(self.lam)
        self.largest = max(
            self.largest,
            self._greatest(reactions / self.extent),
            self._inertia(now.u),
            self.unbalanced if not self.path else 0.0,
        )
        self.path.append((self.q.copy(), now.u, now.a, self.lam.copy()))
        if len(self.path) == 1:
            # first pseudo time: the unbalanced forces may move the model by a hundredth of its size
            pull = self._greatest(self.force * self.extent / mass_metric(self.tangent.M))
            self.step = self.first = np.sqrt(0.02 * self.size / max(pull, 1e-30))
        elif np.isfinite(self.unbalanced):
            self.step *= min(4.0, max(0.3, (before / max(self.unbalanced, 1e-300)) ** 0.7))
        return self._greatest(self.g) <= 1e-9 * self.size and (
            self.unbalanced <= max(tolerance * self.largest, 1e-30) or self._rounded(before)
        )

    def _rounded(self, before: float) -> bool:
        """Are the unbalanced forces what rounding the positions makes? Without any load, these are all there are.

        They are below what the stiffest direction makes of the last digit, and either an iteration leaves them as large
        as they were `before`, or the last digits of these coordinates do make them: a small load on a soft direction,
        as on a thin plate, is below the first bound too.
        """
        stiffest = self._greatest((abs(self.tangent.K) @ self._magnitudes()) / self.extent)
        if self.unbalanced > 1e-16 * stiffest:
            return False
        if 0.1 * before <= self.unbalanced:
            return True
        made, digits = np.zeros(self.system.nu), np.random.default_rng(0)
        self.work.coefficients[3] = 0.0
        for _ in range(3):
            near = self.q * (1.0 + np.finfo(float).eps * digits.choice((-1.0, 1.0), len(self.q)))
            evaluate(self.system.program, self.now._replace(q=near), self.work)
            made = np.maximum(made, np.abs(self.work.residual - self.force))
        return bool(np.all(np.abs(self.force) <= 10.0 * made))

    def _magnitudes(self) -> np.ndarray:
        """Return the size of the numbers (nu,) that are rounded: the model's, or of nodes their vectors themselves."""
        magnitudes = self.size / self.extent
        for iq, iu, count, flexible in self.system.program.vectors:
            if not flexible:
                own = np.linalg.norm(self.q[iq : iq + count].reshape(-1, 3), axis=1)
                magnitudes[iu : iu + count] = np.repeat(own, 3)
        return magnitudes

    def _inertia(self, u: np.ndarray) -> float:
        """Return the size of the inertia forces of a steady motion: they cancel where a rotor is balanced."""
        rate = self._greatest(u * self.extent) / self.size
        return rate * self._greatest((abs(self.tangent.M) @ np.abs(u)) / self.extent)

    def advance(self) -> bool:
        """Move by one iteration, at most three tenths of the model's size; never done by itself."""
        self.before = {name: getattr(self, name) for name in _PLACE}
        # the velocities of a steady motion turn with the bodies
        tangent, motion = self.tangent, self.motion
        block = tangent.M / self.step**2 + tangent.K + tangent.D @ motion.turning + tangent.M @ motion.centripetal
        try:
            x = splu(saddle(block, tangent.L, tangent.G, 1e-12)).solve(-np.concatenate([self.force, self.g]))
        except RuntimeError:  # exactly singular: more inertia helps
            self.step *= 0.5
            return False
        stride = self._greatest(x[: self.system.nu] * self.extent) / self.size
        if stride > 0.2:
            self.step *= 0.5
        scale = min(1.0, 0.3 / stride) if stride > 0.0 else 1.0
        q = np.zeros(self.system.nq)
        advance(self.system.program, self.q, x[: self.system.nu], scale, q)
        self.q, self.lam = q, self.lam + scale * x[self.system.nu :]
        return False

    def most_unbalanced(self) -> str:
        """Return the title of the body on which most force is left."""
        return self.system.owner(int(np.argmax(np.abs(self.force / self.extent)))).partition(",")[0]

    @staticmethod
    def _greatest(x: np.ndarray) -> float:
        return float(np.max(np.abs(x), initial=0.0))


def _solution(model, system, t, path, status) -> Solution:
    q, u, a, lam = (np.array([row[k] for row in path]) for k in range(4))
    n = len(path)
    phase = Phase(
        model=model,
        system=system,
        t=np.full(n, t),
        q=q,
        u=u,
        a=a,
        lam=lam.reshape(n, system.ng),
        works=np.zeros((n, 3)),
        ended=status.kind,
    )
    shared = shared_reactions(system, system.state(t, q[-1], u[-1]))
    known: dict[str, Any] = {SHARED: shared} if shared else {}
    return Solution(phases=(phase,), status=status, statistics={"iterations": n, **known})
