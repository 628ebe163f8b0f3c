"""Signals that follow what is measured: their values before the forces, their derivatives after them.

All such signals of a model, and the rates of the states of its blocks, are one row. It reads scalars (`Measured`: the
atoms) and runs programs, each of which may read atoms and the results of programs before it. The derivatives of all
results by the atoms follow by the chain rule from the jets of the programs, eq. (loop-gradient). A force that follows a
signal tells in `work.channels` how its wrench on a marker changes with the signal.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.constraints.measured_kernels import ACCELERATION, MEASURED, POSITION, SIGNAL, VELOCITY, measure_scalar
from flexmb.math import operations as op
from flexmb.math.callbacks import call_back
from flexmb.math.jets import run_program
from flexmb.math.kernel import inner_kernel
from flexmb.math.plain_loops import knots_until
from flexmb.math.switches import FORMULA, OF_LENGTHS, PIECE, PIECE_BEGIN, PIECE_END, UNKNOWN, switch_kernel
from flexmb.math.tables import row_kernel
from flexmb.model.table import Table

__all__ = ["LOOP", "LOOP_TANGENT", "OF_ATOM", "OF_PROGRAM", "words"]

ROW = np.dtype(
    [
        ("n_atoms", np.int64),
        ("atoms", np.int64),  # where their rows begin in the bulk data
        ("n", np.int64),  # number of programs
        ("n_used", np.int64),  # of those before what only tells kinks
        ("programs", np.int64),  # first operation of each in ops, and the end
        ("ops", np.int64),
        ("args", np.int64),
        ("n_tables", np.int64),
        ("tables", np.int64),  # numbers of all tables
        ("table_starts", np.int64),  # first number of each table, and the end
        ("uses", np.int64),  # inputs that programs read
        ("use_starts", np.int64),  # first of each program, and the end
        ("affine", np.int64),  # 1: a program is a constant and its inputs times numbers
        ("constants", np.int64),  # its constant
        ("factors", np.int64),  # the number of every input that programs read
        ("addresses", np.int64),  # C functions in the place of programs, or 0
        ("n_outputs", np.int64),
        ("outputs", np.int64),  # program, signal
        ("n_acts", np.int64),  # what programs act on: rates of states, then forces by channels
        ("n_rates", np.int64),
        ("acts", np.int64),  # program, marker, component or channel, first block, end of blocks
        ("blocks", np.int64),  # leg, pair, 1 if both markers of the pair are one
        ("n_legs", np.int64),
        ("implicit", np.int64),  # 1: signals follow accelerations
        ("n_held", np.int64),
        ("held", np.int64),  # branches that hold values
        ("n_kinks", np.int64),
        ("kinks", np.int64),  # program, kind of its switch (negative: of a held value), first point, number of points
        ("points", np.int64),  # of tables whose pieces are left; as many as are counted, or less than zero: periodic
        ("units", np.int64),  # 1 to 4: lengths, angles and states, speeds, rates of angles; 0: another atom
        ("shares", np.int64),  # size of an atom in this unit
        ("scratch", np.int64),  # first channel of those that keep what is measured for the derivatives
    ],
    align=True,
)
WORDS = MEASURED.itemsize // 8
OF_ATOM, OF_PROGRAM = 28, 4
"""Numbers kept of an atom (jet, sort, push and slope) and of a program (jet, derivative by its first input)."""
_STACK = op.STACK


@inner_kernel
def _integers(data, first, count):
    """Return integers of the bulk data, which are stored as their bits."""
    return data[first : first + count].view(np.int64)


@inner_kernel
def _code(row, data):
    """Return the programs of a row: addresses, bounds, operations, arguments, inputs, tables.

    They are looked up once for all programs: a slice costs as much as a short program.
    """
    bounds = _integers(data, row.programs, row.n + 1)
    size = bounds[row.n]
    starts = _integers(data, row.use_starts, row.n + 1)
    table_starts = _integers(data, row.table_starts, row.n_tables + 1)
    return (
        _integers(data, row.addresses, row.n),
        bounds,
        _integers(data, row.ops, size),
        data[row.args : row.args + size],
        starts,
        _integers(data, row.uses, starts[row.n]),
        data[row.tables : row.tables + table_starts[row.n_tables]],
        table_starts,
        _integers(data, row.affine, row.n),
        data[row.constants : row.constants + row.n],
        data[row.factors : row.factors + starts[row.n]],
    )


@inner_kernel
def _run(code, p, time, z, stack, answer):
    """Leave value and derivative along the seeds of program p in stack[0]."""
    addresses, bounds, ops, args, starts, uses, tables, table_starts = code[:8]
    if addresses[p] != 0:
        count = starts[p + 1] - starts[p]
        given = np.empty(1 + count)
        given[0] = time[0]
        for k in range(count):
            given[1 + k] = z[uses[starts[p] + k], 0]
        call_back(addresses[p], given.ctypes.data, answer.ctypes.data)
        stack[0, 0], stack[0, 1] = answer[0], 0.0
        for k in range(count):
            stack[0, 1] += answer[1 + k] * z[uses[starts[p] + k], 1]
        return
    run_program(ops, args, bounds[p], bounds[p + 1], time, z, tables, table_starts, stack)


@inner_kernel
def _values(row, data, state, work, count, z, sorts, push, slope, first):
    """Measure the atoms, and write the values of `count` programs behind them in `z` (n_atoms + n, 3).

    The last column, which first derivatives do not need, receives the rates of the atoms; `first` (n,) the derivatives
    of programs by their first inputs, which cost nothing more.
    """
    atoms = data[row.atoms : row.atoms + row.n_atoms * WORDS].view(MEASURED)
    jet, time, stack, answer = np.empty(3), np.zeros(3), np.empty((_STACK, 3)), np.zeros(1 + row.n_atoms + row.n)
    time[0] = state.t
    z[:] = 0.0
    code = _code(row, data)
    for k in range(row.n_atoms):
        sorts[k] = measure_scalar(atoms[k], state, work, jet, push[k], slope[k])
        z[k, 0], z[k, 2] = jet[0], jet[1]
    starts, uses, affine, constants, factors = code[4], code[5], code[8], code[9], code[10]
    for p in range(count):
        if affine[p] == 1:
            total = constants[p]
            for u in range(starts[p], starts[p + 1]):
                total += factors[u] * z[uses[u], 0]
            z[row.n_atoms + p, 0] = total
            continue
        seeded = starts[p + 1] > starts[p]
        if seeded:
            z[uses[starts[p]], 1] = 1.0
        _run(code, p, time, z, stack, answer)
        if seeded:
            z[uses[starts[p]], 1] = 0.0
        z[row.n_atoms + p, 0], first[p] = stack[0, 0], stack[0, 1]


@inner_kernel
def _kept(row, work):
    """Return where an evaluation keeps jets, sorts, pushes and slopes of atoms, derivatives by first inputs."""
    place = work.channels.reshape(-1)[6 * row.scratch :]
    a, n = row.n_atoms, row.n
    z = place[: 3 * (a + n)].reshape((a + n, 3))
    place = place[3 * (a + n) :]
    push, slope = place[: 12 * a].reshape((a, 12)), place[12 * a : 24 * a].reshape((a, 12))
    return z, place[24 * a : 25 * a].view(np.int64), push, slope, place[25 * a : 25 * a + n]


@row_kernel
def sample(raw, data, state, work):
    """Write the values of the signals, and let the rates act on the states."""
    rows = raw.view(ROW)
    for m in range(rows.shape[0]):
        row = rows[m]
        z, sorts, push, slope, first_slope = _kept(row, work)
        _values(row, data, state, work, row.n_used, z, sorts, push, slope, first_slope)
        outputs = _integers(data, row.outputs, 2 * row.n_outputs)
        for k in range(row.n_outputs):
            to = state.signals[outputs[2 * k + 1]]
            to[0], to[1], to[2] = z[row.n_atoms + outputs[2 * k], 0], 0.0, 0.0
        acts = _integers(data, row.acts, 5 * row.n_rates)
        for k in range(row.n_rates):
            work.markers[acts[5 * k + 1]].wrench[acts[5 * k + 2]] += z[row.n_atoms + acts[5 * k], 0]
        held = _integers(data, row.held, row.n_held)
        for k in range(row.n_held):  # a step leaves them as they are
            work.branches[held[k]] = state.q[len(state.q) - len(work.branches) + held[k]]


@inner_kernel
def _gradients(row, data, state, count, z, first):
    """Return the derivatives (n, n_atoms) of the results of `count` programs by the atoms.

    first : (n,), those of programs by their first inputs, of `_values`
    """
    found, time = np.zeros((row.n, row.n_atoms)), np.zeros(3)
    stack, answer = np.empty((_STACK, 3)), np.zeros(1 + row.n_atoms + row.n)
    time[0] = state.t
    code = _code(row, data)
    starts, uses, affine, factors = code[4], code[5], code[8], code[10]
    for p in range(count):
        for u in range(starts[p], starts[p + 1]):
            i = uses[u]
            if affine[p] == 1:
                by = factors[u]
            elif u == starts[p]:
                by = first[p]
            else:
                z[i, 1] = 1.0
                _run(code, p, time, z, stack, answer)
                z[i, 1] = 0.0
                by = stack[0, 1]
            if by == 0.0:
                continue
            if i < row.n_atoms:
                found[p, i] += by
            else:
                before, own = found[i - row.n_atoms], found[p]
                for k in range(row.n_atoms):
                    own[k] += by * before[k]
    return found


@inner_kernel
def _spread(z, x, p, out):
    """Add x p of a scalar's 12 components to the legs, `out` (n_legs, 6)."""
    for i in range(6):
        if z.leg_a >= 0:
            out[z.leg_a, i] += x * p[i]
        if z.leg_b >= 0:
            out[z.leg_b, i] += x * p[6 + i]


