"""Eight numbers at once, for sums over rows that are filled up to eights: one operation of the machine, or few.

The compiler joins neighbouring numbers by itself only where it can prove that nothing is written in between, which in
kernels with many arrays it cannot. A sum with a product is rounded once, whether the processor has an operation for it
or not, so results are the same on every machine. Places are not counted from the end: they must not be negative.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir as code
from numba import types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.extending import intrinsic, register_model

__all__ = [
    "EIGHT",
    "WIDTH",
    "crossing",
    "keep",
    "keep_columns",
    "less",
    "more",
    "only_after",
    "part",
    "plus",
    "put",
    "read",
    "same",
    "times",
    "total",
    "totals",
]

WIDTH = 8
"""Numbers in one."""


class _Eight(types.Type):
    """Eight numbers."""

    def __init__(self) -> None:
        super().__init__(name="Eight")


EIGHT = _Eight()


@register_model(_Eight)
class _EightModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: types.Type) -> None:
        super().__init__(manager, kind, code.VectorType(code.DoubleType(), WIDTH))


def _places(wanted: Any, bits: int = 32) -> Any:
    """Return places among eight numbers, or among twice as many, as a constant."""
    return code.Constant(code.VectorType(code.IntType(bits), len(wanted)), list(wanted))


def _spread(builder: Any, number: Any) -> Any:
    """Return eight times the same number."""
    number_of = code.VectorType(number.type, WIDTH)
    empty = code.Constant(number_of, code.Undefined)
    first = builder.insert_element(empty, number, code.Constant(code.IntType(32), 0))
    return builder.shuffle_vector(first, empty, _places([0] * WIDTH))


def _factor(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """Return eight numbers as they are, one number eight times."""
    return value if kind == EIGHT else _spread(builder, context.cast(builder, value, kind, types.float64))


def _address(context: Any, builder: Any, kinds: tuple, values: tuple) -> Any:
    """Return where eight numbers of an array begin; `kinds` and `values` are the array's and the index's."""
    (kind, index_kind), (array, index) = kinds, values
    made = context.make_array(kind)(context, builder, array)
    if isinstance(index_kind, types.BaseTuple):
        places = [builder.extract_value(index, k) for k in range(len(index_kind))]
        given = [context.cast(builder, one, index_kind[k], types.intp) for k, one in enumerate(places)]
    else:
        given = [context.cast(builder, index, index_kind, types.intp)]
    sizes = cgutils.unpack_tuple(builder, made.shape, kind.ndim)
    at = given[0]
    for place, size in zip(given[1:], sizes[1:], strict=True):
        at = builder.add(builder.mul(at, size), place)
    number = builder.gep(made.data, [at])
    return builder.bitcast(number, code.VectorType(code.DoubleType(), WIDTH).as_pointer())


def _is_dense(array: Any, index: Any) -> bool:
    count = len(index) if isinstance(index, types.BaseTuple) else 1
    return (
        isinstance(array, types.Array) and array.layout == "C" and array.dtype == types.float64 and array.ndim == count
    )


@intrinsic
def read(typing_context, array, index):
    """Return the eight numbers of an array (of floats, one after another) that begin at an index."""
    if not _is_dense(array, index):
        return None

    def generate(context, builder, signature, values):
        return builder.load(_address(context, builder, signature.args, values), align=8)

    return EIGHT(array, index), generate


@intrinsic
def keep(typing_context, array, index, value):
    """Write eight numbers to an array, to begin at an index."""
    if not _is_dense(array, index) or value != EIGHT:
        return None

    def generate(context, builder, signature, values):
        builder.store(values[2], _address(context, builder, signature.args[:2], values[:2]), align=8)
        return context.get_dummy_value()

    return types.void(array, index, value), generate


@intrinsic
def part(typing_context, array, index, count):
    """Return the `count` numbers, up to eight, of an array that begin at an index; zeros behind them."""
    if not _is_dense(array, index):
        return None

    def generate(context, builder, signature, values):
        address = _address(context, builder, signature.args[:2], values[:2])
        whole = context.cast(builder, values[2], signature.args[2], types.int64)
        mask = builder.icmp_signed("<", _places(range(WIDTH), 64), _spread(builder, whole))
        eight = code.VectorType(code.DoubleType(), WIDTH)
        kind = code.FunctionType(eight, [address.type, code.IntType(32), mask.type, eight])
        masked = cgutils.get_or_insert_function(builder.module, kind, "llvm.masked.load.v8f64.p0")
        zeros = code.Constant(eight, [0.0] * WIDTH)
        return builder.call(masked, [address, code.Constant(code.IntType(32), 8), mask, zeros])

    return EIGHT(array, index, count), generate


@intrinsic
def same(typing_context, number):
    """Return eight times the same number."""

    def generate(context, builder, signature, values):
        return _factor(context, builder, signature.args[0], values[0])

    return EIGHT(number), generate


@intrinsic
def times(typing_context, x, a):
    """Return x a; x is one number or eight."""

    def generate(context, builder, signature, values):
        return builder.fmul(_factor(context, builder, signature.args[0], values[0]), values[1])

    return EIGHT(x, a), generate


@intrinsic
def plus(typing_context, a, b):
    """Return a + b."""

    def generate(context, builder, signature, values):
        return builder.fadd(*values)

    return EIGHT(a, b), generate


def _with_product(negative: bool):
    """Return the code of a sum or difference of a and x b, rounded once."""

    def generate(context, builder, signature, values):
        factor = _factor(context, builder, signature.args[1], values[1])
        if negative:
            factor = builder.fneg(factor)
        eight = code.VectorType(code.DoubleType(), WIDTH)
        fused = cgutils.get_or_insert_function(
            builder.module, code.FunctionType(eight, [eight] * 3), f"llvm.fma.v{WIDTH}f64"
        )
        return builder.call(fused, [factor, values[2], values[0]])

    return generate


@intrinsic
def more(typing_context, a, x, b):
    """Return a + x b, rounded once; x is one number or eight."""
    return EIGHT(a, x, b), _with_product(False)


@intrinsic
def less(typing_context, a, x, b):
    """Return a - x b, rounded once; x is one number or eight."""
    return EIGHT(a, x, b), _with_product(True)


@intrinsic
def put(typing_context, a, place, number):
    """Return eight numbers with another one at a place."""

    def generate(context, builder, signature, values):
        whole = context.cast(builder, values[1], signature.args[1], types.int64)
        there = builder.icmp_signed("==", _places(range(WIDTH), 64), _spread(builder, whole))
        return builder.select(there, _spread(builder, values[2]), values[0])

    return EIGHT(a, place, number), generate


@intrinsic
def only_after(typing_context, a, before, place):
    """Return the numbers of a behind a place, those of `before` up to it."""

    def generate(context, builder, signature, values):
        whole = context.cast(builder, values[2], signature.args[2], types.int64)
        behind = builder.icmp_signed(">", _places(range(WIDTH), 64), _spread(builder, whole))
        return builder.select(behind, values[0], values[1])

    return EIGHT(a, before, place), generate


def crossing(*places: int):
    """Return a function for kernels, ``(a, b)``, that gathers the numbers at constant places of both: 0 to 7 of a, 8
    to 15 of b.
    """

    def gathered(typing_context, a, b):
        def generate(context, builder, signature, values):
            return builder.shuffle_vector(*values, _places(places))

        return EIGHT(a, b), generate

    return intrinsic(gathered)


PAIRS = (0, 8, 2, 10, 4, 12, 6, 14), (1, 9, 3, 11, 5, 13, 7, 15)
FOURS = (0, 1, 8, 9, 4, 5, 12, 13), (2, 3, 10, 11, 6, 7, 14, 15)
HALVES = (0, 1, 2, 3, 8, 9, 10, 11), (4, 5, 6, 7, 12, 13, 14, 15)
"""Places by which eight rows become columns, in three steps."""


@intrinsic
def keep_columns(typing_context, array, first, a, b, c, d, e, f, g, h):
    """Write eight times eight numbers, given by columns, to eight whole rows of a matrix from row `first` on."""
    if not (isinstance(array, types.Array) and array.layout == "C" and array.ndim == 2):
        return None

    def generate(context, builder, signature, values):
        rows = list(values[2:])
        for size, wanted in ((1, PAIRS), (2, FOURS), (4, HALVES)):
            low, high = map(_places, wanted)
            for k in range(WIDTH):
                if k & size == 0:
                    one, other = rows[k], rows[k + size]
                    rows[k] = builder.shuffle_vector(one, other, low)
                    rows[k + size] = builder.shuffle_vector(one, other, high)
        for k, row in enumerate(rows):
            place = builder.add(values[1], code.Constant(values[1].type, k))
            index = context.make_tuple(builder, types.UniTuple(types.intp, 2), (place, place.type(0)))
            kinds = array, types.UniTuple(types.intp, 2)
            builder.store(row, _address(context, builder, kinds, (values[0], index)), align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, a, b, c, d, e, f, g, h), generate


@intrinsic
def totals(typing_context, a, b, c, d, e, f, g, h):
    """Return the sums of eight times eight numbers, in the order of the arguments: of neighbours, pairs, and fours."""

    def generate(context, builder, signature, values):
        rows = list(values)
        for wanted in (PAIRS, FOURS, HALVES):
            low, high = map(_places, wanted)
            rows = [
                builder.fadd(builder.shuffle_vector(one, other, low), builder.shuffle_vector(one, other, high))
                for one, other in zip(rows[::2], rows[1::2], strict=True)
            ]
        return rows[0]

    return EIGHT(a, b, c, d, e, f, g, h), generate


@intrinsic
def total(typing_context, a):
    """Return the sum: of the halves, of their halves, of the two that are left."""

    def generate(context, builder, signature, values):
        found, size = values[0], WIDTH
        while size > 1:
            size //= 2
            halves = _places(range(size)), _places(range(size, 2 * size))
            low, high = (builder.shuffle_vector(found, found, half) for half in halves)
            found = builder.fadd(low, high)
        return builder.extract_element(found, code.Constant(code.IntType(32), 0))

    return types.float64(a), generate
