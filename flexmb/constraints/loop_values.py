"""Values of the programs of loops, and their derivatives by what each of them reads.

A value has as many derivatives as its program has inputs, mostly one to three; they are carried along the stack side by
side, and are left out where only values are asked for. What depends on it goes by the operations of `flexmb.math.jets`.
"""

from __future__ import annotations

import numpy as np

from flexmb.math import operations as op
from flexmb.math.callbacks import call_back
from flexmb.math.jets import run_program
from flexmb.math.kernel import inner_kernel, kernel

__all__ = ["by_atoms", "integers", "program_values"]

# numba compiles these as constants; attributes of a module it would look up
_CONSTANT, _INPUT = op.CONSTANT, op.INPUT
_ADD, _SUBTRACT, _MULTIPLY, _DIVIDE, _MIN, _MAX = op.ADD, op.SUBTRACT, op.MULTIPLY, op.DIVIDE, op.MIN, op.MAX
_UNARY_END, _WHERE, _STACK = op.UNARY.stop, op.WHERE, op.STACK


@inner_kernel
def _integers(data, first, count):
    return data[first : first + count].view(np.int64)


@kernel
def integers(data, first, count):
    """Return integers of the bulk data, which are stored as their bits."""
    return _integers(data, first, count)


@inner_kernel
def _single(code, number, x, table):
    """Return value and derivative of an operation on one value, with the number of its table."""
    ops, args, time = np.empty(2, np.int64), np.empty(2), np.zeros(3)
    inputs, stack = np.empty((2, 3)), np.empty((3, 3))
    tables, table_starts = table
    ops[0], ops[1], args[0], args[1] = _INPUT, code, 0.0, number
    inputs[0, 0], inputs[0, 1], inputs[0, 2] = x, 1.0, 0.0
    run_program(ops, args, 0, 2, time, inputs, tables, table_starts, stack)
    return stack[0, 0], stack[0, 1]


@inner_kernel
def _double(code, number, a, b, along, table):
    """Return value of an operation on two values, and its derivative by the first (along = 0) or second (1)."""
    ops, args, time = np.empty(3, np.int64), np.empty(3), np.zeros(3)
    inputs, stack = np.empty((2, 3)), np.empty((3, 3))
    tables, table_starts = table
    ops[0], ops[1], ops[2], args[0], args[1], args[2] = _INPUT, _INPUT, code, 0.0, 1.0, number
    inputs[0, 0], inputs[0, 1], inputs[0, 2] = a, 1.0 - along, 0.0
    inputs[1, 0], inputs[1, 1], inputs[1, 2] = b, along, 0.0
    run_program(ops, args, 0, 3, time, inputs, tables, table_starts, stack)
    return stack[0, 0], stack[0, 1]


@inner_kernel
def _any_single(code, number, x, part, width, table):
    """Return the value of an operation on one value, whose derivatives `part` become those of the result."""
    f, slope = _single(code, number, x, table)
    for j in range(width):
        # a constant stays constant where f' is infinite: sqrt(0)
        part[j] = slope * part[j] if part[j] != 0.0 else 0.0
    return f


@inner_kernel
def _any_double(code, number, a, b, left, right, width, table):
    """Return the value of an operation on two values, whose derivatives become those of the result in `left`."""
    f, by_left = _double(code, number, a, b, 0.0, table)
    varies = False
    for j in range(width):
        left[j] = by_left * left[j] if left[j] != 0.0 else 0.0
        varies = varies or right[j] != 0.0
    if varies:
        by_right = _double(code, number, a, b, 1.0, table)[1]
        for j in range(width):
            if right[j] != 0.0:
                left[j] += by_right * right[j]
    return f


@inner_kernel
def _seldom(which, number, values, parts, top, width, table):
    """Run any other operation; return the new top of the stack."""
    if which < _UNARY_END:
        values[top] = _any_single(which, number, values[top], parts[top], width, table)
        return top
    if which == _WHERE:
        top -= 2
        chosen = top + 1 if values[top] != 0.0 else top + 2
        values[top] = values[chosen]
        for j in range(width):
            parts[top, j] = parts[chosen, j]
        return top
    top -= 1
    a, b, left, right = values[top], values[top + 1], parts[top], parts[top + 1]
    values[top] = _any_double(which, number, a, b, left, right, width, table)
    return top


@inner_kernel
def _function(address, begin, end, time, uses, z, answer):
    """Call a function of the user in the place of a program: its value and derivatives are left in `answer`."""
    given = np.empty(1 + end - begin)
    given[0] = time
    for u in range(begin, end):
        given[1 + u - begin] = z[uses[u]]
    call_back(address, given.ctypes.data, answer.ctypes.data)


