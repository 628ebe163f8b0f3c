"""Machine code of kernels that call each other, instead of holding copies of all that they call.

numba links the code of every called function into its caller and optimises it there once more, at every level of the
calls. Here a kernel that is too large to be inlined is compiled once and called; only small ones are linked into their
callers. What is kept of a kernel on disk names the kernels that it calls, which are loaded before it (decision 0019).
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import blake2b
from importlib import import_module
from itertools import islice
from typing import Any
from weakref import WeakValueDictionary

import llvmlite.binding as llvm
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, CompileResult
from numba.core.typed_passes import NativeLowering, NopythonRewrites, NopythonTypeInference
from numba.core.untyped_passes import InlineClosureLikes

from flexmb.math.kernel_content import UnknownContent, code_digest
from flexmb.math.remembered_types import ComparedFlags, RememberingInference
from flexmb.math.spared_passes import RewritesOfArrays, RewritesOfClosures
from flexmb.math.structure_lowering import StructureLowering

__all__ = ["Callee", "KernelCompiler", "MissingCallee", "rebuilt", "reduced", "register"]

INLINED = 200
"""Instructions, beside two for every argument, of the largest function that callers get a copy of.

A call with many arguments costs as much as it sets up, so the compiler inlines larger functions there (InlineCost of
LLVM: a threshold of 250 and 5 for every argument, against 5 for most instructions).
"""

_kernels: WeakValueDictionary[tuple[str, str], Any] = WeakValueDictionary()


def register(kernel: Any) -> None:
    """Let a kernel be found by its module and name."""
    function = kernel.py_func
    if "<" not in function.__qualname__:
        _kernels[function.__module__, function.__qualname__] = kernel


class MissingCallee(LookupError):
    """A kernel that machine code calls is not there as that code expects it."""


@dataclass(frozen=True)
class Callee:
    """A kernel that machine code calls: where it is declared, its argument types, and its symbol."""

    module: str
    name: str
    arguments: tuple
    symbol: str

    def library(self) -> KernelLibrary:
        """Return its machine code, loaded or compiled; MissingCallee if it is another than was called."""
        import_module(self.module)
        kernel = _kernels.get((self.module, self.name))
        if kernel is None:
            raise MissingCallee(f"{self.module}.{self.name}")
        kernel.compile(self.arguments)
        library = kernel.overloads[self.arguments].library
        if getattr(library, "callee", None) != self:
            raise MissingCallee(self.symbol)
        return library


class KernelLibrary(JITCodeLibrary):
    """The machine code of one kernel, and of the small ones that it calls."""

    def __init__(self, codegen, name: str):
        super().__init__(codegen, name)
        self.called: dict[str, KernelLibrary] = {}
        self.callee: Callee | None = None

    def add_linking_library(self, library) -> None:
        library._ensure_finalized()
        if not isinstance(library, KernelLibrary):
            super().add_linking_library(library)
        elif library.callee is not None:
            self.called[library.callee.symbol] = library
        else:
            super().add_linking_library(library)
            self.called.update(library.called)

    def _optimize_functions(self, module) -> None:
        """Leave functions as they are until all are together: what follows does the same and more."""
        module.data_layout = self._codegen._data_layout

    def stand_alone(self, callee: Callee) -> None:
        """Let callers call this code, if it is too large to be copied into them."""
        if _is_large(self._final_module.get_function(callee.symbol)):
            self.callee = callee

    def kept(self) -> tuple:
        """Return what is kept on disk: name, code, a copy for callers (none if it stands alone), symbols, calls."""
        self._ensure_finalized()
        copy = self._get_module_for_linking().as_bitcode() if self.callee is None else None
        symbols = [
            value.name
            for values in (self._final_module.functions, self._final_module.global_variables)
            for value in values
            if not value.is_declaration
        ]
        calls = [library.callee for library in self.called.values()]
        return self.name, self._get_compiled_object(), copy, symbols, calls, self.callee

    @classmethod
    def loaded(cls, codegen, kept: tuple) -> KernelLibrary:
        """Return the library of what was kept; the kernels that it calls are loaded first."""
        name, code, copy, symbols, calls, callee = kept
        self = cls(codegen, name)
        self.called = {one.symbol: one.library() for one in calls}
        self.callee = callee
        self.enable_object_caching()
        self._set_compiled_object(code)
        if copy is not None:
            self._shared_module = llvm.parse_bitcode(copy)
        self._finalize_final_module()
        codegen._engine._defined_symbols.update(symbols)
        return self


def _is_large(function) -> bool:
    limit = INLINED + 2 * sum(1 for _ in function.arguments)
    instructions = (one for block in function.blocks for one in block.instructions)
    return next(islice(instructions, limit, None), None) is not None  # which of thousands need not be counted


@contextmanager
def _few_collections() -> Iterator[None]:
    """Let Python look for circles of dead objects rarely: a compiler makes many objects that live on."""
    before = gc.get_threshold()
    gc.set_threshold(max(before[0], 200_000) if before[0] else 0, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)


REPLACED = {
    InlineClosureLikes: RewritesOfClosures,
    NativeLowering: StructureLowering,
    NopythonRewrites: RewritesOfArrays,
    NopythonTypeInference: RememberingInference,
}


class KernelCompiler(Compiler):
    """numba's compiler with libraries of ours, and with symbols that are named by what a kernel contains.

    So machine code of another process finds the kernels that it calls. Only the first of several equal functions in a
    process has that name.
    """

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.state.flags = ComparedFlags(self.state.flags)

    def define_pipelines(self):
        made = super().define_pipelines()
        for passes in made:
            passes.passes = [(REPLACED.get(kind, kind), told) for kind, told in passes.passes]
            passes._finalized = False
            passes.finalize()
        return made

    def compile_extra(self, function):
        self.state.library = KernelLibrary(self.state.targetctx.codegen(), function.__qualname__)
        self.state.library.enable_object_caching()
        with _few_collections():
            return super().compile_extra(function)

    def _compile_bytecode(self):
        state = self.state
        identity = state.func_id
        named = _name_by_content(identity, state)
        result = super()._compile_bytecode()
        key = identity.modname, identity.func_qualname
        if named and not state.flags.no_compile and getattr(_kernels.get(key), "py_func", None) is identity.func:
            state.library.stand_alone(Callee(*key, tuple(state.args), result.fndesc.llvm_func_name))
        return result


_named: set[tuple] = set()
"""Content and argument types of the kernels of this process that are named by them."""


def _name_by_content(identity, state) -> bool:
    """Replace the running number in the symbols of a function by a digest; return whether that could be done."""
    try:
        content = blake2b(f"{code_digest(identity.func)} {state.flags.summary()}".encode(), digest_size=8).hexdigest()
    except UnknownContent:
        return False
    name = content, tuple(state.args)
    if name in _named:
        return False
    _named.add(name)
    identity.unique_id = content
    identity.unique_name = f"{identity.func_qualname}${content}"
    return True


def reduced(result: CompileResult) -> tuple:
    """Return what is kept on disk of a compiled function."""
    result.fndesc.typemap = result.fndesc.calltypes = None
    return (
        result.library.kept(),
        result.fndesc,
        result.environment,
        result.signature,
        result.objectmode,
        result.reload_init,
        tuple(result._find_referenced_environments()),
    )


def rebuilt(target_context, kept, fndesc, environment, signature, objectmode, reload_init, environments):
    """Return the compiled function of what was kept."""
    for function in reload_init:
        function()
    library = KernelLibrary.loaded(target_context.codegen(), kept)
    _named.add((fndesc.uid, tuple(fndesc.argtypes)))
    result = CompileResult(
        target_context=target_context,
        typing_context=target_context.typing_context,
        library=library,
        environment=environment,
        entry_point=target_context.get_executable(library, fndesc, environment),
        fndesc=fndesc,
        type_annotation="",
        signature=signature,
        objectmode=objectmode,
        lifted=(),
        typing_error=None,
        call_helper=None,
        metadata=None,
        reload_init=reload_init,
        referenced_envs=environments,
    )
    for other in environments:
        library.codegen.set_env(other.env_name, other)
    return result
