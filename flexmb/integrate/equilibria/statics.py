"""`statics`: equilibrium with joints and large rotations."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from flexmb.errors import IntegrationError, ModelError
from flexmb.integrate.equilibria.descent import Descent
from flexmb.integrate.equilibria.load_path import ArcLength, LoadSteps, follow
from flexmb.integrate.equilibria.stability import unstable_motion
from flexmb.integrate.impulsive import refuse_impulses
from flexmb.integrate.linear.steady import unsteady_equation
from flexmb.integrate.runs.inversion import EXPECTED, REMEDY, first_inversion
from flexmb.integrate.runs.validity import in_equilibrium
from flexmb.model.described import is_number
from flexmb.model.kinds import Force
from flexmb.model.model import Model
from flexmb.results import SHARED, Phase, Solution, Status
from flexmb.system import assemble, assemble_as_drawn
from flexmb.system import compile as compile_model
from flexmb.system.given_state import given_state, refuse_states
from flexmb.system.holds import refuse_holds
from flexmb.system.mobility import shared_reactions
from flexmb.system.program import evaluate, increment

__all__ = ["equilibrium", "statics"]

FAR = 1.0
"""Lengths of the model, or rad: a search that has moved a part by more may have met a motion that nothing holds."""


def statics(
    model: Model,
    *,
    t: float = 0.0,
    path: ArcLength | LoadSteps | None = None,
    tolerance: float = 1e-9,
    iterations: int = 400,
    state: Any = None,
    hold_states: bool = False,
) -> Solution:
    """Find the equilibrium at time `t`: all accelerations zero, loads and drives at their values of that time.

    Drives that move (a rotor at constant speed) keep their rates: the result then is the steady motion. Every body
    turns at constant speed about an axis, with what springs and undriven joints attach to it; points and nodes have the
    accelerations of this rotation. A mechanism without a steady motion (a crank and its coupler) is refused. The
    iteration is Newton's method with an artificial inertia that fades as the forces come into balance (pseudo-transient
    continuation, Kelley & Keyes 1998). It follows the damped motion of the mechanism downhill, through large rotations,
    also where some freedoms have no stiffness. Near an unstable equilibrium, a pendulum that stands on its head, it may
    end there; in models of up to 300 freedoms that rest, without first-order states or motions without inertia, a
    warning says so. In a model with contacts or stops a
    step that runs far into one of them is taken back, and the inertia fades with the forces alone. If that finds
    nothing, it also fades by the stiffness, as without contacts. The last attempt accepts all steps.

    With a `path`, time is a load factor, and the equilibrium is followed from the one at `path.start` to `t`. Loads
    that are functions of time, such as ``force=(0, 0, fmb.expression("-500*t"))``, grow, stay or fall with it. All is
    at rest then.

    Parameters
    ----------
    model : Model
    t : float, s
    path : ArcLength or LoadSteps, optional
        By arc length past limit points, or in equal load steps up to the first of them.
    tolerance : float
        Largest unbalanced force relative to the largest applied, elastic or (of a steady motion) inertia force in the
        equilibrium. Where none is left there, relative to the largest at the start, if it moves nothing any more.
    iterations : int
    state : Solution or Instant, optional
        Where to begin; by default the assembled start.
    hold_states : bool
        Keep first-order states (of controllers, of forces) at their values of the beginning; else their rates are zero
        in the equilibrium too.

    Returns
    -------
    Solution
        Its last sample is the equilibrium, the others are the path of the iteration. With a `path` a LoadPath: the
        equilibria on it, with the load factors as times, and its limit points. Floating bodies that are used beyond
        their validity in equilibrium are warned of, as in `simulate`.

    Raises
    ------
    ModelError
        If `t`, `tolerance` or `iterations` are not numbers, or `state` does not belong to this model.
    IntegrationError
        If no equilibrium is found, or no steady motion; ``error.solution`` holds the path. If loads grow with time, the
        message says up to which of them there is an equilibrium.
    """
    _check_numbers(t, tolerance, iterations)
    refuse_impulses(model, "statics")
    if path is None:
        return _descend(model, t, tolerance, iterations, state, hold_states=hold_states)
    _check_path(path)
    refuse_states(compile_model(model), "statics along a path")
    first = _descend(model, path.start, tolerance, iterations, state, on_path=True)
    system = first.phases[0].system
    start = system.state(path.start, first.final.q, lam=first.final.lam)
    return follow(model, system, start, path, t, tolerance)


def _check_path(path) -> None:
    if not isinstance(path, ArcLength | LoadSteps):
        raise ModelError(
            "statics",
            found=f"path = {path!r}",
            expected="an ArcLength or LoadSteps object",
            remedy="Write path=flexmb.ArcLength()",
        )


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


def _places(model, t, state) -> dict:
    """Return where `assemble` begins: the places of the given state, which may be far from the drawing, and the
    described velocities."""
    system = compile_model(model)
    given, described = given_state(state, system, "statics"), system.state(t)
    places = {name: (given.q[q], described.u[u]) for name, (q, u) in system.slices.items()}
    return places | {
        ("branch", name): given.q[system.program.branches + k] for k, name in enumerate(system.branch_names)
    }


def equilibrium(model: Model, t: float) -> Solution:
    """Return the equilibrium with which a run begins: as `statics`, but the run watches the validity of its bodies.

    Raises
    ------
    IntegrationError
        There is none. Its solution is None: the steps of a search are no samples of a run.
    """
    try:
        return _descend(model, t, 1e-9, 400, None, watched=False)
    except IntegrationError as error:
        raise IntegrationError(
            error.part,
            found=f"the run cannot begin, nothing of it was computed: {error.found}",
            expected=error.expected,
            remedy=error.remedy,
        ) from None


def _descend(
    model, t, tolerance, iterations, state, on_path: bool = False, hold_states: bool = False, watched: bool = True
) -> Solution:
    """Return the path downhill to the equilibrium at time t."""
    system, start = (
        assemble_as_drawn(model, t=t) if state is None else assemble(model, t=t, state=_places(model, t, state))
    )
    refuse_holds(system, "statics")
    work = system.workspace()
    q = start.q.copy()
    if state is not None:
        given = given_state(state, system, "statics")
        q, start.u[system.is_state] = given.q, given.u[system.is_state]
    sought = system if hold_states else _in_statics(system, start, q)
    if sought is not system:
        work = sought.workspace()
    strikes = any(force.strikes for force in model.forces)
    for wary, smooth in ((True, False), (True, True), (False, True)) if strikes else ((False, True),):
        iteration = Descent(sought, start, work, t, q, at_rest=on_path, wary=wary, smooth=smooth, held=hold_states)
        if found := _found(iteration, tolerance, iterations):
            iteration.share_multipliers()
            break
    count = len(iteration.path) if iteration.lost() else iterations
    status = (
        Status.finished(t)
        if found
        else Status.failed(
            f"no equilibrium after {count} iterations; {_left(iteration)}{_runaway(system, iteration.path)}"
            f"{'' if on_path else _limit_below(model, t)}",
            "Begin nearer to the equilibrium, add supports (a drive, a joint) to free motions, or raise iterations; "
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
    told = []
    if not (on_path or iteration.motion.u.any() or iteration.states.any()):
        leaves = unstable_motion(iteration.tangent, iteration.extent, iteration.largest / iteration.size)
        told = [] if leaves is None else [_unstable(system, *leaves)]
    return _watched(solution, told, look=watched)


def _found(iteration: Descent, tolerance: float, iterations: int) -> bool:
    """Iterate; is the equilibrium found? Not if the search leaves all bounds: there it ends."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        for _ in range(iterations):
            if iteration.balanced(tolerance):
                return True
            if iteration.lost():
                return False
            iteration.advance()
    return False


