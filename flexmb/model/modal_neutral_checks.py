"""What must hold of modal neutral data before anything is computed with them: shapes, indices, finite numbers.

Kernels read packed data without looking at bounds, and the libraries that draw read node numbers likewise, so that
every reader of a file passes what it has read through `checked`.
"""

from __future__ import annotations

from dataclasses import fields
from typing import Any, TypeVar

import numpy as np

from flexmb.errors import DataFileError, ModelError
from flexmb.model.modal_arrays import ModalArrays
from flexmb.model.mode_table import left_out_compliance

__all__ = ["check_modes", "check_shapes", "checked", "selected_quality"]

Data = TypeVar("Data", bound=ModalArrays)

_REMEDY = "Make the data with reduction.reduce, or see its fields"


def check_shapes(data: ModalArrays) -> None:
    """Raise ModelError unless all arrays are numbers of shapes that fit each other."""
    part = f"Modal neutral data '{data.name}'"
    m = np.shape(data.stiffness)[0] if np.ndim(data.stiffness) else 0
    n, k, loads = len(data.nodes), len(data.marker_names), len(data.load_names)
    expected: dict[str, tuple[int, ...]] = {
        "nodes": (n, 3),
        "shapes": (n, 3, m),
        "rotation_shapes": (n, 3, m),
        "marker_positions": (k, 3),
        "marker_translations": (k, 3, m),
        "marker_rotations": (k, 3, m),
        "stiffness": (m, m),
        "frequencies": (m,),
        "damping_ratios": (m,),
        "load_shapes": (loads, 6 + m),
        "load_turning": (loads, 6 + m, m),
        "preload_turning": (6 + m, m),
        "stress_modes": (n, 6, m),
    }
    for name, shape in expected.items():
        _check(part, name, getattr(data, name), shape)
    i = {"vv": (3, 3), "vw0": (3, 3), "vw1": (m, 3, 3), "vn": (3, m), "ww0": (3, 3), "ww1": (m, 3, 3)}
    i |= {"ww2": (m, m, 3, 3), "wn0": (3, m), "wn1": (m, 3, m), "nn": (m, m)}
    for name, shape in i.items():
        _check(part, f"invariants.{name}", getattr(data.invariants, name), shape)
    if not 0 <= data.n_interfaces <= k:
        raise ModelError(
            part, found=f"{data.n_interfaces} interfaces", expected=f"0 to {k}, the number of markers", remedy=_REMEDY
        )
    if data.geometric is not None:
        for name, shape in _unit_loads(m, data.n_interfaces, loads).items():
            _check(part, f"geometric.{name}", getattr(data.geometric, name), shape)
    if data.left_out is not None:
        soft = np.shape(data.left_out.preload)[-1] - 3 if np.ndim(data.left_out.preload) else 0
        n = data.n_interfaces
        motions = {"translations": (n, 3, soft), "turns": (n, 3, soft), "compliance": (6 * n, 6 * n)}
        expected = _unit_loads(soft + 3, n, loads) | motions
        for name, shape in expected.items():
            _check(part, f"left_out.{name}", getattr(data.left_out, name), shape)


def _unit_loads(m: int, interfaces: int, loads: int) -> dict[str, tuple[int, ...]]:
    """Return the shapes of the arrays of geometric stiffness on m coordinates."""
    return {
        "inertia": (12, m, m),
        "interface": (interfaces, 6, m, m),
        "loads": (loads, m, m),
        "preload": (m, m),
    }


def _check(part: str, name: str, value: Any, shape: tuple[int, ...]) -> None:
    if value is None and name in ("rotation_shapes", "stress_modes", "load_turning", "preload_turning"):
        return
    found = np.shape(value)
    if found != shape:
        raise ModelError(part, found=f"{name} has the shape {found}", expected=f"{shape}", remedy=_REMEDY)
    kind = np.asarray(value).dtype.kind
    if kind not in "fiu":
        raise ModelError(part, found=f"{name} holds no real numbers (kind '{kind}')", expected="floats", remedy=_REMEDY)


def checked(data: Data, part: str) -> Data:
    """Return data that were read from a file; DataFileError if they are no body that can move.

    Checked are finite numbers, cells of existing nodes, names that differ, a positive mass, modal masses that are
    positive and stiffnesses that are not negative.
    """
    _check_kinds(data, part)
    _check_numbers(data, part)
    for kind, cells in data.cells:
        if cells.size and (cells.min() < 0 or cells.max() >= len(data.nodes)):
            worst = cells.max() if cells.max() >= len(data.nodes) else cells.min()
            raise _refused(part, f"{kind} cells name the node {worst}", f"nodes 0 to {len(data.nodes) - 1}")
    _check_places(data, part)
    for word, names in (("marker", data.marker_names), ("load shape", data.load_names)):
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise _refused(part, f"two of the name '{twice[0]}' ({word})", "names that differ")
    if data.mass <= 0.0:
        raise _refused(part, f"a mass of {data.mass:.6g} kg", "a mass > 0")
    check_modes(part, np.diag(data.invariants.nn), np.diag(data.stiffness))
    return data


