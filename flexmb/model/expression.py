"""Arithmetic expressions of model files and signals, read with Python's parser and never executed as Python.

An expression holds numbers, named parameters, ``t`` (time, s; in signals only), ``+ - * / **``, the constants
``pi``, ``e`` and ``deg`` (pi/180), and the functions sin cos tan asin acos atan atan2 sinh cosh tanh exp log sqrt abs
min max sign,

- ``step(x)``: 0 for x < 0, else 1;
- ``smooth(x)``: 0 for x < 0, 1 for x > 1, and 10 x^3 - 15 x^4 + 6 x^5 between;
- ``name[2]``: an element of a parameter that is a list, counted from 0; in model files a list of numbers may also stand
  as a whole, and the result is a list;
- ``where(condition, a, b)``: a if the condition holds, else b. Comparisons, ``and``, ``or``, ``not`` stand only there.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import ModelError, did_you_mean
from flexmb.math import operations as op
from flexmb.model.described import is_number

__all__ = [
    "Reader",
    "SignalProgram",
    "compile_expression",
    "evaluate",
    "evaluate_values",
    "joined_arrays",
    "names",
    "parse",
]

_BINARY = {
    ast.Add: op.ADD,
    ast.Sub: op.SUBTRACT,
    ast.Mult: op.MULTIPLY,
    ast.Div: op.DIVIDE,
    ast.Pow: op.POWER,
}
_MOST = 40  # names that a message lists
_LONGEST = 2000  # characters: Python's parser is recursive
_ALLOWED = "numbers, parameters, t, + - * / **, and functions such as sin, sqrt, smooth, where"


@dataclass(frozen=True, eq=False)
class SignalProgram:
    """A signal as operations on a stack, in postfix order (`flexmb.math.operations`).

    Parameters
    ----------
    ops : (n,) int64
        Operations.
    args : (n,) float64
        Value of a constant; number of a table within `tables`.
    tables : tuple of (m,) float64
        Count of knots, knots, and coefficients of the cubic pieces.
    inputs : tuple of (int, str)
        Places of constants that are set from outside while a run goes on, and the names of these inputs.
    """

    ops: np.ndarray
    args: np.ndarray
    tables: tuple[np.ndarray, ...] = ()
    inputs: tuple[tuple[int, str], ...] = ()

    def __post_init__(self):
        depth = deepest = 0
        for code in self.ops:
            depth += 1 if code in op.PUSHES else 0 if code in op.UNARY else -1 if code in op.BINARY else -2
            deepest = max(deepest, depth)
        if deepest > op.STACK:
            raise ModelError(
                "Signal",
                found=f"a program that needs {deepest} values at once",
                expected=f"at most {op.STACK}",
                remedy="Nest less deeply, or use a table",
            )

    @staticmethod
    def of(*operations: tuple[int, float], tables: tuple[np.ndarray, ...] = ()) -> SignalProgram:
        """Make a program of (operation, argument) pairs."""
        ops = np.array([code for code, _ in operations], np.int64)
        return SignalProgram(ops, np.array([argument for _, argument in operations], float), tables)

    def then(self, *others: SignalProgram) -> SignalProgram:
        """Return the programs one after another; tables are renumbered."""
        programs = (self, *others)
        return SignalProgram(*joined_arrays(programs), joined_inputs(programs))


def joined_arrays(programs: Sequence[SignalProgram]) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, ...]]:
    """Return ops, args and tables of programs one after another; they need not run as one."""
    shifts = np.cumsum([0] + [len(p.tables) for p in programs])
    of_tables = [(p.ops == op.TABLE) | (p.ops == op.TABLE2) for p in programs]
    args = [np.where(which, p.args + shift, p.args) for p, which, shift in zip(programs, of_tables, shifts)]
    ops = np.concatenate([np.empty(0, np.int64), *(p.ops for p in programs)])
    return ops, np.concatenate([np.empty(0), *args]), tuple(table for p in programs for table in p.tables)


def joined_inputs(programs: Sequence[SignalProgram]) -> tuple[tuple[int, str], ...]:
    """Return places and names of the inputs in the arrays of programs one after another."""
    starts = np.cumsum([0] + [len(p.ops) for p in programs])
    return tuple((int(start) + place, name) for p, start in zip(programs, starts) for place, name in p.inputs)


def evaluate(text: str, parameters: Mapping[str, Any] | None = None) -> float:
    """Return the number that an expression without ``t`` stands for.

    Examples
    --------
    >>> evaluate("2*arm*sin(30*deg)", {"arm": 0.4})
    0.39999999999999997

    Raises
    ------
    ModelError
        The text is not arithmetic, a name is unknown, or there is no finite value.
    """
    operations = Reader(text, parameters or {}, time=False).read()
    return operations[0][1]


def evaluate_values(text: str, parameters: Mapping[str, Any]) -> float | tuple[float, ...]:
    """Return the number of an expression, or one per element where it uses lists of numbers as a whole.

    Examples
    --------
    >>> evaluate_values("2*x + x0", {"x": (1.0, 2.0, 4.0), "x0": 0.5})
    (2.5, 4.5, 8.5)

    Raises
    ------
    ModelError
        Lists of different length, and what `evaluate` raises.
    """
    tree = parse(text)
    inside = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Subscript)}
    whole = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and id(node) not in inside}
    lists = {name: parameters[name] for name in sorted(whole) if isinstance(parameters.get(name), tuple | list)}
    if not lists:
        return evaluate(text, parameters)
    lengths = {len(values) for values in lists.values()}
    if len(lengths) > 1:
        raise ModelError(
            f"Expression '{text.strip()}'",
            found=f"lists of different length: {', '.join(f'{name} ({len(v)})' for name, v in lists.items())}",
            expected="lists of one length",
            remedy="Take elements, as in point[0], or correct the lists",
        )
    found, known = [], dict(parameters)
    for k in range(lengths.pop()):
        known.update({name: values[k] for name, values in lists.items()})
        found.append(Reader(text, known, time=False, tree=tree).read()[0][1])
    return tuple(found)


def compile_expression(text: str, parameters: Mapping[str, float] | None = None) -> SignalProgram:
    """Return the program of an expression that may contain ``t``; what is constant is computed here, once."""
    return SignalProgram.of(*Reader(text, parameters or {}, time=True).read())


def names(text: str) -> set[str]:
    """Return the names an expression uses, functions and constants left out; ModelError if it cannot be read."""
    tree = parse(text)
    used = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    return used - set(op.FUNCTIONS) - set(op.CONSTANTS)


def parse(text: str) -> ast.expr:
    """Return the syntax tree of an expression; ModelError if it is none."""
    part = f"Expression '{text if len(text) < 60 else text[:57] + '...'}'"
    try:
        if len(text) > _LONGEST:
            raise SyntaxError(f"it has {len(text)} characters")
        return ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        reason = error.msg if isinstance(error, SyntaxError) else str(error)
        raise ModelError(
            part,
            found=f"an expression that is not arithmetic ({reason})",
            expected=_ALLOWED,
            remedy="Check brackets and operators",
        ) from None


class Reader:
    """Turns one syntax tree into operations."""

    known: tuple[str, ...] = ()
    """Names beyond parameters and constants, for messages."""

    def __init__(self, text: str, parameters: Mapping[str, float], *, time: bool, tree: ast.expr | None = None):
        self.text, self.parameters, self.time, self.tree = text, parameters, time, tree

    def read(self) -> list[tuple[int, float]]:
        try:
            return self.node(parse(self.text) if self.tree is None else self.tree)
        except RecursionError:
            raise self.error(
                "an expression that is nested too deeply", "Name intermediate results as parameters"
            ) from None

    def error(self, found: str, remedy: str, expected: str = _ALLOWED) -> ModelError:
        short = self.text if len(self.text) < 60 else self.text[:57] + "..."
        return ModelError(f"Expression '{short.strip()}'", found=found, expected=expected, remedy=remedy)

    def node(self, node: ast.expr) -> list[tuple[int, float]]:
        if isinstance(node, ast.Constant) and isinstance(node.value, int | float) and not isinstance(node.value, bool):
            try:
                return [(op.CONSTANT, self.finite(float(node.value)))]
            except OverflowError:
                return [(op.CONSTANT, self.finite(math.inf))]
        if isinstance(node, ast.Name):
            return self.name(node.id)
        if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
            return self.apply(_BINARY[type(node.op)], self.node(node.left), self.node(node.right))
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.UAdd):
            return self.node(node.operand)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            return self.apply(op.NEGATIVE, self.node(node.operand))
        if isinstance(node, ast.Call):
            return self.call(node)
        if isinstance(node, ast.Subscript):
            return self.element(node)
        raise self.error(f"an expression that is not arithmetic: {_kind(node)}", _remedy(node))

    def name(self, name: str) -> list[tuple[int, float]]:
        if name in self.parameters:
            value = self.parameters[name]
            if not is_number(value):
                raise self.error(f"the parameter '{name}' is {value!r:.100}", "Give the parameter a number", "a number")
            return [(op.CONSTANT, self.finite(float(value)))]
        if name == "t":
            if self.time:
                return [(op.TIME, 0.0)]
            raise self.error(
                "'t' in a value that is constant in time",
                "Only signals depend on t",
                "parameters and numbers",
            )
        if name in op.CONSTANTS:
            return [(op.CONSTANT, op.CONSTANTS[name])]
        if name in op.FUNCTIONS:
            raise self.error(f"the function '{name}' without arguments", f"Write {name}(...)")
        known = [*self.known, *self.parameters, *op.CONSTANTS, *(["t"] if self.time else [])]
        shown = known if len(known) <= _MOST else [*known[-_MOST:], f"... ({len(known)} in all)"]
        raise self.error(
            f"the name '{name}' is unknown",
            did_you_mean(name, known) or f"Add {name} to the parameters",
            f"Known names: {', '.join(shown)}",
        )

    def element(self, node: ast.Subscript) -> list[tuple[int, float]]:
        """Read ``name[2]`` or ``name[0][1]``: a number of a parameter that is a list, counted from 0."""
        indices: list[int] = []
        inner: ast.expr = node
        while isinstance(inner, ast.Subscript):
            if not isinstance(inner.slice, ast.Constant) or type(inner.slice.value) is not int:
                raise self.error("square brackets around something other than a whole number", "Write point[0]")
            indices.insert(0, inner.slice.value)
            inner = inner.value
        name = inner.id if isinstance(inner, ast.Name) else ""
        value: Any = self.parameters.get(name)
        for index in indices:
            if not isinstance(value, tuple | list):
                raise self.error(
                    f"[{index}] of '{ast.unparse(inner)}', which is not a list",
                    did_you_mean(name, self.parameters) or "Give the parameter a list",
                )
            if index >= len(value):
                raise self.error(f"{name}[{index}] of a list of {len(value)}", f"Count from 0 to {len(value) - 1}")
            value = value[index]
        if isinstance(value, bool) or not isinstance(value, int | float | np.number):
            raise self.error(f"{ast.unparse(node)} is {value!r}", "Name a number of the list", "a number")
        return [(op.CONSTANT, self.finite(float(value)))]

    def call(self, node: ast.Call) -> list[tuple[int, float]]:
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name not in op.FUNCTIONS:
            raise self.error(
                f"the function '{name}' is unknown" if name else f"a call of '{ast.unparse(node.func)}'",
                did_you_mean(name, op.FUNCTIONS)
                or ("Use one of these functions" if name else "Use one of these; write a number of NumPy as float(x)"),
                f"Functions: {', '.join(op.FUNCTIONS)}",
            )
        code, count = op.FUNCTIONS[name]
        variadic = code in (op.MIN, op.MAX)
        if node.keywords or (len(node.args) < 2 if variadic else len(node.args) != count):
            raise self.error(
                f"{name} with {len(node.args) + len(node.keywords)} arguments",
                f"Write {name}({', '.join('abc'[:count])})",
                f"{count}{' or more' if variadic else ''} argument{'s' * (count > 1)}, without names",
            )
        if code == op.WHERE:
            condition, a, b = node.args
            return self.apply(code, self.condition(condition), self.node(a), self.node(b))
        first, *others = (self.node(argument) for argument in node.args)
        if not others:
            return self.apply(code, first)
        for other in others:
            first = self.apply(code, first, other)
        return first

    def condition(self, node: ast.expr) -> list[tuple[int, float]]:
        """Read a comparison, chained or combined by and, or, not; any other value holds if it is not 0."""
        if isinstance(node, ast.BoolOp):
            code = op.AND if isinstance(node.op, ast.And) else op.OR
            first, *others = (self.condition(value) for value in node.values)
            for other in others:
                first = self.apply(code, first, other)
            return first
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return self.apply(op.NOT, self.condition(node.operand))
        if isinstance(node, ast.Name) and isinstance(self.parameters.get(node.id), bool):
            return [(op.CONSTANT, float(self.parameters[node.id]))]
        if not isinstance(node, ast.Compare):
            return self.node(node)
        values = [self.node(value) for value in (node.left, *node.comparators)]
        result = None
        for left, relation, right in zip(values, node.ops, values[1:]):
            if type(relation).__name__ not in op.COMPARISONS:
                raise self.error("a comparison other than < <= > >= == !=", "Compare numbers")
            holds = self.apply(op.COMPARISONS[type(relation).__name__], left, right)
            result = holds if result is None else self.apply(op.AND, result, holds)
        return result or []

    def apply(self, code: int, *values: list[tuple[int, float]]) -> list[tuple[int, float]]:
        if all(len(value) == 1 and value[0][0] == op.CONSTANT for value in values):
            try:
                return [(op.CONSTANT, self.finite(float(op.PYTHON[code](*(value[0][1] for value in values)))))]
            except (ValueError, ZeroDivisionError, OverflowError):
                self.finite(math.nan)
        return [step for value in values for step in value] + [(code, 0.0)]

    def finite(self, value: float) -> float:
        if not math.isfinite(value):
            raise self.error(
                "it has no finite value",
                "Look for a division by zero or the root of a negative number",
                "a finite number",
            )
        return value


def _kind(node: ast.expr) -> str:
    names = {
        ast.Compare: "a comparison outside of where(...)",
        ast.BoolOp: "'and' or 'or' outside of where(...)",
        ast.IfExp: "'if' and 'else'",
        ast.Attribute: "a dot after a name",
        ast.Lambda: "a function definition",
        ast.Constant: "text or a word that is not a number",
        ast.Tuple: "a comma outside of a function",
    }
    if isinstance(node, ast.BinOp):
        return f"the operator {ast.unparse(node)[len(ast.unparse(node.left)) + 1 :].split(' ')[0]}"
    return names.get(type(node), type(node).__name__)


def _remedy(node: ast.expr) -> str:
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitXor):
        return "A power is written **"
    if isinstance(node, ast.Compare | ast.IfExp | ast.BoolOp):
        return "Write where(condition, value, other)"
    return "Leave it out"
