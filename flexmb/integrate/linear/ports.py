"""Ports of a linear plant: signals of forces and drives by name, and columns of sensors by name."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NamedTuple

from flexmb.errors import ModelError, did_you_mean, listed
from flexmb.model.input_signal import Input, inputs_of, with_more
from flexmb.model.kinds import Sensor
from flexmb.model.model import Model
from flexmb.model.sensor_columns import columns_named, sensor_columns, titles_of, unknown
from flexmb.model.signal import Signal

__all__ = ["InputPort", "NamedInput", "OutputPort", "input_ports", "output_ports"]

AXES = "xyz"
FAMILIES = ("forces", "joints")
READERS = (*FAMILIES, "sensors")
"""Families whose parts may read inputs."""


class InputPort(NamedTuple):
    """A signal: its name "part.field" or "part.field.x", the family and number of the part, field and component."""

    name: str
    family: str
    number: int
    field: str
    component: int | None

    def signal(self, model: Model) -> Signal:
        """Return the signal of the model."""
        value = getattr(getattr(model, self.family)[self.number], self.field)
        return value if self.component is None else value[self.component]

    def added(self, model: Model, more: Signal) -> Model:
        """Return the model with another signal added to this one."""
        parts = list(getattr(model, self.family))
        part, value = parts[self.number], self.signal(model) + more
        if self.component is not None:
            row = list(getattr(part, self.field))
            row[self.component] = value
            value = tuple(row)
        parts[self.number] = part.replaced(**{self.field: value})
        changed: dict[str, Any] = {self.family: tuple(parts)}
        return replace(model, **changed)


class NamedInput(NamedTuple):
    """An input of the model, wherever it is read: see `flexmb.input`."""

    name: str

    def signal(self, model: Model) -> Signal:
        """Return the input."""
        return _named(model)[self.name]

    def added(self, model: Model, more: Signal) -> Model:
        """Return the model with another signal added to the input."""
        made: dict[int, Any] = {}
        changed: dict[str, Any] = {
            family: tuple(with_more(part, self.name, more, made) for part in getattr(model, family))
            for family in READERS
        }
        return replace(model, **changed)


class OutputPort(NamedTuple):
    """A column of a sensor: "sensor" or "sensor column", the sensor, the number of the column and its unit."""

    name: str
    sensor: Sensor
    column: int
    unit: str


def _signals(model: Model) -> list[InputPort]:
    found = []
    for family in FAMILIES:
        for number, part in enumerate(getattr(model, family)):
            for field in part.fields():
                value = getattr(part, field)
                if _of_time(value):
                    found.append(InputPort(f"{part.name}.{field}", family, number, field, None))
                elif isinstance(value, tuple) and value and all(isinstance(v, Signal) for v in value):
                    found += [
                        InputPort(f"{part.name}.{field}.{axis}", family, number, field, k)
                        for k, axis in enumerate(AXES[: len(value)])
                        if _of_time(value[k])
                    ]
    return found


def _named(model: Model) -> dict[str, Input]:
    return {name: one for family in READERS for part in getattr(model, family) for name, one in inputs_of(part).items()}


def _of_time(value: Any) -> bool:
    """Is it a signal of time? Tables over the coordinate of a joint are none: nothing can be added to them."""
    if not isinstance(value, Signal):
        return False
    try:
        value.program()
    except ModelError:
        return False
    return True


def _asked(names: Iterable[str] | str, what: str) -> list[str]:
    asked = [names] if isinstance(names, str) else list(names)
    if not all(isinstance(name, str) for name in asked):
        raise ModelError(
            "linearize",
            found=f"{what} = {names!r}",
            expected="a name or a list of names",
            remedy=f"Leave {what} out for all",
        )
    return asked


def _unknown(name: str, known: list[str]) -> ModelError:
    of = "a signal of a force or a drive, 'part.field'"
    return ModelError(
        "linearize",
        found=f"input '{name}' does not exist",
        expected=f"One of: {listed(name, known)}" if known else f"a model with {of}",
        remedy=did_you_mean(name, [*known, *(port.partition(".")[0] for port in known)]) or f"Name {of}",
    )


def input_ports(model: Model, names: Iterable[str] | str | None) -> list[InputPort | NamedInput]:
    """Return the inputs and signals of these names: of a part that has one only, "part" will do.

    By default all inputs (`flexmb.input`), or all signals of a model that has none.

    Raises
    ------
    ModelError
        There is no such signal, or there are several.
    """
    signals, named = _signals(model), _named(model)
    if names is None:
        asked = list(named) or [port.name for port in signals]
    else:
        asked = _asked(names, "inputs")
    found: list[InputPort | NamedInput] = []
    known = list(dict.fromkeys([*named, *(port.name for port in signals)]))
    for name in asked:
        if name in named:
            found.append(NamedInput(name))
            continue
        matching = [port for port in signals if port.name == name]
        own = matching or [port for port in signals if port.name.startswith(f"{name}.")]
        if not own:
            raise _unknown(name, known)
        if len(own) > 1:
            raise ModelError(
                "linearize",
                found=f"input '{name}' may be {len(own)} signals",
                expected=f"One of: {', '.join(port.name for port in own)}",
                remedy="Name one of them; parts of the same name need different names",
            )
        found.append(own[0])
    return found


def output_ports(model: Model, names: Iterable[str] | str | None) -> list[OutputPort]:
    """Return the columns of these names: "sensor" names all its columns, "sensor fx" one of them; all by default.

    Raises
    ------
    ModelError
        There is no such sensor or column.
    """
    known, sensors = sensor_columns(titles_of(model)), {sensor.name: sensor for sensor in model.sensors}
    found = []
    for name in sensors if names is None else _asked(names, "outputs"):
        columns = columns_named(name, known)
        if not columns:
            said = unknown(name, known)
            raise ModelError(
                "linearize", found=f"output '{name}' does not exist", expected=said.expected, remedy=said.remedy
            )
        found += [OutputPort(one.name, sensors[one.sensor], one.number, one.unit) for one in columns]
    return found
