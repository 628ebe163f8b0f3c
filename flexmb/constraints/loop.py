"""Signals that follow what is measured: their values before the forces, their derivatives after them.

All such signals of a model, and the rates of the states of its blocks, are one row. It reads scalars (`Measured`: the
atoms) and runs programs, each of which may read atoms and the results of programs before it. The derivatives of all
results by the atoms follow by the chain rule from the jets of the programs, eq. (loop-gradient). A force that follows a
signal tells in `work.channels` how its wrench on a marker changes with the signal.

What an evaluation measures stands behind the Jacobians, the last numbers of `work.J`. Kernels here only borrow arrays
(`flexmb.math.borrowing`): a controller of twenty blocks is evaluated in a microsecond, as long as ten arrays take.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.constraints.coordinate_kernels import measure, turn_or_length
from flexmb.constraints.loop_values import gradients, program_values
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
from flexmb.math.operations import STACK
from flexmb.math.plain_loops import knots_until
from flexmb.math.switches import FORMULA, HELD, OF_LENGTHS, PIECE, PIECE_BEGIN, PIECE_END, UNKNOWN, switch_kernel
from flexmb.math.tables import row_kernel
from flexmb.model.table import Table

__all__ = ["LOOP", "LOOP_TANGENT", "kept_places", "words"]

ROW = np.dtype(
    [
        ("n_atoms", np.int64),
        ("atoms", np.int64),  # where their rows begin in the bulk data
        ("sorts", np.int64),  # POSITION, ... of each
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
        ("affine", np.int64),  # 1: a program is a constant and its inputs times numbers; 2: an input within limits
        ("constants", np.int64),  # its constant
        ("factors", np.int64),  # the number of every input that programs read
        ("addresses", np.int64),  # C functions in the place of programs, or 0
        ("reads", np.int64),  # atoms on which each program depends, by way of others too
        ("read_starts", np.int64),  # first of each program, and the end
        ("n_reads", np.int64),
        ("chain", np.int64),  # derivative that grows, derivative of a program by an input, that of the input by an atom
        ("n_chain", np.int64),
        ("n_chain_used", np.int64),  # of the programs that act
        ("n_outputs", np.int64),
        ("outputs", np.int64),  # program, signal
        ("n_rates", np.int64),
        ("rates", np.int64),  # program, marker, component: rates of states
        ("n_own", np.int64),
        ("own", np.int64),  # derivative of a rate by a state, and its place in the iteration matrix
        ("n_acts", np.int64),  # what else programs act on
        ("acts", np.int64),  # marker, component of the rate of a state or -1, channel of a force, end of its blocks
        ("blocks", np.int64),  # marker, first place in the iteration matrix among work.pair_rows, end of its terms
        ("terms", np.int64),  # derivative of a program by an atom, that atom, 1 if by its second marker
        ("implicit", np.int64),  # 1: signals follow accelerations
        ("n_held", np.int64),
        ("held", np.int64),  # branches that hold values
        ("n_kinks", np.int64),
        ("kinks", np.int64),  # program, kind of its switch (negative: of a held value), first point, number of points
        ("points", np.int64),  # of tables whose pieces are left; as many as are counted, or less than zero: periodic
        ("units", np.int64),  # 1 to 4: lengths, angles and states, speeds, rates of angles; 0: another atom
        ("shares", np.int64),  # size of an atom in this unit
        # what is kept of an evaluation, from its first number on: values of atoms and programs, then these
        ("by", np.int64),  # derivatives of programs by their inputs
        ("paces", np.int64),  # rates of atoms
        ("push", np.int64),  # 12 numbers of each atom
        ("slope", np.int64),
        ("gradient", np.int64),  # 1, then the derivatives of programs by the atoms that they read
        ("stack", np.int64),  # scratch of programs: values, their derivatives, an answer
        ("parts", np.int64),
        ("answer", np.int64),
        ("scratch", np.int64),  # of the matrix: 6 numbers, a column, a row
        ("size", np.int64),  # of all this
    ],
    align=True,
)
WORDS = MEASURED.itemsize // 8
_COORDINATE, _PLACE, _VELOCITY = (WHATS.index(what) for what in ("coordinate", "place", "velocity"))
_SIGNAL, _STATE, _HELD = (WHATS.index(what) for what in ("signal", "state", "held"))


def kept_places(n_atoms: int, n: int, n_uses: int, n_reads: int, width: int, most: int = 0) -> dict[str, int]:
    """Return where an evaluation keeps its numbers, as fields of the row.

    Parameters
    ----------
    n_atoms, n, n_uses, n_reads, width : int
        As in the row; `n` programs.
    most : int
        Velocities that move a marker, at most.
    """
    sizes = {
        "by": n_uses,
        "paces": n_atoms,
        "push": 12 * n_atoms,
        "slope": 12 * n_atoms,
        "gradient": 1 + n_reads,
        "stack": STACK,
        "parts": STACK * max(1, width),
        "answer": 1 + width,
        "scratch": 6 + 2 * most,
    }
    places = np.cumsum([n_atoms + n, *sizes.values()]).tolist()
    return dict(zip([*sizes, "size"], places, strict=True))


@inner_kernel
def _value(z, state, work):
    """Return the value of an atom where it takes no derivatives to tell it, and if it does."""
    if z.what == _STATE:  # most atoms are
        marker = work.markers[z.b]
        return marker.v[z.axis] if z.axis < 3 else marker.w[z.axis - 3], True
    if z.what == _COORDINATE and z.rate == 0:
        return turn_or_length(z.c, state, work), True
    if z.what == _HELD:
        return state.q[len(state.q) - len(work.branches) + z.signal], True
    if z.what == _SIGNAL:
        return state.signals[z.signal, z.rate], True
    if z.what == _PLACE and z.rate == 0:
        return work.markers[z.b].r[z.axis], True
    if z.what == _VELOCITY and z.a < 0:
        return work.markers[z.b].v[z.axis], True
    return 0.0, False


@inner_kernel
def _values(row, data, state, work, count, wanted, place):
    """Measure the atoms, and write the values of `count` programs behind them, if wanted with their derivatives."""
    atoms, jet = data[row.atoms : row.atoms + row.n_atoms * WORDS].view(MEASURED), place[row.scratch : row.scratch + 3]
    for k in range(row.n_atoms):
        z = atoms[k]
        push, slope = place[row.push + 12 * k :][:12], place[row.slope + 12 * k :][:12]
        if wanted == 0 or z.what == _STATE:
            x, known = _value(z, state, work)
            if known:
                place[k], place[row.paces + k] = x, 0.0
                continue
        if z.what == _COORDINATE and (wanted == 0 or z.rate == 0):  # without its curvature
            x, rate = measure(z.c, state, work, push)
            place[k], place[row.paces + k] = rate if z.rate == 1 else x, rate
            continue
        measure_scalar(z, state, work, jet, push, slope)
        place[k], place[row.paces + k] = jet[0], jet[1]
    program_values(row, data, state.t, count, wanted, place)


@row_kernel
def sample(raw, data, state, work):
    """Write the values of the signals, and let the rates act on the states."""
    rows = raw.view(ROW)
    for m in range(rows.shape[0]):
        row = rows[m]
        place = work.J[len(work.J) - row.size :]
        _values(row, data, state, work, row.n_used, work.weights[0].wanted, place)
        outputs = data[row.outputs : row.outputs + 2 * row.n_outputs].view(np.int64)
        for k in range(row.n_outputs):
            to = outputs[2 * k + 1]
            state.signals[to, 0], state.signals[to, 1] = place[row.n_atoms + outputs[2 * k]], 0.0
            state.signals[to, 2] = 0.0
        acts = data[row.rates : row.rates + 3 * row.n_rates].view(np.int64)
        for k in range(row.n_rates):
            work.markers[acts[3 * k + 1]].wrench[acts[3 * k + 2]] += place[row.n_atoms + acts[3 * k]]
        held = data[row.held : row.held + row.n_held].view(np.int64)
        for k in range(row.n_held):  # a step leaves them as they are
            work.branches[held[k]] = state.q[len(state.q) - len(work.branches) + held[k]]


@inner_kernel
def _by_twist(row, data, weights, place, first, last, by):
    """Write to `by` (6,) how what a program acts on changes with the twist of a marker, by the terms [first, last)."""
    terms = data[row.terms + 3 * first : row.terms + 3 * last].view(np.int64)
    sorts = data[row.sorts : row.sorts + row.n_atoms].view(np.int64)
    atoms = data[row.atoms : row.atoms + row.n_atoms * WORDS].view(MEASURED)
    used = False
    for i in range(6):
        by[i] = 0.0
    for k in range(last - first):
        x, a, second = place[row.gradient + terms[3 * k]], terms[3 * k + 1], terms[3 * k + 2]
        if x == 0.0:
            continue
        used = True
        if atoms[a].what == _STATE:  # one number
            by[atoms[a].axis] += weights.damping * x
            continue
        if sorts[a] == ACCELERATION and second == 1:
            by[atoms[a].axis] += weights.mass * x
        push, slope = place[row.push + 12 * a + 6 * second :][:6], place[row.slope + 12 * a + 6 * second :][:6]
        if sorts[a] == POSITION:
            for i in range(6):
                by[i] += weights.stiffness * x * push[i]
        elif sorts[a] == VELOCITY or sorts[a] == ACCELERATION:
            for i in range(6):
                by[i] += weights.stiffness * x * slope[i] + weights.damping * x * push[i]
    return used


@inner_kernel
def _add_to_matrix(work, a, b, start, by, column, along):
    """Subtract a wrench on marker a times its derivatives by the twist of marker b from the iteration matrix.

    It is a product of two vectors: `along` (nu of a,), the wrench along the velocities, and `by` (6,). `column` is
    scratch.
    """
    blocks = b.nu // b.width
    for j in range(b.nu):
        column[j] = 0.0
    for m in range(6):
        if by[m] != 0.0:
            for j in range(b.nu):
                column[j] += by[m] * work.J[b.iJ + m * b.nu + j]
    for i in range(a.nu):
        x = along[i]
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
        place = work.J[len(work.J) - row.size :]  # as `sample` has left it in this evaluation
        gradients(row, data, row.n_chain_used, place)
        own = data[row.own : row.own + 2 * row.n_own].view(np.int64)
        for k in range(row.n_own):
            work.S[own[2 * k + 1]] -= weights.damping * place[row.gradient + own[2 * k]]
        acts = data[row.acts : row.acts + 4 * row.n_acts].view(np.int64)
        blocks = data[row.blocks : row.blocks + 3 * (acts[4 * row.n_acts - 1] if row.n_acts > 0 else 0)].view(np.int64)
        half = row.scratch + 6 + (row.size - row.scratch - 6) // 2
        by, column, along = place[row.scratch : row.scratch + 6], place[row.scratch + 6 : half], place[half:]
        block, term = 0, 0
        for k in range(row.n_acts):
            component, channel = acts[4 * k + 1], acts[4 * k + 2]
            a = work.markers[acts[4 * k]]
            for i in range(a.nu):
                if component >= 0:
                    along[i] = work.J[a.iJ + component * a.nu + i]
                else:
                    along[i] = 0.0
                    for j in range(6):
                        along[i] += work.channels[channel, j] * work.J[a.iJ + j * a.nu + i]
            while block < acts[4 * k + 3]:
                last = blocks[3 * block + 2]
                b = work.markers[blocks[3 * block]]
                if _by_twist(row, data, weights, place, term, last, by):
                    _add_to_matrix(work, a, b, blocks[3 * block + 1], by, column, along)
                term = last
                block += 1


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
        kept = np.empty(row.size)  # what the step has kept stays
        _values(row, data, state, work, row.n, 1, kept)
        gradients(row, data, row.n_chain, kept)
        kinks = data[row.kinks : row.kinks + 4 * row.n_kinks].view(np.int64)
        sorts = data[row.sorts : row.sorts + row.n_atoms].view(np.int64)
        units = data[row.units : row.units + row.n_atoms].view(np.int64)
        starts = data[row.read_starts : row.read_starts + row.n + 1].view(np.int64)
        reads = data[row.reads : row.reads + row.n_reads].view(np.int64)
        for k in range(row.n_kinks):
            slot, kind, begin, count = kinks[4 * k], kinks[4 * k + 1], kinks[4 * k + 2], kinks[4 * k + 3]
            place = out[first + k]
            place[:] = 0.0
            place[0], place[1], place[9] = abs(kind), kept[row.n_atoms + slot], 1.0
            for r in range(starts[slot], starts[slot + 1]):
                a, by = reads[r], kept[row.gradient + 1 + r]
                if by == 0.0:
                    continue
                if sorts[a] == POSITION or sorts[a] == SIGNAL:
                    place[4] += by * kept[row.paces + a]
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