def _in_statics(system, start, q: np.ndarray):
    """Return the system with what stands for its forces while an equilibrium is sought from a configuration."""
    if all(type(force).in_statics is Force.in_statics for force in system.model.forces):
        return system
    work, now = system.workspace(), system.state(start.t, q, u=start.u, lam=start.lam)
    evaluate(system.program, now, work)
    forces = [force.in_statics(system, now, work.markers) for force in system.model.forces]
    same = all(one is other for one, other in zip(forces, system.model.forces, strict=True))
    return system if same else compile_model(replace(system.model, forces=forces))


def _unstable(system, freedom: int, seconds: float) -> str:
    """Return the words about a motion that leaves an equilibrium by itself, and grows by e in some seconds."""
    return (
        f"Model '{system.model.name}': the equilibrium is unstable: the smallest push moves {system.owner(freedom)} "
        f"away from it, e times as far every {seconds:.3g} s; expected: a stable equilibrium. Begin nearer to one "
        "(state=, or other places in the model), or add what holds this motion."
    )


def _watched(solution: Solution, sentences: list[str], look: bool) -> Solution:
    """Return the solution with what its bodies are valid for in equilibrium, its last sample; warn beyond that, if
    asked to look at it, and by some sentences more."""
    (phase,) = solution.phases
    some = slice(-1, None) if look else slice(0)
    last = replace(phase, **{name: getattr(phase, name)[some] for name in ("t", "q", "u", "a", "lam", "works")})
    return replace(solution, statistics={**solution.statistics, **in_equilibrium(last, told=sentences)})


def _left(iteration: Descent) -> str:
    """Say what is out of balance at the end of a search."""
    if iteration.lost():
        return "the search has left all bounds"
    return f"unbalanced force {iteration.unbalanced:.3g} N on {iteration.most_unbalanced()}"


def _runaway(system, path) -> str:
    """Say which part a search has moved by more than the size of the model or a radian, if it has."""
    for k, row in enumerate(path[1:], 1):
        moved = np.zeros(system.nu)
        increment(system.program, path[0][0], row[0], moved)
        share = np.abs(moved) * np.where(system.is_state, 0.0, system.units)
        if not np.all(np.isfinite(share)):
            return ""
        worst = int(np.argmax(share))
        if share[worst] > FAR:
            unit = "rad" if "rotation" in system.owner(worst) else "m"
            return (
                f"; in iteration {k} it had moved {system.owner(worst)}, by {moved[worst]:.3g} {unit}: perhaps nothing "
                "holds this motion against the loads"
            )
    return ""


def _limit_below(model, t: float) -> str:
    """Say at which load on the way from zero to time t the equilibrium ends, if that is why none was found."""
    if t == 0.0:
        return ""
    try:
        statics(model, t=t, path=LoadSteps(steps=1))
    except IntegrationError as error:
        return f"; on the way from t = 0: {error.found}"
    return ""


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
