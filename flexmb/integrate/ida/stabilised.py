"""Stabilised index-2 form (Gear, Gupta & Leimkuhler 1985) of the equations of a system, and its Jacobian.

The unknowns are ``y = (q, u, lam, mu, works)``; Euler parameters are four of the coordinates. Theory: integrators,
"IDA with stabilised index two". One function writes the entries of the Jacobian, in an order that depends on the
structure only; called once at the start it gives their rows and columns, so pattern and values cannot disagree.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flexmb.math.energies import powers
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.structures import FloatRows, Floats, IntegerRows, Integers, structure
from flexmb.math.tables import State
from flexmb.math.weights import weigh
from flexmb.system.program import advance, constraint_velocity, evaluate, run_kernels, unit_frames

__all__ = ["FAR", "Stabilised", "jacobian", "kinematics", "residual"]

FAR = 1e8
"""Absolute tolerance that takes a variable out of the error test."""


@structure
class Stabilised(NamedTuple):
    """State and constant tables of the stabilised form."""

    q: Floats
    """(nq,) Euler parameters normalised"""
    u: Floats
    """(nu,)"""
    a: Floats
    """(nu,)"""
    lam: Floats
    """(ng,)"""
    mu: Floats
    """(ng,) multipliers of the positions"""
    signals: FloatRows
    held: Integers
    """(ng,) 0 for an equation at velocity level, which has no position to be held"""
    yielding: FloatRows
    """(2, ng) epsilon of G u + dg/dt + epsilon (lam - usual) = 0 and g + epsilon mu = 0, s; zero unless equations
    depend on each other, and then so small that only the multipliers notice, which would not be determined otherwise"""
    usual: Floats
    """(ng,) multipliers at the start; ones that follow would let self-stress grow. Between light and heavy bodies
    epsilon lam alone is a velocity that shows"""
    metric: Floats
    """(nu,) W of q' = T (u + W G^T mu), the inverse squares of the extents: increments compared as displacements"""
    kin: Floats
    """(nu,) u + W G^T mu"""
    speed: Floats
    """(ng,) G u + dg/dt"""
    length_rate: Floats
    """(1,) kappa of the attraction of |p| to 1, 1/s"""
    frame_of: Integers
    """(nu,) number of the frame, or -1"""
    offset: Integers
    """(nu,) place in it"""
    coordinate: Integers
    """(nu,) the coordinate of a plain vector"""
    own: IntegerRows
    """(n, 3) position in S, row and column of the entries of the block (u, u)"""
    transposed: IntegerRows
    """(n, 3) of the block (u, lam)"""
    gradient: IntegerRows
    """(n, 3) of the block (lam, u)"""
    K: Floats
    """values of the iteration matrix with unit stiffness weight"""
    colour: Integers
    """(nu,) number of the group of bodies that share no equation, -1 for deformation"""
    colours: int
    """number of groups"""
    near: Floats
    """(nq,) scratch"""
    turning: Floats
    """(n,) d(G u)/dq of every entry of the block (lam, u)"""


@kernel
def half_product(p, L):
    """Write the (4, 3) matrix of p' = L w, L w = 1/2 p o (0, w), to `L`."""
    L[0, 0], L[0, 1], L[0, 2] = -0.5 * p[1], -0.5 * p[2], -0.5 * p[3]
    L[1, 0], L[1, 1], L[1, 2] = 0.5 * p[0], -0.5 * p[3], 0.5 * p[2]
    L[2, 0], L[2, 1], L[2, 2] = 0.5 * p[3], 0.5 * p[0], -0.5 * p[1]
    L[3, 0], L[3, 1], L[3, 2] = -0.5 * p[2], 0.5 * p[1], 0.5 * p[0]


@kernel
def kinematics(program, length_rate, y, kin, out):
    """Write q' = T(q) kin to `out`: r' = R v, p' = 1/2 p o (0, w) + kappa (1 - |p|^2) p, eta' as it is."""
    R = np.empty((3, 3))
    L = np.empty((4, 3))
    unit = np.empty(4)
    for n in range(len(program.frames)):
        iq, iu = program.frames[n, 0], program.frames[n, 1]
        square = 0.0
        for i in range(4):
            square += y[iq + 3 + i] ** 2
        for i in range(4):
            unit[i] = y[iq + 3 + i] / square**0.5
        euler_to_matrix(unit, R)
        half_product(y[iq + 3 : iq + 7], L)
        for i in range(3):
            out[iq + i] = R[i, 0] * kin[iu] + R[i, 1] * kin[iu + 1] + R[i, 2] * kin[iu + 2]
        for i in range(4):
            turn = L[i, 0] * kin[iu + 3] + L[i, 1] * kin[iu + 4] + L[i, 2] * kin[iu + 5]
            out[iq + 3 + i] = turn + length_rate * (1.0 - square) * y[iq + 3 + i]
    for n in range(len(program.vectors)):
        iq, iu, size = program.vectors[n, 0], program.vectors[n, 1], program.vectors[n, 2]
        for i in range(size):
            out[iq + i] = kin[iu + i]


