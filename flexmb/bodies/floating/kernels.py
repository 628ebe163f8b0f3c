"""Kernels of a floating body: its markers, its equations of motion with their tangent, its energy."""

from __future__ import annotations

import numpy as np

from flexmb.bodies.floating.inertia import (
    add_inertia,
    add_inertia_damping,
    add_inertia_stiffness,
    mass_matrix,
    rates,
)
from flexmb.bodies.floating.loads import add_loads, add_loads_tangent
from flexmb.bodies.floating.markers import add_marker_stiffness, loaded, place_flexible_marker
from flexmb.bodies.floating.row import ROW, geometry, invariants, mean_motion, stiffness_matrices
from flexmb.bodies.floating.stiffness import add_stiffening, add_stiffening_tangent, load_scales, mean_acceleration
from flexmb.bodies.rows import add_own_block, add_to_residual
from flexmb.math.kernel import inner_kernel
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import add_combination, cross, matvec_t

__all__ = ["energy", "inertia", "place"]


@row_kernel
def place(raw, data, state, work):
    """Write the kinematics of all markers of floating bodies."""
    rows = raw.view(ROW)
    R = np.empty((3, 3))
    vectors = np.empty((12, 3))
    matrices = np.empty((4, 3, 3))
    for n in range(rows.shape[0]):
        row = rows[n]
        m = row.modes
        q = state.q[row.iq : row.iq + 7 + m]
        u = state.u[row.iu : row.iu + 6 + m]
        euler_to_matrix(q[3:7], R)
        for k in range(row.n_markers):
            at = row.geometry + k * (12 + 6 * m)
            place_flexible_marker(work.markers[row.marker + k], work.J, q, u, R, m, data, at, vectors, matrices)


@inner_kernel
def _elastic(K, D, eta, rate, work, residual):
    """Add K eta + D eta'; add to the rate of dissipation."""
    m = len(eta)
    add_combination(eta, K, residual[6:])  # K is symmetric
    for i in range(m):
        damping = 0.0
        for j in range(m):
            damping += D[i, j] * rate[j]
        residual[6 + i] += damping
        work.energy[0].dissipation += damping * rate[i]


@inner_kernel
def _add_step_term(M, u, weights, B):
    """Add h/2 M ad(u): the variation at the end of a step against the increment over it (theory: integrators).

    Where steps translate in world axes, cd takes the place of h/2 in what translations have of it, see `RigidBody`.
    """
    cd, half = weights.damping, weights.half_step
    turning, shifted = (-cd, cd) if weights.world_axes == 1 else (half, half)
    v = u[0:3]
    w = u[3:6]
    e = np.zeros(3)
    a = np.empty(3)
    b = np.empty(3)
    for i in range(3):
        e[:] = 0.0
        e[i] = 1.0
        cross(w, e, a)
        cross(v, e, b)
        for k in range(M.shape[0]):
            for c in range(3):
                B[k, i] += turning * M[k, c] * a[c]
                B[k, 3 + i] += shifted * M[k, c] * b[c] + half * M[k, 3 + c] * a[c]


@inner_kernel
def _add_gravity_stiffness(M, fall, scale, B):
    """Add what gravity adds to the stiffness, as it turns backwards in body axes: -M[:, :3] fall~."""
    for i in range(len(M)):
        for j in range(3):
            a, b = (j + 1) % 3, (j + 2) % 3
            B[i, 3 + j] -= scale * (M[i, a] * fall[b] - M[i, b] * fall[a])


@inner_kernel
def _add_load_stiffness(row, data, state, work, R, B):
    """Add the stiffness that the loads at markers give to the body."""
    m = row.modes
    q = state.q[row.iq : row.iq + 7 + m]
    for k in range(row.n_markers):
        wrench = work.markers[row.marker + k].wrench
        if loaded(wrench):
            r, _, translation, rotation = geometry(data, row.geometry, k, m)
            add_marker_stiffness(B, work.weights[0].stiffness, R, q, m, r, translation, rotation, wrench)


