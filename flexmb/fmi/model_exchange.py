"""`ModelExchange`: the states of a unit of another program in the system, beside the states of blocks and forces."""

from __future__ import annotations

import shutil
import tempfile
import weakref
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import IntegrationError, ModelError
from flexmb.fmi.exchange_unit import ExchangeUnit
from flexmb.fmi.unit_file import FATAL
from flexmb.fmi.unit_variables import SMOOTH, elements_of
from flexmb.model.block import Block
from flexmb.model.described import is_number
from flexmb.model.function_block import Function
from flexmb.model.signal import Signal, as_signal

__all__ = ["ModelExchange"]


@dataclass(frozen=True, eq=False)
class _Result(Function):
    """A rate or an output of a unit, as a function of its states and inputs."""

    unit: Any = None

    def complaint(self) -> str:
        """Return what the unit has failed with."""
        return super().complaint() or self.unit.failure


@dataclass(frozen=True, eq=False)
class ModelExchange(Block):
    """A unit of another program for model exchange (FMI 2.0 or 3.0), its states part of the system.

    ``unit["y"]`` is an output as a signal: the effort of an `Actuator`, a sensor `SignalValue`, another block. Every
    integrator, statics and `linearize` see the states, by their names in the unit (`State`). Derivatives are those that
    the unit offers, else differences. A call costs some 20 us for each state and output, as Python functions do.

    Units with event indicators or events of time do not fit here: `cosimulate` integrates them beside the model. The
    unit is not told of completed steps; one that needs it (delays inside) belongs there as well. It is loaded when the
    object is made, and released with it.

    Parameters
    ----------
    path : path
        The .fmu file.
    inputs : mapping of variable of the unit to signal
        ``{"u": "angle"}``: sensors of the model by name, signals, formulas.
    parameters : mapping of variable of the unit to number
        Set before the start; states begin where the unit's initialisation leaves them.
    name : str
        How sensors and messages call it; by default the name of the file.

    Raises
    ------
    DataFileError, ModelError
        The file is no such unit, or cannot run here; it has events; variables that do not exist.

    Source: FMI 3.0.1, section 3.
    """

    path: str | Path
    _: KW_ONLY
    inputs: Mapping[str, Any] = field(default_factory=dict)
    parameters: Mapping[str, float] = field(default_factory=dict)
    name: str | None = None
    word: ClassVar[str] = "model_exchange"

    def __post_init__(self):
        title = f"Fmu '{self.path}'"
        if not isinstance(self.inputs, Mapping) or not isinstance(self.parameters, Mapping):
            raise ModelError(
                title,
                found="inputs or parameters that are no mapping",
                expected="variables of the unit and what they are connected to",
                remedy='Write inputs={"u": "angle"}, parameters={"gain": 2.0}',
            )
        for name, value in self.parameters.items():
            if not is_number(value) and not isinstance(value, bool):
                raise ModelError(
                    title, found=f"parameter {name} = {value!r}", expected="a finite number", remedy="Correct the value"
                )
        object.__setattr__(self, "name", self.name or Path(self.path).stem)
        given = {name: as_signal(_measured(one), title, f"inputs[{name!r}]") for name, one in self.inputs.items()}
        object.__setattr__(self, "inputs", given)
        unit = _Kept(self.path, title, self.parameters)
        weakref.finalize(self, unit.close)
        object.__setattr__(self, "_unit", unit)
        for name in given:
            unit.loaded.smooth(name, "input")
        if unit.loaded.indicators or np.isfinite(unit.loaded.next_event):
            raise ModelError(
                title,
                found=f"{unit.loaded.indicators} event indicators"
                if unit.loaded.indicators
                else f"an event planned for t = {unit.loaded.next_event:.6g} s",
                expected="a unit whose states change smoothly",
                remedy='Integrate it beside the model: cosimulate(model, Fmu(path, kind="model exchange"), ...)',
            )
        object.__setattr__(self, "_made", {})

    @property
    def outputs(self) -> tuple[str, ...]:
        """Return the names of the outputs that are real numbers."""
        every = self._unit.loaded.variables.values()  # type: ignore[attr-defined]
        return tuple(name for v in every if v.causality == "output" and v.type in SMOOTH for name in elements_of(v))

    def __getitem__(self, name: str) -> Signal:
        """Return an output or a state of the unit as a signal."""
        if name in self._unit.loaded.states:  # type: ignore[attr-defined]
            return self.state(name)
        return self._result(name, len(self._unit.loaded.states) + self._number(name))  # type: ignore[attr-defined]

    def _number(self, name: str) -> int:
        unit = self._unit  # type: ignore[attr-defined]
        unit.loaded.smooth(name, "output", "local")
        if name not in unit.outputs:
            unit.outputs.append(name)
            unit.forget()
        return unit.outputs.index(name)

    def _result(self, name: str, row: int) -> _Result:
        """Return a rate or an output as a function of what it depends on."""
        made = self._made  # type: ignore[attr-defined]
        if name not in made:
            unit = self._unit  # type: ignore[attr-defined]
            known = (*unit.loaded.states, *sorted(self.inputs))
            depends = unit.loaded.depends.get(name, unit.loaded.depends.get(name.partition("[")[0]))
            # rates may be called with all; an output that is said to depend on no input makes no algebraic loop
            every = depends is None or row < len(unit.loaded.states)
            inputs = [n for n in self.inputs if every or n in depends or n.partition("[")[0] in depends]
            used = [known.index(n) for n in (*unit.loaded.states, *inputs)]
            of = [*(self.state(n) for n in unit.loaded.states), *(self.inputs[n] for n in inputs)]
            rest = {n: 0.0 for n in self.inputs if n not in inputs}

            def value(t: float, x: np.ndarray) -> float:
                return unit.at(t, np.real(x), inputs, rest)[0][row]

            def slopes(t: float, x: np.ndarray) -> np.ndarray:
                return unit.at(t, x, inputs, rest)[1][row][used]

            made[name] = _Result(of, function=value, jacobian=slopes, name=f"{self.name}.{name}", unit=unit)
        return made[name]

    def states(self):
        unit = self._unit.loaded  # type: ignore[attr-defined]
        return dict(zip(unit.states, unit.start.tolist(), strict=True))

    def sizes(self):
        unit = self._unit.loaded  # type: ignore[attr-defined]
        return dict(zip(unit.states, unit.sizes.tolist(), strict=True))

    def rates(self):
        unit = self._unit.loaded  # type: ignore[attr-defined]
        return tuple(self._result(f"der({name})", k) for k, name in enumerate(unit.states))

    def output(self):
        """Return the only output; ModelError if there are several."""
        if len(self.outputs) != 1:
            raise ModelError(
                self.title,
                found=f"{len(self.outputs)} outputs",
                expected="one, where the unit itself stands for a signal",
                remedy=f'Write unit["{self.outputs[0] if self.outputs else "y"}"]',
            )
        return self[self.outputs[0]]


