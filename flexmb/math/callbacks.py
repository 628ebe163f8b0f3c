"""Calling back from kernels into Python: for what a user wants to try without writing a kernel."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import numpy as np
from numba import types
from numba.extending import intrinsic

__all__ = ["Repeats", "call_back", "callback"]

POINTER = ctypes.POINTER(ctypes.c_double)
CALLBACK = ctypes.CFUNCTYPE(None, POINTER, POINTER)


def callback(function: Callable) -> tuple[object, int]:
    """Return the C function (double *inputs, double *outputs) that calls `function`, and its address.

    The first result must be kept as long as the address is used. ctypes takes the interpreter's lock by itself, so
    compiled code that has released it may call; an exception in `function` cannot pass through compiled code.
    """
    pointer = CALLBACK(function)
    return pointer, ctypes.cast(pointer, ctypes.c_void_p).value or 0


class Repeats:
    """Asks a function of the user for its answer twice: one that remembers, or draws at random, gives another one.

    Steps are tried, repeated and looked at with small changes, so such a function counts calls in the place of time:
    a sum over calls looks like an integral and is none.
    """

    OFTEN = 32
    """So many calls at the start are repeated, and one of so many later: a sum may begin late."""
    ROUNDING = 1e-10
    """Difference of two answers, relative to the largest so far, that an iteration or a sum by threads may leave."""

    def __init__(self) -> None:
        self.calls, self.found, self.largest = 0, "", 0.0

    def require(self, answer, again: Callable[[], object]) -> None:
        """Raise ValueError if `again`, the same call as that which returned `answer`, returns something else; and at
        every later call, lest one that is not repeated hides it.
        """
        self.calls += 1
        if not self.found and (self.calls <= self.OFTEN or self.calls % self.OFTEN == 0):
            first = np.array(answer).ravel()  # a copy: the function may return the same array twice
            second = np.ravel(np.asarray(again()))
            self.largest = np.fmax(self.largest, np.abs(first))
            with np.errstate(invalid="ignore"):  # of what is not finite others complain
                same = (first == second) | (np.abs(first - second) <= self.ROUNDING * self.largest)
            if not np.all(same | (np.isnan(first) & np.isnan(second))):
                both = ", then ".join(np.array2string(np.squeeze(one), precision=6) for one in (first, second))
                self.found = (
                    f"with the same arguments it returned {both} (it is asked several times in a step, so it must not "
                    "remember calls or draw at random: give memory to fmb.Integral or fmb.SampledStateSpace, or use "
                    "fmb.stepper)"
                )
        if self.found:
            raise ValueError(self.found)


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
