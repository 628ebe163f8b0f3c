"""Bounds of signals over intervals of time: value, rate and second rate of a program on many cells at once.

Interval arithmetic (Moore, Kearfott & Cloud 2009, chapters 2 and 5) over the operations of `flexmb.math.operations`.
What is made of pieces is taken on one piece, the one at a given time of the cell: whoever asks has divided time where
pieces meet. A bound that does not exist (a pole inside) is infinite.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.math import operations as op

__all__ = ["Bounds", "bounds"]

Interval = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True, eq=False)
class Bounds:
    """Bounds on cells: `at` is the value at the time that tells pieces, (n,); each interval is (lowest, highest)."""

    at: np.ndarray
    value: Interval
    rate: Interval
    second: Interval


def _safe(lo: np.ndarray, hi: np.ndarray) -> Interval:
    return np.where(np.isnan(lo), -np.inf, lo), np.where(np.isnan(hi), np.inf, hi)


def _add(x: Interval, y: Interval) -> Interval:
    return _safe(x[0] + y[0], x[1] + y[1])


def _minus(x: Interval) -> Interval:
    return -x[1], -x[0]


def _times(x: Interval, y: Interval) -> Interval:
    # zero times a bound that does not exist is zero: the factor is exactly zero on the whole cell
    a, b, c, d = (_without_nan(one * two) for one in x for two in y)
    return np.minimum(np.minimum(a, b), np.minimum(c, d)), np.maximum(np.maximum(a, b), np.maximum(c, d))


def _without_nan(product):
    return np.where(np.isnan(product), 0.0, product)


def _scaled(x: Interval, factor) -> Interval:
    a, b = (_without_nan(one * np.asarray(factor, float)) for one in x)
    return np.minimum(a, b), np.maximum(a, b)


def _square(x: Interval) -> Interval:
    a, b = x[0] ** 2, x[1] ** 2
    return np.where((x[0] < 0.0) & (x[1] > 0.0), 0.0, np.minimum(a, b)), np.maximum(a, b)


def _inverse(x: Interval) -> Interval:
    pole = (x[0] <= 0.0) & (x[1] >= 0.0)
    return np.where(pole, -np.inf, 1.0 / x[1]), np.where(pole, np.inf, 1.0 / x[0])


def _rising(f, x: Interval) -> Interval:
    return _safe(f(x[0]), f(x[1]))


def _sine(x: Interval, shift: float = 0.0) -> Interval:
    """Return the bounds of sin(x + shift)."""
    lo, hi = x[0] + shift, x[1] + shift
    a, b = np.sin(lo), np.sin(hi)

    def contains(angle):
        return np.floor((hi - angle) / (2.0 * np.pi)) >= np.ceil((lo - angle) / (2.0 * np.pi))

    highest = np.where(contains(0.5 * np.pi), 1.0, np.maximum(a, b))
    lowest = np.where(contains(-0.5 * np.pi), -1.0, np.minimum(a, b))
    endless = ~(np.isfinite(lo) & np.isfinite(hi))
    return np.where(endless, -1.0, lowest), np.where(endless, 1.0, highest)


def _whole_power(x: Interval, n: int) -> Interval:
    if n < 0:
        return _inverse(_whole_power(x, -n))
    if n == 0:
        return np.ones_like(x[0]), np.ones_like(x[1])
    if n % 2:
        return x[0] ** n, x[1] ** n
    size = np.maximum(np.abs(x[0]), np.abs(x[1]))
    least = np.where((x[0] < 0.0) & (x[1] > 0.0), 0.0, np.minimum(np.abs(x[0]), np.abs(x[1])))
    return least**n, size**n


def _powers(x: Interval, p: float) -> Interval:
    if p == round(p) and abs(p) < 1e6:
        return _whole_power(x, int(p))
    valid = x[0] >= 0.0
    lo, hi = np.maximum(x[0], 0.0), np.maximum(x[1], 0.0)
    ends = (lo**p, hi**p) if p > 0.0 else (hi**p, lo**p)
    return np.where(valid, ends[0], -np.inf), np.where(valid, ends[1], np.inf)


def _one(x: Interval) -> Interval:
    return np.ones_like(x[0]), np.ones_like(x[1])


def _none(x: Interval) -> Interval:
    return np.zeros_like(x[0]), np.zeros_like(x[1])


def _polynomial(x: Interval, coefficients) -> Interval:
    """Return the bounds of a polynomial, highest power first (Horner)."""
    total = _none(x)
    for c in coefficients:
        total = _add(_times(total, x), (c, c))
    return total


def _elementary(code: int, x: Interval) -> tuple[Interval, Interval, Interval]:
    """Return the bounds of f, f', f'' of an elementary function."""
    if code in (op.SIN, op.COS):
        shift = 0.0 if code == op.SIN else 0.5 * np.pi
        f = _sine(x, shift)
        return f, _sine(x, shift + 0.5 * np.pi), _minus(f)
    if code == op.TAN:
        turns = np.floor((x[0] + 0.5 * np.pi) / np.pi) != np.floor((x[1] + 0.5 * np.pi) / np.pi)
        f = np.where(turns, -np.inf, np.tan(x[0])), np.where(turns, np.inf, np.tan(x[1]))
        rate = _add(_one(x), _square(f))
        return f, rate, _scaled(_times(f, rate), 2.0)
    if code in (op.ASIN, op.ACOS):
        s = _inverse(_rising(np.sqrt, _add(_one(x), _minus(_square(x)))))
        second = _times(x, _whole_power(s, 3))
        if code == op.ASIN:
            return _rising(np.arcsin, x), s, second
        return _minus(_rising(lambda y: np.arcsin(y) - 0.5 * np.pi, x)), _minus(s), _minus(second)
    if code == op.ATAN:
        s = _inverse(_add(_one(x), _square(x)))
        return _rising(np.arctan, x), s, _scaled(_times(x, _square(s)), -2.0)
    if code in (op.SINH, op.COSH):
        odd, even = _rising(np.sinh, x), _rising(np.cosh, _rising(np.sqrt, _square(x)))
        return (odd, even, odd) if code == op.SINH else (even, odd, even)
    if code == op.TANH:
        f = _rising(np.tanh, x)
        rate = _inverse(_square(_rising(np.cosh, _rising(np.sqrt, _square(x)))))
        return f, rate, _scaled(_times(f, rate), -2.0)
    if code == op.EXP:
        f = _rising(np.exp, x)
        return f, f, f
    if code == op.LOG:
        r = _inverse(x)
        return _rising(np.log, x), r, _minus(_square(r))
    f = _rising(np.sqrt, x)
    r = _inverse(f)
    return f, _scaled(r, 0.5), _scaled(_whole_power(r, 3), -0.25)