class _Kept:
    """A unit with what it last computed."""

    def __init__(self, path: str | Path, title: str, parameters: Mapping[str, float]):
        self.folder = tempfile.mkdtemp(prefix="flexmb_unit_")
        self.failure = ""
        self.outputs: list[str] = []
        self.loaded: Any = None
        self._key: Any = None
        self._found: Any = None
        try:
            self.loaded = ExchangeUnit(path, title, self.folder, parameters, 0.0, None)
        except Exception:
            self.close()
            raise

    def forget(self) -> None:
        """Compute anew when asked next."""
        self._key = None

    def at(self, t: float, x: np.ndarray, names: list[str], rest: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray]:
        """Return rates and outputs, and their derivatives by states and inputs, at states and inputs x."""
        n = len(self.loaded.states)
        given = {**rest, **dict(zip(names, x[n:].tolist(), strict=True))}
        inputs = {name: given[name] for name in sorted(given)}
        key = (t, x[:n].tobytes(), tuple(inputs.items()))
        if key != self._key:
            if self.loaded.worst == FATAL:  # it may not be called any more
                raise IntegrationError(
                    self.loaded.title,
                    found=self.failure,
                    expected="a unit that goes on",
                    remedy="Look at its inputs and at its log, and load it anew",
                )
            try:
                self.loaded.place(t, x[:n], inputs)
                values = np.concatenate([self.loaded.rates(), self.loaded.values(self.outputs)])
                slopes = self.loaded.slopes(t, x[:n], inputs, tuple(self.outputs))
            except Exception as error:
                self.failure = self.failure or f"the unit fails at t = {t:.6g} s: {error}"
                self.loaded.worst = max(self.loaded.worst, getattr(error, "status", FATAL))
                raise
            self._key, self._found = key, (values, slopes)
        return self._found

    def close(self) -> None:
        """End the unit, and remove what was unpacked."""
        if self.loaded is not None:
            self.loaded.close()
        shutil.rmtree(self.folder, ignore_errors=True)


def _measured(given: Any) -> Any:
    """Return the measurement of a sensor that is named; anything else as it is."""
    from flexmb.model.measurement import measured

    return measured(given) if isinstance(given, str) else given
