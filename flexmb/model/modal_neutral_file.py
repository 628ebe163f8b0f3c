"""HDF5 file of `ModalNeutralData`: one dataset per array, names and report as JSON attributes."""

from __future__ import annotations

import json
import warnings
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from flexmb import hdf5
from flexmb.errors import ValidityWarning
from flexmb.model.modal_arrays import GeometricStiffness, InertiaInvariants, LeftOutStiffness, ModalArrays
from flexmb.model.modal_neutral_checks import checked
from flexmb.model.numbering import Numbering

__all__ = ["SCHEMA", "VERSION", "Kept", "kept_as", "load", "load_kept", "read", "save", "write"]

Data = TypeVar("Data", bound=ModalArrays)

SCHEMA = "flexmb.modal_neutral_data"
VERSION = 1
PRESSURE, ONTO = "pressure", "onto the surface"
"""Attribute of files whose load shapes of surfaces push onto them; in former times they pulled outwards."""

KNOWN = "stiffness left out"
"""Attribute of files that hold the geometric stiffness which a reduction leaves out, as far as it can be known."""

TOLD = "warnings given"
"""Dataset of a kept reduction: the warnings that were given as it was made."""
KEY = "kept as"
"""Dataset of a kept reduction: the key under which it was kept, all of what it was made from."""

_GROUPS = {"invariants": InertiaInvariants, "geometric": GeometricStiffness, "left_out": LeftOutStiffness}
_OWN = {"cells", "recipe", "node_sets", "numbering", *_GROUPS}  # written in their own way


class Kept(NamedTuple, Generic[Data]):
    """A kept reduction: its data, the warnings as (category, text), and the key; empty in a file that has none."""

    data: Data
    told: list[tuple[str, str]]
    key: str


def save(data: ModalArrays, path: str | Path, told: Sequence[tuple[str, str]] = (), key: str = "") -> Path:
    """Write `data` to `path` and return the path; an existing file is replaced only by a complete one.

    With it go categories and texts of warnings that were given as they were made, and the key of a kept reduction.
    """
    path = Path(path)
    with hdf5.writing(path, schema=SCHEMA, version=VERSION) as file:
        write(data, file)
        file.attrs[PRESSURE] = ONTO
        file.attrs[KNOWN] = "by interfaces"
        if told:
            _write_text(file, TOLD, json.dumps(list(told)))
        if key:
            _write_text(file, KEY, key)
    return path


def load_kept(path: str | Path, kind: type[Data]) -> Kept[Data]:
    """Read what `save` wrote with warnings and key; DataFileError as of `load`."""
    with hdf5.reading(path, schema=SCHEMA, version=VERSION) as file:
        told = [(str(category), str(text)) for category, text in json.loads(_text(file, TOLD) or "[]")]
        return Kept(read(file, kind), told, _text(file, KEY))


def kept_as(path: str | Path) -> tuple[str, str]:
    """Return the name of the body in a file of `save`, and its key; DataFileError as of `load`."""
    with hdf5.reading(path, schema=SCHEMA, version=VERSION) as file:
        hdf5.require_whole(file, f"Data file '{path}'")
        return str(json.loads(file.attrs["name"])), _text(file, KEY)


def load(path: str | Path, kind: type[Data]) -> Data:
    """Read what `save` wrote, as data of that class.

    DataFileError if the file is missing, foreign, damaged or of another version.
    """
    with hdf5.reading(path, schema=SCHEMA, version=VERSION) as file:
        data = read(file, kind)
        if data.load_names and file.attrs.get(PRESSURE) != ONTO:
            _tell_of_old_sign(data, path)
        if KNOWN not in file.attrs and data.geometric is None and data.n_modes:
            _tell_of_unknown_stiffness(data, path)
        return data


def write(data: ModalArrays, group) -> None:
    """Write `data` into an open HDF5 group (a solution file holds its bodies this way)."""
    for field in fields(data):
        value = getattr(data, field.name)
        if field.name in _OWN or value is None:
            continue
        if isinstance(value, np.ndarray):
            _write_array(group, field.name, value)
        else:
            group.attrs[field.name] = json.dumps(value, default=_plain)
    for name in _GROUPS:
        record = getattr(data, name)
        if record is not None:
            matrices = group.create_group(name)
            for field in fields(record):
                _write_array(matrices, field.name, getattr(record, field.name))
    if data.recipe:
        _write_text(group, "recipe", json.dumps(data.recipe, default=_plain))
    cells = group.create_group("cells")
    for number, (cell_type, connectivity) in enumerate(data.cells):
        block = _write_array(cells, str(number), np.asarray(connectivity))
        block.attrs["type"] = cell_type
    sets = group.create_group("node_sets")
    for number, (name, nodes) in enumerate(data.node_sets.items()):
        _write_array(sets, str(number), np.asarray(nodes)).attrs["name"] = name
    if data.numbering is not None:
        _write_numbering(data.numbering, group.create_group("numbering"))


def _write_numbering(numbering: Numbering, group) -> None:
    _write_array(group, "nodes", numbering.nodes)
    for number, labels in enumerate(numbering.cells):
        _write_array(group, f"cells_{number}", labels)
    if numbering.instance_of is not None:
        _write_array(group, "instance_of", numbering.instance_of)
    group.attrs["instances"] = json.dumps(numbering.instances)