_SMOOTH = np.array([6.0, -15.0, 10.0, 0.0, 0.0, 0.0])


def _piece(code: int, at: np.ndarray, x: Interval) -> tuple[Interval, Interval, Interval]:
    """Return the bounds of f, f', f'' of that piece of a function which it has at `at`."""
    zero = _none(x)
    if code == op.NEGATIVE:
        return _minus(x), (zero[0] - 1.0, zero[0] - 1.0), zero
    if code == op.ABS:
        sense = np.where(at >= 0.0, 1.0, -1.0)
        return _scaled(x, sense), (sense, sense), zero
    if code in (op.SIGN, op.STEP, op.NOT):
        value = np.sign(at) if code == op.SIGN else (at >= 0.0 if code == op.STEP else at == 0.0).astype(float)
        return (value, value), zero, zero
    ended, begun = at >= 1.0, at > 0.0
    if code == op.SMOOTH:
        inner = tuple(_polynomial(x, c) for c in (_SMOOTH, np.polyder(_SMOOTH), np.polyder(_SMOOTH, 2)))
        outer = _one(x), zero, zero
    else:  # soft ramp
        a = _scaled(x, np.pi)
        rate = _scaled(_add(_one(x), _minus(_sine(a, 0.5 * np.pi))), 0.5)
        value = _scaled(_add(x, _scaled(_sine(a), -1.0 / np.pi)), 0.5)
        inner = value, rate, _scaled(_sine(a), 0.5 * np.pi)
        outer = _add(x, (zero[0] - 0.5, zero[0] - 0.5)), _one(x), zero
    return tuple(  # type: ignore[return-value]
        (np.where(ended, o[0], np.where(begun, i[0], 0.0)), np.where(ended, o[1], np.where(begun, i[1], 0.0)))
        for i, o in zip(inner, outer, strict=True)
    )


def _table(table: np.ndarray, at: np.ndarray, x: Interval) -> tuple[Interval, Interval, Interval]:
    n = abs(int(table[0]))
    knots, pieces = table[1 : n + 1], table[n + 1 :].reshape(n - 1, 4)
    if table[0] < 0.0:  # it goes on periodically
        period = knots[-1] - knots[0]
        shift = period * np.floor((at - knots[0]) / period)
        at, x = at - shift, (x[0] - shift, x[1] - shift)
    i = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, n - 2)
    a, b, c, d = pieces[i].T
    local = x[0] - knots[i], x[1] - knots[i]
    first, last = np.polyval(pieces[0], 0.0), np.polyval(pieces[-1], knots[-1] - knots[-2])
    held = np.where(at < knots[0], first, last)
    outside = (at < knots[0]) | (at > knots[-1])
    found = []
    for order, coefficients in enumerate(((a, b, c, d), (3.0 * a, 2.0 * b, c), (6.0 * a, 2.0 * b))):
        inside, constant = _polynomial(local, coefficients), held if order == 0 else 0.0
        found.append((np.where(outside, constant, inside[0]), np.where(outside, constant, inside[1])))
    return tuple(found)  # type: ignore[return-value]