@inner_kernel
def _run(n_atoms, count, wanted, time, bounds, ops, args, inputs, places, affine, z, by, scratch):
    """Run programs, see `program_values`. What is frequent stands here: a call costs as much as ten operations."""
    values, parts, answer, table = scratch[:4]
    starts, uses, constants, factors, addresses = scratch[4:]
    for p in range(count):
        begin, end = starts[p], starts[p + 1]
        if affine[p] == 1:
            total = constants[p]
            for u in range(begin, end):
                total += factors[u] * z[uses[u]]
                by[u] = factors[u]
            z[n_atoms + p] = total
            continue
        if addresses[p] != 0:
            _function(addresses[p], begin, end, time, uses, z, answer)
            z[n_atoms + p] = answer[0]
            for u in range(begin, end):
                by[u] = answer[1 + u - begin]
            continue
        top, width = -1, end - begin if wanted == 1 else 0
        for k in range(bounds[p], bounds[p + 1]):
            which = ops[k]
            if which <= _INPUT:
                top += 1
                for j in range(width):
                    parts[top, j] = 0.0
                if which == _INPUT:
                    values[top] = z[inputs[k]]
                    if width > 0:
                        parts[top, places[k]] = 1.0
                else:
                    values[top] = args[k] if which == _CONSTANT else time
            elif which in (_MIN, _MAX):
                top -= 1
                a, b = values[top], values[top + 1]
                ahead, largest = a > b, which == _MAX
                values[top] = a if ahead == largest else b
                for j in range(width):
                    if a == b:  # the one that will be the least (greatest) next
                        ahead = parts[top, j] > parts[top + 1, j]
                    if ahead != largest:
                        parts[top, j] = parts[top + 1, j]
            elif _ADD <= which <= _DIVIDE:
                top -= 1
                a, b = values[top], values[top + 1]
                by_a, by_b = 1.0, 1.0
                if which == _ADD:
                    a += b
                elif which == _SUBTRACT:
                    a, by_b = a - b, -1.0
                elif which == _MULTIPLY:
                    a, by_a, by_b = a * b, b, a
                else:
                    a, by_a = a / b, 1.0 / b
                    by_b = -a / b
                values[top] = a
                for j in range(width):
                    parts[top, j] = by_a * parts[top, j] + by_b * parts[top + 1, j]
            else:
                top = _seldom(which, args[k], values, parts, top, width, table)
        z[n_atoms + p] = values[0]
        for j in range(width):
            by[begin + j] = parts[0, j]


@kernel
def program_values(row, data, time, count, wanted, z, by):
    """Write the values of `count` programs behind those of the atoms in `z` (n_atoms + n,).

    Parameters
    ----------
    row : record
        Of loops.
    data : (n,)
        Bulk data.
    time : float, s
    count : int
    wanted : int
        1: write the derivatives of each by its inputs to `by`.
    z : (n_atoms + n,)
    by : (inputs of all programs,)
    """
    starts = _integers(data, row.use_starts, row.n + 1)
    bounds = _integers(data, row.programs, row.n + 1)
    size = bounds[row.n]
    table_starts = _integers(data, row.table_starts, row.n_tables + 1)
    scratch = (
        np.empty(_STACK),
        np.empty((_STACK, max(1, row.width))),
        np.empty(1 + row.width),
        (data[row.tables : row.tables + table_starts[row.n_tables]], table_starts),
        starts,
        _integers(data, row.uses, starts[row.n]),
        data[row.constants : row.constants + row.n],
        data[row.factors : row.factors + starts[row.n]],
        _integers(data, row.addresses, row.n),
    )
    ops, inputs = _integers(data, row.ops, size), _integers(data, row.inputs, size)
    places = _integers(data, row.places, size)
    args, affine = data[row.args : row.args + size], _integers(data, row.affine, row.n)
    _run(row.n_atoms, count, wanted, time, bounds, ops, args, inputs, places, affine, z, by, scratch)


@kernel
def by_atoms(row, data, count, by):
    """Return the derivatives (n, n_atoms) of the results of `count` programs by the atoms, eq. (loop-gradient).

    by : derivatives of programs by their inputs, of `program_values`
    """
    found = np.zeros((row.n, row.n_atoms))
    starts = _integers(data, row.use_starts, row.n + 1)
    uses = _integers(data, row.uses, starts[row.n])
    for p in range(count):
        own = found[p]
        for u in range(starts[p], starts[p + 1]):
            i, x = uses[u], by[u]
            if x == 0.0:
                continue
            if i < row.n_atoms:
                own[i] += x
            else:
                before = found[i - row.n_atoms]
                for k in range(row.n_atoms):
                    own[k] += x * before[k]
    return found
