"""Values of the programs of loops, and their derivatives by what each of them reads.

A value has as many derivatives as its program has inputs, mostly one to three; they are carried along the stack side by
side, and are left out where only values are asked for. What depends on it goes by the operations of `flexmb.math.jets`.
Kernels here make no arrays: the numbers of an evaluation stand in one place (`flexmb.constraints.loop.kept_places`).
"""

from __future__ import annotations

import numpy as np

from flexmb.math import operations as op
from flexmb.math.callbacks import call_back
from flexmb.math.jets import of_one_value, of_two_values
from flexmb.math.kernel import inner_kernel, kernel

__all__ = ["gradients", "program_values"]

# numba compiles these as constants; attributes of a module it would look up
_CONSTANT, _INPUT = op.CONSTANT, op.INPUT
_ADD, _SUBTRACT, _MULTIPLY, _DIVIDE, _MIN, _MAX = op.ADD, op.SUBTRACT, op.MULTIPLY, op.DIVIDE, op.MIN, op.MAX
_UNARY_END, _WHERE = op.UNARY.stop, op.WHERE


@inner_kernel
def _any_single(code, number, x, part, width, tables, table_starts):
    """Return the value of an operation on one value, whose derivatives `part` become those of the result."""
    f, slope = of_one_value(code, number, x, tables, table_starts)
    for j in range(width):
        # a constant stays constant where f' is infinite: sqrt(0)
        part[j] = slope * part[j] if part[j] != 0.0 else 0.0
    return f


@inner_kernel
def _any_double(code, number, a, b, left, right, width, tables, table_starts):
    """Return the value of an operation on two values, whose derivatives become those of the result in `left`."""
    f, by_left = of_two_values(code, number, a, b, 0.0, tables, table_starts)
    varies = False
    for j in range(width):
        left[j] = by_left * left[j] if left[j] != 0.0 else 0.0
        varies = varies or right[j] != 0.0
    if varies:
        _, by_right = of_two_values(code, number, a, b, 1.0, tables, table_starts)
        for j in range(width):
            if right[j] != 0.0:
                left[j] += by_right * right[j]
    return f


@inner_kernel
def _seldom(which, number, values, parts, top, stride, width, tables, table_starts):
    """Run any other operation; return the new top of the stack."""
    if which < _UNARY_END:
        values[top] = _any_single(which, number, values[top], parts[top * stride :], width, tables, table_starts)
        return top
    if which == _WHERE:
        top -= 2
        chosen = top + 1 if values[top] != 0.0 else top + 2
        values[top] = values[chosen]
        for j in range(width):
            parts[top * stride + j] = parts[chosen * stride + j]
        return top
    top -= 1
    a, b, left, right = values[top], values[top + 1], parts[top * stride :], parts[(top + 1) * stride :]
    values[top] = _any_double(which, number, a, b, left, right, width, tables, table_starts)
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
def _run(begin, end, ops, args, inputs, places, time, z, values, parts, stride, width, tables, table_starts):
    """Run the operations [begin, end). What is frequent stands here: a call costs as much as ten operations."""
    top = -1
    for k in range(begin, end):
        which = ops[k]
        if which <= _INPUT:
            top += 1
            for j in range(width):
                parts[top * stride + j] = 0.0
            if which == _INPUT:
                values[top] = z[inputs[k]]
                if width > 0:
                    parts[top * stride + places[k]] = 1.0
            else:
                values[top] = args[k] if which == _CONSTANT else time
        elif which in (_MIN, _MAX):
            top -= 1
            a, b = values[top], values[top + 1]
            ahead, largest = a > b, which == _MAX
            values[top] = a if ahead == largest else b
            for j in range(top * stride, top * stride + width):
                if a == b:  # the one that will be the least (greatest) next
                    ahead = parts[j] > parts[j + stride]
                if ahead != largest:
                    parts[j] = parts[j + stride]
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
            for j in range(top * stride, top * stride + width):
                parts[j] = by_a * parts[j] + by_b * parts[j + stride]
        else:
            top = _seldom(which, args[k], values, parts, top, stride, width, tables, table_starts)


@kernel
def program_values(row, data, time, count, wanted, place):
    """Write the values of `count` programs behind those of the atoms in `place`.

    Parameters
    ----------
    row : record
        Of loops.
    data : (n,)
        Bulk data.
    time : float, s
    count : int
    wanted : int
        1: write the derivatives of each by its inputs as well.
    place : (row.size,)
        What is kept of an evaluation.
    """
    starts = data[row.use_starts : row.use_starts + row.n + 1].view(np.int64)
    bounds = data[row.programs : row.programs + row.n + 1].view(np.int64)
    uses = data[row.uses : row.uses + row.n_uses].view(np.int64)
    size = bounds[row.n]
    ops = data[row.ops : row.ops + size].view(np.int64)
    inputs, places = data[row.inputs :].view(np.int64), data[row.places :].view(np.int64)
    affine, addresses = data[row.affine :].view(np.int64), data[row.addresses :].view(np.int64)
    args, constants, factors = data[row.args :], data[row.constants :], data[row.factors :]
    table_starts, tables = data[row.table_starts :].view(np.int64), data[row.tables :]
    z, by, values, parts, answer = place, place[row.by :], place[row.stack :], place[row.parts :], place[row.answer :]
    stride = max(1, row.width)
    for p in range(count):
        begin, end = starts[p], starts[p + 1]
        if affine[p] == 1:
            total = constants[p]
            for u in range(begin, end):
                total += factors[u] * z[uses[u]]
                by[u] = factors[u]
            z[row.n_atoms + p] = total
        elif affine[p] == 2:  # min(max(x, low), high)
            x, low, high = z[uses[begin]], args[bounds[p] + 1], args[bounds[p] + 3]
            above = x if x > low else low
            z[row.n_atoms + p] = high if above > high else above
            by[begin] = 1.0 if low <= x < high else 0.0
        elif addresses[p] != 0:
            _function(addresses[p], begin, end, time, uses, z, answer)
            z[row.n_atoms + p] = answer[0]
            for u in range(begin, end):
                by[u] = answer[1 + u - begin]
        else:
            width = end - begin if wanted == 1 else 0
            first, last = bounds[p], bounds[p + 1]
            _run(first, last, ops, args, inputs, places, time, z, values, parts, stride, width, tables, table_starts)
            z[row.n_atoms + p] = values[0]
            for j in range(width):
                by[begin + j] = parts[j]


@kernel
def gradients(row, data, count, place):
    """Write the derivatives of the results of programs by the atoms that they read, eq. (loop-gradient).

    A chain lists the products of which they consist: a derivative of a program by one of its inputs, and that of the
    input by an atom (1 where it is one). `count` : number of products.
    """
    chain = data[row.chain : row.chain + 3 * count].view(np.int64)
    by, found = place[row.by :], place[row.gradient :]
    found[0] = 1.0
    for k in range(1, row.n_reads + 1):
        found[k] = 0.0
    for k in range(count):
        x = by[chain[3 * k + 1]]
        if x != 0.0:
            found[chain[3 * k]] += x * found[chain[3 * k + 2]]