@inner_kernel
def _add_to_matrix(pair, same, wrench, component, by, column, work):
    """Subtract a wrench (or one component of it) times derivatives by a leg, `by` (6,), from the iteration matrix.

    It is a product of two vectors, so it goes there without a matrix between markers; `column` is scratch.
    """
    a, b = work.markers[pair.a], work.markers[pair.b]
    if a.nu == 0 or b.nu == 0:
        return
    blocks, used = b.nu // b.width, False
    start = pair.iS + (0 if same else a.nu * (a.nu // a.width))
    for m in range(6):
        if by[m] != 0.0:
            if not used:
                column[: b.nu] = 0.0
                used = True
            for j in range(b.nu):
                column[j] += by[m] * work.J[b.iJ + m * b.nu + j]
    if not used:
        return
    for i in range(a.nu):
        x = 0.0
        if component >= 0:
            x = work.J[a.iJ + component * a.nu + i]
        else:
            for k in range(6):
                x += wrench[k] * work.J[a.iJ + k * a.nu + i]
        if x != 0.0:
            for n in range(blocks):
                at = work.pair_rows[start + i * blocks + n]
                for j in range(b.width):
                    work.S[at + j] -= x * column[n * b.width + j]


@row_kernel
def tangent(raw, data, state, work):
    """Write how the rates of states, and the forces that follow signals, change with what is measured."""
    weights = work.weights[0]
    moving = weights.damping != 0.0 or weights.stiffness != 0.0
    if weights.wanted == 0:
        return
    rows = raw.view(ROW)
    for m in range(rows.shape[0]):
        row = rows[m]
        if not moving and (row.implicit == 0 or weights.mass == 0.0):
            continue
        z, sorts, push, slope, first_slope = _kept(row, work)  # as `sample` has left them in this evaluation
        atoms = data[row.atoms : row.atoms + row.n_atoms * WORDS].view(MEASURED)
        by_atoms = _gradients(row, data, state, row.n_used, z, first_slope)
        acts = _integers(data, row.acts, 5 * row.n_acts)
        blocks = _integers(data, row.blocks, 3 * acts[5 * row.n_acts - 1] if row.n_acts > 0 else 0)
        none, by, column = np.zeros(6), np.empty((row.n_legs, 6)), np.empty(len(state.u))
        for k in range(row.n_acts):
            act = acts[5 * k : 5 * k + 5]
            for b in range(act[3], act[4]):
                by[blocks[3 * b]] = 0.0
            for a in range(row.n_atoms):
                x = by_atoms[act[0], a if atoms[a].source < 0 else atoms[a].source]
                if x == 0.0:
                    continue
                if sorts[a] == ACCELERATION and atoms[a].leg_b >= 0:
                    by[atoms[a].leg_b, atoms[a].axis] += weights.mass * x
                if sorts[a] == POSITION:
                    _spread(atoms[a], weights.stiffness * x, push[a], by)
                elif sorts[a] == VELOCITY or sorts[a] == ACCELERATION:
                    _spread(atoms[a], weights.stiffness * x, slope[a], by)
                    _spread(atoms[a], weights.damping * x, push[a], by)
            rate = k < row.n_rates
            wrench = none if rate else work.channels[act[2]]
            for b in range(act[3], act[4]):
                leg, pair = blocks[3 * b], work.pairs[blocks[3 * b + 1]]
                same = blocks[3 * b + 2] == 1
                _add_to_matrix(pair, same, wrench, act[2] if rate else -1, by[leg], column, work)


@inner_kernel
def _piece(x, points, periodic, place):
    """Write the ends of the piece of a table in which x lies."""
    n = len(points)
    shift = 0.0
    if periodic:
        period = points[n - 1] - points[0]
        shift = period * np.floor((x - points[0]) / period)
    i = knots_until(points, x - shift)
    place[PIECE_BEGIN] = -np.inf if i == 0 else points[i - 1] + shift
    place[PIECE_END] = np.inf if i == n else points[i] + shift


@switch_kernel
def switch(raw, data, state, work, out):
    """Where signals have kinks or jump, with the rates that positions and functions of time make."""
    rows = raw.view(ROW)
    first = 0
    for m in range(rows.shape[0]):
        row = rows[m]
        if row.n_kinks == 0:
            continue
        z, sorts = np.empty((row.n_atoms + row.n, 3)), np.empty(row.n_atoms, np.int64)
        push, slope, first_slope = np.empty((row.n_atoms, 12)), np.empty((row.n_atoms, 12)), np.empty(row.n)
        _values(row, data, state, work, row.n, z, sorts, push, slope, first_slope)
        by_atoms = _gradients(row, data, state, row.n, z, first_slope)
        kinks, units = _integers(data, row.kinks, 4 * row.n_kinks), _integers(data, row.units, row.n_atoms)
        for k in range(row.n_kinks):
            slot, kind, begin, count = kinks[4 * k], kinks[4 * k + 1], kinks[4 * k + 2], kinks[4 * k + 3]
            place = out[first + k]
            place[:] = 0.0
            place[0], place[1], place[9] = abs(kind), z[row.n_atoms + slot, 0], 1.0
            for a in range(row.n_atoms):
                by = by_atoms[slot, a]
                if by == 0.0:
                    continue
                if sorts[a] == POSITION or sorts[a] == SIGNAL:
                    place[4] += by * z[a, 2]
                else:
                    place[UNKNOWN] = 1.0
                if units[a] > 0:
                    place[OF_LENGTHS - 1 + units[a]] += abs(by) * data[row.shares + a]
            place[FORMULA] = 1.0
            if kind < 0:  # a held value changes where this passes zero upwards
                place[1], place[4], place[FORMULA], place[UNKNOWN] = -place[1], -place[4], 0.0, 0.0
            if abs(kind) == PIECE:
                points = data[row.points + begin : row.points + begin + abs(count)]
                _piece(place[1], points, count < 0, place)
        first += row.n_kinks


LOOP = Table("Loop", ROW, {"apply": sample, "switch": switch}, switches="n_kinks")
LOOP_TANGENT = Table("LoopTangent", ROW, {"apply": tangent})


def words(numbers: Any) -> np.ndarray:
    """Return integers as bulk data holds them."""
    return np.array(numbers, np.int64).ravel().view(float)
