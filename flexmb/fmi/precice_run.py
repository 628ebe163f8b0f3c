"""`couple`: a model as a participant of a coupled simulation by preCICE (version 3), which exchanges fields at markers.

preCICE is not among the dependencies, and no wheel of it exists: whoever has it makes the participant, and gives it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flexmb.errors import DataFileError, IntegrationError, ModelError, did_you_mean
from flexmb.forces import PointLoad
from flexmb.integrate import Stepper, stepper
from flexmb.model.described import Described, is_number
from flexmb.model.input_signal import input as as_input
from flexmb.model.model import Model
from flexmb.results import Solution
from flexmb.sensors import Position, Velocity

__all__ = ["CouplingMesh", "couple"]

WRITTEN = ("displacement", "position", "velocity")
READ = ("force", "moment")


@dataclass(frozen=True, eq=False)
class CouplingMesh(metaclass=Described):
    """A mesh of the coupling: markers of the model, what they tell, and what acts on them.

    Parameters
    ----------
    name : str
        As in the configuration of preCICE.
    markers : sequence of str
        "body.marker": the vertices, at their places as described. In two dimensions x and y count.
    writes : mapping of name of data to quantity
        ``{"Displacement": "displacement"}``: "displacement" from the described place, "position" (m), "velocity"
        (m/s), all in W.
    reads : mapping of name of data to quantity
        ``{"Force": "force"}``: "force" (N) or "moment" (N m) on the markers, in W.
    """

    name: str
    markers: Sequence[str]
    writes: Mapping[str, str] = field(default_factory=dict)
    reads: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self):
        title = f"Coupling mesh '{self.name}'"
        names = tuple(self.markers) if isinstance(self.markers, list | tuple) else ()
        if not names or not all(isinstance(name, str) for name in names) or len(set(names)) < len(names):
            raise ModelError(
                title,
                found=f"markers = {self.markers!r:.80}",
                expected="different names 'body.marker'",
                remedy='Write markers=["plate.n1", "plate.n2"]',
            )
        object.__setattr__(self, "markers", names)
        for given, known in ((self.writes, WRITTEN), (self.reads, READ)):
            wrong = [one for one in given.values() if one not in known] if isinstance(given, Mapping) else [given]
            if wrong:
                raise ModelError(
                    title,
                    found=f"{wrong[0]!r}",
                    expected=f"names of data and one of {', '.join(known)}",
                    remedy=did_you_mean(str(wrong[0]), known) or 'Write writes={"Displacement": "displacement"}',
                )

    def loads(self) -> list[PointLoad]:
        """Return the loads by which what is read acts: three inputs each."""
        found = []
        for data, kind in self.reads.items():
            for marker in self.markers:
                load = tuple(as_input(self.input(data, marker, axis)) for axis in "xyz")
                name = f"{self.name} {data} {marker}".replace(".", " ")
                force, moment = (load, (0.0, 0.0, 0.0)) if kind == "force" else ((0.0, 0.0, 0.0), load)
                found.append(PointLoad(name, marker=marker, force=force, moment=moment))
        return found

    def input(self, data: str, marker: str, axis: str) -> str:
        """Return the name of the input for a component of what is read at a marker."""
        return f"{self.name} {data} {marker} {axis}"

    def sensors(self) -> dict[str, list[Any]]:
        """Return for each data that is written the sensors of the markers."""
        kinds = {"velocity": Velocity}
        return {
            data: [
                kinds.get(what, Position)(f"{self.name} {data} {m}".replace(".", " "), marker=m) for m in self.markers
            ]
            for data, what in self.writes.items()
        }


class _Exchange:
    """The meshes of a participant: vertices, and what is read and written at them."""

    def __init__(self, participant: Any, meshes: Sequence[CouplingMesh], run: Stepper):
        self.participant, self.run, self.meshes = participant, run, meshes
        self.start = {
            m: np.array(run[Position(m.replace(".", " "), marker=m)]) for mesh in meshes for m in mesh.markers
        }
        self.sensors = {mesh.name: mesh.sensors() for mesh in meshes}
        self.dimensions = {mesh.name: int(participant.get_mesh_dimensions(mesh.name)) for mesh in meshes}
        self.vertices = {
            mesh.name: participant.set_mesh_vertices(
                mesh.name, np.array([self.start[m][: self.dimensions[mesh.name]] for m in mesh.markers])
            )
            for mesh in meshes
        }

    def write(self) -> None:
        """Give the quantities at the present time."""
        for mesh in self.meshes:
            for data, what in mesh.writes.items():
                values = np.array([np.ravel(self.run[sensor]) for sensor in self.sensors[mesh.name][data]])
                if what == "displacement":
                    values -= np.array([self.start[m] for m in mesh.markers])
                given = np.ascontiguousarray(values[:, : self.dimensions[mesh.name]])
                self.participant.write_data(mesh.name, data, self.vertices[mesh.name], given)

    def read(self, after: float) -> None:
        """Let what preCICE has for a time from now, s, act."""
        values = {}
        for mesh in self.meshes:
            for data in mesh.reads:
                found = np.asarray(self.participant.read_data(mesh.name, data, self.vertices[mesh.name], after), float)
                shape = (len(mesh.markers), self.dimensions[mesh.name])
                if found.shape != shape or not np.all(np.isfinite(found)):
                    raise IntegrationError(
                        f"Coupling mesh '{mesh.name}'",
                        found=f"{data} of the shape {found.shape} at t = {self.run.t:.9g} s"
                        + ("" if found.shape != shape else " with values that are not finite"),
                        expected=f"finite numbers of the shape {shape}: vectors at all vertices",
                        remedy="Look at the data of the configuration, and at the other participant",
                    )
                for marker, row in zip(mesh.markers, found, strict=True):
                    values |= {mesh.input(data, marker, axis): float(x) for axis, x in zip("xyz", row)}
        if values:
            self.run.set(values)


def couple(
    model: Model,
    participant: Any,
    meshes: CouplingMesh | Sequence[CouplingMesh],
    *,
    config: Any = None,
    step: float | None = None,
    t_end: float = 100.0,
    integrator: Any = None,
    start: Any = None,
) -> Solution:
    """Integrate a model as a participant of a simulation that is coupled by preCICE.

    The model takes steps as long as preCICE allows (at most `step`); what it reads is asked for the middle of a step
    and held over it, so that the error is of second order where preCICE interpolates in time. Where preCICE iterates,
    the model goes back exactly. The integrator's own steps are as short as its tolerance asks for.

    Parameters
    ----------
    model : Model
        Loads on the markers of the meshes are added to it, "mesh data marker".
    participant : precice.Participant, or str
        With its interface as documented for version 3; or its name, with `config`: then the package precice is needed.
    meshes : CouplingMesh, or several
    config : path, optional
        Configuration of preCICE.
    step : float, s, optional
        Longest step between two exchanges.
    t_end : float, s
        About when the coupling ends, for which the integrator plans.
    integrator, start : optional
        As `simulate`.

    Raises
    ------
    ModelError, DataFileError
        Before the coupling starts.
    IntegrationError
        The model fails; ``error.solution`` holds what was computed. Whatever ends the run, an interrupt too, the
        participant is finalized.

    Source: preCICE 3, Python bindings (Participant); Chourdakis et al. 2022, preCICE v2, Open Research Europe 2:51.
    """
    given = [meshes] if isinstance(meshes, CouplingMesh) else list(meshes)
    if not given or not all(isinstance(mesh, CouplingMesh) for mesh in given):
        raise ModelError("couple", found=f"meshes = {meshes!r:.80}", expected="CouplingMesh", remedy="Give one or more")
    if step is not None and (not is_number(step) or step <= 0.0):
        raise ModelError("couple", found=f"step = {step!r}", expected="a time above 0 s", remedy="Leave step out")
    whole = model.with_parts(forces=[load for mesh in given for load in mesh.loads()])
    one = _participant(participant, config)
    try:
        with stepper(whole, integrator=integrator, start=start, t_end=t_end) as run:
            try:
                _coupled(run, one, _Exchange(one, given, run), np.inf if step is None else float(step))
            except IntegrationError as error:
                error.solution = run.solution
                raise
            solution = run.solution
    except BaseException:  # an interrupt too: the others would wait for ever
        with suppress(Exception):
            one.finalize()
        raise
    one.finalize()
    return solution


def _coupled(run: Stepper, participant: Any, exchange: _Exchange, step: float) -> None:
    """Take part until the coupling ends, or an event of the model ends its run."""
    if participant.requires_initial_data():
        exchange.write()
    participant.initialize()
    moment = None
    while participant.is_coupling_ongoing():
        if participant.requires_writing_checkpoint():
            moment = run.save()
        h = min(float(participant.get_max_time_step_size()), step)
        exchange.read(0.5 * h)
        goes_on = run.advance(by=h)
        exchange.write()
        participant.advance(h)
        if participant.requires_reading_checkpoint():
            if moment is None:
                raise IntegrationError(
                    "couple",
                    found="preCICE asks to go back, and has not asked to save a state before",
                    expected="requires_writing_checkpoint before requires_reading_checkpoint",
                    remedy="Look at the coupling scheme of the configuration",
                )
            run.restore(moment)
        elif not goes_on:
            break


def _participant(given: Any, config: Any) -> Any:
    """Return the participant; made of its name and the configuration where that is given."""
    if not isinstance(given, str):
        return given
    if config is None:
        raise ModelError(
            "couple", found=f"participant '{given}' without config", expected="the path of precice-config.xml",
            remedy='Write config="precice-config.xml"',
        )  # fmt: skip
    try:
        import precice
    except ImportError:
        raise DataFileError(
            "couple",
            found="the package precice is not installed",
            expected="preCICE with its Python bindings (pyprecice)",
            remedy="Build preCICE and install pyprecice; pip has no wheel of it",
        ) from None
    return precice.Participant(given, str(config), 0, 1)
