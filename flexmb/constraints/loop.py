"""Signals that follow what is measured: their values before the forces, their derivatives after them.

All such signals of a model, and the rates of the states of its blocks, are one row. It reads scalars (`Measured`: the
atoms) and runs programs, each of which may read atoms and the results of programs before it. The derivatives of all
results by the atoms follow by the chain rule from the jets of the programs, eq. (loop-gradient). A force that follows a
signal tells in `work.channels` how its wrench on a marker changes with the signal.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.constraints.loop_values import by_atoms, integers, program_values
from flexmb.constraints.measured_kernels import (
    ACCELERATION,
    MEASURED,
    POSITION,
    SIGNAL,
    VELOCITY,
    WHATS,
    measure_scalar,
)
from flexmb.math.kernel import inner_kernel
from flexmb.math.plain_loops import knots_until
from flexmb.math.switches import FORMULA, HELD, OF_LENGTHS, PIECE, PIECE_BEGIN, PIECE_END, UNKNOWN, switch_kernel
from flexmb.math.tables import row_kernel
from flexmb.model.table import Table

__all__ = ["LOOP", "LOOP_TANGENT", "OF_ATOM", "words"]

ROW = np.dtype(
    [
        ("n_atoms", np.int64),
        ("atoms", np.int64),  # where their rows begin in the bulk data
        ("n", np.int64),  # number of programs
        ("n_used", np.int64),  # of those before what only tells kinks
        ("programs", np.int64),  # first operation of each in ops, and the end
        ("ops", np.int64),
        ("args", np.int64),
        ("inputs", np.int64),  # of operations that read one: its number, and its place among those of its program
        ("places", np.int64),
        ("width", np.int64),  # the most inputs of a program
        ("n_tables", np.int64),
        ("tables", np.int64),  # numbers of all tables
        ("table_starts", np.int64),  # first number of each table, and the end
        ("uses", np.int64),  # inputs that programs read
        ("n_uses", np.int64),
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
_STATE = WHATS.index("state")
OF_ATOM = 27
"""Numbers kept of an atom: value, rate, sort, push and slope. Of a program its value is kept, and its derivatives."""


@inner_kernel
def _values(row, data, state, work, count, wanted, kept):
    """Measure the atoms, and write the values of `count` programs behind them, if wanted with their derivatives."""
    z, rates, sorts, push, slope, by = kept
    atoms, jet = data[row.atoms : row.atoms + row.n_atoms * WORDS].view(MEASURED), np.empty(3)
    for k in range(row.n_atoms):
        if atoms[k].what == _STATE:  # most atoms are: without a call
            at, marker = atoms[k].axis, work.markers[atoms[k].b]
            z[k], rates[k], sorts[k] = marker.v[at] if at < 3 else marker.w[at - 3], 0.0, VELOCITY
            if wanted == 1:
                push[k], slope[k] = 0.0, 0.0
                push[k, 6 + at] = 1.0
            continue
        sorts[k] = measure_scalar(atoms[k], state, work, jet, push[k], slope[k])
        z[k], rates[k] = jet[0], jet[1]
    program_values(row, data, state.t, count, wanted, z, by)


@inner_kernel
def _divided(row, place):
    """Return what is kept of an evaluation as parts of a place: values of atoms and programs, rates, sorts, pushes and
    slopes of atoms, derivatives of programs by their inputs.
    """
    a, n = row.n_atoms, row.n
    z, rest = place[: a + n], place[a + n :]
    rates, sorts = rest[:a], rest[a : 2 * a].view(np.int64)
    push, slope = rest[2 * a : 14 * a].reshape((a, 12)), rest[14 * a : 26 * a].reshape((a, 12))
    return z, rates, sorts, push, slope, rest[26 * a :]


@inner_kernel
def _kept(row, work):
    """Return where an evaluation keeps its values for the derivatives."""
    return _divided(row, work.channels.reshape(-1)[6 * row.scratch :])


@row_kernel
def sample(raw, data, state, work):
    """Write the values of the signals, and let the rates act on the states."""
    rows = raw.view(ROW)
    for m in range(rows.shape[0]):
        row = rows[m]
        kept = _kept(row, work)
        _values(row, data, state, work, row.n_used, work.weights[0].wanted, kept)
        z = kept[0]
        outputs = integers(data, row.outputs, 2 * row.n_outputs)
        for k in range(row.n_outputs):
            to = state.signals[outputs[2 * k + 1]]
            to[0], to[1], to[2] = z[row.n_atoms + outputs[2 * k]], 0.0, 0.0
        acts = integers(data, row.acts, 5 * row.n_rates)
        for k in range(row.n_rates):
            work.markers[acts[5 * k + 1]].wrench[acts[5 * k + 2]] += z[row.n_atoms + acts[5 * k]]
        held = integers(data, row.held, row.n_held)
        for k in range(row.n_held):  # a step leaves them as they are
            work.branches[held[k]] = state.q[len(state.q) - len(work.branches) + held[k]]


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
        _, _, sorts, push, slope, by_inputs = _kept(row, work)  # as `sample` has left them in this evaluation
        atoms = data[row.atoms : row.atoms + row.n_atoms * WORDS].view(MEASURED)
        gradients = by_atoms(row, data, row.n_used, by_inputs)
        acts = integers(data, row.acts, 5 * row.n_acts)
        blocks = integers(data, row.blocks, 3 * acts[5 * row.n_acts - 1] if row.n_acts > 0 else 0)
        none, by, column = np.zeros(6), np.empty((row.n_legs, 6)), np.empty(len(state.u))
        for k in range(row.n_acts):
            act = acts[5 * k : 5 * k + 5]
            for b in range(act[3], act[4]):
                by[blocks[3 * b]] = 0.0
            for a in range(row.n_atoms):
                x = gradients[act[0], a if atoms[a].source < 0 else atoms[a].source]
                if x == 0.0:
                    continue
                if atoms[a].what == _STATE:  # most are: one number
                    by[atoms[a].leg_b, atoms[a].axis] += weights.damping * x
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
        kept = _divided(row, np.empty(OF_ATOM * row.n_atoms + row.n + row.n_uses))  # those of the step are kept
        _values(row, data, state, work, row.n, 1, kept)
        z, rates, sorts = kept[:3]
        gradients = by_atoms(row, data, row.n, kept[5])
        kinks, units = integers(data, row.kinks, 4 * row.n_kinks), integers(data, row.units, row.n_atoms)
        for k in range(row.n_kinks):
            slot, kind, begin, count = kinks[4 * k], kinks[4 * k + 1], kinks[4 * k + 2], kinks[4 * k + 3]
            place = out[first + k]
            place[:] = 0.0
            place[0], place[1], place[9] = abs(kind), z[row.n_atoms + slot], 1.0
            for a in range(row.n_atoms):
                by = gradients[slot, a]
                if by == 0.0:
                    continue
                if sorts[a] == POSITION or sorts[a] == SIGNAL:
                    place[4] += by * rates[a]
                else:
                    place[UNKNOWN] = 1.0
                if units[a] > 0:
                    place[OF_LENGTHS - 1 + units[a]] += abs(by) * data[row.shares + a]
            place[FORMULA] = 1.0
            if kind < 0:  # a held value changes where this passes zero upwards
                place[1], place[4], place[FORMULA], place[UNKNOWN] = -place[1], -place[4], HELD, 0.0
            if abs(kind) == PIECE:
                points = data[row.points + begin : row.points + begin + abs(count)]
                _piece(place[1], points, count < 0, place)
        first += row.n_kinks


LOOP = Table("Loop", ROW, {"apply": sample, "switch": switch}, switches="n_kinks")
LOOP_TANGENT = Table("LoopTangent", ROW, {"apply": tangent})


def words(numbers: Any) -> np.ndarray:
    """Return integers as bulk data holds them."""
    return np.array(numbers, np.int64).ravel().view(float)
