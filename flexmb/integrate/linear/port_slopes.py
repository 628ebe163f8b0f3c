"""How accelerations and sensors answer small changes of the state and of signals: differences of fourth order.

Every change is made along the exact tangents of the constraints, and accelerations and multipliers are solved for
again. So a change of one freedom moves all bodies that follow it, and a reaction changes with everything that carries
it. A drive s prescribes g(q) = s(t): q changes with s, the velocities with s' and the accelerations with s''.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_matrix

from flexmb.errors import ModelError, ValidityWarning
from flexmb.integrate.linear.driven import driven_accelerations, prescribed
from flexmb.integrate.linear.ports import InputPort, NamedInput, OutputPort
from flexmb.integrate.matrices import tangent_at
from flexmb.model.signal import expression
from flexmb.results import Phase, Solution, Status
from flexmb.system import compile as compile_model
from flexmb.system.accelerations import accelerations, settled_accelerations
from flexmb.system.mobility import mass_metric
from flexmb.system.program import advance, evaluate

__all__ = ["Slopes", "signal_slopes", "state_slopes"]

STEP, RATE = 1e-4, 1e-5
"""Of the length of the assembly and rad, and of both per second."""
SHARE = 1e-2
"""Of a signal that prescribes nothing: forces are linear in theirs, so large steps lose least."""
WAYS = (1.0, -1.0, 2.0, -2.0)
KINK = 3.0
"""Growth of the even part from one step to the double one: 4 of smooth quantities, 2 at a kink."""
EVEN = 1e-6
"""Even part, relative to the values, below which it is rounding."""
ROUNDED = 1e-15
"""Change, relative to the largest column of a sensor, that is rounding: the moments in a hinge without friction."""
POLYNOMIALS = ("e", "e * (t - t0)", "0.5 * e * (t - t0) ** 2")


class Slopes(NamedTuple):
    """Derivatives by n changes, and the difference between second and fourth order, which bounds their error."""

    a: np.ndarray
    """(nu, n)"""
    y: np.ndarray
    """(ny, n)"""
    error: np.ndarray
    """(ny, n)"""


class _Probe:
    """Collects states, and reads the outputs of one system at all of them."""

    def __init__(self, system, state, outputs: list[OutputPort]):
        self.system, self.state, self.outputs = system, state, outputs
        self.work = system.workspace()
        # an equilibrium takes drives that speed up at their positions of the moment
        held = np.zeros(system.ng) if np.any(state.a) else prescribed(system, state, self.work)
        self.held = held if np.any(held) else None

    def rows(self, system, dx: np.ndarray, du: np.ndarray, ways) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations (nw, nu) and outputs (nw, ny) of the states q + way dx, u + way du."""
        size = system.nu + system.ng
        q, u, a, lam = [], [], [], []
        for way in ways:
            now = system.state(self.state.t, self.state.q, self.state.u + way * du)
            advance(system.program, self.state.q, dx, way, now.q)
            right, sweeps = np.zeros(size), 12 if system.redundant else 4
            found = accelerations(system.program, now, self.work, right, sweeps) < 0
            if not (found and settled_accelerations(system, now, self.work, right)):
                raise ModelError(
                    "linearize",
                    found="the equations of motion have no solution near the state",
                    expected="masses and constraints that determine the accelerations",
                    remedy="Ask flexmb.check(model) what is free of inertia",
                )
            if self.held is not None:
                driven = driven_accelerations(system, now, self.work, self.held)
                now.a[:], now.lam[:] = now.a - driven[0], now.lam - driven[1]
            for family, values in zip((q, u, a, lam), (now.q, now.u, now.a, now.lam), strict=True):
                family.append(values.copy())
        arrays = [np.array(family).reshape(len(ways), -1) for family in (q, u, a, lam)]
        return arrays[2], self._read(system, *arrays)

    def _read(self, system, q, u, a, lam) -> np.ndarray:
        n = len(q)
        phase = Phase(
            model=system.model,
            system=system,
            t=np.full(n, self.state.t),
            q=q,
            u=u,
            a=a,
            lam=lam,
            works=np.full((n, 3), np.nan),  # nobody knows them at an instant
            ended="finished",
        )
        series = Solution(phases=(phase,), status=Status.finished(), statistics={}).series()
        known: dict[str, np.ndarray] = {}
        for port in self.outputs:
            name = port.sensor.name
            if name not in known:
                known[name] = np.asarray(port.sensor.values(series), float).reshape(n, -1)
        columns = [known[port.sensor.name][:, port.column] for port in self.outputs]
        for port, column in zip(self.outputs, columns, strict=True):
            if not np.all(np.isfinite(column)):
                raise ModelError(
                    "linearize",
                    found=f"output '{port.name}' has no value at this state",
                    expected="a quantity that positions, velocities, accelerations and reactions determine",
                    remedy="Leave it out; works and extreme values need a simulation",
                )
        return np.array(columns).reshape(len(columns), n).T

    def _largest(self, values: np.ndarray) -> np.ndarray:
        """Return for each output the largest of the values (ny,) of its sensor."""
        own = np.array([port.sensor.name for port in self.outputs])
        return np.array([values[own == name].max() for name in own])

    def slopes(self, changes: list[tuple[np.ndarray, np.ndarray, float]], systems: Callable) -> Slopes:
        """Return the derivatives by changes (dx, du, step); `systems(k, way)` is the system that is changed so."""
        nu, ny = self.system.nu, len(self.outputs)
        found = Slopes(np.zeros((nu, len(changes))), np.zeros((ny, len(changes))), np.zeros((ny, len(changes))))
        _, middle = self.rows(self.system, np.zeros(nu), np.zeros(nu), (0.0,))
        kinks: set[str] = set()
        for k, (dx, du, step) in enumerate(changes):
            pairs = [self.rows(systems(k, way * step), dx, du, (way * step,)) for way in WAYS]
            a, y = (np.array([pair[i][0] for pair in pairs]) for i in range(2))
            found.a[:, k] = (8.0 * (a[0] - a[1]) - (a[2] - a[3])) / (12.0 * step)
            found.y[:, k] = (8.0 * (y[0] - y[1]) - (y[2] - y[3])) / (12.0 * step)
            found.error[:, k] = np.abs(found.y[:, k] - (y[0] - y[1]) / (2.0 * step))
            near, far = (np.abs(y[i] + y[i + 1] - 2.0 * middle[0]) for i in (0, 2))
            size = self._largest(np.abs(middle[0]) + np.abs(y).max(axis=0))
            nothing = np.abs(y - middle[0]).max(axis=0) <= ROUNDED * size
            found.y[nothing, k] = found.error[nothing, k] = 0.0
            bent = (near > EVEN * size) & (far < KINK * near)
            kinks |= {port.name for port, is_bent in zip(self.outputs, bent, strict=True) if is_bent}
        if kinks:
            warnings.warn(
                f"Model '{self.system.model.name}', linearize: {', '.join(sorted(kinks))} has a kink at this state, so "
                "that its slope is the mean of both sides. Expected: a smooth quantity. Measure components instead of "
                "amounts, or start from a state away from the kink",
                ValidityWarning,
                stacklevel=4,
            )
        return found