def _check_kinds(data: ModalArrays, part: str) -> None:
    """Raise DataFileError unless names are texts and cells are numbers of nodes."""
    texts = (data.name, data.frame, *data.marker_names, *data.load_names, *(kind for kind, _ in data.cells))
    lists = (data.marker_names, data.load_names, data.cells)
    right = all(isinstance(text, str) for text in texts) and all(isinstance(names, tuple) for names in lists)
    if not right or not isinstance(data.quality, dict) or not isinstance(data.n_interfaces, int):
        raise _refused(part, "names or numbers of another type", "texts, a number of interfaces, a quality report")
    for kind, cells in data.cells:
        if cells.ndim != 2 or cells.dtype.kind not in "iu":
            raise _refused(part, f"{kind} cells of the shape {cells.shape} and type {cells.dtype}", "node numbers")


def _check_numbers(data: ModalArrays, part: str) -> None:
    """Raise DataFileError unless all numbers are finite, and none is absurd."""
    arrays = {f.name: getattr(data, f.name) for f in fields(data)}
    arrays |= {f"invariants.{f.name}": getattr(data.invariants, f.name) for f in fields(data.invariants)}
    for group in ("geometric", "left_out"):
        record = getattr(data, group)
        if record is not None:
            arrays |= {f"{group}.{f.name}": getattr(record, f.name) for f in fields(record)}
    for name, value in arrays.items():
        if isinstance(value, np.ndarray) and not np.isfinite(value).all():
            wrong = np.argwhere(~np.isfinite(value))[0].tolist()
            raise _refused(part, f"{name}{wrong} is {value[tuple(wrong)]}", "finite numbers")
        if isinstance(value, np.ndarray) and value.size and np.abs(value).max() > _LARGEST:
            raise _refused(part, f"{name} holds {np.abs(value).max():.3g}", f"numbers up to {_LARGEST:g} in SI units")


def _check_places(data: ModalArrays, part: str) -> None:
    """Raise DataFileError unless node sets and the numbers of the file fit the nodes and cells."""
    n = len(data.nodes)
    for name, nodes in data.node_sets.items():
        if not isinstance(name, str) or not _whole(nodes) or (nodes.size and not 0 <= nodes.min() <= nodes.max() < n):
            raise _refused(part, f"the node set '{name}' with nodes that do not exist", f"nodes 0 to {n - 1}")
    own = data.numbering
    if own is None:
        return
    counts = [len(cells) for _, cells in data.cells]
    tables = (own.nodes, *own.cells)
    fits = all(_whole(table) for table in tables) and [len(table) for table in tables] == [n, *counts]
    known = all(isinstance(name, str) for name in own.instances)
    if own.instance_of is not None:
        known &= _whole(own.instance_of) and len(own.instance_of) == n
        known = known and bool(np.all((own.instance_of >= -1) & (own.instance_of < len(own.instances))))
    if not fits or not known:
        raise _refused(part, "numbers of the deck that do not fit the nodes and cells", f"{n} and {counts} numbers")


def _whole(array: Any) -> bool:
    return isinstance(array, np.ndarray) and array.ndim == 1 and array.dtype.kind in "iu"


def selected_quality(data: ModalArrays, modes: np.ndarray) -> dict[str, Any]:
    """Return the quality report with the rows of some modes (int indices) only."""
    rows = data.quality.get("modes", [])
    if data.quality and (not isinstance(rows, list) or len(rows) <= max(modes, default=-1)):
        raise ModelError(
            f"Modal neutral data '{data.name}'",
            found="a quality report of other modes",
            expected=f"a row for each of the {data.n_modes} modes",
            remedy="Reduce the part again: the file is damaged",
        )
    if not data.quality:
        return data.quality
    if len(np.unique(modes)) == len(rows):
        return {**data.quality, "modes": [rows[k] for k in modes]}
    # bounds hold for all shapes together
    kept = {name: value for name, value in data.quality.items() if name != "transfer"}
    for words in ("tracks", "contact"):
        if words in kept:
            kept[words] = {name: _without_missing(one) for name, one in kept[words].items()}
    mean, worst = left_out_compliance(data, modes)
    told = (
        f"{len(modes)} of {len(rows)} coordinates are kept: static error, frequencies and effective masses are "
        f"those of all. {100.0 * mean:.3g} % of the static deflection of the interfaces under their own loads is left "
        f"out, {100.0 * worst:.3g} % of one of them. Reduce again with fewer modes to keep statics."
    )
    return {**kept, "modes": [rows[k] for k in modes], "warnings": [*kept.get("warnings", []), told]}


def _without_missing(told: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in told.items() if not name.startswith("missing")}


def check_modes(part: str, modal: np.ndarray, stiffness: np.ndarray) -> None:
    """Raise DataFileError unless modal masses (m,), kg, are positive and stiffnesses (m,), N/m, not negative."""
    wrong = np.flatnonzero(~((modal > 0.0) & (stiffness >= 0.0)))
    if len(wrong):
        j = int(wrong[0])
        raise _refused(
            part,
            f"mode {j + 1} has the modal mass {modal[j]:.6g} kg and the stiffness {stiffness[j]:.6g} N/m",
            "a mass > 0 and a stiffness >= 0",
        )


_LARGEST = 1e60
"""Products of such numbers stay finite; nothing that is built comes near."""


def _refused(part: str, found: str, expected: str) -> DataFileError:
    return DataFileError(
        part,
        found=found,
        expected=expected,
        remedy="The file is damaged, or was written with wrong settings: write it again",
    )
