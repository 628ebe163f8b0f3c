"""What runs inside a functional mock-up unit: a model file that is stepped from outside."""

from __future__ import annotations

import keyword
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.fmi.unit_parameters import TUNABLE_FILE, read_places, start_values, with_values
from flexmb.integrate import Stepper, stepper
from flexmb.io import load_model, load_simulation
from flexmb.model.model import Model
from flexmb.model.sensor_columns import sensor_columns, titles_of

__all__ = ["MODEL_FILE", "Inside", "model_inputs", "output_names", "variable_name"]

MODEL_FILE = "model.toml"
"""Name of the model file among the resources of the unit."""


def variable_name(text: str) -> str:
    """Return a name as FMI's structured naming convention writes it: identifiers with dots, anything else in quotes."""
    parts = text.replace(" ", ".").split(".")
    plain = all(part.isidentifier() and part.isascii() and not keyword.iskeyword(part) for part in parts)
    return ".".join(parts) if plain else "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"


def model_inputs(model: Model) -> dict[str, float]:
    """Return the inputs of a model with their values at the start."""
    from flexmb.model.input_signal import inputs_of

    parts = (*model.forces, *model.joints, *model.sensors)
    return {name: one.value for part in parts for name, one in inputs_of(part).items()}


def output_names(model: Model) -> dict[str, tuple[str, int, str]]:
    """Return the columns of all sensors by variable name: the sensor, the number of the column, and its unit."""
    known = sensor_columns(titles_of(model))
    every = (column for sensor in model.sensors for column in known[sensor.name])
    return {variable_name(column.name): (column.sensor, column.number, column.unit) for column in every}


class Inside:
    """A run of the model in `resources`, which begins when the first output or step is asked for.

    Attributes
    ----------
    values : dict of name to float
        The inputs as they are set.
    parameters : dict of name to float
        Numbers of parts, with which the run begins.
    tunable : set of str
        Those that may change between steps.
    """

    def __init__(self, resources: str | Path):
        path = Path(resources) / MODEL_FILE
        self.model = load_model(path)
        self.settings = load_simulation(path)
        self.start = 0.0
        self.values = model_inputs(self.model)
        tunable = read_places(path.parent, TUNABLE_FILE)
        self.tunable = set(tunable)
        self.places = {**read_places(path.parent), **tunable}
        self.parameters = start_values(self.model, self.places)
        self.outputs = output_names(self.model)
        self._run: Stepper | None = None
        self._read: dict[str, np.ndarray] = {}

    @property
    def run(self) -> Stepper:
        """The run, which begins now if it has not before."""
        if self._run is None:
            end = max(self.settings.t_end, self.start + 1e-3)
            model = with_values(self.model, self.places, self.parameters)
            self._run = stepper(model, integrator=self.settings.integrator, t_start=self.start, t_end=end, keep=False)
            self._run.set(self.values)
        return self._run

    @property
    def t(self) -> float:
        """Present time, s."""
        return self.start if self._run is None else self._run.t

    def begin(self, start: float) -> None:
        """Take the start time; the run begins there."""
        self.start, self._run, self._read = float(start), None, {}

    def set(self, name: str, value: float) -> None:
        """Set an input from the present time on."""
        if self._run is not None:
            self._run.set(name, value)
        self.values[name] = float(value)

    def tune(self, name: str, value: float) -> None:
        """Set a parameter, from the present time on: the run goes on from its state with the changed model."""
        before, self.parameters[name] = self.parameters[name], float(value)
        if self._run is None or self.parameters[name] == before or name not in self.tunable:
            return
        run, part = self._run, self.places[name].rpartition(".")[0]
        try:
            # as events have changed it so far
            model = run.model.changed(part, **{self.places[name].rpartition(".")[2]: self.parameters[name]})
            end = max(self.settings.t_end, run.t + 1e-3)
            self._run = stepper(
                model, integrator=self.settings.integrator, t_start=run.t, t_end=end, start=run.state, keep=False
            )
        except FlexmbError:
            self.parameters[name] = before
            raise
        self._run.set(self.values)
        self._read = {}

    def output(self, name: str) -> float:
        """Return the value of an output at the present time."""
        sensor, column, _ = self.outputs[name]
        if sensor not in self._read:
            self._read[sensor] = np.ravel(self.run[sensor])
        return float(self._read[sensor][column])

    def step(self, t: float, h: float) -> bool:
        """Integrate from `t` to `t + h`; return False if an event of the model has ended the run."""
        if abs(self.run.t - t) > 1e-9 * max(1.0, abs(t)):
            raise FlexmbError(
                f"Model '{self.model.name}'",
                found=f"a step from t = {t:.9g} s, and the model stands at {self.run.t:.9g} s",
                expected="steps that follow each other, or a state of the unit that was set back",
                remedy="Let the host get and set the state of the unit where it repeats steps",
            )
        self._read = {}
        return self.run.advance(to=t + h)

    def state(self) -> dict[str, Any]:
        """Return all that the next steps depend on."""
        moment = self.run.save()
        return {"run": self._run, "moment": moment, "inputs": dict(self.values), "parameters": dict(self.parameters)}

    def restore(self, state: dict[str, Any]) -> None:
        """Return to a state."""
        self._run = state["run"]  # a parameter that was set since has made another one
        self.run.restore(state["moment"])
        self.values.update(state["inputs"])
        self.parameters.update(state["parameters"])
        self._read = {}

    def close(self) -> None:
        """End the run; warnings about it are given now."""
        if self._run is not None:
            self._run.close()
