"""Signals and their first two time derivatives, computed by second-order jets on a stack.

A jet is (x, x', x''), the Taylor coefficients of a function of time. Every operation maps jets to jets by the chain
rule (Griewank & Walther, Evaluating Derivatives, 2nd ed., section 13.2), so derivatives are exact, without
differences:

    y = f(x):   y' = f1 x',   y'' = f2 x'^2 + f1 x''

At a kink (abs, min, max, step, the ends of a table) the derivatives belong to the branch on the right.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from flexmb.math import operations as op
from flexmb.math.grids import interpolate_grid
from flexmb.math.kernel import entry_kernel, inner_kernel, kernel
from flexmb.math.kernel_on_demand import kernel_on_demand
from flexmb.math.plain_loops import copy_into, knots_until
from flexmb.math.structures import Floats, Integers, array_type, numba_type, structure
from flexmb.math.tables import COUNT, FLOATS, INTEGERS, NUMBER, void

__all__ = ["SignalCode", "interpolate", "of_one_value", "of_two_values", "run_program", "sample_signals"]


@structure
class SignalCode(NamedTuple):
    """Signals as programs in postfix order, one after another (see `flexmb.math.operations`)."""

    starts: Integers
    """(ns + 1,) first operation of each signal, and the end"""
    ops: Integers
    args: Floats
    """(n,) arguments of the operations"""
    tables: Floats
    """knots and coefficients of all tables"""
    table_starts: Integers
    """(nt + 1,) first number of each table, and the end"""


# Global integers are constants to the compiler.
_CONSTANT, _TIME, _INPUT, _TABLE, _WHERE, _STACK = op.CONSTANT, op.TIME, op.INPUT, op.TABLE, op.WHERE, op.STACK
_PUSHES_END, _UNARY_END, _BINARY_END = op.PUSHES.stop, op.UNARY.stop, op.BINARY.stop
_NEGATIVE, _ABS, _SIGN, _STEP, _SMOOTH, _SOFT_RAMP = (
    op.NEGATIVE,
    op.ABS,
    op.SIGN,
    op.STEP,
    op.SMOOTH,
    op.SOFT_RAMP,
)
_SIN, _COS, _TAN, _ASIN, _ACOS, _ATAN = op.SIN, op.COS, op.TAN, op.ASIN, op.ACOS, op.ATAN
_SINH, _COSH, _TANH, _EXP, _LOG, _SQRT, _NOT = op.SINH, op.COSH, op.TANH, op.EXP, op.LOG, op.SQRT, op.NOT
_ADD, _SUBTRACT, _MULTIPLY, _DIVIDE, _POWER = op.ADD, op.SUBTRACT, op.MULTIPLY, op.DIVIDE, op.POWER
_ATAN2, _MIN, _MAX, _AND, _OR = op.ATAN2, op.MIN, op.MAX, op.AND, op.OR
_LESS, _LESS_EQUAL, _GREATER, _GREATER_EQUAL = op.LESS, op.LESS_EQUAL, op.GREATER, op.GREATER_EQUAL
_EQUAL, _NOT_EQUAL = op.EQUAL, op.NOT_EQUAL
_TABLE2 = op.TABLE2


@inner_kernel
def _elementary(code, x):
    """Return f, f', f'' of an elementary function at x."""
    if code == _SIN:
        return math.sin(x), math.cos(x), -math.sin(x)
    if code == _COS:
        return math.cos(x), -math.sin(x), -math.cos(x)
    if code == _TAN:
        f = math.tan(x)
        return f, 1.0 + f * f, 2.0 * f * (1.0 + f * f)
    if code == _ASIN:
        s = 1.0 / math.sqrt(1.0 - x * x)
        return math.asin(x), s, x * s**3
    if code == _ACOS:
        s = 1.0 / math.sqrt(1.0 - x * x)
        return math.acos(x), -s, -x * s**3
    if code == _ATAN:
        s = 1.0 / (1.0 + x * x)
        return math.atan(x), s, -2.0 * x * s * s
    if code == _SINH:
        return math.sinh(x), math.cosh(x), math.sinh(x)
    if code == _COSH:
        return math.cosh(x), math.sinh(x), math.cosh(x)
    if code == _TANH:
        f = math.tanh(x)
        return f, 1.0 - f * f, -2.0 * f * (1.0 - f * f)
    if code == _EXP:
        f = math.exp(x)
        return f, f, f
    if code == _LOG:
        return math.log(x), 1.0 / x, -1.0 / (x * x)
    f = math.sqrt(x)
    return f, 0.5 / f, -0.25 / (f * x)