def _read_numbering(group) -> Numbering:
    count = sum(name.startswith("cells_") for name in group)
    return Numbering(
        nodes=group["nodes"][()],
        cells=tuple(group[f"cells_{k}"][()] for k in range(count)),
        instances=tuple(json.loads(group.attrs["instances"])),
        instance_of=group["instance_of"][()] if "instance_of" in group else None,
    )


def read(group, kind: type[Data]) -> Data:
    """Return what `write` wrote into an open HDF5 group as data of a class; KeyError if something is missing."""
    hdf5.require_whole(group, f"Reduced body in '{group.file.filename}'")
    values = {}
    for field in fields(kind):
        name = field.name
        if name in _OWN:
            continue
        if name in group:
            values[name] = group[name][()]
        elif name in group.attrs:
            value = json.loads(group.attrs[name])
            values[name] = tuple(value) if isinstance(value, list) else value
        elif name not in ("rotation_shapes", "stress_modes", "load_turning", "preload_turning"):
            raise KeyError(f"'{name}' is missing")
    for name, record in _GROUPS.items():
        if name in group and not (name == "left_out" and "compliance" not in group[name]):  # of former times
            values[name] = record(**{f.name: group[name][f.name][()] for f in fields(record)})
    if "invariants" not in values:
        raise KeyError("'invariants' is missing")
    if "recipe" in group:
        recipe = json.loads(_text(group, "recipe"))
        values["recipe"] = recipe if isinstance(recipe, dict) else {}
    blocks = group["cells"]
    values["cells"] = tuple(
        (blocks[str(number)].attrs["type"], blocks[str(number)][()]) for number in range(len(blocks))
    )
    if "node_sets" in group:  # bodies that were reduced before have none
        values["node_sets"] = {found.attrs["name"]: found[()] for found in group["node_sets"].values()}
    if "numbering" in group:
        values["numbering"] = _read_numbering(group["numbering"])
    part = f"Reduced body '{values['name']}' in '{group.file.filename}'"
    data = checked(kind(**values), part)
    _tell_of_old_loads(data, part)
    return data


def _tell_of_old_sign(data: ModalArrays, path: str | Path) -> None:
    """Warn of load shapes that may have the former sign; in a solution file, bodies and amounts are of one time."""
    names = ", ".join(map(repr, data.load_names))
    warnings.warn(
        f"Reduced body '{data.name}' in '{path}': it was reduced when a unit pressure on a surface pulled outwards, "
        f"the opposite of today's sign; its load shape{'s' if len(data.load_names) > 1 else ''} {names} may be of "
        "that kind (tractions in a direction, line loads and nodal forces are not); expected: pressures that push onto "
        "the surface. Reduce it again from its mesh, and give suction a negative amount",
        ValidityWarning,
        stacklevel=4,
    )


def _tell_of_unknown_stiffness(data: ModalArrays, path: str | Path) -> None:
    """Warn that nothing will be told of buckling: files of former times do not hold what is needed."""
    warnings.warn(
        f"Reduced body '{data.name}' in '{path}': it has no geometric stiffness, and it is not known by how much loads "
        "change its stiffness: the file is of a former version; expected: a file that tells it. Reduce it again "
        "from its mesh or deck; until then, and for bodies of matrices alone, no run warns where it would buckle",
        ValidityWarning,
        stacklevel=4,
    )


def _tell_of_old_loads(data: ModalArrays, part: str) -> None:
    """Warn of loads whose change with the deformation is not in the file: it was not computed in former times."""
    lacking = list(data.load_names) if data.load_turning is None and data.n_modes else []
    preload = data.geometric is not None and np.any(data.geometric.preload) and data.preload_turning is None
    if not (lacking or preload):
        return
    named = [f"load shape{'s' if len(lacking) > 1 else ''} {', '.join(map(repr, lacking))}"] if lacking else []
    named += ["its preload"] if preload else []
    warnings.warn(
        f"{part}: {' and '.join(named)} cannot turn with the material, because the file does not tell how; they turn "
        "with the body frame, and stiffness and buckling under them depend on the choice of that frame; expected: a "
        "body with load_turning and preload_turning. Reduce it again from its mesh",
        ValidityWarning,
        stacklevel=4,
    )


def _write_array(group, name: str, array: np.ndarray):
    """Compress what is large: shapes and stresses of fine meshes are most of a file."""
    large = array.nbytes > 1_000_000
    return group.create_dataset(
        name, data=array, **({"compression": "gzip", "compression_opts": 1, "shuffle": True} if large else {})
    )


def _write_text(group, name: str, text: str) -> None:
    """Write a text as bytes: an attribute holds 64 kB at most."""
    _write_array(group, name, np.frombuffer(text.encode(), np.uint8))


def _text(group, name: str) -> str:
    """Return a text that was written as bytes; empty if there is none."""
    return np.asarray(group[name][()], np.uint8).tobytes().decode() if name in group else ""


def _plain(value):
    """Turn numpy numbers and arrays into what JSON can hold."""
    return value.tolist()
