"""`write_fmu`: a model as a functional mock-up unit for co-simulation (FMI 3.0 or 2.0)."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flexmb.errors import DataFileError, ModelError
from flexmb.files import complaints
from flexmb.fmi.inside import MODEL_FILE, model_inputs, output_names, variable_name
from flexmb.fmi.unit_parameters import TUNABLE_FILE, start_values, write_places
from flexmb.integrate import Plant
from flexmb.io import Simulation, save_model, write_plant
from flexmb.model.model import Model

__all__ = ["ports", "write_fmu"]

PLANT_FILE = "plant.mat"
SCRIPT = '''"""The unit's entry: flexmb runs the model in this folder."""

from {package} import {slave}

import flexmb.fmi.slaves


class {name}(flexmb.fmi.slaves.{motion}, {slave}):
    pass
'''


def ports(model: Model) -> tuple[list[str], list[str]]:
    """Return the names of the inputs and outputs that a unit of the model has."""
    return [variable_name(name) for name in model_inputs(model)], list(output_names(model))


def write_fmu(
    model: Model,
    path: str | Path,
    *,
    settings: Simulation | None = None,
    version: int = 3,
    parameters: Mapping[str, str] | None = None,
    tunable: Mapping[str, str] | None = None,
    plant: Plant | None = None,
) -> Path:
    """Write a model as a unit for co-simulation, and return its path.

    Its inputs are the model's (`flexmb.input`), its outputs all columns of its sensors. States can be got and
    set (steps taken back). The unit holds the model file and its reduced bodies, no solver: it runs in hosts that load
    a Python interpreter with flexmb in it (FMPy does); elsewhere it is refused when it is loaded.

    Parameters
    ----------
    model : Model
    path : path
        Ends in ".fmu"; the stem is the name of the unit, an identifier.
    settings : Simulation, optional
        Integrator, and the time for which steps are planned; 1 s by default.
    version : 3 or 2
        Of FMI; made with pythonfmu3 or pythonfmu (``pip install "flexmb[fmi]"``). A host must load a unit of version 2
        only once in a process: with pythonfmu 0.7 the second load ends it.

    parameters : mapping of variable to "part.field", optional
        Numbers of parts that a host may set before the start: ``{"stiffness": "spring.stiffness"}``.
    tunable : mapping of variable to "part.field", optional
        The same, which a host may also set between steps: the run goes on from its state with the changed part.
    plant : Plant, optional
        A linearisation of the model, put beside it as ``resources/plant.mat`` (A, B, C, D, names and units): hosts
        cannot ask the unit itself for directional derivatives.

    Raises
    ------
    ModelError
        The model cannot be stored (functions in Python), or variables of the same name.
    DataFileError
        The package is missing, or the file cannot be written.

    Source: FMI 3.0.1, sections 2.4 and 4.
    """
    path = Path(path)
    _require_file_name(path, version)
    places, changing = parameters or {}, tunable or {}
    _require_different_names(model, places, changing)
    builder, package, options = _builder(version)
    settings = Simulation(t_end=1.0) if settings is None else settings
    with tempfile.TemporaryDirectory(prefix="flexmb_fmu_") as folder:
        parts, made = Path(folder) / "parts", Path(folder) / "made"
        save_model(model, parts / MODEL_FILE, settings)  # says what a file cannot hold
        _write_beside(parts, places, changing, plant)
        script = Path(folder) / f"{path.stem}_fmi{version}.py"
        words = {"package": package, "slave": f"Fmi{version}Slave", "motion": f"Fmi{version}Motion", "name": path.stem}
        script.write_text(SCRIPT.format(**words), encoding="utf-8")
        try:
            builder.build_FMU(script, dest=made, project_files=sorted(parts.iterdir()), **options)
        finally:
            sys.modules.pop(script.stem, None)  # it was imported to describe the unit
        built = (made / f"{path.stem}.fmu").read_bytes()
    with complaints(f"FMU '{path}'", "write"):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(built)
    return path


def _require_file_name(path: Path, version: int) -> None:
    """Raise ModelError unless a unit of this version may have this name."""
    if version not in (2, 3):
        raise ModelError("FMU", found=f"version = {version!r}", expected="3 or 2", remedy="Write version=3")
    if path.suffix != ".fmu" or not path.stem.isidentifier() or not path.stem.isascii():
        raise ModelError(
            "FMU",
            found=f"the file name '{path.name}'",
            expected="an identifier and .fmu, as 'four_bar.fmu': it names the unit and its functions",
            remedy="Use letters, digits and underscores",
        )


def _require_different_names(model: Model, places: Mapping[str, str], changing: Mapping[str, str]) -> None:
    """Raise ModelError where variables of a unit have the same name, or a place is none of the model."""
    inputs, outputs = ports(model)
    known = [*start_values(model, places), *start_values(model, changing)]
    names = [*inputs, *outputs, *(variable_name(name) for name in known)]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ModelError(
            "FMU",
            found=f"several variables of the name '{twice[0]}'",
            expected="inputs and sensors of different names",
            remedy="Rename the input or the sensor",
        )


def _write_beside(folder: Path, places: Mapping[str, str], changing: Mapping[str, str], plant: Plant | None) -> None:
    """Write what a unit holds beside its model: where its parameters are in it, and a linearisation."""
    if places:
        write_places(folder, places)
    if changing:
        write_places(folder, changing, TUNABLE_FILE)
    if plant is not None:
        write_plant(plant, folder / PLANT_FILE)


def _builder(version: int) -> tuple[Any, str, dict[str, bool]]:
    """Return the builder, its package, and the options of the unit."""
    package = {3: "pythonfmu3", 2: "pythonfmu"}[version]
    state = {3: "canGetAndSetFMUState", 2: "canGetAndSetFMUstate"}[version]
    try:
        if version == 3:
            from pythonfmu3.builder import FmuBuilder
        else:
            from pythonfmu.builder import FmuBuilder
    except ImportError:
        raise DataFileError(
            "FMU",
            found=f"the package {package} is not installed",
            expected=f"{package}, which builds units of FMI {version}",
            remedy='pip install "flexmb[fmi]"',
        ) from None
    return FmuBuilder, package, {state: True, "canHandleVariableCommunicationStepSize": True}
