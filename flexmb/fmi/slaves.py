"""What a unit of FMI is beside the class of PythonFMU3 or PythonFMU that it is made with: all goes to `Inside`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from flexmb.errors import FlexmbError
from flexmb.fmi.inside import Inside, variable_name
from flexmb.fmi.library import release_at_exit
from flexmb.fmi.units import base_units

__all__ = ["Fmi2Motion", "Fmi3Motion"]

DESCRIPTION = (
    "Mechanism simulated by flexmb. The unit runs in hosts that load a Python interpreter in which flexmb is "
    "installed; its binary does not bring one. No directional derivatives: the binary refuses such calls."
)


class _Motion:
    """What both versions share: the run, its variables and its state."""

    resources: Any
    register_variable: Callable[..., None]
    register_units: Callable[..., None]
    variables: Callable[[], Iterator[Any]]
    """returns the variables, of the package's own class"""
    log: Callable[..., None]

    def __init__(self, **given):
        super().__init__(**given)
        release_at_exit(self.resources)
        self.inside = Inside(self.resources)
        self.description = f"{DESCRIPTION} Model: {self.inside.model.name}."
        for variable in self.variables():
            self.register_variable(variable, nested=False)

    def ports(self) -> Iterator[tuple[str, str, Callable[[], float], Callable[[float], None] | None]]:
        """Return name, unit, getter and setter of the inputs, then of the outputs, whose setter is None."""
        inside = self.inside
        for name in inside.values:
            yield variable_name(name), "", partial(inside.values.__getitem__, name), partial(inside.set, name)
        for name, (_, _, unit) in inside.outputs.items():
            yield name, unit, partial(inside.output, name), None

    def parameters(self) -> Iterator[tuple[str, bool, Callable[[], float], Callable[[float], None]]]:
        """Return name, if it may change between steps, getter and setter of the parameters."""
        values = self.inside.parameters
        for name in values:
            tunable = name in self.inside.tunable
            yield variable_name(name), tunable, partial(values.__getitem__, name), partial(self.inside.tune, name)

    def step(self, t: float, h: float, error: Any) -> bool | None:
        """Return if the model goes on after a step, or None if it failed; the message goes to the host's log."""
        try:
            return self.inside.step(t, h)
        except FlexmbError as failure:
            self.log(str(failure), error)
            return None

    def terminate(self) -> None:
        """End the run."""
        self.inside.close()

    def _get_fmu_state(self) -> dict[str, Any]:
        return self.inside.state()

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        self.inside.restore(state)


class Fmi3Motion(_Motion):
    """A model as a unit of FMI 3, beside ``pythonfmu3.Fmi3Slave``."""

    def variables(self) -> Iterator[Any]:
        from pythonfmu3.enums import Fmi3Causality, Fmi3Variability
        from pythonfmu3.unit import Unit
        from pythonfmu3.variables import Float64

        kind = Fmi3Variability.continuous
        yield Float64("time", causality=Fmi3Causality.independent, variability=kind, getter=lambda: self.inside.t)
        for name, unit, getter, setter in self.ports():
            known, base = {}, base_units(unit)
            if unit and base is not None:
                self.register_units([Unit(unit, **base)])
                known = {"unit": unit}
            causality = Fmi3Causality.input if setter else Fmi3Causality.output
            yield Float64(name, causality=causality, variability=kind, getter=getter, setter=setter, **known)
        for name, tunable, getter, setter in self.parameters():
            yield Float64(
                name,
                causality=Fmi3Causality.parameter,
                variability=Fmi3Variability.tunable if tunable else Fmi3Variability.fixed,
                getter=getter,
                setter=setter,
            )

    def setup_experiment(self, start_time: float) -> None:
        """Take the start time."""
        self.inside.begin(start_time)

    def do_step(self, current_time: float, step_size: float) -> Any:
        """Take a step of the host."""
        from pythonfmu3.enums import Fmi3Status
        from pythonfmu3.fmi3slave import Fmi3StepResult

        goes_on = self.step(current_time, step_size, Fmi3Status.error)
        if goes_on is None:
            return Fmi3StepResult(status=Fmi3Status.error)
        return Fmi3StepResult(status=Fmi3Status.ok, terminateSimulation=not goes_on)


class Fmi2Motion(_Motion):
    """A model as a unit of FMI 2, beside ``pythonfmu.Fmi2Slave``."""

    def variables(self) -> Iterator[Any]:
        from pythonfmu import Fmi2Causality, Fmi2Variability, Real

        for name, unit, getter, setter in self.ports():
            causality = Fmi2Causality.input if setter else Fmi2Causality.output
            yield Real(
                name,
                causality=causality,
                variability=Fmi2Variability.continuous,
                description=unit or None,
                getter=getter,
                setter=setter,
            )
        for name, tunable, getter, setter in self.parameters():
            yield Real(
                name,
                causality=Fmi2Causality.parameter,
                variability=Fmi2Variability.tunable if tunable else Fmi2Variability.fixed,
                getter=getter,
                setter=setter,
            )

    def to_xml(self, *given) -> Any:
        """Return the description; all outputs are calculated at the start, which FMI 2 wants to be told."""
        from xml.etree.ElementTree import SubElement

        root = super().to_xml(*given)  # type: ignore[misc]
        structure = root.find("ModelStructure")
        unknown = SubElement(structure, "InitialUnknowns")
        for output in structure.findall("Outputs/Unknown"):
            SubElement(unknown, "Unknown", attrib=dict(output.attrib))
        return root

    def setup_experiment(
        self, start_time: float, stop_time: float | None = None, tolerance: float | None = None
    ) -> None:
        """Take the start time."""
        self.inside.begin(start_time)

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Take a step of the host."""
        from pythonfmu.enums import Fmi2Status

        return bool(self.step(current_time, step_size, Fmi2Status.error))