@inner_kernel
def _piecewise(code, x):
    """Return f, f', f'' of a function made of pieces at x.

    smooth: 10 x^3 - 15 x^4 + 6 x^5 on [0, 1], the lowest polynomial with zero rate and second rate at both ends.
    soft ramp: rate (1 - cos(pi x)) / 2 on [0, 1], then 1.
    """
    if code == _NEGATIVE:
        return -x, -1.0, 0.0
    if code == _ABS:
        return abs(x), 1.0 if x >= 0.0 else -1.0, 0.0
    if code == _SIGN:
        return (1.0 if x > 0.0 else 0.0) - (1.0 if x < 0.0 else 0.0), 0.0, 0.0
    if code == _STEP:
        return 1.0 if x >= 0.0 else 0.0, 0.0, 0.0
    if code == _NOT:
        return 1.0 if x == 0.0 else 0.0, 0.0, 0.0
    if code == _SMOOTH:
        if x <= 0.0:
            return 0.0, 0.0, 0.0
        if x >= 1.0:
            return 1.0, 0.0, 0.0
        return (
            x**3 * (10.0 + x * (6.0 * x - 15.0)),
            30.0 * (x * (1.0 - x)) ** 2,
            60.0 * x * (1.0 - x) * (1.0 - 2.0 * x),
        )
    if x <= 0.0:
        return 0.0, 0.0, 0.0
    if x >= 1.0:
        return x - 0.5, 1.0, 0.0
    a = math.pi * x
    return 0.5 * (x - math.sin(a) / math.pi), 0.5 * (1.0 - math.cos(a)), 0.5 * math.pi * math.sin(a)


@kernel
def interpolate(x, table):
    """Return f, f', f'' of a piecewise cubic at x: `table` = n, knots (n,), coefficients (n - 1, 4) from x^3 to x^0.

    Before the first and after the last knot the value is held; if n is negative, the function goes on periodically.
    """
    n = abs(int(table[0]))
    knots, coefficients = table[1 : n + 1], table[n + 1 :]
    if table[0] < 0.0:
        x = knots[0] + (x - knots[0]) % (knots[n - 1] - knots[0])
    if x < knots[0]:
        return coefficients[3], 0.0, 0.0
    i = min(knots_until(knots, x) - 1, n - 2)
    a, b, c, d = (
        coefficients[4 * i],
        coefficients[4 * i + 1],
        coefficients[4 * i + 2],
        coefficients[4 * i + 3],
    )
    h = min(x, knots[n - 1]) - knots[i]
    f = ((a * h + b) * h + c) * h + d
    if x > knots[n - 1]:
        return f, 0.0, 0.0
    return f, (3.0 * a * h + 2.0 * b) * h + c, 6.0 * a * h + 2.0 * b