def _chained(at: np.ndarray, f, x: Bounds) -> Bounds:
    """Return the bounds of f(x(t)): y' = f' x', y'' = f'' x'^2 + f' x''."""
    rate = _times(f[1], x.rate)
    return Bounds(at, f[0], rate, _add(_times(f[2], _square(x.rate)), _times(f[1], x.second)))


def _product(at: np.ndarray, x: Bounds, y: Bounds) -> Bounds:
    rate = _add(_times(x.rate, y.value), _times(x.value, y.rate))
    mixed = _scaled(_times(x.rate, y.rate), 2.0)
    second = _add(_add(_times(x.second, y.value), mixed), _times(x.value, y.second))
    return Bounds(at, _times(x.value, y.value), rate, second)


def _reciprocal(x: Bounds) -> Bounds:
    r = _inverse(x.value)
    return _chained(1.0 / x.at, (r, _minus(_square(r)), _scaled(_whole_power(r, 3), 2.0)), x)


def _power(at: np.ndarray, x: Bounds, p: Bounds) -> Bounds:
    exponent = p.value[0]
    if len(exponent) and np.all(p.value[1] == exponent) and np.all(exponent == exponent[0]):
        e = float(exponent[0])
        f = _powers(x.value, e), _scaled(_powers(x.value, e - 1.0), e), _scaled(_powers(x.value, e - 2.0), e * (e - 1))
        return _chained(at, f, x)
    log = _chained(np.log(x.at), _elementary(op.LOG, x.value), x)
    y = _product(np.log(at), p, log)
    return _chained(at, _elementary(op.EXP, y.value), y)


def _angle(at: np.ndarray, x: Bounds, y: Bounds) -> Bounds:
    """Return the bounds of atan2(x, y)."""
    corners = [np.arctan2(a, b) for a in x.value for b in y.value]
    cut = (x.value[0] <= 0.0) & (x.value[1] >= 0.0) & (y.value[0] <= 0.0)
    value = np.where(cut, -np.pi, np.minimum.reduce(corners)), np.where(cut, np.pi, np.maximum.reduce(corners))
    d = _inverse(_add(_square(x.value), _square(y.value)))
    n = _add(_times(y.value, x.rate), _minus(_times(x.value, y.rate)))
    n1 = _add(_times(y.value, x.second), _minus(_times(x.value, y.second)))
    d1 = _scaled(_add(_times(x.value, x.rate), _times(y.value, y.rate)), 2.0)
    rate = _times(n, d)
    return Bounds(at, value, rate, _times(_add(n1, _minus(_times(rate, d1))), d))


def _side(knots: np.ndarray, at: np.ndarray, x: Interval) -> tuple[np.ndarray, Interval, np.ndarray]:
    """Return the number of the piece at `at`, the distances from its first knot, and if values are not held there."""
    i = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(knots) - 2)
    inside = (at >= knots[0]) & (at <= knots[-1])
    held = np.where(at < knots[0], 0.0, knots[i + 1] - knots[i])
    return i, (np.where(inside, x[0] - knots[i], held), np.where(inside, x[1] - knots[i], held)), inside


def _grid(table: np.ndarray, at: tuple[np.ndarray, np.ndarray], x: Interval, y: Interval) -> dict[tuple, Interval]:
    """Return the bounds of f and its derivatives, by their orders along x and y."""
    n, m = int(table[0]), int(table[1])
    knots = table[2 : 2 + n], table[2 + n : 2 + n + m]
    (i, h, in_x), (j, k, in_y) = (_side(*of) for of in zip(knots, at, (x, y)))
    c = table[2 + n + m :].reshape(n - 1, m - 1, 4, 4)[i, j]
    found = {}
    for orders in ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)):
        a = _falling(_falling(c, 1, orders[0]), 2, orders[1])
        total = _none(h)
        for p in range(a.shape[1]):
            row = _polynomial(k, [a[:, p, q] for q in range(a.shape[2])])
            total = _add(_times(total, h), row)
        zero = ((orders[0] > 0) & ~in_x) | ((orders[1] > 0) & ~in_y)
        found[orders] = np.where(zero, 0.0, total[0]), np.where(zero, 0.0, total[1])
    return found


def _falling(c: np.ndarray, axis: int, order: int) -> np.ndarray:
    """Return the coefficients, highest power first along an axis, of a derivative."""
    for _ in range(order):
        powers = np.arange(c.shape[axis] - 1, 0, -1.0)
        c = np.take(c, range(len(powers)), axis) * powers.reshape([-1 if k == axis else 1 for k in range(3)])
    return c


