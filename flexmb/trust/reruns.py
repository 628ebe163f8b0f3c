"""The same problem solved again: with a tenth of the tolerance, by another integrator, with other modes and meshes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.integrate import simulate, statics
from flexmb.integrate.impulsive import rigid_contacts
from flexmb.model.described import is_number
from flexmb.model.model import Model
from flexmb.results import Instant, Phase, Solution
from flexmb.system import compile as compile_model
from flexmb.trust.fewer_modes import without_highest
from flexmb.trust.settings import another, tighter

__all__ = ["Rerun", "reruns", "whole_window"]

REST = 1e-9
"""Speed, relative to what gravity gives over the size of the model, below which a run begins at rest."""


class Changed(NamedTuple):
    """A model with other modes or meshes, and how it differs in words.

    shapes : of bodies that deform in a subspace, by name, in flexible coordinates of the given body, (m, p)
    """

    model: Model
    what: str
    shapes: Mapping[str, np.ndarray] = {}


COSTLY = 20000
"""Steps of a run above which another integrator does not repeat all of it."""
SHARE = 0.1
"""Of a long run, what another integrator repeats."""


class Rerun(NamedTuple):
    """name : "tolerance", "integrator", "modes" or "mesh"; what : in words; solution : or None with why."""

    name: str
    what: str
    solution: Solution | None
    failure: str = ""


def whole_window(solution: Solution, window) -> tuple[float, float]:
    """Return the window in which another integrator repeats a run, s.

    That given, or the whole run; of a run of many steps a tenth about the time of its greatest kinetic energy.
    """
    first, last = float(solution.t[0]), float(solution.t[-1])
    if window is not None:
        return float(window[0]), float(window[1])
    steps = solution.statistics.get("steps", 0)
    if not is_number(steps) or steps <= COSTLY:
        return first, last
    kinetic = np.concatenate([solution.series(k).energy[:, 0] for k in range(len(solution.phases))])
    middle = float(solution.t[int(np.argmax(kinetic))])
    begin = min(max(middle - 0.5 * SHARE * (last - first), first), last - SHARE * (last - first))
    return begin, begin + SHARE * (last - first)


def reruns(solution: Solution, integrator: Any, window: tuple[float, float]) -> Iterator[Rerun]:
    """Yield every other run of the problem, one after the other."""
    begin, end = float(solution.t[0]), float(solution.t[-1])
    first = solution.phases[0].instant(0)
    settings, what = tighter(integrator)
    yield _run("tolerance", f"a tenth of the tolerance ({what})", solution, first, (begin, end), settings)
    model = solution.phases[0].model
    if not rigid_contacts(model):  # no other integrator follows impulses
        yield _by_another(solution, integrator, window)
    for name, changed in (("modes", _other_modes(model)), ("mesh", _finer(model))):
        if changed is None:
            continue
        try:
            start = _start_of(changed, solution.phases[0])
        except FlexmbError as error:
            yield Rerun(name, changed.what, None, str(error))
            continue
        yield _run(name, changed.what, solution, start, (begin, end), integrator, changed.model)


def _by_another(solution: Solution, integrator: Any, window: tuple[float, float]) -> Rerun:
    """Repeat the window by an integrator of another family."""
    other = another(integrator)
    start, span = _begin(solution, window)
    where = "" if span == (float(solution.t[0]), float(solution.t[-1])) else f", t = {span[0]:.4g} to {span[1]:.4g} s"
    return _run("integrator", f"by {type(other).__name__}{where}", solution, start, span, other)


def _begin(solution: Solution, window) -> tuple[Instant, tuple[float, float]]:
    """Return the last sample before a window, and the window from there to the last sample within."""
    times = solution.t
    k = max(0, int(np.searchsorted(times, window[0], side="right")) - 1)
    number = 0
    while k >= len(solution.phases[number].t):
        k -= len(solution.phases[number].t)
        number += 1
    start = solution.phases[number].instant(k)
    return start, (start.t, float(min(window[1], times[-1])))


def _run(name, what, solution, start, span, integrator, model=None) -> Rerun:
    events = {float(phase.t[-1]) for phase in solution.phases[:-1]}
    times = np.unique(solution.t)
    times = np.array([t for t in times[(times >= span[0]) & (times <= span[1])] if t not in events or t == span[0]])
    if len(times) < 2:
        return Rerun(name, what, None, "the window holds fewer than two samples")
    model = model or start.model
    try:
        found = simulate(
            model, float(times[-1]), t_start=float(times[0]), samples=times, start=start, integrator=integrator
        )
    except FlexmbError as error:
        return Rerun(name, what, None, str(error))
    return Rerun(name, what, found)


def _other_modes(model: Model) -> Changed | None:
    """Return the model with more modes of its reduced bodies if their data have more, else with fewer."""
    bodies, told, shapes = [], [], {}
    for body in model.bodies:
        reduced = getattr(body, "reduced", None)
        have = reduced.n_modes if reduced is not None else 0
        if have == 0 or np.ndim(getattr(body, "damping", 0.0)) == 2:
            bodies.append(body)
            continue
        known = body.data.n_modes
        if have < known:
            bodies.append(replace(body, modes=None))
            told.append(f"{body.name} {known} for {have}")
            continue
        less = without_highest(body.data)
        if less is None:
            bodies.append(body)
            continue
        data, shapes[body.name] = less
        bodies.append(replace(body, data=data, modes=None))
        told.append(f"{body.name} {data.n_modes} for {have}")
    return Changed(replace(model, bodies=tuple(bodies)), f"other modes: {', '.join(told)}", shapes) if told else None


def _finer(model: Model) -> Changed | None:
    """Return the model with twice the elements of its cables and beams."""
    bodies, told = [], []
    for body in model.bodies:
        elements = getattr(body, "elements", None)
        if not isinstance(elements, int):
            bodies.append(body)
            continue
        bodies.append(replace(body, elements=2 * elements))
        told.append(f"{body.name} {2 * elements} for {elements} elements")
    return Changed(replace(model, bodies=tuple(bodies)), f"finer mesh: {', '.join(told)}") if told else None


def _start_of(changed: Changed, phase: Phase) -> Instant | str | None:
    """Return how a changed model begins: as described if the run did, or as the run did, in equilibrium if it rests.

    First-order states are what they were. Finer meshes at rest take the equilibrium from their description.
    """
    model = changed.model
    old, new = compile_model(phase.model), compile_model(model)
    q0, u0, a0 = phase.q[0], phase.u[0], phase.a[0]
    bodies = slice(0, old.program.branches)
    as_described = np.allclose(q0[bodies], old.q0[bodies], rtol=0.0, atol=1e-9) and np.allclose(u0, old.u0, atol=1e-9)
    if as_described:
        return None
    moves = ~old.is_state
    fall = float(np.linalg.norm(model.gravity)) or 1.0
    speed, change = (np.abs(x[moves]).max(initial=0.0) for x in (u0, a0))
    rests = bool(speed <= REST * fall and change <= 1e-3 * fall)
    coarser = [name for name, (iq, _) in new.slices.items() if _grown(iq, old.slices[name][0], name, model)]
    if coarser:
        if rests:
            return "equilibrium"
        raise FlexmbError(
            "verify",
            found=f"the run does not begin as '{coarser[0]}' is described, nor at rest",
            expected="a start that another mesh can have",
            remedy="Simulate from the described start, or from start='equilibrium'",
        )
    start = _carried(changed, phase, old, new)
    if not rests:
        return start
    found = statics(model, t=float(phase.t[0]), state=start, hold_states=True)
    return replace(found.phases[-1].instant(-1), works=np.zeros(3))


def _grown(span: slice, before: slice, name: str, model: Model) -> bool:
    """Has a body another mesh?"""
    return (span.stop - span.start) != (before.stop - before.start) and not model.body(name).has_frame


def _carried(changed: Changed, phase: Phase, old: Any, new: Any) -> Instant:
    """Return the first sample in the coordinates of a changed model.

    Of modes that are left out behind the others nothing remains; a body that deforms in a subspace begins with what
    is next in energy: y = (T^T K T)^-1 T^T K eta.
    """
    q0, u0 = phase.q[0], phase.u[0]
    q, u = new.q0.copy(), new.u0.copy()
    for name, (iq, iu) in new.slices.items():
        jq, ju = old.slices[name]
        n, m = min(iq.stop - iq.start, jq.stop - jq.start), min(iu.stop - iu.start, ju.stop - ju.start)
        q[iq.start : iq.start + n], u[iu.start : iu.start + m] = q0[jq][:n], u0[ju][:m]
        if name in changed.shapes:
            T, K = changed.shapes[name], phase.model.body(name).reduced.stiffness
            onto = np.linalg.solve(T.T @ K @ T, T.T @ K)
            modes, p = T.shape
            q[iq.stop - p : iq.stop] = onto @ q0[jq.stop - modes : jq.stop]
            u[iu.stop - p : iu.stop] = onto @ u0[ju.stop - modes : ju.stop]
    at_old = {name: q0[old.program.branches + k] for k, name in enumerate(old.branch_names)}
    for k, name in enumerate(new.branch_names):
        q[new.program.branches + k] = at_old.get(name, q[new.program.branches + k])
    zero = np.zeros(len(u))
    return Instant(t=phase.t[0], q=q, u=u, a=zero, lam=np.zeros(new.ng), works=np.zeros(3), model=changed.model)
