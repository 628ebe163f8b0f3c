"""What the machine code of a kernel depends on, as a digest of contents: code, constants, and the kernels it calls.

Global names are constants to the compiler, and called kernels become part of the code. So a file's own age says little
(a number that is swapped two imports away changes the code), and the age of every file says too much (a checkout
touches them all). Here the values are followed as the compiler does: every global name that a function loads, every
value of its closure, and the same for every function reached. Nothing in the digest depends on where the package is
installed, on times or on line numbers.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dis import opmap
from enum import Enum
from hashlib import blake2b
from types import CodeType, FunctionType, ModuleType
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numba import types
from numba.core.typing import Signature

from flexmb.math.structure_type import Structure

__all__ = ["UnknownContent", "code_digest", "loaded_globals", "type_text"]

LIBRARIES = ("builtins", "cmath", "llvmlite", "math", "numba", "numpy", "scipy")
"""Their functions are known by name: numba compiles its own versions of them, and its version is part of every key."""


class UnknownContent(TypeError):
    """A function uses a value of a kind whose content is not known: its machine code cannot be kept."""


def code_digest(function: FunctionType) -> str:
    """Return a digest of all that the machine code of a function is made from, apart from its argument types."""
    order: dict[FunctionType, int] = {}
    waiting = [function]
    while waiting:
        found = waiting.pop()
        if found not in order:
            order[found] = len(order)
            waiting.extend(_own(found)[1])
    digest = blake2b(digest_size=20)
    for found in order:
        text, called = _own(found)
        digest.update(f"{text}\n{[order[other] for other in called]}\n".encode())
    return digest.hexdigest()


_known: WeakKeyDictionary[FunctionType, tuple[str, tuple[FunctionType, ...]]] = WeakKeyDictionary()


def _own(function: FunctionType) -> tuple[str, tuple[FunctionType, ...]]:
    """Return what a function itself contains, as text, and the functions that it refers to, in the order of the text.

    numba takes globals when it first compiles a function and keeps them; so does the memory of this one.
    """
    if function not in _known:
        reader = _Reader()
        text = reader.function(function)
        _known[function] = text, tuple(reader.called)
    return _known[function]


def loaded_globals(code: CodeType) -> set[str]:
    """Return the global names that a code object and those inside it load (attributes have names as well)."""
    names, extension = set(), 0
    for operation, argument in zip(code.co_code[::2], code.co_code[1::2]):
        argument |= extension
        extension = argument << 8 if operation == opmap["EXTENDED_ARG"] else 0
        if operation == opmap["LOAD_GLOBAL"]:  # the last bit is a flag of the interpreter
            names.add(code.co_names[argument >> 1])
    return names.union(*(loaded_globals(inner) for inner in code.co_consts if isinstance(inner, CodeType)))


class _Reader:
    """Describe values as text; functions are collected in `called` and described by whoever asked."""

    def __init__(self) -> None:
        self.called: list[FunctionType] = []
        self.open: list[int] = []

    def function(self, function: FunctionType) -> str:
        code = function.__code__
        namespace = function.__globals__
        cells = zip(code.co_freevars, function.__closure__ or ())
        names = sorted(loaded_globals(code) & namespace.keys())
        attributes = _attribute_names(code)
        parts = [f"{function.__module__}.{function.__qualname__}", _code_text(code, function.__doc__)]
        parts += [f"{name}={self.value(namespace[name], attributes)}" for name in names]
        parts += [f"{name}:{self.value(cell.cell_contents, attributes)}" for name, cell in cells]
        parts += [self.value(function.__defaults__, ()), self.value(function.__kwdefaults__, ())]
        return "\n".join(parts)

    def value(self, value: Any, attributes: tuple[str, ...]) -> str:
        """Describe one value; of a module, the `attributes` that it has."""
        kind = type(value)
        if value is None or value is Ellipsis or kind in (bool, int, float, complex, str, bytes, range):
            return f"{kind.__name__} {value!r}"
        if isinstance(value, np.generic):
            return f"{self.value(value.dtype, ())} {value.tobytes()!r}"
        if isinstance(value, np.ndarray):
            content = blake2b(np.ascontiguousarray(value).tobytes(), digest_size=20).hexdigest()
            return f"array {self.value(value.dtype, ())} {value.shape} {value.strides} {content}"
        if isinstance(value, np.dtype):
            return f"dtype {value!r} {value.fields} {value.itemsize} {value.alignment}"
        if isinstance(value, (types.Type, Signature)):
            return type_text(value)
        if isinstance(value, ModuleType):
            return self._module(value, attributes)
        if isinstance(value, Enum):
            return f"{kind.__module__}.{value} {self.value(value.value, ())}"
        if isinstance(value, (tuple, list, set, frozenset, Mapping)):
            return self._collection(value)
        return self._code(value)

    def _collection(self, value: Any) -> str:
        if id(value) in self.open:
            raise UnknownContent(f"{value!r} contains itself")
        self.open.append(id(value))
        if isinstance(value, Mapping):
            parts = [f"{self.value(k, ())}: {self.value(v, ())}" for k, v in value.items()]
        else:
            parts = [self.value(entry, ()) for entry in value]
        self.open.pop()
        if isinstance(value, (set, frozenset)):
            parts.sort()
        fields = getattr(value, "_fields", ())
        return f"{type(value).__module__}.{type(value).__qualname__}{fields}({', '.join(parts)})"

    def _module(self, module: ModuleType, attributes: tuple[str, ...]) -> str:
        if _of_library(module.__name__):
            return f"module {module.__name__}"
        used = [name for name in attributes if name in vars(module)]
        values = ", ".join(f"{name}={self.value(vars(module)[name], attributes)}" for name in used)
        return f"module {module.__name__} {values}"

    def _code(self, value: Any) -> str:
        """Describe what can be called: kernels and intrinsics by their functions, others by name."""
        function = getattr(value, "py_func", None) or getattr(value, "_defn", None) or value
        named = f"{getattr(function, '__module__', '')}.{getattr(function, '__qualname__', '')}"
        if isinstance(getattr(value, "types", None), Signature):  # called through a cell: its own code is elsewhere
            return f"kernel on demand {named} {type_text(value.types)} {value.call_digest}"
        if isinstance(function, FunctionType) and not _of_library(function.__module__):
            self.called.append(function)
            return f"function {named} {getattr(value, 'targetoptions', '')}"
        if isinstance(function, type) and issubclass(function, tuple) and hasattr(function, "_fields"):
            return f"tuple {named} {function._fields}"
        if isinstance(function, type) and (_of_library(function.__module__) or issubclass(function, Exception)):
            return f"class {named}"
        if isinstance(function, np.ufunc):
            return f"ufunc {function.__name__}"
        if callable(function) and hasattr(function, "__name__") and _of_library(getattr(function, "__module__", "")):
            return f"library {named}"
        raise UnknownContent(f"{value!r} of {type(value)}")


def _of_library(module: str | None) -> bool:
    return (module or "").partition(".")[0] in LIBRARIES


def _attribute_names(code: CodeType) -> tuple[str, ...]:
    inner = [name for part in code.co_consts if isinstance(part, CodeType) for name in _attribute_names(part)]
    return tuple(dict.fromkeys([*code.co_names, *inner]))


def _code_text(code: CodeType, docstring: str | None = None) -> str:
    constants = code.co_consts
    if docstring is not None and constants and constants[0] == docstring:
        constants = constants[1:]
    return " ".join(
        [
            blake2b(code.co_code + code.co_exceptiontable, digest_size=20).hexdigest(),
            f"{code.co_names} {code.co_varnames} {code.co_cellvars} {code.co_freevars}",
            f"{code.co_argcount} {code.co_posonlyargcount} {code.co_kwonlyargcount} {code.co_flags}",
            *(_constant_text(value) for value in constants),
        ]
    )


def _constant_text(value: Any) -> str:
    if isinstance(value, CodeType):
        return f"code({_code_text(value)})"
    if isinstance(value, frozenset):
        return f"frozenset({sorted(map(_constant_text, value))})"
    return f"{type(value).__name__} {value!r}"


def type_text(kind: Any) -> str:
    """Describe a type of numba with the names of all fields: its own name omits the fields of tuples."""
    return f"{type(kind).__name__}({', '.join(_type_parts(kind))})"


def _type_parts(kind: Any) -> Iterator[str]:
    if isinstance(kind, types.Array):
        yield type_text(kind.dtype)
        yield f"{kind.ndim} {kind.layout} {kind.mutable} {kind.aligned}"
        if isinstance(kind, types.NestedArray):  # of a record: its sizes are part of the type
            yield str(kind.shape)
    elif isinstance(kind, Structure):
        yield f"{kind.kind.__module__}.{kind.kind.__qualname__}{kind.kind._fields}"
        yield from map(type_text, kind.types)
    elif isinstance(kind, types.BaseTuple):
        made = getattr(kind, "instance_class", None)
        if made is not None:
            yield f"{made.__module__}.{made.__qualname__}{made._fields}"
        yield from map(type_text, kind)
    elif isinstance(kind, types.Optional):
        yield type_text(kind.type)
    elif isinstance(kind, Signature):
        yield from map(type_text, (kind.return_type, *kind.args))
    elif isinstance(kind, types.FunctionType):
        yield type_text(kind.signature)
    elif isinstance(kind, types.Dispatcher):
        yield code_digest(kind.dispatcher.py_func)
    elif " at 0x" in str(kind):
        raise UnknownContent(f"type {kind}")
    else:
        yield str(kind)
