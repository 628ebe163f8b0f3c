"""Which force, drive or equation is no longer finite when a run cannot continue: sqrt(1 - t) after one second."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexmb.math.weights import no_matrix
from flexmb.system.observe import observe
from flexmb.system.program import advance, constraint_acceleration, constraint_velocity, evaluate

__all__ = ["REMEDY", "unknown_on_the_way", "unknown_value", "what_is_unknown"]

REMEDY = "Correct its signals, its function or its table, so that it is a number until the end"
LOOKS, HALVINGS = 64, 50
FARTHER = 1.5
"""Of the time from the last sample to where a run failed: how far its motion is followed at constant acceleration."""


def what_is_unknown(system, start, known, reached: float, gone, now: float, times) -> str | None:
    """Return the sentence about what has no finite value, after the last sample that is known, if there is one."""
    q, u, a = (start.q, start.u, start.a) if known is None else (known[name][-1] for name in "qua")
    begin = now if known is None else float(known["t"][-1])
    unknown = unknown_value(system, q, u, begin, float(next((t for t in times if t > begin), times[-1])))
    return unknown or (None if gone else unknown_on_the_way(system, begin, q, u, a, reached))


def unknown_value(system, q: np.ndarray, u: np.ndarray, begin: float, end: float) -> str | None:
    """Return a sentence about the first force, drive or equation without a finite value after `begin`, or None.

    The configuration comes from the last sample, so values that depend on time only are found exactly.

    Parameters
    ----------
    q, u : (nq,), (nu,)
        The last state that is known.
    begin, end : float, s
        Its time, and that which the run tried to reach.
    """
    poles = system.signal_times.between(begin, end).breaks  # 1/(t - 0.52) has no value at one time alone
    model, times = system.model, np.union1d(np.linspace(begin, end, LOOKS + 1), poles[(poles > begin) & (poles < end)])
    for joint in model.joints:
        given = [getattr(joint, name, None) for name in ("angle", "displacement")] if joint.prescribes else []
        for signal in given:
            found = None if signal is None else _first(signal.sample, times)
            if found is not None:
                where = f"{joint.title}{_bodies(joint, model)}"
                return f"{where}: its signal with its two rates is {_text(found[1])} from t = {found[0]:.9g} s on"
    return _of_forces(system, q, u, times) or _of_equations(system, q, u, times)


def unknown_on_the_way(system, begin: float, q, u, a, reached: float) -> str | None:
    """Return a sentence about the first block or force without a finite value where the motion leads, or None.

    What follows measurements has a value at the last sample: it is lost on the way from there, which is followed at
    constant acceleration.

    Parameters
    ----------
    begin : float, s
        Time of the last sample.
    q, u, a : (nq,), (nu,), (nu,)
        Its state.
    reached : float, s
        Where the run failed.
    """
    if not (system.model.forces or system.states) or not reached > begin:
        return None
    work, then, rest = system.workspace(), np.zeros(system.nq), [np.zeros((1, n)) for n in (system.nu, system.ng)]
    numbers = [system.force_index[force.name] for force in system.model.forces]
    for h in FARTHER * (reached - begin) * np.arange(1, LOOKS + 1) / LOOKS:
        advance(system.program, q, u + 0.5 * h * a, h, then)
        speed = u + h * a
        if not (np.isfinite(then).all() and np.isfinite(speed).all()):
            return None
        no_matrix(work.weights)
        evaluate(system.program, system.state(begin + h, then, speed), work)
        for group in system.states:
            rates = work.markers["wrench"][group.marker : group.marker + group.markers].ravel()[: len(group.names)]
            for name, rate in zip(group.names, rates, strict=True):
                if not np.isfinite(rate):
                    return f"{group.title}: the rate of its state '{name}' is {rate} {_WAY}"
        if not numbers or np.isfinite(work.residual).all():
            continue
        seen = observe(system, np.array([begin + h]), then[None], speed[None], *rest).force[0, numbers]
        for force, wrench in zip(system.model.forces, seen, strict=True):
            if not np.isfinite(wrench).all():
                where = f"{force.title}{_bodies(force, system.model)}"
                return f"{where}: its force and moment are {_text(wrench)} {_WAY}"
    return None


_WAY = "where the motion leads after its last sample"


def _of_forces(system, q: np.ndarray, u: np.ndarray, times: np.ndarray) -> str | None:
    model = system.model
    if not model.forces:
        return None
    numbers = [system.force_index[force.name] for force in model.forces]

    def forces(t: np.ndarray) -> np.ndarray:
        still = [np.zeros((len(t), n)) for n in (system.nu, system.ng)]
        seen = observe(system, t, np.tile(q, (len(t), 1)), np.tile(u, (len(t), 1)), *still)
        return seen.force[:, numbers].reshape(len(t), -1)

    found = _first(forces, times)
    if found is None:
        return None
    wrench = found[1].reshape(-1, 6)
    k = int(np.flatnonzero(~np.isfinite(wrench).all(axis=1))[0])
    wrong = model.forces[k]
    where = f"{wrong.title}{_bodies(wrong, model)}"
    return f"{where}: its force and moment are {_text(wrench[k])} from t = {found[0]:.9g} s on"


def _of_equations(system, q: np.ndarray, u: np.ndarray, times: np.ndarray) -> str | None:
    """Tell of an equation whose residual, rate or second rate ends: 0.5 sqrt(1 - 2 t) has infinite rates at its end."""
    if not system.ng:
        return None
    work, rest = system.workspace(), np.zeros(system.nu)

    def numbers(t: np.ndarray) -> np.ndarray:
        found = np.zeros((len(t), system.ng, 3))
        for row, now in zip(found, t, strict=True):
            no_matrix(work.weights)
            evaluate(system.program, system.state(float(now), q, u), work)
            first, second = np.zeros((2, system.ng))
            constraint_velocity(work, u, first)
            constraint_acceleration(work, rest, second)
            row[:] = np.stack([work.equations["g"], first, second], axis=1)
        return found.reshape(len(t), -1)

    found = _first(numbers, times)
    if found is None:
        return None
    values = found[1].reshape(-1, 3)
    k = int(np.flatnonzero(~np.isfinite(values).all(axis=1))[0])
    joint = system.joints[system.equation_owners[k][0]]
    kind = system.equation_names[k].rpartition(": ")[2]
    where = f"{joint.title}{_bodies(joint, system.model)}"
    return f"{where}: its equation '{kind}' with its two rates is {_text(values[k])} from t = {found[0]:.9g} s on"


def _bodies(part, model) -> str:
    """Return " on Body 'a', Body 'b'", as far as the part names markers."""
    places = (*(getattr(part, "markers", None) or ()), getattr(part, "marker", None))
    names = dict.fromkeys(place.rpartition(".")[0] for place in places if isinstance(place, str) and place)
    titles = [model.body(name).title for name in names if any(body.name == name for body in model.bodies)]
    return f" on {', '.join(titles)}" if titles else ""


def _first(values: Callable, times: np.ndarray) -> tuple[float, np.ndarray] | None:
    """Return the first time at which values (nt, n) are not all finite, by halving, and they."""
    unsound = ~np.isfinite(values(times)).all(axis=1)
    if not unsound.any():
        return None
    k = int(unsound.argmax())
    good, bad = float(times[max(k - 1, 0)]), float(times[k])
    for _ in range(HALVINGS if k else 0):
        middle = 0.5 * (good + bad)
        sound = bool(np.isfinite(values(np.array([middle]))).all())
        good, bad = (middle, bad) if sound else (good, middle)
    return bad, values(np.array([bad]))[0]


def _text(values: np.ndarray) -> str:
    return np.array2string(values, precision=4, max_line_width=200)
