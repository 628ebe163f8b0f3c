"""What numba works out again and again while it compiles, remembered.

A third of the time that numba takes before it hands over to LLVM goes into asking, for every ``a * b`` and ``x[i]``,
all of its overloads, and into comparing compiler flags field by field as it does. The answer depends on the types of
the arguments only. Nothing of numba is replaced: the compiler of our kernels gets flags and a typing context that
remember.
"""

from __future__ import annotations

import operator
from typing import Any

from numba import types
from numba.core.compiler import Flags
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NopythonTypeInference
from numba.core.typing import Signature

__all__ = ["ComparedFlags", "RememberingInference", "remembering"]

SIMPLE = (types.Number, types.Boolean, types.Array, types.SliceType, types.Literal)
"""Kinds of arguments whose operators are typed by the types alone."""


class ComparedFlags(Flags):
    """Flags of the compiler that are compared quickly: they are part of the key of every overload."""

    _HASH = hash(Flags())  # of the names of the options, so the same for all

    def __hash__(self) -> int:
        return self._HASH

    def __eq__(self, other) -> bool:
        return getattr(other, "_values", None) == self._values or super().__eq__(other)


class _Operator(types.Function):
    """An operator of numba that remembers how it was called."""

    def __init__(self, function: types.Function):
        self.__dict__.update(vars(function))  # its templates, and the tables that lowering reads
        self._function = function
        self._known: dict[tuple, Signature] = {}

    def get_call_type(self, context, args, kws):
        if args in self._known:
            return self._known[args]
        found = self._function.get_call_type(getattr(context, "numbas", context), args, kws)
        if found is not None and not kws and all(map(_is_simple, args)):
            self._known[args] = found
        return found


def _is_simple(kind: types.Type) -> bool:
    return all(map(_is_simple, kind)) if isinstance(kind, types.BaseTuple) else isinstance(kind, SIMPLE)


class RememberingContext:
    """numba's typing context, but that operators remember."""

    def __init__(self, context: Any):
        self.numbas = context
        self._operators: dict[Any, _Operator] = {}

    def __getattr__(self, name: str) -> Any:
        return getattr(self.numbas, name)

    def __hash__(self) -> int:
        return hash(self.numbas)

    def __eq__(self, other) -> bool:
        """It is part of the keys of numba's tables, where it is the same as the one that it stands for."""
        return self.numbas is getattr(other, "numbas", other)

    def resolve_value_type(self, value: Any) -> types.Type:
        if getattr(value, "__module__", None) != "_operator":
            return self.numbas.resolve_value_type(value)
        if value not in self._operators:
            found = self.numbas.resolve_value_type(value)
            if type(found) is not types.Function:
                return found
            self._operators[value] = _Operator(found)
        return self._operators[value]

    def resolve_getitem(self, target, index):
        return self.resolve_value_type(operator.getitem).get_call_type(self.numbas, (target, index), {})

    def resolve_setitem(self, target, index, value):
        return self.resolve_value_type(operator.setitem).get_call_type(self.numbas, (target, index, value), {})


_contexts: dict[int, RememberingContext] = {}


def remembering(context: Any) -> RememberingContext:
    """Return the one that stands for a typing context in this process."""
    if id(context) not in _contexts:
        _contexts[id(context)] = RememberingContext(context)
    return _contexts[id(context)]


@register_pass(mutates_CFG=True, analysis_only=False)
class RememberingInference(NopythonTypeInference):
    """Type inference of kernels."""

    _name = "type_inference_that_remembers"

    def run_pass(self, state):
        context = state.typingctx
        state.typingctx = remembering(context)
        try:
            return super().run_pass(state)
        finally:
            state.typingctx = context
