"""The error of a kernel that writes an array to a slice of another size, in a constant text.

numba, since it has such a function, puts both sizes into the text. It compiles its functions of texts for that, which
takes longer than most of our kernels, in each process that compiles such an assignment.

What a kernel does is the same with either text. So this file is not among those by whose content the machine code on
disk is named (`COMPILER` in `kernel_cache.py`): code that was made without it stays valid.
"""

from __future__ import annotations

from typing import Any

from numba import types
from numba.core.registry import cpu_target
from numba.extending import overload

from flexmb.math import remembered_types

try:
    from numba.np.arrayobj import raise_with_shape_context as with_sizes
except ImportError:  # its text is constant
    with_sizes = None

__all__ = ["MESSAGE", "refuse", "use_constant_text", "with_sizes"]

MESSAGE = "cannot assign slice from input of different size"
"""As numba says it where it has no texts."""


def refuse(given, wanted):
    """Raise ValueError for sizes `given` and `wanted`, two tuples of integers; kernels call what replaces it below."""
    raise ValueError(MESSAGE)


@overload(refuse)
def _refuse(given, wanted):
    def refuse_in_kernel(given, wanted):
        raise ValueError(MESSAGE)

    return refuse_in_kernel


class _Context(remembered_types.RememberingContext):
    """A typing context that gives `refuse` for numba's own function."""

    def resolve_value_type(self, value: Any) -> types.Type:
        return super().resolve_value_type(refuse if with_sizes is not None and value is with_sizes else value)


def use_constant_text() -> None:
    """Let kernels that are compiled from here on raise the constant text; no function of numba is replaced."""
    typing = cpu_target.typing_context
    remembered_types._contexts.setdefault(id(typing), _Context(typing))
