"""`cosimulate`: a model together with functional mock-up units of other programs (FMI 2.0 and 3.0, co-simulation)."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Collection, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from itertools import islice, pairwise
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import IntegrationError, ModelError, did_you_mean
from flexmb.fmi.exchange_steps import SteppedExchange
from flexmb.fmi.inside import output_names
from flexmb.fmi.library import release
from flexmb.fmi.unit_file import FATAL, Speaking, load_unit, read_unit, require_platform, what_it_is_for
from flexmb.fmi.unit_variables import Element, UnitVariables, failed_reading
from flexmb.integrate import Stepper, stepper
from flexmb.model.described import Described, is_number
from flexmb.model.model import Model
from flexmb.model.sensor_columns import columns_named, sensor_columns, titles_of, unknown
from flexmb.results import Solution

__all__ = ["Fmu", "cosimulate"]

MOST_STEPS = 50_000_000
"""Steps of one run: the state of each is kept."""
SETTABLE, READABLE = ("input", "parameter"), ("output", "local")
"""Causalities of what may be set and read; a new value of a parameter counts from the start on."""
CO_SIMULATION, MODEL_EXCHANGE = "co-simulation", "model exchange"


@dataclass(frozen=True, eq=False)
class Fmu(metaclass=Described):
    """A unit of another program, and how it is connected.

    Parameters
    ----------
    path : path
        The .fmu file.
    inputs : mapping of variable of the unit to sensor of the model
        ``{"measured": "angle"}``, ``{"load": "pin fx"}``: a sensor with several columns is named with one.
    outputs : mapping of input of the model to variable of the unit
        ``{"torque": "u"}``, for ``effort=flexmb.input("torque")``.
    parameters : mapping of variable of the unit to number
        Set before the start. Variables may be reals, integers, enumerations (by number), booleans (0 and 1) and
        elements of arrays, ``"A[2,1]"``. Of what is connected, integers take the nearest number, and booleans are true
        from 0.5 on.
    kind : "co-simulation" or "model exchange"
        The unit brings its solver; or it says how fast its states change, and is integrated here with its inputs held,
        to a relative tolerance of 1e-9, with its events found. `ModelExchange` makes states part of the system.
    """

    path: str | Path
    inputs: Mapping[str, str] = field(default_factory=dict)
    outputs: Mapping[str, str] = field(default_factory=dict)
    parameters: Mapping[str, float] = field(default_factory=dict)
    kind: str = CO_SIMULATION

    def __post_init__(self):
        if self.kind not in (CO_SIMULATION, MODEL_EXCHANGE):
            raise ModelError(
                f"Fmu '{self.path}'",
                found=f"kind = {self.kind!r}",
                expected=f"{CO_SIMULATION!r} or {MODEL_EXCHANGE!r}",
                remedy=did_you_mean(str(self.kind), (CO_SIMULATION, MODEL_EXCHANGE)) or "Leave kind out",
            )
        for name in ("inputs", "outputs", "parameters"):
            given = getattr(self, name)
            if not isinstance(given, Mapping):
                raise ModelError(
                    f"Fmu '{self.path}'",
                    found=f"{name} = {given!r}",
                    expected="names and what they are connected to",
                    remedy=f'Write {name}={{"u": "angle"}}',
                )
        for name, value in self.parameters.items():
            if not is_number(value) and not isinstance(value, bool):
                raise ModelError(
                    f"Fmu '{self.path}'",
                    found=f"parameter {name} = {value!r}",
                    expected="a finite number",
                    remedy="Correct the value",
                )


_LOADED: dict[str, str] = {}
"""Units that PythonFMU has made and this process has loaded: path by identifier of the build."""


class _Unit:
    """A unit that has been loaded: its variables by name, and its run."""

    def __init__(self, described: Fmu, folder: str, start: float, end: float):
        self.described, self.title = described, f"Fmu '{described.path}'"
        self.worst = 0
        """The gravest status that the unit has given (0: ok, 3: error, 4: fatal)."""
        path = Path(described.path)
        fmpy, about, unpacked = read_unit(path, self.title, folder)
        self._require_runnable(fmpy, about, path)
        kind = {"2.0": fmpy.fmi2.FMU2Slave}.get(about.fmiVersion, fmpy.fmi3.FMU3Slave)
        self.old = about.fmiVersion == "2.0"
        self.variables = UnitVariables(self.title, about.modelVariables, self.old)
        for name in described.parameters:
            self.variables.find(name, *SETTABLE)
        self.slave = self.variables.unit = load_unit(
            kind, about, about.coSimulation.modelIdentifier, unpacked, path, self.title
        )
        with self._speaking("cannot be started"):
            self.slave.instantiate()
            self._begin(start, end)

    def _require_runnable(self, fmpy, about, path: Path) -> None:
        if about.coSimulation is None or about.fmiVersion not in ("2.0", "3.0"):
            raise ModelError(
                self.title,
                found=what_it_is_for(about, CO_SIMULATION if about.coSimulation is None else ""),
                expected="a unit for co-simulation of FMI 2.0 or 3.0",
                remedy='Export it for co-simulation, with its solver, or write kind="model exchange"',
            )
        self._require_fresh_process(about, path)
        require_platform(fmpy, path, self.title)

    def _require_fresh_process(self, about, path: Path) -> None:
        """Raise ModelError for a unit that would end the process: PythonFMU 0.7 starts its interpreter only once."""
        if about.fmiVersion != "2.0" or not str(about.generationTool or "").startswith("PythonFMU "):
            return
        if about.guid in _LOADED:
            raise ModelError(
                self.title,
                found=f"the unit was loaded in this process before (from {_LOADED[about.guid]}), and the library of "
                f"{about.generationTool} ends a process that loads it twice",
                expected="a process of its own for each load",
                remedy="Start a new process, or export the unit for FMI 3",
            )
        _LOADED[about.guid] = path.name

    def _begin(self, start: float, end: float) -> None:
        if self.old:
            self.slave.setupExperiment(startTime=start, stopTime=end)
        self.set_all(self.described.parameters)
        if self.old:
            self.slave.enterInitializationMode()
        else:
            self.slave.enterInitializationMode(startTime=start, stopTime=end)
        self.slave.exitInitializationMode()

    def variable(self, name: str, *causalities: str) -> Element:
        """Return a number of one of these causalities; ModelError if there is none."""
        return self.variables.find(name, *causalities)

    def set_all(self, given: Mapping[str, float]) -> None:
        """Set variables."""
        told = [f"'{name}' was set to {value:.9g}" for name, value in islice(given.items(), 3)]
        rest = f", and {len(given) - 3} others" if len(given) > 3 else ""
        with self._speaking(f"failed when {', '.join(told)}{rest}"):
            self.variables.set_all(given, *SETTABLE)

    def get_all(self, names: Collection[str]) -> list[float]:
        """Return the values of variables."""
        with self._speaking(failed_reading(names)):
            return self.variables.get_all(names, *READABLE)

    def step(self, t: float, h: float) -> bool:
        """Let the unit take a step; return if it goes on."""
        with self._speaking(f"failed at t = {t:.9g} s"):
            if self.old:
                self.slave.doStep(currentCommunicationPoint=t, communicationStepSize=h)
                return True
            _, ends, *_ = self.slave.doStep(currentCommunicationPoint=t, communicationStepSize=h)
            return not ends

    def close(self) -> None:
        """End the unit, as far as its state allows: a unit that failed is not terminated, a fatal one is left as it is.

        PythonFMU3 0.3 has already released its object when a step raises, and would release it again.
        """
        release(self.slave.dll)
        if self.worst == FATAL:
            return
        with suppress(Exception):  # foreign code
            if self.worst == 0:
                self.slave.terminate()
            self.slave.freeInstance()

    def _speaking(self, what: str) -> Speaking:
        return Speaking(self, what)


def cosimulate(
    model: Model,
    units: Fmu | Sequence[Fmu],
    t_end: float,
    *,
    step: float,
    t_start: float = 0.0,
    integrator: Any = None,
    start: Any = None,
) -> Solution:
    """Integrate a model and units of other programs side by side, with values exchanged every `step`, s.

    At every communication time the units read sensors of the model and the model takes the outputs of the units; then
    all go on to the next with what they have read (Jacobi scheme). What passes from one to the other is late by up to
    a step, so the coupling has an error of first order in `step`: halve it to see how much it matters.

    Parameters
    ----------
    model : Model
    units : Fmu, or several
    t_end, t_start, step : float, s
    integrator, start : optional
        As `simulate`.

    Returns
    -------
    Solution
        With a sample at every communication time.

    Raises
    ------
    ModelError, DataFileError
        Before computing starts: names that do not exist, units that cannot run here.
    IntegrationError
        The model or a unit fails; ``error.solution`` holds what was computed.

    Source: FMI 3.0.1, section 4; Gomes et al. 2018, section 4 (schemes of co-simulation).
    """
    given = [units] if isinstance(units, Fmu) else list(units)
    times = _communication_times(t_start, t_end, step)
    readings = _readings(given, model)
    with ExitStack() as stack:
        folder = tempfile.mkdtemp(prefix="flexmb_units_")
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        run = stack.enter_context(stepper(model, integrator=integrator, start=start, t_start=t_start, t_end=t_end))
        loaded = []
        for number, unit in enumerate(given):
            exchange = unit.kind == MODEL_EXCHANGE
            one = (SteppedExchange if exchange else _Unit)(unit, f"{folder}/{number}", t_start, t_end)
            stack.callback(one.close)
            for name in unit.inputs:
                one.variable(name, "input")
            for name in unit.outputs.values():
                one.variable(name, *READABLE)
            loaded.append(one)
        try:
            _exchange(run, loaded, readings)
            for t, following in pairwise(times):
                goes_on = _all_step(loaded, float(t), float(following - t))
                goes_on = run.advance(to=float(following)) and goes_on
                if not goes_on:
                    break
                _exchange(run, loaded, readings)
        except IntegrationError as error:
            error.solution = run.solution
            raise
        return run.solution


def _communication_times(t_start: float, t_end: float, step: float) -> np.ndarray:
    """Return the times of all exchanges: every `step` from the start, and the end."""
    if not all(is_number(x) for x in (step, t_start, t_end)) or not 0.0 < step <= t_end - t_start:
        raise ModelError(
            "cosimulate",
            found=f"step = {step!r} s from {t_start!r} to {t_end!r} s",
            expected="a positive step, not longer than the run",
            remedy="Give the time between two exchanges, as step=0.001",
        )
    count = int(np.ceil((t_end - t_start) / step * (1.0 - 1e-12)))
    if count > MOST_STEPS:
        raise ModelError(
            "cosimulate", found=f"{count} steps", expected=f"at most {MOST_STEPS}", remedy="Give a longer step"
        )
    return np.append(t_start + step * np.arange(count), t_end)


def _all_step(units: list[Any], t: float, h: float) -> bool:
    """Let all units take a step; return if all go on."""
    ended = [unit for unit in units if not unit.step(t, h)]
    return not ended


def _exchange(run: Stepper, units: list[Any], readings: Mapping[str, tuple[str, int]]) -> None:
    """Let all read what they are connected to, at the present time."""
    values: dict[str, np.ndarray] = {}
    taken = {}
    for unit in units:
        outputs = unit.described.outputs
        for (name, variable), value in zip(outputs.items(), unit.get_all(outputs.values()), strict=True):
            taken[name] = value
            if not np.isfinite(taken[name]):
                raise IntegrationError(
                    unit.title,
                    found=f"{variable} = {taken[name]} at t = {run.t:.9g} s",
                    expected="a finite value",
                    remedy="Look at the inputs of the unit, and at its log",
                )
    for unit in units:
        given = {}
        for name, reading in unit.described.inputs.items():
            sensor, column = readings[reading]
            if sensor not in values:
                values[sensor] = np.ravel(run[sensor])
            given[name] = float(values[sensor][column])
        unit.set_all(given)
    run.set(taken)


def _readings(units: list[Fmu], model: Model) -> dict[str, tuple[str, int]]:
    """Return sensor and column by what units read: names of sensors and columns, or of variables of a unit."""
    known, variables = sensor_columns(titles_of(model)), output_names(model)
    found = {}
    for unit, name in [(one, name) for one in units for name in one.inputs.values()]:
        columns = columns_named(name, known) if isinstance(name, str) else ()
        if len(columns) == 1:
            found[name] = (columns[0].sensor, columns[0].number)
        elif name in variables:
            found[name] = variables[name][:2]
        else:
            said = unknown(str(name), known)
            raise ModelError(
                f"Fmu '{unit.path}'",
                found=f"sensor '{name}' has {len(columns)} columns" if columns else f"no sensor '{name}' in the model",
                expected=said.expected,
                remedy="Name one of them" if columns else said.remedy,
            )
    return found
