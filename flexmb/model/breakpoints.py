"""Where signals are not smooth: the times of their steps, corners and points of tables, read from their programs."""

from __future__ import annotations

import numpy as np

from flexmb.math import operations as op
from flexmb.model.expression import Program

__all__ = ["breakpoints"]

RECORD = 1000
"""Points from which on a table is a record of something that goes on all the time: then only its ends count."""
COMPARED = (op.MIN, op.MAX, *range(op.LESS, op.NOT_EQUAL + 1))


def breakpoints(program: Program) -> np.ndarray:
    """Return the times (n,), s, at which a signal jumps or kinks, or passes a point of a table.

    Operations that are made of pieces (step, smooth, abs, sign, min, max, comparisons, tables) change pieces where
    their argument passes certain values. The times are found where this argument is ``a t + b``, as in all signals of
    the library but tables of other signals, and in most expressions.
    """
    stack: list[tuple[float, float] | None] = []
    found: list[float] = []

    def passes(line, *values) -> None:
        if line is not None and line[0] != 0.0:
            found.extend((value - line[1]) / line[0] for value in values)

    for code, argument in zip(program.ops, program.args, strict=True):
        if code in (op.CONSTANT, op.TIME):
            stack.append((0.0, argument) if code == op.CONSTANT else (1.0, 0.0))
        elif code in op.UNARY:
            line = stack.pop()
            if code in (op.ABS, op.SIGN, op.STEP):
                passes(line, 0.0)
            elif code in (op.SMOOTH, op.SOFT_RAMP):
                passes(line, 0.0, 1.0)
            elif code == op.TABLE:
                passes(line, *_points(program.tables[int(argument)]))
            stack.append((-line[0], -line[1]) if code == op.NEGATIVE and line is not None else None)
        elif code in op.BINARY:
            b, a = stack.pop(), stack.pop()
            if code in COMPARED:
                passes(_line(op.SUBTRACT, a, b), 0.0)
            stack.append(_line(code, a, b))
        else:
            stack[-3:] = [None]
    return np.unique(found)


def _points(table: np.ndarray) -> np.ndarray:
    """Return the points of a table at which pieces meet."""
    n = int(table[0])
    return table[1 : n + 1 : 1 if n <= RECORD else n - 1]


def _line(code: int, a, b) -> tuple[float, float] | None:
    """Return slope and value at t = 0 of an operation on two such lines; None if the result is none."""
    if a is None or b is None:
        return None
    if code == op.ADD:
        return a[0] + b[0], a[1] + b[1]
    if code == op.SUBTRACT:
        return a[0] - b[0], a[1] - b[1]
    if code == op.MULTIPLY and (a[0] == 0.0 or b[0] == 0.0):
        return a[0] * b[1] + a[1] * b[0], a[1] * b[1]
    if code == op.DIVIDE and b[0] == 0.0 and b[1] != 0.0:
        return a[0] / b[1], a[1] / b[1]
    return None
