"""`Series`: what a sensor may read: the motion, forces and energies of a phase at all its times."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from flexmb.errors import FlexmbError, did_you_mean
from flexmb.results import recover

__all__ = ["MarkerMotion", "Series"]


class MarkerMotion(NamedTuple):
    """Motion of a marker at nt times, all in W.

    r : (nt, 3), m; R : (nt, 3, 3), marker axes to W; v, w : (nt, 3), m/s and rad/s; a, alpha : (nt, 3), m/s2 and
    rad/s2.
    """

    r: np.ndarray
    R: np.ndarray
    v: np.ndarray
    w: np.ndarray
    a: np.ndarray
    alpha: np.ndarray


class Series:
    """The quantities of one phase, evaluated once, when the first sensor asks.

    Parameters
    ----------
    phase : Phase
    """

    def __init__(self, phase):
        self.phase = phase

    @property
    def t(self) -> np.ndarray:
        """Times, (nt,), s."""
        return self.phase.t

    @property
    def model(self) -> Any:
        """The model of the phase."""
        return self.phase.model

    @cached_property
    def system(self):
        """The compiled model."""
        if self.phase.system is not None:
            return self.phase.system
        if self.model is None:
            raise FlexmbError(
                "Solution",
                found="the model is not known, so no new quantity can be evaluated",
                expected="a solution with its model",
                remedy="Load it with Solution.load(path, read_model=...), or ask for a stored sensor",
            )
        from flexmb.system import compile as compile_model

        return compile_model(self.model)

    @cached_property
    def signals(self) -> np.ndarray:
        """Values of all compiled signals, (nt, ns)."""
        from flexmb.system.observe import observe_signals

        p = self.phase
        return np.concatenate([observe_signals(self.system, *rows) for rows in self._spans(p.q, p.u, p.a, p.lam)])

    @cached_property
    def observation(self):
        """The arrays over time of all markers, joints and forces (see flexmb.system.observe)."""
        from flexmb.system import observe

        p = self.phase
        seen = [observe(self.system, *rows) for rows in self._spans(p.q, p.u, p.a, p.lam, p.works)]
        if len(seen) == 1:
            return seen[0]
        return type(seen[0])(
            **{f.name: np.concatenate([getattr(one, f.name) for one in seen]) for f in fields(seen[0])}
        )

    def _spans(self, *arrays: np.ndarray) -> Iterator[list[np.ndarray]]:
        """Yield times and rows of the samples that the same inputs led to; meanwhile the inputs have those values."""
        given = self.phase.inputs
        if given is None or not self.system.inputs:
            yield [self.t, *arrays]
            return
        args = self.system.program.signals.args
        before = args.copy()
        turns = 1 + np.flatnonzero(np.any(given[1:] != given[:-1], axis=1))
        try:
            for first, last in pairwise([0, *turns.tolist(), len(given)]):
                for places, value in zip(self.system.inputs.values(), given[first]):
                    args[places] = value
                yield [x[first:last] for x in (self.t, *arrays)]
        finally:
            args[:] = before

    @cached_property
    def impacts(self) -> tuple[tuple[Any, float, dict[str, np.ndarray]], ...]:
        """The impacts of the event that ended the phase: the action, its impulse (N s), and that of every joint on the
        body of its second marker, there, in W (6,), N s and N m s.

        They follow from the velocities before them, the last sample.
        """
        from flexmb.system import observe
        from flexmb.system.impact import strike

        phase = self.phase
        event = next((e for e in phase.model.events if e.name == phase.ended), None)
        if event is None or not any(action.strikes for action in event.then):
            return ()
        system, t, q, found = self.system, float(phase.t[-1]), phase.q[-1], []
        for action, impulse, multipliers in strike(system, event, t, q, phase.u[-1])[1]:
            still = np.zeros((2, 1, system.nu))
            seen = observe(system, [t], q[None], still[0], still[1], multipliers[None]).reaction[0]
            found.append((action, impulse, {name: seen[k] for name, k in system.joint_index.items()}))
        return tuple(found)

    def marker(self, name: str) -> MarkerMotion:
        """Return the motion of "body.marker"."""
        k = _index(self.system.marker_index, name, "marker")
        seen = self.observation
        return MarkerMotion(seen.r[:, k], seen.R[:, k], seen.v[:, k], seen.w[:, k], seen.a[:, k], seen.alpha[:, k])

    def reaction(self, joint: str) -> np.ndarray:
        """Force and moment (nt, 6), N and N m, of a joint on the body of its second marker, at that marker, in W."""
        return self.observation.reaction[:, _index(self.system.joint_index, joint, "joint")]

    def multipliers(self, joint: str) -> np.ndarray:
        """Multipliers (nt, n) of the equations of a joint."""
        _index(self.system.joint_index, joint, "joint")
        return self.phase.lam[:, self.system.joint_equations[joint]]

    def force(self, name: str) -> np.ndarray:
        """Force and moment (nt, 6), N and N m, of a force on the body of its second marker, at that marker, in W."""
        return self.observation.force[:, _index(self.system.force_index, name, "force")]

    def wrenches(self, markers: Sequence[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Force and moment (nt, n, 6), N and N m, of all joints and forces on each "body.marker", at the marker, in W;
        the part of it that joints and drives exert; and the amounts of all load shapes (nt, n_loads).
        """
        from flexmb.system.observe import observe_wrenches

        p, numbers = self.phase, [_index(self.system.marker_index, name, "marker") for name in markers]
        seen = [observe_wrenches(self.system, numbers, *rows) for rows in self._spans(p.q, p.u, p.a, p.lam)]
        every, of_joints, loads = (np.concatenate(parts) for parts in zip(*seen, strict=True))
        return every, of_joints, loads

    @property
    def energy(self) -> np.ndarray:
        """Kinetic, strain and potential energy, (nt, 3), J."""
        return self.observation.energy

    @property
    def works(self) -> np.ndarray:
        """Work of loads, work of drives, dissipated energy since the start, (nt, 3), J."""
        return self.phase.works

    @property
    def constraint_error(self) -> np.ndarray:
        """Largest residual of all constraint equations, their rates and second rates, (nt, 3), m or rad,
        per s, per s2.
        """
        return self.observation.constraint_error

    def coordinates(self, body: str) -> tuple[np.ndarray, np.ndarray]:
        """Return the body's own (q (nt, nq_b), u (nt, nu_b))."""
        iq, iu = self.system.body_slices[body]
        return self.phase.q[:, iq], self.phase.u[:, iu]

    def modal_coordinates(self, body: str) -> np.ndarray:
        """Return the flexible coordinates eta (nt, m), m, of a floating body."""
        return self.coordinates(body)[0][:, 7:]

    def stress(self, body: str, nodes) -> np.ndarray:
        """Return the stress xx, yy, zz, xy, yz, zx (nt, len(nodes), 6), Pa, in body axes, at nodes of a body."""
        data = recover.modal_data(self.model.body(body))
        return recover.stress(data, self.modal_coordinates(body), nodes)

    def largest_von_mises(self, body: str, nodes=None) -> np.ndarray:
        """Return the largest von Mises stress (nt,), Pa, among nodes (all by default) of a body."""
        data = recover.modal_data(self.model.body(body))
        return recover.largest_von_mises(data, self.modal_coordinates(body), nodes)


def _index(index, name: str, family: str) -> int:
    if name not in index:
        known = ", ".join(sorted(index)) or "none"
        raise FlexmbError(
            "Series",
            found=f"{family} '{name}' does not exist",
            expected=f"One of: {known}",
            remedy=did_you_mean(name, index) or "Correct the name",
        )
    return index[name]
