"""`ExchangeUnit`: a unit for model exchange that has been loaded, FMI 2.0 and 3.0 behind one face.

The unit says how fast its states change, x' = f(t, x, u), what it puts out, and where something happens; whoever holds
it integrates. Source: FMI 3.0.1, section 3; FMI 2.0.4, section 3.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import DataFileError, IntegrationError, ModelError
from flexmb.fmi.library import release
from flexmb.fmi.unit_file import FATAL, Speaking, load_unit, read_unit, require_platform, what_it_is_for
from flexmb.fmi.unit_variables import SMOOTH, Element, UnitVariables, elements_of

__all__ = ["ExchangeUnit"]

POINTER = ctypes.POINTER(ctypes.c_double)
MOST_UPDATES = 1000
"""Updates of the discrete states in one event."""
RELATIVE = 1e-6
"""Step of differences where a unit offers no derivatives, relative."""


class ExchangeUnit:
    """A unit in continuous time, or in an event.

    Attributes
    ----------
    states : tuple of str
    start, sizes : (n,)
        States after initialisation, and their nominal values.
    indicators : int
        Number of event indicators.
    next_event : float
        When the unit wants an event, s; infinite if it does not.
    derivatives : bool
        Does it offer directional derivatives?
    """

    def __init__(
        self, path: str | Path, title: str, folder: str, parameters: Mapping[str, float], t: float, end: float | None
    ):
        self.title, path = title, Path(path)
        fmpy, about, unpacked = read_unit(path, title, folder)
        if about.modelExchange is None or about.fmiVersion not in ("2.0", "3.0"):
            raise ModelError(
                title,
                found=what_it_is_for(about, "model exchange" if about.modelExchange is None else ""),
                expected="a unit for model exchange of FMI 2.0 or 3.0",
                remedy="Export it for model exchange, or let it bring its solver and take it for co-simulation",
            )
        require_platform(fmpy, path, title)
        self.old = about.fmiVersion == "2.0"
        self.numbers = UnitVariables(title, about.modelVariables, self.old)
        self.variables = self.numbers.by_name
        for name in parameters:
            self.numbers.find(name, "input", "parameter")
        self._rates = [u.variable for u in about.derivatives]
        _require_states(title, self._rates)
        self.states = tuple(name for v in self._rates for name in elements_of(v.derivative))
        self.indicators = int(about.numberOfEventIndicators or 0)
        self.derivatives = _offers_derivatives(Path(unpacked))
        self.depends = {u.variable.name: _names(u.dependencies) for u in (*about.outputs, *about.derivatives)}
        kind = fmpy.fmi2.FMU2Model if self.old else fmpy.fmi3.FMU3Model
        self.unit = load_unit(kind, about, about.modelExchange.modelIdentifier, unpacked, path, title)
        self.numbers.unit = self.unit
        self._closed = False
        self.next_event, self.ended, self.worst = np.inf, False, 0
        with self.speaking("cannot be started"):
            self.unit.instantiate()
            self._begin(parameters, t, end)

    def _begin(self, parameters: Mapping[str, float], t: float, end: float | None) -> None:
        if self.old:
            self.unit.setupExperiment(startTime=t, stopTime=end)
        self.numbers.set_all(parameters, "input", "parameter")
        if self.old:
            self.unit.enterInitializationMode()
        else:
            self.unit.enterInitializationMode(startTime=t, stopTime=end)
        self.unit.exitInitializationMode()
        self._update()
        self.start = self.state()
        n = len(self.states)
        sizes = np.ones(n)
        if n:
            self.unit.getNominalsOfContinuousStates(sizes.ctypes.data_as(POINTER), n)
        self.sizes = np.where(np.isfinite(sizes) & (sizes > 0.0), sizes, 1.0)

    def variable(self, name: str, *causalities: str) -> Element:
        """Return a number of one of these causalities; ModelError if there is none."""
        return self.numbers.find(name, *causalities)

    def smooth(self, name: str, *causalities: str) -> None:
        """Raise ModelError unless a number is real and continuous: what is part of a system has derivatives."""
        variable, _ = self.variable(name, *causalities)
        discrete = causalities[0] == "input" and variable.variability == "discrete"
        if variable.type not in SMOOTH or discrete:
            raise ModelError(
                self.title,
                found=f"{causalities[0]} '{name}', " + ("discrete" if discrete else f"of the type {variable.type}"),
                expected="a continuous real number, which has derivatives",
                remedy='Run it beside the model: cosimulate(model, Fmu(path, kind="model exchange"), ...)',
            )

    def set(self, name: str, value: float) -> None:
        """Set an input, or a parameter before the start."""
        self.numbers.set(name, value, "input", "parameter")

    def get(self, name: str) -> float:
        """Return the value of a variable."""
        return self.numbers.get(name, "output", "local")

    def values(self, names: Iterable[str]) -> list[float]:
        """Return the values of variables."""
        return self.numbers.get_all(names, "output", "local")

    def place(self, t: float, x: np.ndarray, inputs: Mapping[str, float] | None = None) -> None:
        """Set time, states (n,) and inputs."""
        self.unit.setTime(t)
        if len(x):
            given = np.ascontiguousarray(x, float)
            self.unit.setContinuousStates(given.ctypes.data_as(POINTER), len(given))
        self.numbers.set_all(inputs or {}, "input", "parameter")

    def state(self) -> np.ndarray:
        """Return the states (n,)."""
        x = np.zeros(len(self.states))
        if len(x):
            self.unit.getContinuousStates(x.ctypes.data_as(POINTER), len(x))
        return x

    def rates(self) -> np.ndarray:
        """Return the rates of the states (n,), where it stands."""
        f, read = np.zeros(len(self.states)), self.unit
        if len(f):
            ask = read.getDerivatives if self.old else read.getContinuousStateDerivatives
            ask(f.ctypes.data_as(POINTER), len(f))
        return f

    def signs(self) -> np.ndarray:
        """Return which event indicators are above zero, (ni,) bool, where it stands."""
        z = np.zeros(self.indicators)
        if len(z):
            self.unit.getEventIndicators(z.ctypes.data_as(POINTER), len(z))
        return z > 0.0

    def slopes(self, t: float, x: np.ndarray, inputs: Mapping[str, float], outputs: tuple[str, ...]) -> np.ndarray:
        """Return derivatives of rates and outputs by states and inputs, (n + outputs, n + inputs).

        Those that the unit offers; else central differences.
        """
        self.place(t, x, inputs)
        known, n = (*self.states, *inputs), len(x)
        J = np.zeros((n + len(outputs), len(known)))
        single = all(name in self.variables for name in (*known, *outputs))  # no elements of arrays
        if self.derivatives and single:
            unknown = [v.valueReference for v in self._rates] + [self.variables[y].valueReference for y in outputs]
            for k, reference in enumerate(self.variables[name].valueReference for name in known):
                J[:, k] = self.unit.getDirectionalDerivative(unknown, [reference], [1.0])
            return J
        names = list(inputs)
        for k in range(len(known)):
            size = self.sizes[k] if k < n else 1.0
            value = x[k] if k < n else inputs[names[k - n]]
            h = RELATIVE * max(abs(value), size)
            ends = []
            for way in (h, -h):
                moved, given = x.copy(), dict(inputs)
                if k < n:
                    moved[k] += way
                else:
                    given[names[k - n]] += way
                self.place(t, moved, given)
                ends.append(np.concatenate([self.rates(), self.values(outputs)]))
            J[:, k] = (ends[0] - ends[1]) / (2.0 * h)
        self.place(t, x, inputs)
        return J

    def completed(self) -> bool:
        """Tell the unit that a step is over; return if it wants an event."""
        event, ends = self.unit.completedIntegratorStep()
        self.ended = self.ended or bool(ends)
        return bool(event)

    def happen(self, inputs: Mapping[str, float] | None = None) -> np.ndarray:
        """Let an event happen where the unit stands, with inputs that jump; return the states after it (n,)."""
        self.unit.enterEventMode()
        self.numbers.set_all(inputs or {}, "input", "parameter")
        self._update()
        return self.state()

    def _update(self) -> None:
        """Update the discrete states until they stay, and go on in continuous time."""
        again = True
        for _ in range(MOST_UPDATES):
            update = self.unit.newDiscreteStates if self.old else self.unit.updateDiscreteStates
            again, ends, _, _, planned, time = update()
            self.next_event = float(time) if planned else np.inf
            self.ended = self.ended or bool(ends)
            if not again:
                break
        if again:
            raise IntegrationError(
                self.title,
                found=f"discrete states that still change after {MOST_UPDATES} updates",
                expected="an event that ends",
                remedy="Look for states of the unit that switch each other",
            )
        self.unit.enterContinuousTimeMode()

    def speaking(self, what: str) -> Speaking:
        """Return a context in which whatever the unit fails with names it."""
        return Speaking(self, what)

    def close(self) -> None:
        """End the unit as far as its state allows: one that failed is not terminated, a fatal one is left as it is."""
        if self._closed:
            return
        self._closed = True
        release(self.unit.dll)
        if self.worst == FATAL:
            return
        with suppress(Exception):  # foreign code
            if self.worst == 0:
                self.unit.terminate()
            self.unit.freeInstance()


def _require_states(title: str, rates: list[Any]) -> None:
    """Raise DataFileError for derivatives that do not say of which state they are one."""
    stray = [v.name for v in rates if v.derivative is None]
    if stray:
        raise DataFileError(
            title,
            found=f"'{stray[0]}' is listed as a derivative, and does not say of which variable",
            expected="an attribute derivative with the state",
            remedy="Export it again: its description is damaged",
        )


def _offers_derivatives(unpacked: Path) -> bool:
    """Does the description say that there are directional derivatives? fmpy 0.3 reads it of version 2 only."""
    from xml.etree.ElementTree import parse

    found = parse(unpacked / "modelDescription.xml").getroot().find("ModelExchange")
    words = ("providesDirectionalDerivative", "providesDirectionalDerivatives")
    return found is not None and any(found.get(word) in ("true", "1") for word in words)


def _names(dependencies: Any) -> tuple[str, ...] | None:
    """Return on which variables something depends; None if the unit does not say."""
    return None if dependencies is None else tuple(v.name for v in dependencies)
