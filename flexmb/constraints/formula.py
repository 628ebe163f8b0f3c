"""`Formula`: an equation of the user between measured scalars, with exact derivatives from jets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.constraints.by_function import FunctionOfScalars
from flexmb.constraints.measured import Measured
from flexmb.constraints.measured_kernels import (
    MEASURED,
    POSITION,
    VELOCITY,
    add_measured_curvature,
    measure_scalar,
)
from flexmb.constraints.rows import HEADER, add_to_pairs, pair_blocks
from flexmb.math import operations as op
from flexmb.math.callbacks import call_back
from flexmb.math.jets import run_program
from flexmb.math.kernel import inner_kernel
from flexmb.math.tables import DAMPED, STIFF, row_kernel
from flexmb.model.expression import SignalProgram
from flexmb.model.primitives import Equation
from flexmb.model.table import Table, in_order

__all__ = ["Formula"]

ROW = np.dtype(
    [
        *HEADER,
        ("own_level", np.int64),  # 0: positions, 1: velocities
        ("n", np.int64),  # number of inputs
        ("inputs", np.int64),  # where their rows begin in the bulk data
        ("n_legs", np.int64),
        ("pairs", np.int64),  # where the places of the blocks of the legs begin: pair, row, column
        ("n_programs", np.int64),  # of the equation, then of given forces
        ("programs", np.int64),  # first operation of each in ops, and the end
        ("pushed", np.int64),  # input on which each given force acts
        ("ops", np.int64),
        ("args", np.int64),
        ("address", np.int64),  # of the function of the equation, or 0
    ],
    align=True,
)
WORDS = MEASURED.itemsize // 8
_STACK = op.STACK
ROUNDING = 1e-14
"""Relative to the terms of an equation of velocities: what is left of it without them is rounding below this."""


@inner_kernel
def _run(row, data, which, time, jets, stack):
    """Leave the jet of a program in stack[0]."""
    bounds = data[row.programs : row.programs + row.n_programs + 1]
    first, last = int(bounds[which]), int(bounds[which + 1])
    size = int(bounds[row.n_programs])
    ops = data[row.ops : row.ops + size].view(np.int64)
    none, starts = np.empty(0), np.zeros(1, np.int64)
    run_program(ops, data[row.args : row.args + size], first, last, time, jets, none, starts, stack)


@inner_kernel
def _slopes(row, data, which, time, seeds, stack, out):
    """Write the derivatives of a program by its inputs to `out` (n,)."""
    for k in range(row.n):
        seeds[k, 1] = 1.0
        _run(row, data, which, time, seeds, stack)
        out[k] = stack[0, 1]
        seeds[k, 1] = 0.0


@inner_kernel
def _second_slopes(row, data, time, seeds, stack, lam, out):
    """Add lam times the second derivatives of the equation by its inputs to `out` (n, n).

    From second derivatives along one and two inputs at once: 2 f_kl = f''(k + l) - f''(k) - f''(l).
    """
    single = np.empty(row.n)
    for k in range(row.n):
        seeds[k, 1] = 1.0
        _run(row, data, 0, time, seeds, stack)
        single[k] = stack[0, 2]
        out[k, k] += lam * single[k]
        for j in range(k):
            seeds[j, 1] = 1.0
            _run(row, data, 0, time, seeds, stack)
            mixed = 0.5 * lam * (stack[0, 2] - single[k] - single[j])
            out[k, j] += mixed
            out[j, k] += mixed
            seeds[j, 1] = 0.0
        seeds[k, 1] = 0.0


@inner_kernel
def _spread(z, x, p, out):
    """Add x p of a scalar's 12 components to the equation's legs, `out` (n_legs, 6)."""
    for i in range(6):
        if z.leg_a >= 0:
            out[z.leg_a, i] += x * p[i]
        if z.leg_b >= 0:
            out[z.leg_b, i] += x * p[6 + i]


@inner_kernel
def _add_tangent(work, row, data, inputs, sorts, push, slope, forces, change):
    """Add -d(wrenches) by displacements and twists to the pairs of the equation's markers.

    The forces f_k (n,) on the inputs change by `change` (n, n): the wrenches are sum f_k p_k.
    """
    legs = 6 * row.n_legs
    K, D = np.zeros((legs, legs)), np.zeros((legs, legs))
    local = np.empty((12, 12))
    by_place, by_twist = np.zeros((row.n_legs, 6)), np.zeros((row.n_legs, 6))
    at = np.empty(12, np.int64)
    for k in range(row.n):
        z = inputs[k]
        for i in range(6):
            at[i] = 6 * z.leg_a + i if z.leg_a >= 0 else -1
            at[6 + i] = 6 * z.leg_b + i if z.leg_b >= 0 else -1
        if forces[k] != 0.0:
            local[:] = 0.0
            add_measured_curvature(z, -forces[k], work, local)
            for i in range(12):
                for j in range(12):
                    if at[i] >= 0 and at[j] >= 0:
                        K[at[i], at[j]] += local[i, j]
        by_place[:] = 0.0
        by_twist[:] = 0.0
        for j in range(row.n):
            if change[k, j] != 0.0:
                _spread(inputs[j], change[k, j], push[j] if sorts[j] == POSITION else slope[j], by_place)
                if sorts[j] == VELOCITY:
                    _spread(inputs[j], change[k, j], push[j], by_twist)
        for i in range(12):
            if at[i] >= 0 and push[k, i] != 0.0:
                for leg in range(row.n_legs):
                    for j in range(6):
                        K[at[i], 6 * leg + j] -= push[k, i] * by_place[leg, j]
                        D[at[i], 6 * leg + j] -= push[k, i] * by_twist[leg, j]
    add_to_pairs(work, data, row.pairs, row.n_legs, K, D)


@inner_kernel
def _ask(row, t, second, jets, by_input, answer):
    """Write what the function of the equation returns to `answer`, and its derivatives by the inputs to `by_input`."""
    n = row.n
    given = np.empty(2 + 3 * n)
    given[0] = t
    given[1] = 1.0 if second else 0.0
    for k in range(n):
        given[2 + 3 * k : 5 + 3 * k] = jets[k]
    call_back(row.address, given.ctypes.data, answer.ctypes.data)
    by_input[:] = answer[4 : 4 + n]


@inner_kernel
def _derivatives(row, data, t, sorts, jets, seeds, stack, by_input, answer):
    """Write the value of a program, its derivatives along the motion and by explicit time to `answer`."""
    time = np.zeros(3)
    time[0] = t
    _slopes(row, data, 0, time, seeds, stack, by_input)
    time[1] = 1.0
    _run(row, data, 0, time, jets, stack)
    answer[0:3] = stack[0]
    for k in range(row.n):
        seeds[k, 1] = jets[k, 1] if sorts[k] != POSITION and sorts[k] != VELOCITY else 0.0
    _run(row, data, 0, time, seeds, stack)
    answer[3] = stack[0, 1]
    for k in range(row.n):
        seeds[k, 1] = 0.0


@inner_kernel
def _equation(row, work, inputs, sorts, jets, push, slope, by_input, answer):
    """Write residual, rate, drift and gradients of the equation, and its derivatives by the inputs to `by_input`.

    Along the motion the inputs are jets. Positions: g' = G u + dg/dt, and g'' with accelerations of the markers that
    are zero is the drift. Velocities: the residual psi is G u + rate with G = d psi/du, in linear equations and in
    others; its derivative by time is the drift.
    """
    equation = work.equations[row.equation]
    equation.g = answer[0]
    equation.drift = answer[2] if row.own_level == 0 else answer[1]
    equation.rate = answer[3]
    if row.own_level == 1:
        equation.rate, terms = equation.g, abs(equation.g)
        for k in range(row.n):
            if sorts[k] == VELOCITY:
                equation.rate -= by_input[k] * jets[k, 0]
                terms += abs(by_input[k] * jets[k, 0])
        if abs(equation.rate) <= ROUNDING * terms:  # no work: a step's error must not be compared with rounding
            equation.rate = 0.0
    gradient, by_place = np.zeros((row.n_legs, 6)), np.zeros((row.n_legs, 6))
    for k in range(row.n):
        if sorts[k] == VELOCITY:
            _spread(inputs[k], by_input[k], push[k], gradient)
            _spread(inputs[k], by_input[k], slope[k], by_place)
        elif sorts[k] == POSITION:
            _spread(inputs[k], by_input[k], push[k], by_place)
    for n in range(row.n_legs):
        leg = work.legs[row.leg + n]
        for i in range(6):
            leg.gradient[i] = gradient[n, i] if row.own_level == 1 else by_place[n, i]
            leg.slope[i] = by_place[n, i] if row.own_level == 1 else 0.0


@row_kernel
def evaluate(raw, data, state, work):
    """g = f(z, t) of measured scalars z, eq. (formula); the multiplier and given forces push the scalars."""
    rows = raw.view(ROW)
    stack, time = np.empty((_STACK, 3)), np.zeros(3)
    for m in range(rows.shape[0]):
        row = rows[m]
        n = row.n
        inputs = data[row.inputs : row.inputs + n * WORDS].view(MEASURED)
        sorts, forces, by_input = np.empty(n, np.int64), np.zeros(n), np.empty(n)
        jets, seeds = np.empty((n, 3)), np.zeros((n, 3))
        push, slope = np.empty((n, 12)), np.empty((n, 12))
        for k in range(n):
            sorts[k] = measure_scalar(inputs[k], state, work, jets[k], push[k], slope[k])
            seeds[k, 0] = jets[k, 0]
        weights = work.weights[0]
        tangent = weights.wanted == 1 and (weights.damping != 0.0 or weights.stiffness != 0.0)
        answer = np.zeros(4 + n + n * n)
        if row.address != 0:
            _ask(row, state.t, tangent, jets, by_input, answer)
        else:
            _derivatives(row, data, state.t, sorts, jets, seeds, stack, by_input, answer)
        _equation(row, work, inputs, sorts, jets, push, slope, by_input, answer)
        lam = state.lam[row.equation]
        work.equations[row.equation].force = lam
        for k in range(n):
            # at its own level an equation pushes what its gradient is made of
            forces[k] = lam * by_input[k] if sorts[k] == (POSITION if row.own_level == 0 else VELOCITY) else 0.0
        time[0] = state.t
        for p in range(1, row.n_programs):
            k = int(data[row.pushed + p - 1])
            _run(row, data, p, time, seeds, stack)
            forces[k] += stack[0, 0]
            work.energy[0].load_power += stack[0, 0] * (jets[k, 1] if sorts[k] == POSITION else jets[k, 0])
        for k in range(n):
            z = inputs[k]
            for i in range(6):
                if z.a >= 0:
                    work.markers[z.a].wrench[i] += forces[k] * push[k, i]
                if z.b >= 0:
                    work.markers[z.b].wrench[i] += forces[k] * push[k, 6 + i]
        if tangent:
            change = np.zeros((n, n))
            if row.address != 0:
                change += lam * answer[4 + n :].reshape((n, n))
            else:
                _second_slopes(row, data, time, seeds, stack, lam, change)
            for k in range(n):
                if sorts[k] != (POSITION if row.own_level == 0 else VELOCITY):
                    change[k, :] = 0.0
            for p in range(1, row.n_programs):
                _slopes(row, data, p, time, seeds, stack, by_input)
                for j in range(n):
                    change[int(data[row.pushed + p - 1]), j] += by_input[j]
            _add_tangent(work, row, data, inputs, sorts, push, slope, forces, change)


@dataclass(frozen=True)
class Formula(Equation):
    """An equation f(z, t) = 0 between measured scalars z, with given forces on some of them.

    Parameters
    ----------
    inputs : tuple of Measured
        The scalars z that the programs read.
    program : SignalProgram
        f.
    own_level : int
        0 for an equation between positions, 1 for one between velocities.
    given : tuple of (int, SignalProgram)
        Number of the scalar on which a force acts, and the force.
    function, jacobian : callable, optional
        f in the place of the program, see `FunctionOfScalars`; positions stand first among the inputs then.
    keep : list
        Takes the C function that is made.
    """

    inputs: tuple[Measured, ...]
    program: SignalProgram
    own_level: int = 0
    given: tuple[tuple[int, SignalProgram], ...] = ()
    function: Any = None
    jacobian: Any = None
    keep: Any = None

    table: ClassVar[Table] = Table("Formula", ROW, {"evaluate": evaluate}, on_demand=(run_program,))
    stiffens: ClassVar[bool] = False

    @property
    def level(self) -> int:  # type: ignore[override]
        """0: g(q, t) = 0; 1: an equation of velocities."""
        return self.own_level

    def involved(self, markers):
        """Return each marker once."""
        return tuple(dict.fromkeys(markers))

    def record(self, compiler, markers):
        """Return the row by field name; `markers` of all inputs."""
        legs = self.involved(markers)
        writes = DAMPED if self.own_level == 1 or self.given else STIFF
        legs_of = {marker: k for k, marker in enumerate(legs)}
        rows = np.array(
            [in_order(MEASURED, z.record(compiler, lambda m: legs_of.get(m, -1))) for z in self.inputs], MEASURED
        )
        programs = [self.program, *(force for _, force in self.given)]
        ops = np.concatenate([p.ops for p in programs]).astype(np.int64)
        address = 0
        if self.function is not None:
            positions = sum(z.sort == POSITION for z in self.inputs)
            self.keep.append(
                FunctionOfScalars(self.function, self.jacobian, positions, len(self.inputs), self.own_level)
            )
            address = self.keep[-1].address
        return {
            "n": len(self.inputs),
            "inputs": compiler.bulk(rows.view(float)),
            "n_legs": len(legs),
            "pairs": compiler.bulk(np.array(pair_blocks(compiler, legs, writes), float)),
            "n_programs": len(programs),
            "programs": compiler.bulk(np.cumsum([0] + [len(p.ops) for p in programs])),
            "pushed": compiler.bulk(np.array([k for k, _ in self.given], float)),
            "ops": compiler.bulk(ops.view(float)),
            "args": compiler.bulk(np.concatenate([p.args for p in programs])),
            "address": address,
        }
