"""Fields of structures that a kernel was given are read once, where it begins.

numba reads a field where it is used. In a loop the compiler could not move the read of an address out of it, as any
write to an array might have changed the block; at the beginning of the function it is read once, as if the caller had
passed it by itself.
"""

from __future__ import annotations

from collections.abc import Iterator

from llvmlite import ir as code
from numba import types
from numba.core import cgutils, ir
from numba.core.compiler_machinery import register_pass
from numba.core.errors import LoweringError, NumbaRuntimeError
from numba.core.lowering import Lower
from numba.core.typed_passes import NativeLowering

from flexmb.math.borrowing import only_borrows
from flexmb.math.element_lowering import element, is_element, write_element
from flexmb.math.own_room import own_rooms, take_room
from flexmb.math.remembered_types import remembering
from flexmb.math.structure_type import Structure, field_value, made_structure

__all__ = ["StructureLowering"]


def _given_fields(kind: Structure, call: ir.Expr) -> Iterator[tuple[int, ir.Var]]:
    """Yield the places of fields, and the variables that a call of the constructor gives for them."""
    yield from enumerate(call.args)
    for name, value in call.kws:
        yield kind.place(name), value


class _Lower(Lower):
    def pre_lower(self):
        super().pre_lower()
        self._first = self.builder.basic_block
        self._given: dict[tuple, code.Value] = {}
        self._assigned: dict[str, list] = {}
        for block in self.blocks.values():
            for one in block.find_insts(ir.Assign):
                self._assigned.setdefault(one.target.name, []).append(one.value)
        self._rooms = own_rooms(self.func_ir, self.fndesc.typemap, self.fndesc.restype, self.context)
        self._hold()

    def lower_expr(self, kind, expression):
        if (
            expression.op == "getattr"
            and isinstance(self.typeof(expression.value.name), Structure)
            and not isinstance(kind, types.Boolean)  # which numba reads with a branch
        ):
            value = self._read_first(self._source(expression))
            if value is not None:
                self.incref(kind, value)
                return value
        if expression.op == "static_getitem" and self._is_place(expression.value, expression.index_var):
            call = self.fndesc.calltypes[expression]
            if call is not None:
                return self.lower_getitem(kind, expression, expression.value, expression.index_var, call)
        if id(expression) in self._rooms:
            return take_room(self.context, self.builder, self._rooms[id(expression)])
        if expression.op == "call" and isinstance(kind, Structure):
            function = self.typeof(expression.func.name)
            if isinstance(function, types.NamedTupleClass):
                return self._make(kind, function, expression)
        return super().lower_expr(kind, expression)

    def lower_inst(self, statement):
        """numba asks for an own way to write at a constant place of an array, looks for new ones, and has none."""
        if isinstance(statement, ir.StaticSetItem) and self._is_place(statement.target, statement.index_var):
            call = self.fndesc.calltypes[statement]
            return self.lower_setitem(statement.target, statement.index_var, statement.value, call)
        if isinstance(statement, ir.Return):
            if ending := self._ending(statement.value):
                raise LoweringError(f"a kernel returns a {ending}, whose memory may end with it", loc=self.loc)
            for array, room in self._held.values():
                self.decref(array, self.builder.load(room))
        return super().lower_inst(statement)

    def lower_getitem(self, kind, expression, array, index, signature):
        kinds = self.typeof(array.name), self.typeof(index.name)
        if not is_element(*kinds) or self.context.enable_boundscheck:
            return super().lower_getitem(kind, expression, array, index, signature)
        values = self.loadvar(array.name), self.loadvar(index.name)
        found = element(self.context, self.builder, kinds, values)
        return self.context.cast(self.builder, found, signature.return_type, kind)

    def lower_setitem(self, array, index, given, signature):
        kinds = self.typeof(array.name), self.typeof(index.name)
        kind = self.typeof(given.name)
        if (
            not is_element(*kinds)
            or isinstance(kinds[0].dtype, types.Record)
            or not isinstance(kind, (types.Number, types.Boolean))
            or self.context.enable_boundscheck
        ):
            return super().lower_setitem(array, index, given, signature)
        values = self.loadvar(array.name), self.loadvar(index.name)
        number = self.context.cast(self.builder, self.loadvar(given.name), kind, signature.args[2])
        number = self.context.cast(self.builder, number, signature.args[2], kinds[0].dtype)
        return write_element(self.context, self.builder, kinds, values, number)

    def _is_place(self, array, index) -> bool:
        """Is an index of an array a variable as well?"""
        return index is not None and isinstance(self.typeof(array.name), types.Array)

    def _hold(self) -> None:
        """Reserve places for the arrays, made in this function, of which structures are made.

        A structure holds no references; they are held here until the function returns.
        """
        self._held: dict[tuple[int, int], tuple[types.Type, code.Value]] = {}
        for block in self.blocks.values():
            for one in block.find_insts(ir.Assign):
                kind = self.typeof(one.target.name)
                if isinstance(kind, Structure) and isinstance(one.value, ir.Expr) and one.value.op == "call":
                    for place, value in _given_fields(kind, one.value):
                        array = self.typeof(value.name)
                        if isinstance(array, types.Array) and not self._is_given(value):
                            room = cgutils.alloca_once(self.builder, self.context.get_value_type(array), zfill=True)
                            self._held[id(one.value), place] = array, room

    def _make(self, kind: Structure, function, expression) -> code.Value:
        """Make a structure in memory of this function."""
        call = self.fndesc.calltypes[expression]
        given = self.fold_call_args(function, call, expression.args, expression.vararg, expression.kws)
        values = [
            self.context.cast(self.builder, value, found, wanted)
            for value, found, wanted in zip(given, call.args, kind.types)
        ]
        for place, value in enumerate(values):
            if (id(expression), place) in self._held:
                array, room = self._held[id(expression), place]
                before = self.builder.load(room)
                self.incref(array, value)
                self.builder.store(value, room)
                self.decref(array, before)
        return made_structure(self.context, self.builder, kind, values)

    def _is_given(self, value) -> bool:
        """Is an array an argument, a field of a structure, or a part of such an array?"""
        if isinstance(value, ir.Var):
            found = self._assigned.get(value.name, ())
            return bool(found) and all(map(self._is_given, found))
        if isinstance(value, ir.Expr) and value.op in ("getitem", "static_getitem", "cast"):
            return self._is_given(value.value)
        return isinstance(value, ir.Arg) or (isinstance(value, ir.Expr) and value.op == "getattr")

    def _ending(self, value, within: bool = False) -> str:
        """Return what of a returned value may end with this function, in words; a tuple may hold a given structure."""
        kind, found = self.typeof(value.name), self._assigned.get(value.name, ())
        if isinstance(kind, Structure):
            return "" if within and self._is_given(value) else "structure"
        if isinstance(kind, types.Record):
            return "" if self._is_given(value) else "record"
        if not isinstance(kind, types.BaseTuple):
            return ""
        parts = [(one.value, within) for one in found if isinstance(one, ir.Expr) and one.op == "cast"]
        parts += [(one, within) for one in found if isinstance(one, ir.Var)]
        parts += [(item, True) for one in found if getattr(one, "op", "") == "build_tuple" for item in one.items]
        return next(filter(None, (self._ending(*part) for part in parts)), "")

    def _source(self, value) -> tuple | None:
        """Return the argument, and the fields in it, that a value is; None if it is not known."""
        if isinstance(value, ir.Var):
            found = self._assigned.get(value.name, ())
            return self._source(found[0]) if len(found) == 1 else None
        if isinstance(value, ir.Arg):
            return (value.index,)
        if isinstance(value, ir.Expr) and value.op == "getattr":
            above = self._source(value.value)
            return None if above is None else (*above, value.attr)
        return None

    def _read_first(self, source: tuple | None) -> code.Value | None:
        """Return a field as it is read at the beginning of the function."""
        if source is None:
            return None
        if source not in self._given:
            builder = code.IRBuilder(self._first)
            kind, address = self.fndesc.argtypes[source[0]], self.fnargs[source[0]]
            for name in source[1:-1]:
                address = field_value(self.context, builder, kind, address, name)
                kind = kind.types[kind.place(name)]
            self._given[source] = field_value(self.context, builder, kind, address, source[-1])
        return self._given[source]


@register_pass(mutates_CFG=True, analysis_only=False)
class StructureLowering(NativeLowering):
    """Lowering of kernels with structures; references to arrays are counted only where arrays are made."""

    _name = "native_lowering_of_structures"

    @property
    def lowering_class(self):
        return _Lower

    def run_pass(self, state):
        counting = state.targetctx = state.targetctx.subtarget(typing_context=remembering(state.typingctx))
        own = own_rooms(state.func_ir, state.typemap, state.return_type, state.targetctx)
        if not only_borrows(state, own):
            return super().run_pass(state)
        state.targetctx = counting.subtarget(enable_nrt=False)
        vars(state.targetctx).pop("nrt", None)  # kept by the context that it is a copy of
        try:
            return super().run_pass(state)
        except (NumbaRuntimeError, LoweringError) as error:
            if "NRT required" not in str(error):
                raise
            state.targetctx = counting
            return super().run_pass(state)
