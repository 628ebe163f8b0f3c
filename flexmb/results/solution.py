"""`Solution`: what came out of a simulation."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError, ValidityWarning, did_you_mean, listed
from flexmb.files import check_folder, complaints, replacing
from flexmb.lock import Lock
from flexmb.model.kinds import Sensor
from flexmb.model.sensor_columns import SensorColumn, columns_named, sensor_columns, without_unit
from flexmb.results.interpolation import instant_at
from flexmb.results.phase import INPUTS, Instant, Phase
from flexmb.results.read_file import read_solution_file
from flexmb.results.run_file import RunFile, floating_data
from flexmb.results.series import Series
from flexmb.results.status import SHARED, STORED, Status
from flexmb.results.written import FIELDS

__all__ = ["SHARED", "Solution"]

NEGLIGIBLE = 1e-9
"""Multipliers that are so small relative to the largest one carry no load."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Solution:
    """The samples of a simulation, phase by phase, and every sensor's values over time.

    ``solution["bow"]`` are the values of the sensor named "bow", (nt,) or (nt, k), at the times ``solution.t``,
    ``solution["bow z"]`` one column of it, (nt,); a sensor that is not in the model can be asked directly:
    ``solution[flexmb.Position("x", marker="crank.A")]``.
    Values are evaluated when they are asked for and kept.

    Parameters
    ----------
    phases : tuple of Phase
        One unless events changed the model. At an event both states are there: the last sample of a phase and the
        first of the next have the same time.
    status : Status
    statistics : mapping
        Numbers of the integrator: steps, iterations, rejected steps, seconds.
    columns : mapping of sensor name to column titles
        Known for solutions read from a file; otherwise the sensors tell.
    """

    phases: tuple[Phase, ...]
    status: Status = field(default_factory=Status.finished)
    statistics: Mapping[str, Any] = field(default_factory=dict)
    columns: Mapping[str, tuple[str, ...]] = field(default_factory=dict, repr=False)
    _known: dict[Any, np.ndarray] = field(default_factory=dict, init=False, repr=False)
    _series: dict[int, Series] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self):
        object.__setattr__(self, "phases", tuple(self.phases))
        if not self.phases or not all(len(phase.t) for phase in self.phases):
            raise FlexmbError(
                "Solution",
                found="a solution or phase without samples",
                expected="at least one sample",
                remedy="Give the initial state as the first sample",
            )

    def __repr__(self):
        phases = f" in {len(self.phases)} phases" if len(self.phases) > 1 else ""
        sensors, how = ", ".join(self.sensor_names) or "none", str(self.status).rstrip(".")
        shared = f"; reactions not unique: {', '.join(self.shared_reactions)}" if self.shared_reactions else ""
        return (
            f"Solution({len(self.t)} samples{phases}, t = {self.t[0]:.6g} to {self.t[-1]:.6g} s; {how}; "
            f"sensors: {sensors}{shared})"
        )

    @property
    def shared_reactions(self) -> dict[str, list[str]]:
        """The primitive equations whose reactions are not unique, by joint, at the start of the phases.

        Redundant hinges share a load as nobody can tell without their stiffness; what sensors read is of least norm.
        """
        found: dict[str, list[str]] = {}
        for text in self.statistics.get(SHARED, ()):
            joint, _, kinds = text.rpartition(": ")
            found[joint] = kinds.split(", ")
        return found

    @property
    def t(self) -> np.ndarray:
        """Times of all samples, (nt,), s; an event's time is there twice."""
        return np.concatenate([phase.t for phase in self.phases])

    @property
    def model(self):
        """The model at the start (None for a file read without its model)."""
        return self.phases[0].model

    @property
    def sensor_names(self) -> tuple[str, ...]:
        """Names of the sensors that can be asked by name, in the order of the model."""
        names = dict.fromkeys(s.name for phase in self.phases if phase.model for s in phase.model.sensors)
        names.update(dict.fromkeys(name for phase in self.phases for name in phase.tables))
        return tuple(names)

    @property
    def final(self) -> Instant:
        """The last sample."""
        return self.phases[-1].instant(-1)

    def last(self) -> Solution:
        """Return the last sample alone, as a solution: of `statics` the equilibrium without the way to it."""
        phase = self.phases[-1]
        rows: dict[str, Any] = {name: getattr(phase, name)[-1:] for name in ("t", "q", "u", "a", "lam", "works")}
        tables = {name: values[-1:] for name, values in phase.tables.items()}
        inputs = None if phase.inputs is None else phase.inputs[-1:]
        return replace(self, phases=(replace(phase, **rows, tables=tables, inputs=inputs),))

    def series(self, phase: int = 0) -> Series:
        """Return what sensors read in one phase; evaluated once."""
        if phase not in self._series:
            self._series[phase] = Series(self.phases[phase])
        return self._series[phase]

    def state(self, t: float) -> Instant:
        """Return the state at a time: the sample, or between samples the cubic interpolation of both.

        At the time of an event it is the state after the event.
        """
        if np.any(np.diff(self.t) < 0.0):
            raise FlexmbError(
                "Solution",
                found="the load goes up and down, so it has several states for one value",
                expected="the number of a sample",
                remedy="Take solution.phases[0].instant(number)",
            )
        first, last = self.phases[0].t[0], self.phases[-1].t[-1]
        if not first <= t <= last:
            raise FlexmbError(
                "Solution",
                found=f"t = {t:.6g} s is outside",
                expected=f"{first:.6g} to {last:.6g} s",
                remedy="Simulate longer, or ask for a time in between",
            )
        phase = next(p for p in reversed(self.phases) if p.t[0] <= t)
        return instant_at(phase, t)

    def __getitem__(self, key: str | Sensor) -> np.ndarray:
        if isinstance(key, Sensor):
            if all(phase.model is None for phase in self.phases):
                raise FlexmbError(
                    "Solution",
                    found=f"sensor '{key.name}' asked of a file that was read without its model",
                    expected=f"One of those stored: {listed(key.name, self.sensor_names)}",
                    remedy='Give the model: Solution.load(path, model=fmb.load_model("run/model.toml"))',
                )
            return self._values(
                key.name, [(key if phase.model is not None else None) for phase in self.phases], stored=False
            )
        if not isinstance(key, str):
            raise FlexmbError(
                "Solution",
                found=f"{key!r} asked for",
                expected="the name of a sensor, or a sensor",
                remedy="`final` is the last sample, `state(t)` any other",
            )
        if key not in self._known:
            own = [_sensor(phase.model, key) for phase in self.phases]
            if not any(own) and not any(key in phase.tables for phase in self.phases):
                known = self.sensor_columns
                columns = columns_named(key, known)
                if columns:
                    own_columns = self[columns[0].sensor].reshape(len(self.t), -1)[:, [one.number for one in columns]]
                    self._known[key] = own_columns[:, 0] if len(columns) == 1 else own_columns
                    return self._known[key]
                raise FlexmbError(
                    "Solution",
                    found=f"sensor '{key}' does not exist",
                    expected=f"One of: {listed(key, self.sensor_names)}",
                    remedy=_instead(self.model, key, self.sensor_names, known),
                )
            self._known[key] = self._values(key, own, stored=True)
            self._tell_of_shared(key, own)
        return self._known[key]

    def _tell_of_shared(self, name: str, sensors) -> None:
        """Warn of reactions that are not unique and not zero, when they are read first."""
        shared = self.shared_reactions
        for joint in {s.joint for s in sensors if s is not None and s.reads_reactions and s.joint in shared}:
            titles = {f"{joint}: {kind}" for kind in shared[joint]}
            loaded = set()
            for number, phase in enumerate(self.phases):
                names = self.series(number).system.equation_names
                sizes = np.abs(phase.lam).max(axis=0, initial=0.0)
                least = NEGLIGIBLE * sizes.max(initial=0.0)
                loaded |= {title for title, size in zip(names, sizes, strict=True) if title in titles and size > least}
            if loaded:
                warnings.warn(
                    f"Sensor '{name}': reactions of joint '{joint}' are not unique ({', '.join(shared[joint])}); "
                    "expected: joints that share no load. Stiffness would decide how they share it, and rigid bodies "
                    "have none: the values have least norm, and only sums over the joints are known. "
                    "flexmb.check lists the equations and says how to make them unique",
                    ValidityWarning,
                    stacklevel=3,
                )

    def _values(self, name: str, sensors, stored: bool) -> np.ndarray:
        """Join the values of all phases; a phase without the sensor shows the sensor's value for "absent"."""
        pieces: list[np.ndarray | None] = []
        for number, (phase, sensor) in enumerate(zip(self.phases, sensors, strict=True)):
            if stored and name in phase.tables:
                pieces.append(phase.tables[name])
            elif sensor is not None:
                if not stored:
                    sensor.check(phase.model)
                pieces.append(np.asarray(sensor.values(self.series(number)), float))
            else:
                pieces.append(None)
        sensor = next((s for s in sensors if s is not None), None)
        shape = next(piece.shape[1:] for piece in pieces if piece is not None)
        absent = sensor.absent if sensor is not None else np.nan
        full = [
            np.full((len(phase.t), *shape), absent) if piece is None else piece
            for phase, piece in zip(self.phases, pieces, strict=True)
        ]
        return sensor.joined(full) if sensor is not None else np.concatenate(full)

    @property
    def sensor_columns(self) -> dict[str, tuple[SensorColumn, ...]]:
        """What can be asked by name, with its columns: sensors, and "tip dz" for a column of one."""
        return sensor_columns({name: self.column_titles(name) for name in self.sensor_names})

    def column_titles(self, name: str) -> tuple[str, ...]:
        """Return the titles of a sensor's columns with units, ("fx [N]", ...), or that of one column, "tip dz"."""
        if name not in self.sensor_names:
            own = columns_named(name, self.sensor_columns)
            return tuple(self.column_titles(column.sensor)[column.number] for column in own)
        for phase in self.phases:
            sensor = _sensor(phase.model, name)
            if sensor is not None:
                return tuple(sensor.columns(phase.model))
        width = self[name].shape[1:]
        return tuple(self.columns.get(name, ())) or (tuple(str(k) for k in range(width[0])) if width else ("",))

    def save(self, path: str | Path, write_model: Callable[[Any], str] | None = None) -> Path:
        """Write the solution with the values of all its sensors to an HDF5 file and return the path.

        The file takes the place of an older one when it is complete: a program that saves again and again what it has
        reached has at any time, also when it is killed, the one or the other.

        Parameters
        ----------
        path : path
        write_model : callable Model -> text, optional
            Makes the text of the model that is stored beside it (flexmb.io has one). Without it the file holds the
            samples and tables, and `load` needs the model for anything beyond the stored sensors.
        """
        bodies = floating_data(self.model) if self.model is not None else {}
        values = {name: self[name] for name in self.sensor_names}
        columns = {name: self.column_titles(name) for name in values}
        start, part = 0, f"Solution file '{path}'"
        check_folder(Path(path), part)
        with complaints(part, "write"):
            lock = Lock(path, part)
        with lock, replacing(path, part) as temporary, RunFile(temporary, bodies, part=part) as run:
            for phase in self.phases:
                rows = slice(start, start + len(phase.t))
                start = rows.stop
                run.begin(write_model(phase.model) if write_model is not None and phase.model is not None else "")
                samples = len(phase.t) - phase.cut_off  # its last row is no sample
                run.append(*(getattr(phase, name)[:samples] for name in FIELDS))
                if phase.cut_off:
                    run.reached(*(getattr(phase, name)[-1] for name in FIELDS))
                if phase.memory is not None:
                    run.remember(phase.memory)
                tables, titles = {name: array[rows] for name, array in values.items()}, dict(columns)
                if phase.inputs is not None and phase.inputs.size:
                    tables[INPUTS], titles[INPUTS] = phase.inputs, tuple(phase.system.inputs)
                run.end(phase.ended, tables, titles)
            # where the file of the run was left is nothing that this one could say
            run.finish(self.status, {name: x for name, x in self.statistics.items() if name != STORED})
        return Path(path)

    @staticmethod
    def load(path: str | Path, *, model=None, read_model: Callable[[str, dict], Any] | None = None) -> Solution:
        """Read a solution file, also one of a run that was cut off.

        Stored sensors are there without the model. For anything else give the `model` (one, or one per phase), or
        `read_model(text, {body name: ModalNeutralData})` which makes it from the text in the file.
        """
        phases, status, statistics, columns = read_solution_file(path, model=model, read_model=read_model)
        return Solution(phases=phases, status=status, statistics=statistics, columns=columns)


