"""Calling back from kernels into Python: for what a user wants to try without writing a kernel."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

from numba import types
from numba.extending import intrinsic

__all__ = ["call_back", "callback"]

POINTER = ctypes.POINTER(ctypes.c_double)
CALLBACK = ctypes.CFUNCTYPE(None, POINTER, POINTER)


def callback(function: Callable) -> tuple[object, int]:
    """Return the C function (double *inputs, double *outputs) that calls `function`, and its address.

    The first result must be kept as long as the address is used. ctypes takes the interpreter's lock by itself, so
    compiled code that has released it may call; an exception in `function` cannot pass through compiled code.
    """
    pointer = CALLBACK(function)
    return pointer, ctypes.cast(pointer, ctypes.c_void_p).value or 0


@intrinsic
def call_back(context, address, inputs, outputs):
    """Call the C function at `address` with the addresses of two arrays (``array.ctypes.data``)."""

    pointer = types.CPointer(types.float64)
    prototype = types.FunctionType(types.void(pointer, pointer)).ftype

    def generate(target, builder, signature, values):
        function = builder.inttoptr(values[0], target.get_value_type(prototype))
        builder.call(function, [builder.inttoptr(v, target.get_value_type(pointer)) for v in values[1:]])
        return target.get_dummy_value()

    return types.void(types.int64, types.uintp, types.uintp), generate