@inner_kernel
def _power(x, x1, x2, p, p1, p2):
    """Return the jet of x^p; p may vary in time where x > 0."""
    f = x**p
    if p1 == 0.0 and p2 == 0.0:
        f1 = p * x ** (p - 1.0) if p != 0.0 else 0.0
        f2 = p * (p - 1.0) * x ** (p - 2.0) if p != 0.0 and p != 1.0 else 0.0
        if x1 == 0.0 and x2 == 0.0:  # 0 * inf at x = 0
            return f, 0.0, 0.0
        return f, f1 * x1, (f2 * x1 * x1 if x1 != 0.0 else 0.0) + f1 * x2
    # x^p = exp(y), y = p log x
    log = math.log(x)
    l1 = x1 / x
    l2 = x2 / x - l1 * l1
    y1 = p1 * log + p * l1
    y2 = p2 * log + 2.0 * p1 * l1 + p * l2
    return f, f * y1, f * (y1 * y1 + y2)


@inner_kernel
def _compare(code, a, b):
    """Return 1.0 if the comparison holds, else 0.0."""
    if code == _LESS:
        return 1.0 if a < b else 0.0
    if code == _LESS_EQUAL:
        return 1.0 if a <= b else 0.0
    if code == _GREATER:
        return 1.0 if a > b else 0.0
    if code == _GREATER_EQUAL:
        return 1.0 if a >= b else 0.0
    if code == _EQUAL:
        return 1.0 if a == b else 0.0
    if code == _NOT_EQUAL:
        return 1.0 if a != b else 0.0
    if code == _AND:
        return 1.0 if a != 0.0 and b != 0.0 else 0.0
    return 1.0 if a != 0.0 or b != 0.0 else 0.0


@inner_kernel
def _binary(code, a, a1, a2, b, b1, b2):
    """Return the jet of an operation on two jets."""
    if code == _ADD:
        return a + b, a1 + b1, a2 + b2
    if code == _SUBTRACT:
        return a - b, a1 - b1, a2 - b2
    if code == _MULTIPLY:
        return a * b, a1 * b + a * b1, a2 * b + 2.0 * a1 * b1 + a * b2
    if code == _DIVIDE:
        f = a / b
        f1 = (a1 - f * b1) / b
        return f, f1, (a2 - 2.0 * f1 * b1 - f * b2) / b
    if code == _POWER:
        return _power(a, a1, a2, b, b1, b2)
    if code == _ATAN2:
        n, d = b * a1 - a * b1, a * a + b * b
        n1, d1 = b * a2 - a * b2, 2.0 * (a * a1 + b * b1)
        return math.atan2(a, b), n / d, (n1 - n * d1 / d) / d
    if code in (_MIN, _MAX):
        # Where both are equal, the one that will be the least (greatest) next.
        ahead = a1 > b1 if a == b else a > b
        if ahead == (code == _MAX):
            return a, a1, a2
        return b, b1, b2
    return _compare(code, a, b), 0.0, 0.0


@inner_kernel
def _over_two(a, a1, a2, b, b1, b2, table):
    """Return the jet of a function of two jets: y'' = f_aa a'^2 + 2 f_ab a' b' + f_bb b'^2 + f_a a'' + f_b b''."""
    d = np.empty(6)
    interpolate_grid(a, b, table, d)
    second = d[3] * a1 * a1 + 2.0 * d[4] * a1 * b1 + d[5] * b1 * b1
    return d[0], d[1] * a1 + d[2] * b1, second + d[1] * a2 + d[2] * b2


# These two choose as `run_program` does. One function of all three derivatives for both is slower: jets take half as
# long again, values with one derivative two thirds.
@kernel
def of_one_value(code, number, x, tables, table_starts):
    """Return an operation of one value x and its derivative; `number` of its table."""
    if code == _TABLE:
        j = int(number)
        f, slope, _ = interpolate(x, tables[table_starts[j] : table_starts[j + 1]])
    elif code >= _SIN:
        f, slope, _ = _elementary(code, x)
    else:
        f, slope, _ = _piecewise(code, x)
    return f, slope


