"""Small arrays that a kernel makes and does not give away stand in memory of the function, not on the heap.

numba asks the heap for each of them, gives it back, and counts references between, which in kernels of a few dozen
numbers takes longer than the numbers. A function that returns no array cannot give one away, so ``np.empty(3)`` and
``np.zeros((3, 3))`` in it need none of that. In a loop an array may outlive the turn that made it, and in a generator
the step; those stay with numba, and so do all arrays of a function that returns a record (which is the address of a
row), raises an error with a value, or has lists.
"""

from __future__ import annotations

import operator
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir as code
from numba import types
from numba.core import cgutils, ir
from numba.core.analysis import compute_cfg_from_blocks
from numba.np.arrayobj import populate_array

__all__ = ["Room", "keeps", "own_rooms", "take_room"]

LARGEST = 4096
"""Bytes of the largest of these arrays: what all functions that are at work take together stays far below a stack."""

LINE = 64
"""Bytes that the processor's memory takes at once: rows of whole lines begin at one."""

CONTAINERS = (
    types.List,
    types.ListType,
    types.DictType,
    types.Set,
    types.ClassInstanceType,
    types.Generator,
)
"""What an array can be put into, and live on."""

ANY = 16
"""Bytes whose multiples all others begin at: rows of a record are bytes to the compiler, which may stand anywhere."""

OPERATIONS = (operator.add, operator.sub, operator.mul)


class Room(NamedTuple):
    """An array of constant size."""

    kind: types.Array
    shape: tuple[int, ...]
    zeros: bool


def own_rooms(function: ir.FunctionIR, kinds: Mapping[str, types.Type], returned: types.Type, context: Any) -> dict:
    """Return the arrays, each a `Room`, that a typed function can keep in its own memory, by the calls (their `id`)
    that make them.
    """
    if function.is_generator or any(map(keeps, kinds.values())) or _gives_away(returned, context):
        return {}
    if any(_raises_values(block) for block in function.blocks.values()):
        return {}
    graph = compute_cfg_from_blocks(function.blocks)
    repeated = {place for loop in graph.loops().values() for place in loop.body}
    found = {}
    for place, block in function.blocks.items():
        if place in repeated:
            continue
        for one in block.find_insts(ir.Assign):
            room = _room(one, kinds, function, context)
            if room is not None:
                found[id(one.value)] = room
    return found


def keeps(kind: types.Type) -> bool:
    """Can an array be put into a value of a type, or into a part of it, and live on there?"""
    if isinstance(kind, types.Optional):
        return keeps(kind.type)
    return isinstance(kind, CONTAINERS) or (isinstance(kind, types.BaseTuple) and any(map(keeps, kind)))


def _gives_away(returned: types.Type, context: Any) -> bool:
    """Does a returned value hold an array, or the address of a row of one?"""
    if isinstance(returned, types.Optional):
        return _gives_away(returned.type, context)
    if isinstance(returned, types.BaseTuple):
        return any(_gives_away(kind, context) for kind in returned)
    return isinstance(returned, types.Record) or context.data_model_manager[returned].contains_nrt_meminfo()


def _raises_values(block: ir.Block) -> bool:
    """Does a block raise an error with values that are read when the function has ended?"""
    return any(isinstance(one, (ir.DynamicRaise, ir.DynamicTryRaise)) for one in block.body)


def _room(one: ir.Assign, kinds: Any, function: ir.FunctionIR, context: Any) -> Room | None:
    call, kind = one.value, kinds[one.target.name]
    if not (isinstance(call, ir.Expr) and call.op == "call" and call.args and type(kind) is types.Array):
        return None
    maker = getattr(kinds[call.func.name], "typing_key", None)
    if maker not in (np.empty, np.zeros) or call.vararg is not None or kind.layout != "C":
        return None
    size = _constant(call.args[0], function)
    shape = (size,) if isinstance(size, int) else size
    if (
        not isinstance(shape, tuple)
        or not 0 < len(shape) == kind.ndim
        or not all(isinstance(n, int) and n > 0 for n in shape)
    ):
        return None
    bytes_of_one = context.get_abi_sizeof(context.get_data_type(kind.dtype))
    if int(np.prod(shape)) * bytes_of_one > LARGEST:
        return None
    return Room(kind, shape, maker is np.zeros)


def _constant(value: Any, function: ir.FunctionIR) -> Any:
    """Return the integer, or the tuple of integers, that an expression always has; None if it is none."""
    if isinstance(value, ir.Var):
        try:
            return _constant(function.get_definition(value), function)
        except KeyError:  # it has several
            return None
    if isinstance(value, (ir.Const, ir.Global, ir.FreeVar)):
        return value.value if type(value.value) in (int, tuple) else None
    if isinstance(value, ir.Expr) and value.op == "build_tuple":
        return tuple(_constant(item, function) for item in value.items)
    if isinstance(value, ir.Expr) and value.op == "binop" and value.fn in OPERATIONS:
        left, right = _constant(value.lhs, function), _constant(value.rhs, function)
        return value.fn(left, right) if type(left) is type(right) is int else None
    return None


def take_room(context: Any, builder: code.IRBuilder, room: Room) -> code.Value:
    """Return the array."""
    number = context.get_data_type(room.kind.dtype)
    size, count = context.get_abi_sizeof(number), int(np.prod(room.shape))
    first = cgutils.alloca_once(builder, number, size=context.get_constant(types.intp, count))
    first.align = LINE if room.shape[-1] * size % LINE == 0 else ANY
    if room.zeros:
        cgutils.memset(builder, first, context.get_constant(types.intp, count * size), 0)
    steps = [size * int(np.prod(room.shape[k + 1 :])) for k in range(len(room.shape))]
    array = context.make_array(room.kind)(context, builder)
    populate_array(
        array,
        data=first,
        shape=[context.get_constant(types.intp, n) for n in room.shape],
        strides=[context.get_constant(types.intp, step) for step in steps],
        itemsize=context.get_constant(types.intp, size),
        meminfo=None,
    )
    return array._getvalue()
