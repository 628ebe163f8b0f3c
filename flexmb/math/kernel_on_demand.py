"""Kernels that are compiled when one is called for the first time: most models never need them.

A kernel that calls another is compiled after it, whether the call is ever reached or not. Here the caller holds a cell
for the address instead. Where the cell is empty, it calls back into Python, which compiles the kernel, or loads it, and
fills the cell. So a pendulum compiles nothing of contacts, friction and signals (decision 0041).
"""

from __future__ import annotations

import _thread
import ctypes
import threading
from collections.abc import Callable, Iterator
from hashlib import blake2b
from inspect import Parameter, Signature, signature
from typing import Any

import llvmlite.binding as llvm
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.errors import TypingError
from numba.core.typeconv import Conversion
from numba.core.typing import Signature as TypedSignature
from numba.core.typing.templates import infer, infer_global, make_intrinsic_template

from flexmb.math.kernel import entry_kernel

__all__ = ["KernelOnDemand", "kernel_on_demand"]

BYTES_OF = ir.IntType(8).as_pointer()
CALLBACK = ctypes.CFUNCTYPE(None)
INTERRUPTIONS = 3
"""So many times compiling begins again after Ctrl-C."""
WAITING = 8
"""Generators that wait for calls: one is used up by each, and threads may come at once."""
LOSING = (None, Conversion.unsafe)
"""Conversions of arguments that would cut off a fraction or take a part of an array for another."""
_kept: list[KernelOnDemand] = []
"""All of this process: machine code refers to their cells, also after a module was loaded anew."""


class KernelOnDemand:
    """A function that Python calls as any other kernel, and kernels through the cell of its address.

    Attributes
    ----------
    kernel : the compiled function
    types : numba's signature of it
    call_digest : of the function that writes calls, a part of the names of callers' machine code
    """

    call_digest = ""

    def __init__(self, function: Callable, declared: TypedSignature):
        if "<locals>" in function.__qualname__:
            raise TypeError(
                f"kernel on demand {function.__qualname__}: its cell is found by its name, so it must be a "
                "function of a module"
            )
        self.kernel = entry_kernel(*declared.args)(function)
        self.types = declared
        self.__doc__ = function.__doc__
        self._name = f"{function.__module__}.{function.__qualname__}"
        self.__module__, self.__qualname__ = function.__module__, function.__qualname__  # pickled by these
        self._waiting: list[Iterator[None]] = []
        self._await_calls()
        self._cell = ctypes.c_void_p()
        self._filler = CALLBACK(map(next, iter(self._waiting.pop, None)).__next__)  # takes one and goes on in it
        _kept.append(self)
        llvm.add_symbol(self._symbol("cell"), ctypes.addressof(self._cell))
        llvm.add_symbol(self._symbol("fill"), ctypes.cast(self._filler, ctypes.c_void_p).value)
        template = make_intrinsic_template(self, _typing(self, function), function.__qualname__)
        infer(template)
        infer_global(self, types.Function(template))

    def __getattr__(self, name: str) -> Any:
        if name == "kernel" or (name.startswith("_") and name != "_cache"):  # numba must not take it for that one
            raise AttributeError(name)
        return getattr(self.kernel, name)

    def __deepcopy__(self, memo: dict) -> KernelOnDemand:
        return self  # numba copies statements

    def __reduce__(self) -> str:
        return self.__qualname__

    def __call__(self, *arguments):
        return self.kernel(*arguments)

    def __repr__(self) -> str:
        return f"<kernel on demand {self._name}>"

    def _symbol(self, part: str) -> str:
        return f"flexmb.{part}.{self._name}"

    def ready(self) -> None:
        """Compile it now, where an error can be told, and fill the cell.

        Whoever builds a model for kernels that are called through their addresses does so: they cannot pass errors on.
        """
        if self._cell.value is None:
            self.kernel.compile(self.types.args)
            made = self.kernel.overloads[self.types.args]
            if made.signature.return_type != self.types.return_type:
                raise TypeError(f"{self!r} returns {made.signature.return_type}, declared {self.types.return_type}")
            self._cell.value = made.library.get_pointer_to_function(made.fndesc.llvm_func_name)

    def _await_calls(self) -> None:
        while len(self._waiting) < WAITING:
            filling = self._fill()
            next(filling)
            self._waiting.append(filling)

    def _fill(self) -> Iterator[None]:
        """Wait for a call from machine code, fill the cell, and yield again: the machine code goes on.

        No exception can pass through machine code, so Ctrl-C waits until the kernel is there. One that struck before,
        while machine code ran, is raised by Python with the first instruction after the call. In a function that comes
        before any `try`; here it is the one after `yield`.
        """
        struck = called = False
        for _ in range(INTERRUPTIONS):
            try:
                if not called:
                    called = True
                    yield
                self._await_calls()
                self.ready()
            except KeyboardInterrupt:
                struck = True
            else:
                break
        if struck:
            later = threading.Timer(0.02, _thread.interrupt_main)  # once the machine code goes on
            later.daemon = True
            later.start()
        yield

    def call(self, target: Any, builder: ir.IRBuilder, values: tuple) -> ir.Value:
        """Return the code of a call."""
        module, convention = builder.module, target.call_conv
        name = self._symbol("cell")
        cell = module.globals.get(name) or ir.GlobalVariable(module, BYTES_OF, name)
        prototype = convention.get_function_type(self.types.return_type, self.types.args).as_pointer()
        with cgutils.if_unlikely(builder, cgutils.is_null(builder, builder.load(cell))):
            filler = cgutils.get_or_insert_function(module, ir.FunctionType(ir.VoidType(), []), self._symbol("fill"))
            builder.call(filler, [])
            with cgutils.if_unlikely(builder, cgutils.is_null(builder, builder.load(cell))):
                convention.return_user_exc(builder, RuntimeError, (f"{self._name} could not be compiled",))
        function = builder.bitcast(builder.load(cell), prototype)
        status, found = convention.call_function(builder, function, self.types.return_type, self.types.args, values)
        with cgutils.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
        return found


_writer = KernelOnDemand.call.__code__
KernelOnDemand.call_digest = blake2b(
    repr((_writer.co_code, _writer.co_consts, _writer.co_names)).encode(), digest_size=8
).hexdigest()


def _typing(called: KernelOnDemand, function: Callable) -> Callable:
    """Return what numba asks for the types of a call and for its code, with the names of the arguments."""

    declared = called.types.args

    def typed(context, *arguments):
        for name, given, expected in zip(signature(function).parameters, arguments, declared, strict=True):
            if context.can_convert(given, expected) in LOSING:
                raise TypingError(f"{called!r}: argument {name} is declared {expected}, the call has {given}")

        def code(target, builder, _, values):
            return called.call(target, builder, values)

        return called.types, code

    names = ["context", *signature(function).parameters]
    named: Any = typed
    named.__signature__ = Signature([Parameter(name, Parameter.POSITIONAL_OR_KEYWORD) for name in names])
    return typed


def kernel_on_demand(result: types.Type, *arguments: types.Type) -> Callable[[Callable], KernelOnDemand]:
    """Compile a function of these types, numba's, when it is called for the first time, from Python or from kernels.

    It is meant for what large kernels call in rare cases. A call costs as much as that of any kernel which is too large
    to become part of its caller. One that is needed for sure is compiled ahead by `flexmb.math.ahead`.
    """
    return lambda function: KernelOnDemand(function, result(*arguments))