@kernel
def of_two_values(code, number, a, b, along, tables, table_starts):
    """Return an operation of two values and its derivative by the first (along = 0) or the second (1)."""
    if code == _TABLE2:
        j = int(number)
        table = tables[table_starts[j] : table_starts[j + 1]]
        f, slope, _ = _over_two(a, 1.0 - along, 0.0, b, along, 0.0, table)
    else:
        f, slope, _ = _binary(code, a, 1.0 - along, 0.0, b, along, 0.0)
    return f, slope


@kernel_on_demand(
    void,
    array_type(INTEGERS),
    array_type(FLOATS),
    COUNT,
    COUNT,
    array_type(FLOATS),
    array_type(FLOATS, 2),
    array_type(FLOATS),
    array_type(INTEGERS),
    array_type(FLOATS, 2),
)
def run_program(ops, args, first, last, time, inputs, tables, table_starts, stack):
    """Run the operations [first, last) and leave the jet of the result in stack[0].

    Parameters
    ----------
    ops, args : (n,) int64, (n,) float
        Programs in postfix order (see `flexmb.math.operations`).
    time : (3,) float
        Jet of the time: (t, 1, 0) along a motion, (t, 0, 0) at rest.
    inputs : (ni, 3) float
        Jets of the inputs.
    tables : (m,) float
        Knots and coefficients of all tables.
    table_starts : (nt + 1,) int64
        First number of each table, and the end.
    stack : (STACK, 3) float
        Scratch.
    """
    top = -1
    for k in range(first, last):
        code = ops[k]
        if code < _PUSHES_END:
            top += 1
            if code == _CONSTANT:
                stack[top, 0], stack[top, 1], stack[top, 2] = args[k], 0.0, 0.0
            elif code == _TIME:
                copy_into(stack[top], time)
            else:
                copy_into(stack[top], inputs[int(args[k])])
        elif code < _UNARY_END:
            x, x1, x2 = stack[top, 0], stack[top, 1], stack[top, 2]
            if code == _TABLE:
                j = int(args[k])
                f, f1, f2 = interpolate(x, tables[table_starts[j] : table_starts[j + 1]])
            elif code >= _SIN:
                f, f1, f2 = _elementary(code, x)
            else:
                f, f1, f2 = _piecewise(code, x)
            stack[top, 0] = f
            # A constant stays constant where f' is infinite: sqrt(0).
            stack[top, 1] = f1 * x1 if x1 != 0.0 else 0.0
            stack[top, 2] = (f2 * x1 * x1 if x1 != 0.0 else 0.0) + (f1 * x2 if x2 != 0.0 else 0.0)
        elif code < _BINARY_END:
            top -= 1
            a, a1, a2 = stack[top, 0], stack[top, 1], stack[top, 2]
            b, b1, b2 = stack[top + 1, 0], stack[top + 1, 1], stack[top + 1, 2]
            if code == _TABLE2:
                j = int(args[k])
                f, f1, f2 = _over_two(a, a1, a2, b, b1, b2, tables[table_starts[j] : table_starts[j + 1]])
            else:
                f, f1, f2 = _binary(code, a, a1, a2, b, b1, b2)
            stack[top, 0], stack[top, 1], stack[top, 2] = f, f1, f2
        else:  # where
            top -= 2
            chosen = top + 1 if stack[top, 0] != 0.0 else top + 2
            copy_into(stack[top], stack[chosen])


@entry_kernel(NUMBER, numba_type(SignalCode), array_type(FLOATS, 2))
def sample_signals(t, signals, out):
    """Write value, first and second time derivative of every signal at time t.

    Parameters
    ----------
    t : float, s
    signals : SignalCode
    out : (ns, 3) float
        Receives value, rate and second rate.
    """
    starts = signals.starts
    stack, time, none = np.empty((_STACK, 3)), np.empty(3), np.empty((0, 3))
    time[0], time[1], time[2] = t, 1.0, 0.0
    for s in range(len(starts) - 1):
        run_program(
            signals.ops, signals.args, starts[s], starts[s + 1], time, none, signals.tables, signals.table_starts, stack
        )
        copy_into(out[s], stack[0])
