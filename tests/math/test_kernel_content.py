"""The digest of a kernel knows everything that its machine code is made from."""

import dis
import importlib
import pkgutil
from functools import cache
from types import CodeType

import numpy as np
import pytest
from numba import types

import flexmb
from flexmb.math import kernel_content
from flexmb.math.kernel_content import UnknownContent, code_digest, loaded_globals, type_text
from flexmb.math.tables import PointerKernel, caller, void


@cache
def kernels():
    """Return the function of every kernel of the package by its name."""
    found = {}
    for module in pkgutil.walk_packages(flexmb.__path__, "flexmb."):
        if not module.name.endswith("__main__"):
            for value in vars(importlib.import_module(module.name)).values():
                function = value.function if isinstance(value, PointerKernel) else getattr(value, "py_func", None)
                if function is not None and function.__module__.startswith("flexmb."):
                    found[f"{function.__module__}.{function.__qualname__}"] = function
    return found


def test_content_of_every_kernel_is_known():
    """None uses a value of an unknown kind: such a kernel would be compiled in every process."""
    digests = {name: code_digest(function) for name, function in kernels().items()}
    assert len(digests) > 300
    assert len(set(digests.values())) == len(digests)


def test_every_loaded_name_is_found():
    def by_dis(code):
        names = {one.argval for one in dis.get_instructions(code) if one.opname == "LOAD_GLOBAL"}
        return names.union(*(by_dis(inner) for inner in code.co_consts if isinstance(inner, CodeType)))

    found = kernels()
    assert len(found) > 300
    for function in found.values():
        assert loaded_globals(function.__code__) == by_dis(function.__code__)


def test_every_number_that_a_kernel_uses_is_part_of_its_content(monkeypatch):
    """Each whole number among the global names of a kernel is raised by one: the digest changes."""
    changed = 0
    for function in kernels().values():
        before = code_digest(function)
        for name in loaded_globals(function.__code__):
            value = function.__globals__.get(name)
            if isinstance(value, int):
                with monkeypatch.context() as patch:
                    patch.setitem(function.__globals__, name, value + 1)
                    patch.delitem(kernel_content._known, function)
                    assert code_digest(function) != before, (function, name)
                    changed += 1
                kernel_content._known.pop(function)
                assert code_digest(function) == before
    assert changed > 100


VALUE = 0


def reads():
    return VALUE


VALUES = [
    0,
    1,
    True,
    0.0,
    -0.0,
    "a",
    (1, 2),
    (2, 1),
    [1, 2],
    {1: 2},
    {2: 1},
    frozenset({1}),
    range(3),
    None,
    np.float64(1.0),
    np.float32(1.0),
    np.zeros(3),
    np.zeros((3, 1)),
    np.array([0.0, 0.0, -0.0]),
    np.dtype([("a", float), ("b", float)]),
    np.dtype([("b", float), ("a", float)]),
    np.dtype([("a", np.int8), ("b", float)]),
    np.dtype([("a", np.int8), ("b", float)], align=True),
    types.float64,
    types.Array(types.float64, 1, "C"),
    types.Array(types.float64, 1, "C", readonly=True),
    np.sqrt,
    np.cross,
    max,
    ValueError,
]


def test_each_value_has_a_content_of_its_own(monkeypatch):
    digests = set()
    for value in VALUES:
        monkeypatch.setitem(globals(), "VALUE", value)
        kernel_content._known.pop(reads, None)
        digests.add(code_digest(reads))
    kernel_content._known.pop(reads, None)
    assert len(digests) == len(VALUES)


@pytest.mark.parametrize("value", [object(), open, dis.Bytecode, iter([])], ids=["object", "open", "class", "iterator"])
def test_unknown_values_are_not_passed_over(monkeypatch, value):
    monkeypatch.setitem(globals(), "VALUE", value)
    kernel_content._known.pop(reads, None)
    with pytest.raises(UnknownContent):
        code_digest(reads)
    kernel_content._known.pop(reads, None)


def test_signature_of_a_call_through_an_address_is_part_of_the_content():
    one, other = (caller(void(kind)) for kind in (types.float64, types.int64))
    assert code_digest(one._defn) != code_digest(other._defn)


def test_types_whose_content_cannot_be_told_are_refused():
    with pytest.raises(UnknownContent):
        type_text(types.Opaque(f"thing {object()}"))


def test_sizes_of_arrays_in_records_are_part_of_their_types():
    """numba takes a call with other sizes for another function, and refuses to pass one for the other."""
    one, other = (types.NestedArray(types.float64, (6, n)) for n in (6, 8))
    assert type_text(one) != type_text(other)
