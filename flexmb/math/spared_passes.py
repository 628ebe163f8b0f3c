"""Passes of numba that rewrite what few kernels hold, left out for those that hold nothing of it.

Each works out the lifetime of every variable two or three times, whether it finds something to rewrite or not. The
machine code is the same with and without them.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce

from numba import types
from numba.core import ir
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NopythonRewrites
from numba.core.untyped_passes import InlineClosureLikes

__all__ = ["RewritesOfArrays", "RewritesOfClosures"]


def _assignments(function: ir.FunctionIR) -> Iterator[ir.Assign]:
    for block in function.blocks.values():
        yield from block.find_insts(ir.Assign)


def _may_be_a_closure(value: object) -> bool:
    """Could a value be a function inside a function, a list that becomes an array, a reduction or a stencil?"""
    if isinstance(value, ir.Expr):
        return value.op in ("make_function", "build_list")
    if isinstance(value, (ir.Global, ir.FreeVar)):
        return value.value is reduce or type(value.value).__name__ == "StencilFunc"
    return False


@register_pass(mutates_CFG=True, analysis_only=False)
class RewritesOfClosures(InlineClosureLikes):
    """Functions inside functions become part of them."""

    _name = "inline_closures_if_any"

    def run_pass(self, state):
        if any(_may_be_a_closure(one.value) for one in _assignments(state.func_ir)):
            return super().run_pass(state)
        return False


@register_pass(mutates_CFG=True, analysis_only=False)
class RewritesOfArrays(NopythonRewrites):
    """Expressions of whole arrays become one loop, names of fields that are texts become fields."""

    _name = "rewrite_array_expressions_if_any"

    def run_pass(self, state):
        kinds = state.typemap
        makes_arrays = (
            isinstance(one.value, ir.Expr)
            and one.value.op not in ("getattr", "getitem", "static_getitem", "cast")
            and isinstance(kinds[one.target.name], types.Array)
            for one in _assignments(state.func_ir)
        )
        if any(isinstance(kind, types.StringLiteral) for kind in kinds.values()) or any(makes_arrays):
            return super().run_pass(state)
        return False
