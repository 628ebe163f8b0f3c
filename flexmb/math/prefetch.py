"""Numbers asked for ahead of their use, so that the processor brings them from memory beside other work.

The processor sees by itself what a kernel reads next where it goes through few arrays from front to back. Passes from
the leaves of a tree to its root go through many arrays from the back; there it waited for each one.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir as code
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

__all__ = ["ask", "ask_to_write"]

LINE = 64
"""Bytes that come at once."""


def _asking(writes: bool):
    """Return the code that asks for the first bytes of one entry of an array along its first axis."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        kind, place_kind, _ = signature.args
        made = context.make_array(kind)(context, builder, values[0])
        place = context.cast(builder, values[1], place_kind, types.intp)
        size = cgutils.unpack_tuple(builder, made.strides, kind.ndim)[0]
        count = context.cast(builder, values[2], signature.args[2], types.intp)
        number, flag = code.IntType(64), code.IntType(32)
        first = builder.add(builder.ptrtoint(made.data, number), builder.mul(place, size))
        start = builder.and_(first, number(-LINE))
        lines = builder.udiv(builder.add(builder.sub(builder.add(first, count), start), number(LINE - 1)), number(LINE))
        asked = code.FunctionType(code.VoidType(), [cgutils.voidptr_t, flag, flag, flag])
        function = cgutils.get_or_insert_function(builder.module, asked, "llvm.prefetch.p0")
        with cgutils.for_range(builder, lines) as loop:
            at = builder.add(start, builder.mul(loop.index, number(LINE)))
            asking = [builder.inttoptr(at, cgutils.voidptr_t), flag(int(writes)), flag(3), flag(1)]
            builder.call(function, asking)
        return context.get_dummy_value()

    return generate


@intrinsic
def ask(typing_context, array, place, count):
    """Ask for the first `count` bytes of an entry of an array along its first axis, to be read; nothing goes wrong if
    there is no such entry.
    """
    return types.void(array, place, count), _asking(False)


@intrinsic
def ask_to_write(typing_context, array, place, count):
    """Ask for the first `count` bytes of an entry of an array along its first axis, to be written."""
    return types.void(array, place, count), _asking(True)