def state_slopes(system, state, places: np.ndarray, velocities: np.ndarray, outputs: list[OutputPort]) -> Slopes:
    """Return the derivatives by coordinates, whose unit moves all by `places` (nu, nz), and by velocities (nu, nw)."""
    none = np.zeros(system.nu)
    changes = [(x, none, STEP / _size(system, x)) for x in places.T]
    changes += [(none, u, RATE / _size(system, u)) for u in velocities.T]
    return _Probe(system, state, outputs).slopes(changes, lambda k, way: system)


def signal_slopes(system, state, port: InputPort | NamedInput, outputs: list[OutputPort]) -> tuple[np.ndarray, Slopes]:
    """Return how all coordinates move with a signal (nu,), zero unless it drives, and the derivatives by the signal,
    its rate and its second rate: three columns, accelerations besides that motion's own.
    """
    signal = port.signal(system.model)
    value = 0.0 if signal.follows else abs(float(signal.sample(state.t)[0]))
    step = SHARE * max(value, 1.0)
    gap = np.zeros(system.ng)
    work = system.workspace()
    work.weights[0].wanted = 0
    for sign in (1.0, -1.0):
        now = system.state(state.t, state.q, state.u)
        evaluate(_changed(system, port, 0, sign * step, state.t).program, now, work)
        gap += sign * np.where(system.program.equation_level == 0, work.equations["g"], 0.0) / (2.0 * step)
    follows = np.zeros(system.nu)
    if np.any(gap):
        tangent = tangent_at(system, state, system.workspace())
        scale = 1.0 / np.sqrt(np.maximum(mass_metric(csr_matrix(tangent.M)), system.least_inertia))
        follows = -scale * np.linalg.lstsq(tangent.G.toarray() * scale, gap, rcond=None)[0]
    none = np.zeros(system.nu)
    size = _size(system, follows) if np.any(follows) else 0.0
    changes = [
        (follows, none, STEP / size if size else step),
        (none, follows, RATE / size if size else step),
        (none, none, step),
    ]

    def changed(k: int, way: float):
        return _changed(system, port, k, way, state.t)

    found = _Probe(system, state, outputs).slopes(changes, changed)
    found.a[:, 2] -= follows
    return follows, found


def _changed(system, port: InputPort | NamedInput, order: int, amount: float, t: float):
    """Return the system with `amount` added to a signal, its rate or its second rate at the time t."""
    names = {"e": amount} if order == 0 else {"e": amount, "t0": t}
    model = port.added(system.model, expression(POLYNOMIALS[order], **names))
    return replace(system, program=system.program._replace(signals=compile_model(model).program.signals))


def _size(system, change: np.ndarray) -> float:
    return float(np.abs(change * system.units).max()) or 1.0
