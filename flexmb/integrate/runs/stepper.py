"""`stepper`: a run that another program moves on, step by step, with inputs of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError, ModelError, did_you_mean, listed
from flexmb.integrate.impulsive import refuse_impulses
from flexmb.integrate.orbital import unless_stiff
from flexmb.integrate.runs.simulate import chosen_integrator, state_at
from flexmb.integrate.runs.stepped_phase import SteppedPhase, new_phase
from flexmb.integrate.runs.validity import Validity
from flexmb.model.described import is_number
from flexmb.model.kinds import Sensor
from flexmb.model.model import Model
from flexmb.model.orbit import require_orbit
from flexmb.model.sensor_columns import found_in
from flexmb.results import Instant, Series, Solution, Status
from flexmb.system import assemble, assemble_as_drawn
from flexmb.system.branching import require_motion_to_begin
from flexmb.told import listening

__all__ = ["Moment", "Stepper", "stepper"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Moment:
    """A moment of a run to which it can return, as often as one likes: see `Stepper.save`.

    Parameters
    ----------
    t : float, s
    inputs : mapping of name to value
        As they were set.
    """

    t: float
    inputs: Mapping[str, float]
    _phase: SteppedPhase
    _variables: Any
    _samples: tuple[int, ...]
    _status: Status | None
    _validity: dict[str, Any]

    def __repr__(self):
        return f"Moment(t = {self.t:.9g} s)"


class Stepper:
    """A run that stands at a time `t`, and goes on when it is told to. Made by `flexmb.stepper`.

    ``run.set("torque", 3.0)`` sets inputs of the model, ``run.advance(to=0.01)`` integrates, ``run["angle"]`` reads a
    sensor at the present time. It can be used in a ``with`` block, at the end of which it closes.
    """

    def __init__(self, phase: SteppedPhase, validity: Validity, keep: bool):
        self._phase, self._validity, self._keep = phase, validity, keep
        self._done: list[SteppedPhase] = []
        self._status: Status | None = None
        """How the run has ended; None while it can go on."""
        self._closed = False
        self._readers: dict[str, Callable[[], Any]] = {}

    def __repr__(self):
        ended = "" if self._status is None else f", {self._status}"
        return f"Stepper(model '{self.model.name}' at t = {self.t:.9g} s{ended})"

    def __enter__(self) -> Stepper:
        return self

    def __exit__(self, *_):
        self.close()

    @property
    def t(self) -> float:
        """Present time, s."""
        return self._phase.t

    @property
    def model(self) -> Model:
        """The model, as events so far have changed it."""
        return self._phase.model

    @property
    def status(self) -> Status:
        """How the run stands: "finished" with its present time, "stopped" by an event, or "failed"."""
        return Status.finished(self.t) if self._status is None else self._status

    @property
    def inputs(self) -> dict[str, float]:
        """The values of all inputs by name."""
        return self._phase.inputs

    @property
    def state(self) -> Instant:
        """Coordinates, velocities, accelerations, multipliers and works at the present time."""
        return self._phase.instant()

    def set(self, name: str | Mapping[str, float], value: float | None = None) -> None:
        """Set an input, or several at once, from the present time on: ``run.set("torque", 3.0)``.

        Raises
        ------
        ModelError
            The model has no such input, or the value is not a finite number; then none is set.
        """
        given = dict(name) if isinstance(name, Mapping) else {name: value}
        known = self._phase.system.inputs
        for one, number in given.items():
            if one not in known:
                raise ModelError(
                    "Stepper",
                    found=f"input {one!r} does not exist",
                    expected=f"one of: {listed(str(one), known)}" if known else "a model with inputs",
                    remedy=did_you_mean(str(one), known)
                    or f"Write effort=flexmb.input({str(one)!r}) where the value is to act",
                )
            if not is_number(number):
                raise ModelError(
                    "Stepper",
                    found=f"input '{one}' = {number!r} at t = {self.t:.9g} s",
                    expected="a finite number",
                    remedy="Look at what computes it; the run stands as it was",
                )
        self._phase.set({one: float(number) for one, number in given.items()})  # type: ignore[arg-type]

    def advance(self, *, to: float | None = None, by: float | None = None) -> bool:
        """Integrate to a time, or by a duration, s, with the inputs as they are; return if the run can go on.

        False means that an event has stopped it, at the time `t`.

        Raises
        ------
        ModelError
            The time lies before the present one, or the run has ended.
        IntegrationError
            The integrator cannot continue. The run stands at the last time that was reached; `restore` leads back
            to a saved moment.
        """
        goal = self._goal(to, by)
        require_orbit(self.model, goal)
        while self._phase.t < goal:
            try:
                following = self._phase.advance(goal)
            except FlexmbError as error:
                expected = f"; expected: {error.expected}" if error.expected else ""
                what = f"{error.part} at t = {self.t:.9g} s: {error.found}{expected}"
                self._status = Status.failed(what, error.remedy)
                raise
            if following is None:
                break
            if isinstance(following, Status):
                self._status = following
                return False
            self._done.append(self._phase)
            self._phase = following
            self._readers.clear()
            # now: a moment that is saved later knows what this phase had to tell; and last, as warnings may be errors
            self._done[-1].look(self._validity)
        self._status = None
        return True

    def __getitem__(self, sensor: str | Sensor) -> Any:
        """Return what a sensor of the model, or any other, reads at the present time: a number, or (n,)."""
        if isinstance(sensor, str):
            if sensor not in self._readers:
                self._readers[sensor] = self._reader(sensor)
            return self._readers[sensor]()
        sensor.check(self.model)
        return self._value(sensor)

    def save(self) -> Moment:
        """Return the present moment, to which `restore` leads back exactly."""
        phase = self._phase
        return Moment(
            t=phase.t,
            inputs=phase.inputs,
            _phase=phase,
            _variables=phase.saved(),
            _samples=(*(len(done.rows) for done in self._done), len(phase.rows)),
            _status=self._status,
            _validity=self._validity.saved(),
        )

    def restore(self, moment: Moment) -> None:
        """Go back to a saved moment of this run: what came after it is forgotten, with its warnings, and inputs have
        the values of then.

        The steps that follow are those that would have followed then, to the last bit; but IDA, whose solver keeps
        what it knows to itself, begins there anew.
        """
        if not isinstance(moment, Moment) or moment._phase not in (*self._done, self._phase):
            raise ModelError(
                "Stepper",
                found=f"restore({moment!r})",
                expected="a moment that save() of this run has returned, and that has not been given up since",
                remedy="Save again after going back to an earlier moment",
            )
        phases = (*self._done, self._phase)
        number = phases.index(moment._phase)
        self._done, self._phase = list(phases[:number]), moment._phase
        self._phase.restore(moment._variables, moment._samples[-1])
        self._validity.restore(moment._validity)
        self._status = moment._status
        self._readers.clear()

    @property
    def solution(self) -> Solution:
        """All states between which the run was advanced, with the start, as a `Solution`; warnings come with it.

        Inputs that jump have two values at the time: accelerations and reactions are those just before.
        """
        self._look()
        phases = [phase.result() for phase in (*self._done, self._phase)]
        statistics = {
            **self._phase.statistics(),
            **deepcopy(self._validity.statistics),  # which goes on to change
            "integrator": repr(self._phase.integrator),
        }
        return Solution(phases=tuple(phases), status=self.status, statistics=statistics)

    def close(self) -> None:
        """End the run; warnings about its energy and validity are given now. States and sensors stay readable."""
        if not self._closed:
            self._look()
            self._validity.tell(self._validity.creeps())
            self._validity.tell_of_tracks()
            self._closed = True

    def _look(self) -> None:
        """Give the warnings of what was computed since the last look."""
        for phase in (*self._done, self._phase):
            phase.look(self._validity)

    def _goal(self, to: float | None, by: float | None) -> float:
        given = by if to is None else to
        if (to is None) == (by is None) or not is_number(given):
            raise ModelError(
                "Stepper",
                found=f"advance(to={to!r}, by={by!r})",
                expected="either a time or a duration, s",
                remedy="Write run.advance(to=0.01) or run.advance(by=0.001)",
            )
        goal = self.t + float(by) if by is not None else float(given)  # type: ignore[arg-type]
        if self._closed or self._status is not None:
            raise ModelError(
                "Stepper",
                found="the run is closed" if self._closed else str(self._status),
                expected="a run that can go on",
                remedy="Restore a moment before, or make a new stepper",
            )
        if goal < self.t:
            raise ModelError(
                "Stepper",
                found=f"advance to t = {goal:.9g} s, and the run stands at {self.t:.9g} s",
                expected="a later time",
                remedy="Use save() and restore() to go back",
            )
        return goal

    def _reader(self, name: str) -> Callable[[], Any]:
        found = found_in(self.model, name)
        if found is None:
            sensors = [sensor.name for sensor in self.model.sensors]
            raise ModelError(
                "Stepper",
                found=f"sensor '{name}' does not exist",
                expected=f"one of: {listed(name, sensors)}" if sensors else "a model with sensors",
                remedy=did_you_mean(name, sensors) or "Add the sensor to the model, or ask run[flexmb.Position(...)]",
            )
        sensor, column = found
        fast = self._phase.readings().reader(sensor)
        whole = (lambda: self._value(sensor)) if fast is None else lambda: fast(self._phase.last)
        return whole if column is None else lambda: float(np.ravel(whole())[column])

    def _value(self, sensor: Sensor) -> Any:
        """Return what a sensor reads at the present time."""
        value = np.asarray(sensor.values(Series(self._phase.last_row())))[-1]
        return float(value) if np.ndim(value) == 0 else value


def stepper(
    model: Model,
    *,
    integrator: Any = None,
    formulation: Any = None,
    t_start: float = 0.0,
    t_end: float = 100.0,
    start: Any = None,
    keep: bool = True,
) -> Stepper:
    """Return a run of a model that stands at its start and is moved on from outside.

    Parameters
    ----------
    model : Model
        Loads that are set from outside are inputs: ``effort=flexmb.input("torque")``.
    integrator, formulation, start : optional
        As `simulate`.
    t_start : float, s
    t_end : float, s
        About when the run will end, for which step sizes are planned; it may go on beyond.
    keep : bool
        Keep the state at the end of every step for `Stepper.solution`; False for very long runs.

    Raises
    ------
    ModelError, CompileError
        If the model or the settings are wrong.

    Examples
    --------
    >>> y, top = fmb.Pose.axes(z=(0, 1, 0)), fmb.Pose.axes((0, 0, 0.5), z=(0, 1, 0))
    >>> rod = fmb.RigidBody("rod", mass=2.0, inertia=(0.2, 0.2, 0.01), at=(0, 0, -0.5), markers={"top": top})
    >>> hinge = fmb.Revolute("hinge", markers=("ground.y", "rod.top"))
    >>> motor = fmb.Actuator("motor", joint="hinge", effort=fmb.input("torque"))
    >>> angle = fmb.JointCoordinate("angle", joint="hinge")
    >>> ground = fmb.Ground(markers={"y": y})
    >>> model = fmb.Model(bodies=[ground, rod], joints=[hinge], forces=[motor], sensors=[angle])
    >>> with fmb.stepper(model) as run:
    ...     for k in range(100):
    ...         run.set("torque", 5.0 * (0.1 - run["angle"]))
    ...         run.advance(by=0.01)
    """
    if not is_number(t_start) or not is_number(t_end) or not t_end > t_start:
        raise ModelError(
            "stepper",
            found=f"t_start = {t_start!r}, t_end = {t_end!r}",
            expected="times in s, the end after the start",
            remedy="Give about the time at which the run will end",
        )
    refuse_impulses(model, "stepper")
    chosen = chosen_integrator(model, integrator, formulation)
    state = None if start is None else state_at(start, model, t_start)
    told: list[str] = []
    with listening() as heard:
        system, begin = (
            assemble_as_drawn(model, t=t_start, tell=told.extend)
            if state is None
            else assemble(model, t=t_start, state=state)
        )
    told += require_motion_to_begin(system, begin, system.workspace())
    chosen, stiff = unless_stiff(chosen, system, begin, float(t_end) - t_start)
    told += stiff
    validity = Validity()
    validity.tell(told)
    validity.note([*system.unlocated])
    with listening() as begun:
        phase = new_phase(model, system, begin, chosen, float(t_end), keep=keep)
    validity.keep([*heard, *begun])
    return Stepper(phase, validity, keep)
