"""Code that reads or writes one element of an array, a third as long as that of numba.

numba copies the array's description to memory of the function at every index, and reads all of its sizes and strides
back from there. The compiler removes that again, which takes it as long as the rest of a kernel.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir as code
from numba import types
from numba.cpython.slicing import fix_index
from numba.np.arrayobj import load_item, store_item

__all__ = ["element", "is_element", "write_element"]


def is_element(array: types.Type, index: types.Type) -> bool:
    """Does an index of integers say which element of an array of numbers or records is meant?"""
    places = tuple(index) if isinstance(index, types.BaseTuple) else (index,)
    return (
        type(array) is types.Array
        and array.layout in "CA"
        and isinstance(array.dtype, (types.Number, types.Boolean, types.Record))
        and len(places) == array.ndim > 0
        and all(isinstance(place, types.Integer) for place in places)
    )


def element(context: Any, builder: code.IRBuilder, kinds: tuple, values: tuple) -> code.Value:
    """Return the element of an array at an index; `kinds` and `values` are those of both."""
    return load_item(context, builder, kinds[0], _address(context, builder, kinds, values))


def write_element(context: Any, builder: code.IRBuilder, kinds: tuple, values: tuple, number: code.Value) -> None:
    """Write a number of the array's own type to its element at an index."""
    store_item(context, builder, kinds[0], number, _address(context, builder, kinds, values))


def _address(context: Any, builder: code.IRBuilder, kinds: tuple, values: tuple) -> code.Value:
    (kind, index_kind), (array, index) = kinds, values
    model = context.data_model_manager[kind]

    def field(name: str) -> code.Value:
        return builder.extract_value(array, model.get_field_position(name))

    if isinstance(index_kind, types.BaseTuple):
        given = [(one, builder.extract_value(index, k)) for k, one in enumerate(index_kind)]
    else:
        given = [(index_kind, index)]
    sizes = field("shape")
    places = [_from_start(context, builder, one, value, sizes, k) for k, (one, value) in enumerate(given)]
    if kind.layout == "C":
        at = places[0]
        for k, place in enumerate(places[1:], 1):
            at = builder.add(builder.mul(at, builder.extract_value(sizes, k)), place)
        return builder.gep(field("data"), [at])
    strides = field("strides")
    steps = [builder.mul(builder.extract_value(strides, k), place) for k, place in enumerate(places)]
    offset = steps[0]
    for step in steps[1:]:
        offset = builder.add(offset, step)
    data = field("data")
    bytes_of = builder.bitcast(data, code.IntType(8).as_pointer())
    return builder.bitcast(builder.gep(bytes_of, [offset]), data.type)


def _from_start(context: Any, builder: code.IRBuilder, kind, value, sizes, axis: int) -> code.Value:
    """Return a place counted from the start of an axis: negative ones count from its end."""
    if not kind.signed:
        return context.cast(builder, value, kind, types.uintp)
    place = context.cast(builder, value, kind, types.intp)
    if isinstance(place, code.Constant) and place.constant >= 0:
        return place
    return fix_index(builder, place, builder.extract_value(sizes, axis))
