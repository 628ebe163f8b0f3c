"""The compiled evaluation of a system: one loop over kinds, called through pointers, never over parts.

`Program` is constant, `Work` is scratch; every function here is pure apart from the workspace it is given.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from flexmb.math.energies import clear_energy
from flexmb.math.jets import sample_signals
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.program import EVALUATION, Program, call_evaluation
from flexmb.math.rotations import advance_frame, relative_frame
from flexmb.math.tables import DAMPED, STIFF, PointerKernel, call_row_kernel, pointer_kernel
from flexmb.model.table import Table

__all__ = [
    "Program",
    "advance",
    "compile_shared",
    "evaluate",
    "increment",
    "keep_branches",
    "kernel_table",
    "row_kernels",
    "run_kernels",
    "unit_frames",
]


def kernel_table(kernels) -> np.ndarray:
    """Return the addresses of the machine code of row kernels."""
    return np.array([k.compiled.address for k in kernels], np.int64)


def row_kernels(tables: Iterable[Table | None]) -> list[Any]:
    """Return the kernels that run over tables, in the order in which models are compiled, and what calls them."""
    found = {table.name: table.kernels for table in tables if table is not None}.values()
    stages = dict.fromkeys(stage for kernels in found for stage in kernels)
    return [*(kernels[stage] for stage in stages for kernels in found if stage in kernels), evaluation]


def compile_shared(kernels: Iterable[PointerKernel]) -> None:
    """Compile or load kernels, last those that another process is compiling: meanwhile there is something to do."""
    elsewhere = []
    for one in kernels:
        if one.is_missing() and one.is_being_compiled():
            elsewhere.append(one)
        else:
            _ = one.compiled
    for one in elsewhere:
        _ = one.compiled


@inner_kernel
def run_kernels(addresses, first, program, state, work):
    """Call the kernels on their record tables, the first of which is number `first`."""
    for k in range(len(addresses)):
        start, stop = program.starts[first + k], program.starts[first + k + 1]
        call_row_kernel(addresses[k], program.raw[start:stop], program.bulk, state, work)


@inner_kernel
def assemble_constraints(program, work):
    """Write G and -G^T into the iteration matrix, with the part of G^T that stiffens reduced bodies.

    The row of a velocity-level equation is its residual per displacement, divided by the velocity per
    displacement gamma / (beta h): A + (beta h / gamma) d(A u)/dq, where c_K / c_D = beta h / gamma.
    """
    weights = work.weights[0]
    delay = weights.stiffness / weights.damping if weights.damping > 0.0 else 0.0
    for n in range(len(work.legs)):
        leg = work.legs[n]
        marker = work.markers[leg.marker]
        nu = marker.nu
        for k in range(6):
            x = leg.gradient[k] + leg.push[k]
            y = leg.gradient[k] + delay * leg.slope[k]
            if x == 0.0 and y == 0.0:
                continue
            start = marker.iJ + k * nu
            for j in range(nu):
                work.S[work.transposed[leg.iT + j]] -= x * work.J[start + j]
            for b in range(nu // max(1, marker.width)):
                first = b * marker.width
                at = work.transposed[leg.iS + b]
                for j in range(marker.width):
                    work.S[at + j] += y * work.J[start + first + j]
            if marker.iH >= 0:
                start = marker.iH + k * nu
                for j in range(6, nu):
                    work.S[work.transposed[leg.iT + j]] += x * work.H[start + j]
    for n in range(len(work.equations)):
        work.S[work.equations[n].diagonal] += program.regularisation[n]


@inner_kernel
def lend_inertia(program, work):
    """Add the inertia that makes the blocks of bodies without inertia regular, eq. (lent-inertia)."""
    for n in range(len(program.floor_at)):
        work.S[program.floor_at[n, 1]] += work.weights[0].mass * program.floor[n]


@inner_kernel
def _add_pair_block(pair, ck, cd, ia, ib, a, b, start, work):
    """Add J_a^T (ck K + cd D) J_b to the blocks of bodies a and b; most entries of K and D are zero."""
    column = np.empty(b.nu)
    blocks = b.nu // b.width
    for k in range(6):
        used = False
        for m in range(6):
            x = ck * pair.K[ia + k, ib + m]
            if pair.active == DAMPED:
                x += cd * pair.D[ia + k, ib + m]
            if x == 0.0:
                continue
            if not used:
                column[:] = 0.0
                used = True
            at = b.iJ + m * b.nu
            for j in range(b.nu):
                column[j] += x * work.J[at + j]
        if not used:
            continue
        for i in range(a.nu):
            x = work.J[a.iJ + k * a.nu + i]
            if x != 0.0:
                for n in range(blocks):
                    at = work.pair_rows[start + i * blocks + n]
                    for j in range(b.width):
                        work.S[at + j] += x * column[n * b.width + j]


@inner_kernel
def assemble_pairs(work):
    """Write the stiffness and damping between pairs of markers into the iteration matrix."""
    cd, ck = work.weights[0].damping, work.weights[0].stiffness
    if cd == 0.0 and ck == 0.0:
        return
    for n in range(len(work.pairs)):
        pair = work.pairs[n]
        if pair.active <= 0:
            continue
        start = pair.iS
        for block in range(4):
            # one place of call: each would be compiled for itself
            first = work.markers[pair.a if block < 2 else pair.b]
            second = work.markers[pair.a if block % 2 == 0 else pair.b]
            if first.nu > 0 and second.nu > 0:
                _add_pair_block(pair, ck, cd, 6 * (block // 2), 6 * (block % 2), first, second, start, work)
                start += first.nu * (second.nu // second.width)


@pointer_kernel(EVALUATION)
def evaluation(program, state, work):
    """Evaluate residual, constraints and (if asked for by the weights) the iteration matrix: see `evaluate`."""
    tangent = work.weights[0].wanted == 1
    work.residual[:] = 0.0
    clear_energy(work.energy)
    work.loads[:] = 0.0
    for n in range(len(work.markers)):
        wrench = work.markers[n].wrench
        for i in range(6):
            wrench[i] = 0.0
    if tangent:
        work.S[:] = 0.0
        for n in range(len(work.legs)):
            work.legs[n].push[:] = 0.0
        for n in range(len(work.pairs)):
            pair = work.pairs[n]
            if pair.active >= STIFF:
                pair.K[:] = 0.0
            if pair.active == DAMPED:
                pair.D[:] = 0.0
    sample_signals(
        state.t,
        program.signals,
        state.signals,
    )
    n_bodies, n_equations = len(program.inertia), len(program.equations)
    run_kernels(program.place, 0, program, state, work)
    run_kernels(program.equations, n_bodies, program, state, work)
    run_kernels(program.forces, n_bodies + n_equations, program, state, work)
    run_kernels(program.inertia, 0, program, state, work)
    for n in range(len(work.equations)):
        equation = work.equations[n]
        work.energy[0].drive_power -= equation.force * equation.rate
    if tangent:
        lend_inertia(program, work)
        if work.weights[0].constrained == 1:
            assemble_constraints(program, work)
        assemble_pairs(work)


@kernel
def evaluate(program, state, work):
    """Evaluate residual, constraints and (if asked for by the weights) the iteration matrix.

    ``residual = M(q) a + h(q, u) - f(q, u, t) - G^T lam``; ``equations.g``; ``S = [cm M + cd D + ck K, -G^T; G, 0]``.
    """
    call_evaluation(program.evaluation, program, state, work)


@kernel
def energies(program, state, work):
    """Evaluate, and add the energies of the bodies to work.energy."""
    evaluate(program, state, work)
    run_kernels(program.energy, 0, program, state, work)


@kernel
def advance(program, q, d, scale, out):
    """Write q [+] scale d to `out`: frames on SE(3), vectors by addition."""
    for n in range(len(program.frames)):
        iq, iu = program.frames[n, 0], program.frames[n, 1]
        advance_frame(q[iq : iq + 7], d[iu : iu + 6], scale, out[iq : iq + 7])
    for n in range(len(program.vectors)):
        iq, iu, size = program.vectors[n, 0], program.vectors[n, 1], program.vectors[n, 2]
        for i in range(size):
            out[iq + i] = q[iq + i] + scale * d[iu + i]
    for i in range(program.branches, len(q)):
        out[i] = q[i]


@kernel
def unit_frames(program, q):
    """Scale the Euler parameters of all frames to unit length."""
    for n in range(len(program.frames)):
        p = q[program.frames[n, 0] + 3 : program.frames[n, 0] + 7]
        length = (p[0] ** 2 + p[1] ** 2 + p[2] ** 2 + p[3] ** 2) ** 0.5
        for i in range(4):
            p[i] /= length


@kernel
def keep_branches(program, work, q):
    """Write the branches of the latest evaluation to the end of the accepted coordinates `q`."""
    for k in range(len(work.branches)):
        q[program.branches + k] = work.branches[k]


@kernel
def increment(program, a, b, d):
    """Write the increment d with b = a [+] d to `d`: the inverse of `advance`."""
    for n in range(len(program.frames)):
        iq, iu = program.frames[n, 0], program.frames[n, 1]
        relative_frame(a[iq : iq + 7], b[iq : iq + 7], d[iu : iu + 6])
    for n in range(len(program.vectors)):
        iq, iu, size = program.vectors[n, 0], program.vectors[n, 1], program.vectors[n, 2]
        for i in range(size):
            d[iu + i] = b[iq + i] - a[iq + i]


@kernel
def constraint_velocity(work, u, out):
    """Write G u + dg/dt of every equation to `out`."""
    for n in range(len(work.equations)):
        out[n] = work.equations[n].rate
    for n in range(len(work.legs)):
        leg = work.legs[n]
        marker = work.markers[leg.marker]
        for k in range(6):
            x = leg.gradient[k]
            if x != 0.0:
                start = marker.iJ + k * marker.nu
                for j in range(marker.nu):
                    out[leg.equation] += x * work.J[start + j] * u[marker.iu + j]


@kernel
def constraint_acceleration(work, a, out):
    """Write g'' = G a + drift of every equation to `out`; the drift includes the bias of the markers."""
    constraint_velocity(work, a, out)
    for n in range(len(work.equations)):
        out[n] += work.equations[n].drift - work.equations[n].rate
    for n in range(len(work.legs)):
        leg = work.legs[n]
        bias = work.markers[leg.marker].bias
        for k in range(6):
            out[leg.equation] += leg.gradient[k] * bias[k]
