"""Kernels that only borrow arrays: they need not count references to them.

numba counts a reference for every array that a variable names, each view and each field included. Where a function
returns no array, and makes none but in its own memory (`flexmb.math.own_room`), whoever called it keeps all others
alive until it returns, and nothing has to be counted. That is most of our kernels, and about a third of the code that
would be compiled.
"""

from __future__ import annotations

from collections.abc import Container
from typing import Any

from numba import types
from numba.core import ir

from flexmb.math.own_room import keeps
from flexmb.math.structure_type import Structure

__all__ = ["only_borrows"]

VIEWS = ("array.view", "array.reshape")
"""Methods of arrays whose result is a view in compiled code, always."""


def only_borrows(state: Any, own: Container[int]) -> bool:
    """Does a typed function hold no reference of its own to an array, and return none?

    own : calls (their `id`) that make arrays in the function's own memory
    """
    kinds = state.typemap
    manager = state.targetctx.data_model_manager

    def counted(kind) -> bool:
        return manager[kind].contains_nrt_meminfo()

    if state.func_ir.is_generator or counted(state.return_type) or any(map(keeps, state.args)):
        return False
    for block in state.func_ir.blocks.values():
        for one in block.body:
            if isinstance(one, (ir.DynamicRaise, ir.DynamicTryRaise)):
                return False
            if not (isinstance(one, ir.Assign) and counted(kinds[one.target.name])):
                continue
            if id(one.value) not in own and not _borrowed(one.value, kinds):
                return False
    return True


def _borrowed(value: Any, kinds: Any) -> bool:
    """Is an array, or a tuple of arrays, part of something that is alive anyway?"""
    if not isinstance(value, ir.Expr):
        return isinstance(value, (ir.Arg, ir.Var, ir.Global, ir.FreeVar, ir.Const))
    if value.op == "getattr":
        return isinstance(kinds[value.value.name], (Structure, types.BaseTuple, types.Record, types.Array))
    if value.op == "static_getitem":
        return isinstance(kinds[value.value.name], types.BaseTuple) or (
            isinstance(kinds[value.value.name], types.Array)
            and (value.index_var is None or _plain(kinds[value.index_var.name]))
        )
    if value.op == "getitem":
        return isinstance(kinds[value.value.name], types.Array) and _plain(kinds[value.index.name])
    if value.op == "call":
        function = kinds[value.func.name]
        return isinstance(function, types.BoundFunction) and str(function.template.key) in VIEWS
    if value.op == "exhaust_iter":
        return isinstance(kinds[value.value.name], types.BaseTuple)
    return value.op in ("cast", "build_tuple", "phi")


def _plain(index: types.Type) -> bool:
    """Does an index give a view of an array? Arrays as indices give copies."""
    if isinstance(index, types.BaseTuple):
        return all(map(_plain, index))
    return isinstance(index, (types.Integer, types.SliceType, types.EllipsisType))
