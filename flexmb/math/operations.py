"""The operations of signal programs: numbers, names and how many values each takes from the stack.

A program is a list of (operation, argument) in postfix order. The numbers are compiled into the kernels of
`flexmb.math.jets`; the names are used by expressions in model files.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

__all__ = ["BINARY", "COMPARISONS", "CONSTANTS", "FUNCTIONS", "PUSHES", "PYTHON", "STACK", "UNARY"]

STACK = 64
"""Depth of the stack on which programs run."""

# Push a value.
CONSTANT, TIME, INPUT = 0, 1, 2  # the argument of an input is its number
PUSHES = range(3)
# One value in, one out.
NEGATIVE, ABS, SIGN, STEP, SMOOTH, SOFT_RAMP, NOT = 10, 11, 12, 13, 14, 15, 16
SIN, COS, TAN, ASIN, ACOS, ATAN, SINH, COSH, TANH, EXP, LOG, SQRT = range(20, 32)
TABLE = 40  # the argument is the number of the table
UNARY = range(10, 41)
# Two values in, one out.
ADD, SUBTRACT, MULTIPLY, DIVIDE, POWER, ATAN2, MIN, MAX = range(50, 58)
LESS, LESS_EQUAL, GREATER, GREATER_EQUAL, EQUAL, NOT_EQUAL, AND, OR = range(60, 68)
TABLE2 = 68  # the argument is the number of the table
BINARY = range(50, 69)
# Three values in, one out: condition, value if it holds, value if not.
WHERE = 70

FUNCTIONS: Mapping[str, tuple[int, int]] = {
    "sin": (SIN, 1),
    "cos": (COS, 1),
    "tan": (TAN, 1),
    "asin": (ASIN, 1),
    "acos": (ACOS, 1),
    "atan": (ATAN, 1),
    "atan2": (ATAN2, 2),
    "sinh": (SINH, 1),
    "cosh": (COSH, 1),
    "tanh": (TANH, 1),
    "exp": (EXP, 1),
    "log": (LOG, 1),
    "sqrt": (SQRT, 1),
    "abs": (ABS, 1),
    "min": (MIN, 2),
    "max": (MAX, 2),
    "sign": (SIGN, 1),
    "step": (STEP, 1),
    "smooth": (SMOOTH, 1),
    "where": (WHERE, 3),
}
"""Functions of expressions: operation and number of arguments (min and max take two or more)."""

CONSTANTS: Mapping[str, float] = {"pi": math.pi, "e": math.e, "deg": math.pi / 180.0}
"""Constants of expressions; ``38*deg`` is 38 degrees in rad."""

COMPARISONS: Mapping[str, int] = {
    "Lt": LESS,
    "LtE": LESS_EQUAL,
    "Gt": GREATER,
    "GtE": GREATER_EQUAL,
    "Eq": EQUAL,
    "NotEq": NOT_EQUAL,
}
"""Comparisons by the names of Python's syntax tree."""


def _smooth(x: float) -> float:
    return 0.0 if x <= 0.0 else 1.0 if x >= 1.0 else x**3 * (10.0 + x * (6.0 * x - 15.0))


def _soft_ramp(x: float) -> float:
    return 0.0 if x <= 0.0 else x - 0.5 if x >= 1.0 else 0.5 * (x - math.sin(math.pi * x) / math.pi)


PYTHON: Mapping[int, Callable[..., float]] = {
    NEGATIVE: lambda x: -x,
    ABS: abs,
    SIGN: lambda x: float((x > 0) - (x < 0)),
    STEP: lambda x: float(x >= 0),
    SMOOTH: _smooth,
    SOFT_RAMP: _soft_ramp,
    NOT: lambda x: float(x == 0),
    SIN: math.sin,
    COS: math.cos,
    TAN: math.tan,
    ASIN: math.asin,
    ACOS: math.acos,
    ATAN: math.atan,
    SINH: math.sinh,
    COSH: math.cosh,
    TANH: math.tanh,
    EXP: math.exp,
    LOG: math.log,
    SQRT: math.sqrt,
    ADD: lambda a, b: a + b,
    SUBTRACT: lambda a, b: a - b,
    MULTIPLY: lambda a, b: a * b,
    DIVIDE: lambda a, b: a / b,
    POWER: math.pow,
    ATAN2: math.atan2,
    MIN: min,
    MAX: max,
    LESS: lambda a, b: float(a < b),
    LESS_EQUAL: lambda a, b: float(a <= b),
    GREATER: lambda a, b: float(a > b),
    GREATER_EQUAL: lambda a, b: float(a >= b),
    EQUAL: lambda a, b: float(a == b),
    NOT_EQUAL: lambda a, b: float(a != b),
    AND: lambda a, b: float(a != 0 and b != 0),
    OR: lambda a, b: float(a != 0 or b != 0),
    WHERE: lambda c, a, b: a if c else b,
}
"""The same operations on plain numbers: what does not depend on time is computed once, when it is read."""