@row_kernel
def inertia(raw, data, state, work):
    """Inertia, velocity terms, gravity, elasticity, geometric stiffness and marker loads, with the tangent."""
    rows = raw.view(ROW)
    weights = work.weights[0]
    R = np.empty((3, 3))
    fall = np.empty(3)
    vwd, wwd = np.empty((3, 3)), np.empty(6)
    acceleration = np.empty(6)
    for n in range(rows.shape[0]):
        row = rows[n]
        m, iu = row.modes, row.iu
        size = 6 + m
        eta = state.q[row.iq + 7 : row.iq + 7 + m]
        u = state.u[iu : iu + size]
        residual = work.residual[iu : iu + size]
        terms = invariants(data, row.mass, m)
        K, D, shapes, turning, G = stiffness_matrices(data, row.elastic, m, row.loads, row.turning, row.stiffening)
        mean = mean_motion(data, row.mass, m)
        M, W = np.empty((size, size)), np.empty((m, 6))
        wnd, swing = np.empty((3, m)), np.empty((m, 3))
        A, P = np.empty(size), np.empty(size)
        euler_to_matrix(state.q[row.iq + 3 : row.iq + 7], R)
        matvec_t(R, row.gravity, fall)
        for i in range(size):
            A[i] = state.a[iu + i]
        for i in range(3):
            A[i] -= fall[i]
        mass_matrix(terms, eta, M, W)
        rates(terms, W, u, wnd, vwd, wwd, swing)
        add_inertia(terms, M, W, u, A, wnd, vwd, wwd, swing, P, residual)
        _elastic(K, D, eta, u[6:], work, residual)
        add_loads(shapes, turning, eta, u, row.first_load, work.loads, work.energy, residual)
        s, g = np.empty(row.stiffening), np.empty((row.stiffening, m))
        if row.stiffening > 0:
            mean_acceleration(mean, A, acceleration)
            wrenches = work.markers[row.marker : row.marker + row.interfaces]
            load_scales(u, acceleration, R, wrenches, work.loads[row.first_load : row.first_load + row.loads], s)
            add_stiffening(G, s, eta, g, residual[6:])
        for k in range(row.n_markers):
            add_to_residual(work, iu, work.markers[row.marker + k])
        if weights.wanted == 0:
            continue
        B = weights.mass * M
        if weights.damping != 0.0:
            add_inertia_damping(terms, M, W, u, wnd, vwd, wwd, swing, P, weights.damping, B)
            _add_step_term(M, u, weights, B)
        if weights.stiffness != 0.0:
            add_inertia_stiffness(terms, W, u, A, swing, weights.stiffness, B)
            _add_gravity_stiffness(M, fall, weights.stiffness, B)
            _add_load_stiffness(row, data, state, work, R, B)
        for i in range(m):
            for j in range(m):
                B[6 + i, 6 + j] += weights.stiffness * K[i, j] + weights.damping * D[i, j]
        add_loads_tangent(turning, row.loads, row.first_load, work.loads, weights.stiffness, B)
        if row.stiffening > 0:
            wrenches = work.markers[row.marker : row.marker + row.interfaces]
            add_stiffening_tangent(G, s, g, mean, u, R, fall, weights, B, wrenches, work.H)
        add_own_block(work, iu, B, size)


@row_kernel
def energy(raw, data, state, work):
    """T = 1/2 u.P, V = 1/2 eta.K eta - m g.(r + R c(eta))."""
    rows = raw.view(ROW)
    R = np.empty((3, 3))
    fall = np.empty(3)
    for n in range(rows.shape[0]):
        row = rows[n]
        m = row.modes
        eta = state.q[row.iq + 7 : row.iq + 7 + m]
        u = state.u[row.iu : row.iu + 6 + m]
        terms = invariants(data, row.mass, m)
        vv, vw0, vn = terms[0], terms[1], terms[3]
        M, W = np.empty((6 + m, 6 + m)), np.empty((m, 6))
        mass_matrix(terms, eta, M, W)
        for i in range(6 + m):
            for j in range(6 + m):
                work.energy[0].kinetic += 0.5 * u[i] * M[i, j] * u[j]
        K, _, _, _, _ = stiffness_matrices(data, row.elastic, m, row.loads, row.turning, row.stiffening)
        for i in range(m):
            for j in range(m):
                work.energy[0].strain += 0.5 * eta[i] * K[i, j] * eta[j]
        euler_to_matrix(state.q[row.iq + 3 : row.iq + 7], R)
        matvec_t(R, row.gravity, fall)
        # first moment of mass, m c = (M_vw)_zy and cyclic, plus the modes'
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            moment = vw0[a, b]
            for j in range(m):
                moment += vn[i, j] * eta[j]
            work.energy[0].potential -= fall[i] * moment
            work.energy[0].potential -= vv[i, i] * row.gravity[i] * state.q[row.iq + i]