def _over_two(table: np.ndarray, x: Bounds, y: Bounds) -> Bounds:
    at = x.at, y.at
    f = _grid(table, at, x.value, y.value)
    value = _grid(table, at, (x.at, x.at), (y.at, y.at))[0, 0][0]
    rate = _add(_times(f[1, 0], x.rate), _times(f[0, 1], y.rate))
    mixed = _scaled(_times(f[1, 1], _times(x.rate, y.rate)), 2.0)
    bent = _add(_add(_times(f[2, 0], _square(x.rate)), mixed), _times(f[0, 2], _square(y.rate)))
    return Bounds(value, f[0, 0], rate, _add(bent, _add(_times(f[1, 0], x.second), _times(f[0, 1], y.second))))


def _chosen(which: np.ndarray, x: Bounds, y: Bounds) -> Bounds:
    def choose(a: Interval, b: Interval) -> Interval:
        return np.where(which, a[0], b[0]), np.where(which, a[1], b[1])

    return Bounds(
        np.where(which, x.at, y.at), choose(x.value, y.value), choose(x.rate, y.rate), choose(x.second, y.second)
    )


def _binary(code: int, x: Bounds, y: Bounds) -> Bounds:
    if code in (op.MIN, op.MAX):
        return _chosen((x.at > y.at) == (code == op.MAX), x, y)
    if code >= op.LESS:
        a, b = x.at, y.at
        holds = {
            op.LESS: a < b,
            op.LESS_EQUAL: a <= b,
            op.GREATER: a > b,
            op.GREATER_EQUAL: a >= b,
            op.EQUAL: a == b,
            op.NOT_EQUAL: a != b,
            op.AND: (a != 0.0) & (b != 0.0),
            op.OR: (a != 0.0) | (b != 0.0),
        }[code].astype(float)
        zero = np.zeros_like(holds)
        return Bounds(holds, (holds, holds), (zero, zero), (zero, zero))
    if code in (op.ADD, op.SUBTRACT):
        if code == op.SUBTRACT:
            y = Bounds(-y.at, _minus(y.value), _minus(y.rate), _minus(y.second))
        return Bounds(x.at + y.at, _add(x.value, y.value), _add(x.rate, y.rate), _add(x.second, y.second))
    if code == op.MULTIPLY:
        return _product(x.at * y.at, x, y)
    if code == op.DIVIDE:
        return _product(x.at / y.at, x, _reciprocal(y))
    return _power(x.at**y.at, x, y) if code == op.POWER else _angle(np.arctan2(x.at, y.at), x, y)


_VALUES = {
    op.SIN: np.sin,
    op.COS: np.cos,
    op.TAN: np.tan,
    op.ASIN: np.arcsin,
    op.ACOS: np.arccos,
    op.ATAN: np.arctan,
    op.SINH: np.sinh,
    op.COSH: np.cosh,
    op.TANH: np.tanh,
    op.EXP: np.exp,
    op.LOG: np.log,
    op.SQRT: np.sqrt,
}


def _unary(code: int, argument: float, tables, x: Bounds) -> Bounds:
    point = x.at, x.at
    if code == op.TABLE:
        table = tables[int(argument)]
        return _chained(_table(table, x.at, point)[0][0], _table(table, x.at, x.value), x)
    if code in _VALUES:
        return _chained(_VALUES[code](x.at), _elementary(code, x.value), x)
    return _chained(_piece(code, x.at, point)[0][0], _piece(code, x.at, x.value), x)


def bounds(ops, args, tables, begin: np.ndarray, end: np.ndarray, at: np.ndarray) -> Bounds:
    """Return the bounds of a program (see `flexmb.model.expression`) on the cells [begin, end], all (n,), s.

    `at` is the time in (or near) each cell that tells which piece of every function holds there.
    """
    stack: list[Bounds] = []
    zero = np.zeros_like(at)
    time = Bounds(at, (begin, end), (zero + 1.0, zero + 1.0), (zero, zero))
    with np.errstate(all="ignore"):
        for code, argument in zip(ops, args, strict=True):
            if code == op.TIME:
                stack.append(time)
            elif code == op.CONSTANT:
                c = zero + argument
                stack.append(Bounds(c, (c, c), (zero, zero), (zero, zero)))
            elif code in op.UNARY:
                stack.append(_unary(code, argument, tables, stack.pop()))
            elif code in op.BINARY:
                y, x = stack.pop(), stack.pop()
                stack.append(_over_two(tables[int(argument)], x, y) if code == op.TABLE2 else _binary(code, x, y))
            else:
                b, a, holds = stack.pop(), stack.pop(), stack.pop()
                stack.append(_chosen(holds.at != 0.0, a, b))
    return stack[0]