def _instead(model, key: str, names: tuple[str, ...], columns: Mapping[str, tuple[SensorColumn, ...]]) -> str:
    """Return what to write for a sensor that does not exist: one of a similar name, or of a part of that name."""
    plain = without_unit(key)
    if plain != key and plain in columns:
        units = dict.fromkeys(f"[{column.unit}]" if column.unit else "no unit" for column in columns[plain])
        return f"Write '{plain}', which has {' and '.join(units)}"
    if similar := did_you_mean(key, [*names, *columns]):
        return similar
    plain = "".join(c for c in key.lower() if c.isalnum())
    within = [name for name in names if plain and plain in "".join(c for c in name.lower() if c.isalnum())]
    if within:
        return f"Did you mean '{within[0]}'?"
    if model is not None:
        body, _, marker = key.partition(".")
        if any(joint.name == key for joint in model.joints):
            return f"It is a joint: solution[fmb.Reaction('{key} force', joint='{key}')]"
        if any(force.name == key for force in model.forces):
            return f"It is a force: solution[fmb.ForceOf('{key} force', force='{key}')]"
        if any(known.name == body for known in model.bodies):
            place = key if marker else f"{body}.MARKER"
            return f"Ask for a quantity of a marker: solution[fmb.Position('place', marker='{place}')]"
    return "Add the sensor to the model"


def _sensor(model, name: str):
    """Return the model's sensor of this name, or None."""
    return next((s for s in model.sensors if s.name == name), None) if model is not None else None
