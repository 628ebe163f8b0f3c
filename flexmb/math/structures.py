"""Structures of arrays that kernels take apart by name, each declared once.

A structure is a `NamedTuple` whose annotations say what its fields hold. Its constructor takes the fields by name, the
texts below them are its documentation, and numba's type follows from the annotations (`numba_type`), so that a new
field is one line. Numbers that stand alone and change are the fields of a `Record`: a structure holds a table of one
row of it, ``work.energy[0].kinetic`` in kernels and in Python.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, get_args, get_origin, get_type_hints

import numpy as np
from numba import from_dtype, types

from flexmb.math.structure_type import Structure, read_as_structure

__all__ = [
    "ArrayOf",
    "Bytes",
    "FloatRows",
    "Floats",
    "IntegerRows",
    "Integers",
    "Record",
    "array_type",
    "counted",
    "numba_type",
    "structure",
]


def array_type(dtype: np.dtype, ndim: int = 1):
    """Return the type of arrays of numbers or records."""
    return types.Array(from_dtype(dtype), ndim, "C")


class ArrayOf:
    """Annotation of a field: an array of numbers or records with so many axes."""

    def __init__(self, dtype, ndim: int = 1):
        self.numba = array_type(np.dtype(dtype), ndim)


Floats = Annotated[np.ndarray, ArrayOf(float)]
FloatRows = Annotated[np.ndarray, ArrayOf(float, 2)]
Integers = Annotated[np.ndarray, ArrayOf(np.int64)]
IntegerRows = Annotated[np.ndarray, ArrayOf(np.int64, 2)]
Bytes = Annotated[np.ndarray, ArrayOf(np.uint8)]


class Record:
    """Ancestor of records: numbers by name, `float` or `int`, that a kernel changes in place."""

    dtype: ClassVar[np.dtype]

    def __init_subclass__(cls) -> None:
        kinds = get_type_hints(cls, include_extras=True)
        own = {name: kind for name, kind in kinds.items() if get_origin(kind) is not ClassVar}
        made = [(name, np.dtype(float if kind is float else np.int64)) for name, kind in own.items()]
        # elements of an array of numpy records have their fields as attributes, as those of kernels do
        cls.dtype = np.dtype((np.record, np.dtype(made, align=True)))

    @classmethod
    def table(cls, **values: float) -> np.ndarray:
        """Return a table of one row; fields that are not given are zero."""
        row = np.zeros(1, cls.dtype)
        for name, value in values.items():
            row[name] = value
        return row


def counted(table: np.ndarray, names: Sequence[str]) -> dict[str, int]:
    """Return fields of the first row as whole numbers, by their names in words."""
    return {name.replace("_", " "): int(table[name][0]) for name in names}


def numba_type(kind: Any) -> types.Type:
    """Return the numba type of a structure, from its annotations."""
    hints = get_type_hints(kind, include_extras=True)
    return Structure(kind, tuple(_field_type(hints[name]) for name in kind._fields))


def structure(kind: type) -> type:
    """Declare a `NamedTuple` as a structure: kernels get its address (see `structure_type`)."""
    read_as_structure(kind)
    return kind


def _field_type(hint: Any) -> types.Type:
    """Return the numba type of one field."""
    if get_origin(hint) is Annotated:
        return get_args(hint)[1].numba
    return {float: types.float64, int: types.int64, bool: types.boolean}.get(hint) or numba_type(hint)
