"""How kernels hold a structure: by the address of a block of memory that its caller has filled.

numba's own tuples are values: every call copies all fields of all tables, some hundred words, and every function that
is compiled names them one by one. A structure never changes while a kernel runs and kernels make none, so its address
is enough. The block is filled where Python calls (`_fill`), from the arrays that the named tuple holds; they are
borrowed from it, without counting references. A structure in a structure is part of its block.

numba sees a type of its own with the fields as attributes; there is no index, no length and no way back to Python.
"""

from __future__ import annotations

from functools import cached_property
from hashlib import blake2b
from inspect import signature
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.typing.templates import AttributeTemplate, make_callable_template
from numba.extending import NativeValue, infer_getattr, lower_getattr_generic, register_model, typeof_impl, unbox

__all__ = ["Structure", "field_value", "made_structure", "read_as_structure", "seen"]

WORD = 8  # bytes; every field begins at a multiple
LARGE = 2**62  # whole numbers below are of one type
NUMBERS = float, bool, np.float64, np.bool_
BYTE, LONG, INT = ir.IntType(8), ir.IntType(64), ir.IntType(32)


class Structure(types.Type):
    """The type of a structure: its class and the types of its fields."""

    def __init__(self, kind: Any, members: tuple[types.Type, ...]):
        self.kind = kind
        self.types = members
        super().__init__(name=f"{kind.__module__}.{kind.__qualname__}{kind._fields}({', '.join(map(str, members))})")

    @property
    def key(self) -> tuple:
        return self.kind, self.types

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        """Asked for at every use of every field."""
        return hash(self.key)

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what another process works out anew: hashes of texts and classes differ there."""
        return {name: value for name, value in vars(self).items() if name not in ("_hash", "mangling_args")}

    def __eq__(self, other) -> bool:
        return self is other or (isinstance(other, Structure) and self.key == other.key)

    @cached_property
    def mangling_args(self) -> tuple[str, tuple]:
        """A short name for symbols, instead of one with all fields of all tables."""
        return f"{self.kind.__name__}_{blake2b(self.name.encode(), digest_size=6).hexdigest()}", ()

    def place(self, name: str) -> int:
        """Return the number of a field."""
        return self.kind._fields.index(name)


_types: dict[tuple, Structure] = {}
"""Types of structures by what they depend on: numba makes the type of every array of records anew, field by field."""


def seen(values: tuple[Any, ...]) -> tuple | None:
    """Return all that the types of the fields of a structure, or of arguments, depend on; None if there is something
    else than arrays, numbers and structures of them.
    """
    parts: list[Any] = [type(values)]
    for value in values:
        kind = type(value)
        if kind is np.ndarray:
            parts.append((value.dtype, value.ndim, value.flags.num))
        elif kind in NUMBERS or (kind is int and abs(value) < LARGE):
            parts.append(kind)
        elif isinstance(value, tuple) and hasattr(value, "_fields"):
            inner = seen(value)
            if inner is None:
                return None
            parts.append(inner)
        else:
            return None
    return tuple(parts)


def read_as_structure(kind: Any) -> None:
    """Let numba see instances of a named tuple as structures, those too that kernels make."""

    @typeof_impl.register(kind)
    def _type_of(value, context):
        known = seen(value)
        if known is not None and known in _types:
            return _types[known]
        members = tuple(typeof_impl(field, context) for field in value)
        if None in members:
            return None
        found = Structure(kind, members)
        if known is not None:
            _types[known] = found
        return found

    @infer_getattr
    class _Constructor(AttributeTemplate):
        key = types.NamedTupleClass(kind)

        def resolve___call__(self, _):
            call = signature(kind)

            def typer(*given, **named):
                return Structure(kind, tuple(map(types.unliteral, call.bind(*given, **named).args)))

            typer.pysig = call
            return types.Function(make_callable_template(kind, typer))


@infer_getattr
class _Fields(AttributeTemplate):
    key = Structure

    def generic_resolve(self, kind, name):
        return kind.types[kind.place(name)] if name in kind.kind._fields else None


@register_model(Structure)
class _Address(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, ir.PointerType(BYTE))


_layouts: dict[Structure, tuple[list[int], int]] = {}
"""Of every structure on this machine: LLVM is asked for sizes by a module of text for each type, which takes long."""


def _layout(context: Any, kind: Structure) -> tuple[list[int], int]:
    """Return where the fields begin, bytes, and the size of the block."""
    if kind in _layouts:
        return _layouts[kind]
    places, end = [], 0
    for member in kind.types:
        places.append(end)
        size = (
            _layout(context, member)[1]
            if isinstance(member, Structure)
            else context.get_abi_sizeof(context.get_data_type(member))
        )
        end += -(-size // WORD) * WORD
    _layouts[kind] = places, end
    return places, end


def field_value(context: Any, builder: ir.IRBuilder, kind: Structure, address: ir.Value, name: str) -> ir.Value:
    """Return the value of a field: an address in the same block, if that is a structure."""
    place = kind.place(name)
    member = kind.types[place]
    pointer = cgutils.pointer_add(builder, address, _layout(context, kind)[0][place])
    if isinstance(member, Structure):
        return pointer
    data = builder.bitcast(pointer, ir.PointerType(context.get_data_type(member)))
    return context.data_model_manager[member].load_from_data_pointer(builder, data)


def made_structure(context: Any, builder: ir.IRBuilder, kind: Structure, values: list[ir.Value]) -> ir.Value:
    """Return the address of a block in this function that holds values of the fields."""
    places, size = _layout(context, kind)
    block = cgutils.alloca_once(builder, ir.ArrayType(LONG, max(size // WORD, 1)))
    address = builder.bitcast(block, ir.PointerType(BYTE))
    for place, member, value in zip(places, kind.types, values):
        _store(context, builder, member, cgutils.pointer_add(builder, address, place), value)
    return address


def _store(context: Any, builder: ir.IRBuilder, member: types.Type, pointer: ir.Value, value: ir.Value) -> None:
    data = builder.bitcast(pointer, ir.PointerType(context.get_data_type(member)))
    builder.store(context.data_model_manager[member].as_data(builder, value), data)


@lower_getattr_generic(Structure)
def _field(context, builder, kind, address, name):
    return field_value(context, builder, kind, address, name)


@unbox(Structure)
def _unboxed(kind, tuple_object, c):
    size = _layout(c.context, kind)[1]
    block = cgutils.alloca_once(c.builder, ir.ArrayType(LONG, max(size // WORD, 1)))
    address = c.builder.bitcast(block, ir.PointerType(BYTE))
    failed = c.builder.call(_fill(c, kind), [tuple_object, address])
    return NativeValue(address, is_error=c.builder.icmp_unsigned("!=", failed, INT(0)))


def _fill(c: Any, kind: Structure) -> ir.Function:
    """Return a function of this module, (tuple, block) -> 0 or -1, that fills a block from a named tuple.

    Arrays are read in one loop over a table of their places, so that little code is made for many fields.
    """
    module = c.builder.module
    name = f"fill_{kind.mangling_args[0]}"
    if name in module.globals:
        return module.globals[name]
    pointer = ir.PointerType(BYTE)
    function = ir.Function(module, ir.FunctionType(INT, [c.pyapi.pyobj, pointer]), name)
    function.linkage = "internal"
    function.attributes.add("noinline")
    builder = ir.IRBuilder(function.append_basic_block())
    values, block = function.args
    api = c.context.get_python_api(builder)
    places = _layout(c.context, kind)[0]
    arrays = [k for k, member in enumerate(kind.types) if isinstance(member, types.Array)]
    if arrays:
        table = [[k, places[k]] for k in arrays]
        constant = ir.Constant(ir.ArrayType(ir.ArrayType(LONG, 2), len(table)), table)
        held = cgutils.global_constant(module, f"{name}_arrays", constant)
        read = cgutils.get_or_insert_function(
            module, ir.FunctionType(c.pyapi.pyobj, [c.pyapi.pyobj, LONG]), "PyTuple_GetItem"
        )
        adapt = ir.FunctionType(INT, [c.pyapi.pyobj, pointer])
        adaptor = cgutils.get_or_insert_function(module, adapt, "numba_adapt_ndarray")
        with cgutils.for_range(builder, LONG(len(table))) as loop:
            k, at = (builder.load(builder.gep(held, [INT(0), loop.index, INT(j)])) for j in (0, 1))
            item = builder.call(read, [values, k])
            _leave_if(builder, builder.call(adaptor, [item, builder.gep(block, [at])]))
    for k, member in enumerate(kind.types):
        if k in arrays:
            continue
        item = api.tuple_getitem(values, k)
        start = cgutils.pointer_add(builder, block, places[k])
        if isinstance(member, Structure):
            _leave_if(builder, builder.call(_fill(c, member), [item, start]))
        else:
            value = api.to_native_value(member, item)
            _leave_if(builder, builder.zext(value.is_error, INT))
            _store(c.context, builder, member, start, value.value)
    builder.ret(INT(0))
    return function


def _leave_if(builder: ir.IRBuilder, failed: ir.Value) -> None:
    with cgutils.if_unlikely(builder, builder.icmp_unsigned("!=", failed, INT(0))):
        builder.ret(INT(-1))
