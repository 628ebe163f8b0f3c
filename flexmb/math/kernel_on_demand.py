"""Kernels that are compiled when one is called for the first time: most models never need them.

A kernel that calls another is compiled after it, whether the call is ever reached or not. Here the caller holds a cell
for the address instead. Where the cell is empty, it calls back into Python, which compiles the kernel, or loads it, and
fills the cell. So a pendulum compiles nothing of contacts, friction and signals (decision 0041).
"""

from __future__ import annotations

import _thread
import ctypes
import threading
from collections.abc import Callable
from hashlib import blake2b
from inspect import Parameter, Signature, signature
from typing import Any

import llvmlite.binding as llvm
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing import Signature as TypedSignature
from numba.core.typing.templates import infer, infer_global, make_intrinsic_template

from flexmb.math.kernel import entry_kernel

__all__ = ["KernelOnDemand", "kernel_on_demand"]

BYTES_OF = ir.IntType(8).as_pointer()
CALLBACK = ctypes.CFUNCTYPE(None)
INTERRUPTIONS = 3
"""So many times compiling begins again after Ctrl-C."""
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
        self.kernel = entry_kernel(*declared.args)(function)
        self.types = declared
        self.__doc__ = function.__doc__
        self._name = f"{function.__module__}.{function.__qualname__}"
        self._cell, self._filler = ctypes.c_void_p(), CALLBACK(self._fill)
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

    def _fill(self) -> None:
        """Fill the cell; called from machine code, which waits for it, and which no exception can pass through.

        So Ctrl-C waits until the kernel is there.
        """
        struck = False
        for _ in range(INTERRUPTIONS):
            try:
                self.ready()
            except KeyboardInterrupt:
                struck = True
            else:
                break
        if struck:
            later = threading.Timer(0.02, _thread.interrupt_main)  # once the machine code goes on
            later.daemon = True
            later.start()

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

    def typed(context, *arguments):
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
