"""Where signals are not smooth: the times of their steps, corners and points of tables, read from their programs.

Operations that are made of pieces (step, smooth, abs, sign, min, max, comparisons, tables) change pieces where their
argument passes certain values. Where the argument is ``a t + b`` these times are computed. Elsewhere bounds of the
argument and its rate over intervals isolate them: intervals are halved until each holds one root or none (Moore,
Kearfott & Cloud 2009, chapter 8). None is missed, however close two of them are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.math import operations as op
from flexmb.math.interval_jets import bounds
from flexmb.model.expression import SignalProgram

__all__ = ["RECORD", "TRUTHS", "Breaks", "bent_points", "breakpoints"]

RECORD = 1000
"""From this number of points on, a table is a record of continuous change: only its ends count."""
BENT = 1e-12
"""Change of the coefficients at a point of a table, relative to its values, below which it is rounding."""
MOST = 200_000
"""Intervals that are looked at together before the search ends."""
NARROW = 1e-13
"""Width of an interval, relative to the times, that cannot be halved."""
HALVINGS = 60
PERIODS = 10_000
"""Of a periodic table, in one run, whose corners are looked for."""
COMPARED = (op.MIN, op.MAX, *range(op.LESS, op.NOT_EQUAL + 1))
TRUTHS = (op.NOT, *range(op.LESS, op.OR + 1))


@dataclass(frozen=True, eq=False)
class Breaks:
    """Times at which a signal may not be smooth.

    Parameters
    ----------
    times : (n,), s
        Increasing; where it jumps or kinks, and the ends and points of tables.
    pieces : (m,), s
        The same with all points of records: between neighbours every operation stays on one piece.
    complete : bool
        Were all isolated?
    """

    times: np.ndarray
    pieces: np.ndarray
    complete: bool = True


class _Search:
    """The switches of one program, found from the inner ones outwards."""

    def __init__(self, program: SignalProgram, begin: float, end: float):
        self.program, self.begin, self.end = program, begin, end
        self.found: list[np.ndarray] = []
        self.records: list[np.ndarray] = []
        self.complete = True

    def edges(self) -> np.ndarray:
        """Return begin, the times found so far, and end."""
        inner = np.concatenate([np.empty(0), *self.found, *self.records])
        return np.unique(np.concatenate([[self.begin, self.end], inner[(inner > self.begin) & (inner < self.end)]]))

    def shifts(self, span: tuple[int, int], line, period: float) -> np.ndarray:
        """Return the whole periods (n,) by which the argument of a periodic table is shifted."""
        if line is not None:
            ends = [line[0] * t + line[1] for t in (self.begin, self.end)]
        else:
            edges = self.edges()
            a, b = edges[:-1], edges[1:]
            ops, args = self.program.ops[slice(*span)], self.program.args[slice(*span)]
            found = bounds(ops, args, self.program.tables, a, b, 0.5 * (a + b))
            ends = [float(np.min(found.value[0])), float(np.max(found.value[1]))]
        many = abs(ends[1] - ends[0]) / period if np.all(np.isfinite(ends)) else np.inf
        if not many < PERIODS:
            self.complete = False
            return np.zeros(1)
        return period * np.arange(np.floor(min(ends) / period) - 1.0, np.ceil(max(ends) / period) + 2.0)

    def passes(self, span: tuple[int, int], line, levels, *extra: tuple[int, float], record=False) -> None:
        """Look for the times at which operations [first, last), followed by `extra`, pass levels."""
        levels, into = np.asarray(levels, float), self.records if record else self.found
        if line is not None:
            if line[0] != 0.0:
                into.append((levels - line[1]) / line[0])
            return
        if self.begin >= self.end:
            return
        codes, arguments = zip(*extra, strict=True) if extra else ((), ())
        ops = np.concatenate([self.program.ops[slice(*span)], np.array(codes, np.int64)])
        args = np.concatenate([self.program.args[slice(*span)], np.array(arguments, float)])
        roots, complete = _roots(ops, args, self.program.tables, self.edges(), levels)
        into.append(roots)
        self.complete &= complete


def _roots(ops, args, tables, edges: np.ndarray, levels: np.ndarray) -> tuple[np.ndarray, bool]:
    """Return the times (n,) at which a program passes one of the levels between edges, and if all were isolated."""
    a, b = np.repeat(edges[:-1], len(levels)), np.repeat(edges[1:], len(levels))
    level, at = np.tile(levels, len(edges) - 1), 0.5 * (a + b)
    narrow = NARROW * max(abs(edges[0]), abs(edges[-1]))
    roots, touched, complete = [], np.empty((0, 2)), True
    for _ in range(2 * HALVINGS):
        found = bounds(ops, args, tables, a, b, at)
        lo, hi = found.value[0] - level, found.value[1] - level
        flat = (found.rate[0] == 0.0) & (found.rate[1] == 0.0)
        possible = (lo <= 0.0) & (hi >= 0.0) & ~flat
        single = (found.rate[0] >= 0.0) | (found.rate[1] <= 0.0)
        roots.append(_passed(ops, args, tables, *(x[possible & single] for x in (a, b, at, level))))
        stuck = possible & ~single & (b - a <= narrow)
        touched = np.concatenate([touched, np.column_stack([a, b])[stuck]])
        a, b, at, level = (x[possible & ~single & ~stuck] for x in (a, b, at, level))
        if not len(a):
            break
        if len(a) > MOST:
            complete = False
            break
        middle = 0.5 * (a + b)
        a, b = np.concatenate([a, middle]), np.concatenate([middle, b])
        at, level = np.tile(at, 2), np.tile(level, 2)
    return np.concatenate([*roots, _joined(touched, 4.0 * narrow)]), complete


def _joined(cells: np.ndarray, near: float) -> np.ndarray:
    """Return the middles (n,) of chains of cells (m, 2) next to each other: around a touch all bounds contain zero."""
    cells = cells[np.argsort(cells[:, 0])]
    first = np.concatenate([[True], cells[1:, 0] - cells[:-1, 1] > near])[: len(cells)]
    last = np.concatenate([first[1:], [True]])[: len(cells)]
    return 0.5 * (cells[first, 0] + cells[last, 1])


def _passed(ops, args, tables, a, b, at, level) -> np.ndarray:
    """Return the roots in intervals on which a program grows or falls all the way, those that have one."""

    if not len(a):
        return a

    def value(t):
        return bounds(ops, args, tables, t, t, at).value[0] - level

    begin, end = value(a), value(b)
    has = begin * end <= 0.0
    a, b, at, level, begin = (x[has] for x in (a, b, at, level, begin))
    if not len(a):
        return a
    exact = begin == 0.0
    start = a.copy()
    for _ in range(HALVINGS):
        middle = 0.5 * (a + b)
        left = value(middle) * begin > 0.0
        a, b = np.where(left, middle, a), np.where(left, b, middle)
    return np.where(exact, start, 0.5 * (a + b))


def breakpoints(program: SignalProgram, begin: float, end: float) -> Breaks:
    """Return the times between `begin` and `end`, s, at which a signal jumps or kinks, or passes a point of a table.

    Times that follow from an argument ``a t + b`` may lie outside.
    """
    search = _Search(program, begin, end)
    stack: list[tuple[int, tuple[float, float] | None, int]] = []  # first operation, line, last operation
    for k, (code, argument) in enumerate(zip(program.ops, program.args, strict=True)):
        if code in (op.CONSTANT, op.TIME):
            stack.append((k, (0.0, argument) if code == op.CONSTANT else (1.0, 0.0), code))
        elif code in op.UNARY:
            first, line, _ = stack.pop()
            _unary(search, code, argument, (first, k), line)
            stack.append((first, (-line[0], -line[1]) if code == op.NEGATIVE and line is not None else None, code))
        elif code in op.BINARY:
            (middle, b, right), (first, a, left) = stack.pop(), stack.pop()
            _binary(search, code, (first, middle, k), (a, b), (left, right))
            stack.append((first, _line(code, a, b), code))
        else:
            (_, _, _), (second, _, _), (first, line, condition) = stack.pop(), stack.pop(), stack.pop()
            if condition not in TRUTHS:
                search.passes((first, second), line, [0.0])
            stack.append((first, None, code))
    times = np.unique(np.concatenate([np.empty(0), *search.found]))
    return Breaks(times, search.edges(), search.complete)


def _unary(search: _Search, code: int, argument: float, span: tuple[int, int], line) -> None:
    if code == op.TABLE:
        table = search.program.tables[int(argument)]
        n = abs(int(table[0]))
        repeated = search.shifts(span, line, table[n] - table[1])[:, None] if table[0] < 0.0 else np.zeros((1, 1))
        if n > RECORD:
            search.passes(span, line, (table[2:n] + repeated).ravel(), record=True)
            search.passes(span, line, (table[[1, n]] + repeated).ravel())
        else:
            search.passes(span, line, np.unique((bent_points(table) + repeated).ravel()))
    elif code in (op.ABS, op.SIGN, op.STEP, op.SQRT, op.LOG):
        search.passes(span, line, [0.0])
    elif code in (op.SMOOTH, op.SOFT_RAMP):
        search.passes(span, line, [0.0, 1.0])
    elif code in (op.ASIN, op.ACOS):
        search.passes(span, line, [-1.0, 1.0])
    elif code == op.TAN:
        search.passes(span, None, [0.0], (op.COS, 0.0))
    elif code == op.NOT and search.program.ops[span[1] - 1] not in TRUTHS:
        search.passes(span, line, [0.0])


def _binary(search: _Search, code: int, spans: tuple[int, int, int], lines, operands: tuple[int, int]) -> None:
    first, middle, last = spans
    a, b = lines
    if code in COMPARED:
        difference = _line(op.SUBTRACT, a, b)
        search.passes((first, last), difference, [0.0], (op.SUBTRACT, 0.0))
    elif code in (op.AND, op.OR):
        for span, line, operand in (((first, middle), a, operands[0]), ((middle, last), b, operands[1])):
            if operand not in TRUTHS:
                search.passes(span, line, [0.0])
    elif code == op.TABLE2:
        table = search.program.tables[int(search.program.args[last])]
        n, m = int(table[0]), int(table[1])
        search.passes((first, middle), a, table[2 : 2 + n])
        search.passes((middle, last), b, table[2 + n : 2 + n + m])
    elif code == op.DIVIDE and not _constant(b):
        search.passes((middle, last), b, [0.0])
    elif (code == op.ATAN2 and not _constant(a)) or (
        code == op.POWER and not _constant(a) and not (_constant(b) and b[1] >= 0.0 and b[1] == round(b[1]))
    ):
        search.passes((first, middle), a, [0.0])


def _constant(line) -> bool:
    return line is not None and line[0] == 0.0


def bent_points(table: np.ndarray, derivatives: int = 3) -> np.ndarray:
    """Return the ends of a table and the points at which it, or one of so many derivatives, jumps."""
    n = abs(int(table[0]))
    knots, pieces = table[1 : n + 1], table[n + 1 :].reshape(n - 1, 4)
    h = np.diff(knots)
    # the piece on the left, written about the point at its end
    a, b, c, d = pieces[:-1].T
    left = np.column_stack(
        [
            a,
            3.0 * a * h[:-1] + b,
            (3.0 * a * h[:-1] + 2.0 * b) * h[:-1] + c,
            ((a * h[:-1] + b) * h[:-1] + c) * h[:-1] + d,
        ]
    )
    reach = np.minimum(h[:-1], h[1:])[:, None] ** np.array([3.0, 2.0, 1.0, 0.0])
    size = np.abs(pieces[:, 3]).max()
    bends = np.any((np.abs(left - pieces[1:]) * reach > BENT * size)[:, 3 - derivatives :], axis=1)
    return knots[np.concatenate([[True], bends, [True]])]


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
