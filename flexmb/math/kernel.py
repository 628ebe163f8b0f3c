"""`kernel` and `inner_kernel`: the way to compile a function in flexmb."""

from __future__ import annotations

from numba import njit

from flexmb.math.kernel_cache import KernelCache
from flexmb.math.kernel_library import KernelCompiler, register
from flexmb.math.unequal_sizes import use_constant_text

__all__ = ["entry_kernel", "inner_kernel", "kernel"]

use_constant_text()


def kernel(function):
    """Compile with numba; the machine code is kept on disk, so only the first run on a machine compiles.

    ``error_model="numpy"`` makes a division by zero give inf or nan as numpy does (found by the residual checks),
    instead of a branch in every division. ``fastmath`` stays off: the order of operations is part of the result.
    The second entry for callers in C is left out, as nobody uses it and every kernel would pay for compiling it;
    kernels that are called through their address are `PointerKernel`.
    """
    return _compiled(function, called_from_python=True)


def inner_kernel(function):
    """Compile a function that only kernels call: of its own file if its name begins with an underscore, else of any.

    It gets no entry for Python: unpacking the tables of a system there takes longer to compile than many a function. A
    call from Python would end the process; a test of the architecture sees to it that there is none, in tests neither.
    """
    return _compiled(function, called_from_python=False)


def entry_kernel(*arguments):
    """Compile a function that Python calls with these argument types, numba's: it can be compiled before it is called.

    The compiled function carries them as `entry` (`flexmb.math.ahead`).
    """

    def compiled(function):
        made = kernel(function)
        made.entry = arguments
        return made

    return compiled


def _compiled(function, called_from_python: bool):
    compiled = njit(
        error_model="numpy",
        nogil=True,
        no_cfunc_wrapper=True,
        no_cpython_wrapper=not called_from_python,
        pipeline_class=KernelCompiler,
    )(function)
    register(compiled)
    compiled._cache = KernelCache(function, compiled.targetoptions)
    return compiled
