"""Programs that only multiply their inputs by numbers and add: most of what controllers are made of."""

from __future__ import annotations

from flexmb.math import operations as op
from flexmb.model.expression import SignalProgram

__all__ = ["affine_parts"]

Parts = tuple[float, dict[int, float]]
"""A constant, and the factor of every input by its number."""


def affine_parts(program: SignalProgram) -> Parts | None:
    """Return the constant and the factors of the inputs of an affine program; None for all others.

    Examples
    --------
    >>> affine_parts(SignalProgram.of((op.INPUT, 3.0), (op.CONSTANT, 2.0), (op.MULTIPLY, 0.0)))
    (0.0, {3: 2.0})
    """
    if program.inputs:  # set from outside while a run goes on
        return None
    stack: list[Parts] = []
    for operation, argument in zip(program.ops.tolist(), program.args.tolist(), strict=True):
        if operation == op.CONSTANT:
            stack.append((argument, {}))
        elif operation == op.INPUT:
            stack.append((0.0, {int(argument): 1.0}))
        elif operation == op.NEGATIVE:
            stack.append(_scaled(stack.pop(), -1.0))
        elif operation in (op.ADD, op.SUBTRACT):
            second, first = stack.pop(), stack.pop()
            stack.append(_sum(first, _scaled(second, -1.0 if operation == op.SUBTRACT else 1.0)))
        elif operation in (op.MULTIPLY, op.DIVIDE):
            second, first = stack.pop(), stack.pop()
            if not second[1] and (operation == op.MULTIPLY or second[0] != 0.0):
                stack.append(_scaled(first, second[0] if operation == op.MULTIPLY else 1.0 / second[0]))
            elif not first[1] and operation == op.MULTIPLY:
                stack.append(_scaled(second, first[0]))
            else:
                return None
        else:
            return None
    return stack[0]


def _scaled(parts: Parts, by: float) -> Parts:
    return by * parts[0], {name: by * factor for name, factor in parts[1].items()}


def _sum(one: Parts, other: Parts) -> Parts:
    names = dict.fromkeys([*one[1], *other[1]])
    return one[0] + other[0], {name: one[1].get(name, 0.0) + other[1].get(name, 0.0) for name in names}