@inner_kernel
def _unpack(program, s, y, yp):
    """Copy the state out of `y`; Euler parameters are normalised there, so nothing depends on their length."""
    nq, nu, ng = len(s.q), len(s.u), len(s.lam)
    s.q[:] = y[:nq]
    unit_frames(program, s.q)
    s.u[:] = y[nq : nq + nu]
    s.a[:] = yp[nq : nq + nu]
    s.lam[:] = y[nq + nu : nq + nu + ng]
    s.mu[:] = y[nq + nu + ng : nq + nu + 2 * ng]


@kernel
def residual(program, work, s, t, y, yp, out):
    """Write the residual: kinematics, motion, velocity constraints (row of lam), constraints (row of mu), works."""
    _unpack(program, s, y, yp)
    nq, nu, ng = len(s.q), len(s.u), len(s.lam)
    work.weights[0].wanted = 0
    evaluate(program, State(t, s.q, s.u, s.a, s.lam, s.signals), work)
    s.kin[:] = s.u
    for n in range(len(work.legs)):
        leg = work.legs[n]
        marker = work.markers[leg.marker]
        for k in range(6):
            x = leg.gradient[k] * s.mu[leg.equation]
            if x != 0.0:
                for j in range(marker.nu):
                    i = marker.iu + j
                    s.kin[i] += s.metric[i] * x * work.J[marker.iJ + k * marker.nu + j]
    kinematics(program, s.length_rate[0], y, s.kin, out)
    for i in range(program.branches):
        out[i] = yp[i] - out[i]
    for k in range(len(work.branches)):
        out[program.branches + k] = y[program.branches + k] - work.branches[k]
    out[nq : nq + nu] = work.residual
    constraint_velocity(work, s.u, s.speed)
    for k in range(ng):
        out[nq + nu + k] = s.speed[k] + s.yielding[0, k] * (s.lam[k] - s.usual[k])
        out[nq + nu + ng + k] = work.equations[k].g + s.yielding[1, k] * s.mu[k] if s.held[k] == 1 else s.mu[k]
    end = nq + nu + 2 * ng
    out[end : end + 3] = yp[end : end + 3] - powers(work.energy)


@inner_kernel
def _put(rows, columns, values, n, row, column, value):
    rows[n] = row
    columns[n] = column
    values[n] = value
    return n + 1


@inner_kernel
def _put_row(s, R, L, row, j, value, rows, columns, values, n):
    """Write the entries of d(row)/dq that follow from d(row)/d(variation j) = `value`."""
    f, o, c = s.frame_of[j], s.offset[j], s.coordinate[j]
    if f < 0:
        return _put(rows, columns, values, n, row, c, value)
    if o < 3:
        for i in range(3):
            n = _put(rows, columns, values, n, row, c + i, value * R[f, i, o])
    else:
        # dtheta = 2 vec(p^-1 o dp) / |p| = 4 L^T dp at unit length
        for i in range(4):
            n = _put(rows, columns, values, n, row, c + 3 + i, 4.0 * value * L[f, i, o - 3])
    return n


@inner_kernel
def _put_kinematics(program, s, cj, y, R, L, rows, columns, values, n):
    """Write the entries of the rows q' - T(q) (u + W G^T mu) against q and u."""
    nq = len(s.q)
    for f in range(len(program.frames)):
        iq, iu = program.frames[f, 0], program.frames[f, 1]
        w = s.kin[iu + 3 : iu + 6]
        p = y[iq + 3 : iq + 7]
        square = p[0] ** 2 + p[1] ** 2 + p[2] ** 2 + p[3] ** 2
        kappa = s.length_rate[0]
        for i in range(3):
            n = _put(rows, columns, values, n, iq + i, iq + i, cj)
            for j in range(3):
                n = _put(rows, columns, values, n, iq + i, nq + iu + j, -R[f, i, j])
            for m in range(4):
                # d(R v) = R (dtheta x v), dtheta = 4 L^T dp
                value = 0.0
                for k in range(3):
                    a, b = (k + 1) % 3, (k + 2) % 3
                    value += R[f, i, k] * 4.0 * (L[f, m, a] * s.kin[iu + b] - L[f, m, b] * s.kin[iu + a])
                n = _put(rows, columns, values, n, iq + i, iq + 3 + m, -value)
        for i in range(4):
            for j in range(3):
                n = _put(rows, columns, values, n, iq + 3 + i, nq + iu + 3 + j, -L[f, i, j])
            for m in range(4):
                value = 2.0 * kappa * p[i] * p[m]
                if i == m:
                    value += cj - kappa * (1.0 - square)
                elif i == 0:
                    value += 0.5 * w[m - 1]
                elif m == 0:
                    value -= 0.5 * w[i - 1]
                else:
                    # -1/2 (p_vec x w): the sign of the permutation (i, m, other)
                    other = 6 - i - m
                    value += (0.5 if (m - i) % 3 == 2 else -0.5) * w[other - 1]
                n = _put(rows, columns, values, n, iq + 3 + i, iq + 3 + m, value)
    for v in range(len(program.vectors)):
        iq, iu, size = program.vectors[v, 0], program.vectors[v, 1], program.vectors[v, 2]
        for i in range(size):
            n = _put(rows, columns, values, n, iq + i, iq + i, cj)
            n = _put(rows, columns, values, n, iq + i, nq + iu + i, -1.0)
    for i in range(program.branches, nq):
        n = _put(rows, columns, values, n, i, i, 1.0)
    return n


