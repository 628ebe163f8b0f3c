"""Where the rows of forces stand in the compiled tables, and which of them have kinks."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.constraints.loop import LOOP
from flexmb.model.model import Model
from flexmb.model.table import Table
from flexmb.system.loops import Loops

__all__ = ["rows_of_forces", "switches_of"]


def rows_of_forces(model: Model, tables: list[Table], starts: np.ndarray) -> np.ndarray:
    """Return (kind, first byte, last byte) of the row of every force, (nf, 3)."""
    kinds = {table.name: k for k, table in enumerate(tables)}
    used = [0] * len(tables)
    rows = np.zeros((len(model.forces), 3), np.int64)
    for n, force in enumerate(model.forces):
        k = kinds[force.table.name]
        size = force.table.row.itemsize
        first = starts[k] + used[k] * size
        rows[n] = k, first, first + size
        used[k] += 1
    return rows


def switches_of(
    model: Model, tables: list[Table], rows: list[np.ndarray], starts: np.ndarray, loops: Loops
) -> dict[str, Any]:
    """Return what a system knows of kinks: (address, first byte, last byte, number of switches, address of the sweep or
    0) of the kinds with one, the force or block of every switch, and which kinks are not located.
    """
    kinds, owners = [], []
    for table, array, first, last in zip(tables, rows, starts[:-1], starts[1:], strict=True):
        if not table.switches:
            continue
        counts = array[table.switches] if isinstance(table.switches, str) else np.full(len(array), table.switches)
        if not np.sum(counts):
            continue
        sweep = table.kernels["sweep"].compiled.address if "sweep" in table.kernels else 0
        kinds.append((table.kernels["switch"].compiled.address, first, last, int(np.sum(counts)), sweep))
        if table is LOOP:
            owners += [title for _, _, title in loops.kinks]
            continue
        forces = [force.title for force in model.forces if force.table.name == table.name]
        owners += [title for title, count in zip(forces, counts, strict=True) for _ in range(count)]
    return {
        "switch_kinds": np.array(kinds, np.int64).reshape(-1, 5),
        "switch_owners": tuple(owners),
        "unlocated": tuple(dict.fromkeys(loops.unlocated)),
    }