@inner_kernel
def _turn_gradient(program, work, s, t):
    """Write d(G u + dg/dt)/dq of every entry of the block (lam, u) to `turning`, by differences.

    The corrections of positions by mu are not smaller in smaller steps, so this block decides about convergence.
    Bodies of one colour share no equation and are moved at once: six evaluations per colour, of markers and equations.
    """
    small = 1e-7
    n_bodies = len(program.place)
    d = np.zeros(len(s.u))
    rest = np.empty(len(s.lam))
    work.weights[0].wanted = 0
    run_kernels(program.place, 0, program, State(t, s.q, s.u, s.a, s.lam, s.signals), work)
    run_kernels(program.equations, n_bodies, program, State(t, s.q, s.u, s.a, s.lam, s.signals), work)
    constraint_velocity(work, s.u, rest)
    for colour in range(s.colours):
        for o in range(6):
            for j in range(len(d)):
                d[j] = 1.0 if s.colour[j] == colour and s.offset[j] == o else 0.0
            advance(program, s.q, d, small, s.near)
            state = State(t, s.near, s.u, s.a, s.lam, s.signals)
            run_kernels(program.place, 0, program, state, work)
            run_kernels(program.equations, n_bodies, program, state, work)
            constraint_velocity(work, s.u, s.speed)
            for e in range(len(s.gradient)):
                k, j = s.gradient[e, 1], s.gradient[e, 2]
                if d[j] != 0.0:
                    s.turning[e] = (s.speed[k] - rest[k]) / small


@kernel
def jacobian(program, work, s, t, cj, y, yp, rows, columns, values):
    """Write the entries of dF/dy + cj dF/dyp one after another and return their number.

    Left out is d(G^T mu)/dq: mu vanishes in the exact solution.
    """
    _unpack(program, s, y, yp)
    nq, nu, ng = len(s.q), len(s.u), len(s.lam)
    R = np.empty((len(program.frames), 3, 3))
    L = np.empty((len(program.frames), 4, 3))
    for f in range(len(program.frames)):
        iq = program.frames[f, 0]
        euler_to_matrix(s.q[iq + 3 : iq + 7], R[f])
        half_product(s.q[iq + 3 : iq + 7], L[f])
    _turn_gradient(program, work, s, t)
    state = State(t, s.q, s.u, s.a, s.lam, s.signals)
    weigh(work.weights, 0.0, stiffness=1.0)
    evaluate(program, state, work)
    s.K[:] = work.S
    weigh(work.weights, cj, damping=1.0)
    evaluate(program, state, work)
    s.kin[:] = s.u
    n = _put_kinematics(program, s, cj, y, R, L, rows, columns, values, 0)
    for e in range(len(s.own)):
        at, i, j = s.own[e, 0], s.own[e, 1], s.own[e, 2]
        n = _put(rows, columns, values, n, nq + i, nq + j, work.S[at])
        n = _put_row(s, R, L, nq + i, j, s.K[at], rows, columns, values, n)
    for e in range(len(s.transposed)):
        at, i, k = s.transposed[e, 0], s.transposed[e, 1], s.transposed[e, 2]
        n = _put(rows, columns, values, n, nq + i, nq + nu + k, work.S[at])
    lam, mu = nq + nu, nq + nu + ng
    for e in range(len(s.gradient)):
        at, k, j = s.gradient[e, 0], s.gradient[e, 1], s.gradient[e, 2]
        G = work.S[at]
        n = _put(rows, columns, values, n, lam + k, nq + j, G)
        n = _put_row(s, R, L, lam + k, j, s.turning[e], rows, columns, values, n)
        G *= s.held[k]
        n = _put_row(s, R, L, mu + k, j, G, rows, columns, values, n)
        # d(T W G^T mu)/dmu
        G *= -s.metric[j]
        f, o, c = s.frame_of[j], s.offset[j], s.coordinate[j]
        if f < 0:
            n = _put(rows, columns, values, n, c, mu + k, G)
        elif o < 3:
            for i in range(3):
                n = _put(rows, columns, values, n, c + i, mu + k, R[f, i, o] * G)
        else:
            for i in range(4):
                n = _put(rows, columns, values, n, c + 3 + i, mu + k, L[f, i, o - 3] * G)
    for k in range(ng):
        n = _put(rows, columns, values, n, lam + k, lam + k, s.yielding[0, k])
        n = _put(rows, columns, values, n, mu + k, mu + k, s.yielding[1, k] if s.held[k] == 1 else 1.0)
    for i in range(3):
        n = _put(rows, columns, values, n, mu + ng + i, mu + ng + i, cj)
    return n
