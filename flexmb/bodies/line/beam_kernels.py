"""Row kernels of beams with directors: markers on the section frame, inertia and elasticity, energies."""

from __future__ import annotations

import numpy as np

from flexmb.bodies.line.beam_element import ELEMENT, beam_element
from flexmb.bodies.line.director_frame import frame_stiffness, place_frame, spin_gradient
from flexmb.bodies.rows import HEADER, add_to_residual
from flexmb.math.kernel import inner_kernel
from flexmb.math.tables import row_kernel

__all__ = ["MARKER_SIZE", "ROW", "energy", "inertia", "place"]

ROW = np.dtype(
    [
        *HEADER,
        ("elements", np.int64),
        ("data", np.int64),  # elements in the bulk data
        ("geometry", np.int64),  # markers in the bulk data
        ("couplings", np.int64),  # of the elements' nodes, in work.rows
        ("gravity", float, 3),  # m/s2, in W
    ],
    align=True,
)

MARKER_SIZE = 14
"""Numbers per marker: first node, number of nodes, shape functions of the nodes (3), axes in the section frame (9)."""


@inner_kernel
def _directors(data, at, count, first, x, a, b):
    """Write both directors at a marker, sums over its nodes of coordinates or velocities x, to a, b (3,)."""
    for i in range(3):
        a[i], b[i] = 0.0, 0.0
        for k in range(count):
            a[i] += data[at + 2 + k] * x[first + 9 * k + 3 + i]
            b[i] += data[at + 2 + k] * x[first + 9 * k + 6 + i]


@inner_kernel
def _place_marker(marker, data, at, q, u, work):
    """Write the kinematics of one marker; `q`, `u` begin at its first node."""
    count = int(data[at + 1])
    a = np.empty(3)
    b = np.empty(3)
    da = np.empty(3)
    db = np.empty(3)
    _directors(data, at, count, 0, q, a, b)
    _directors(data, at, count, 0, u, da, db)
    for i in range(3):
        marker.r[i], marker.v[i] = 0.0, 0.0
        for k in range(count):
            marker.r[i] += data[at + 2 + k] * q[9 * k + i]
            marker.v[i] += data[at + 2 + k] * u[9 * k + i]
    E = np.empty((3, 3))
    length, across, along = place_frame(marker, a, b, da, db, data[at + 5 : at + 14], E)
    ga = np.empty(3)
    gb = np.empty(3)
    torque = np.empty(3)
    for i in range(3):
        # row i of the Jacobian is the force of a unit torque along axis i of W
        torque[0], torque[1], torque[2] = E[0, i], E[1, i], E[2, i]
        ga[:] = 0.0
        gb[:] = 0.0
        spin_gradient(E, length, across, along, torque, ga, gb)
        for k in range(count):
            top, bottom = marker.iJ + i * marker.nu + 9 * k, marker.iJ + (3 + i) * marker.nu + 9 * k
            work.J[top + i] = data[at + 2 + k]
            for j in range(3):
                work.J[bottom + 3 + j] = data[at + 2 + k] * ga[j]
                work.J[bottom + 6 + j] = data[at + 2 + k] * gb[j]


@row_kernel
def place(raw, data, state, work):
    """Position and section frame of every marker."""
    rows = raw.view(ROW)
    for n in range(rows.shape[0]):
        row = rows[n]
        for k in range(row.n_markers):
            marker = work.markers[row.marker + k]
            at = row.geometry + MARKER_SIZE * k
            first = 9 * int(data[at])
            q, u = state.q[row.iq + first :], state.u[row.iu + first :]
            _place_marker(marker, data, at, q, u, work)


@inner_kernel
def _row_start(row, work, e, m, n):
    """Return the place in work.rows of the rows of local node m in the columns of local node n, of element e."""
    if m == n:
        return row.iu + 9 * (2 * e + m)
    low, high = min(m, n), max(m, n)
    pair = low + high - 1  # (0, 1), (0, 2), (1, 2)
    return row.couplings + 54 * e + 18 * pair + (0 if m < n else 9)


@inner_kernel
def _add_marker_tangent(row, data, state, work, ck):
    """Add the derivative of the moments on section frames, by complex step."""
    a = np.empty(3)
    b = np.empty(3)
    H = np.empty((6, 6))
    for k in range(row.n_markers):
        moment = work.markers[row.marker + k].wrench[3:6]
        if moment[0] == 0.0 and moment[1] == 0.0 and moment[2] == 0.0:
            continue
        at = row.geometry + MARKER_SIZE * k
        node, count = int(data[at]), int(data[at + 1])
        e = min(node // 2, row.elements - 1)
        _directors(data, at, count, row.iq + 9 * node, state.q, a, b)
        frame_stiffness(a, b, moment, ck, H)
        for m in range(count):
            for n in range(count):
                f = data[at + 2 + m] * data[at + 2 + n]
                start = _row_start(row, work, e, node - 2 * e + m, node - 2 * e + n) + 3
                for i in range(6):
                    for j in range(6):
                        work.S[work.rows[start + i] + 3 + j] += f * H[i, j]


@inner_kernel
def _add_inertia(row, data, start, e, state, work, cm):
    """Add M (a - g) of element e to the residual, and cm M to the iteration matrix."""
    first = row.iu + 18 * e
    for m in range(3):
        for i in range(3):
            work.residual[first + 9 * m + i] -= data[start + 28 + m] * row.gravity[i]
        for n in range(3):
            at = _row_start(row, work, e, m, n)
            for v in range(3):
                mass = data[start + 1 + 9 * v + 3 * m + n]
                for i in range(3):
                    k = 3 * v + i
                    work.residual[first + 9 * m + k] += mass * state.a[first + 9 * n + k]
                    if cm != 0.0:
                        work.S[work.rows[at + k] + k] += cm * mass


@row_kernel
def inertia(raw, data, state, work):
    """M (a - g) + elastic and damping forces - marker loads; constant mass, no quadratic velocity terms."""
    rows = raw.view(ROW)
    f = np.empty(27)
    K = np.empty((27, 27))
    weights = work.weights[0]
    tangent = weights.wanted == 1
    for n in range(rows.shape[0]):
        row = rows[n]
        for e in range(row.elements):
            start = row.data + ELEMENT * e
            first = 18 * e
            q = state.q[row.iq + first : row.iq + first + 27]
            u = state.u[row.iu + first : row.iu + first + 27]
            ck, cd = (weights.stiffness, weights.damping) if tangent else (0.0, 0.0)
            _, power = beam_element(data, start, q, u, ck, cd, f, K)
            work.energy[0].dissipation += power
            for i in range(27):
                work.residual[row.iu + first + i] += f[i]
            _add_inertia(row, data, start, e, state, work, weights.mass if tangent else 0.0)
            if ck != 0.0 or cd != 0.0:
                for m in range(3):
                    for k in range(3):
                        at = _row_start(row, work, e, m, k)
                        for i in range(9):
                            for j in range(9):
                                work.S[work.rows[at + i] + j] += K[9 * m + i, 9 * k + j]
        for k in range(row.n_markers):
            marker = work.markers[row.marker + k]
            add_to_residual(work, marker.iu, marker)
        if tangent and weights.stiffness != 0.0:
            _add_marker_tangent(row, data, state, work, weights.stiffness)


@row_kernel
def energy(raw, data, state, work):
    """T = 1/2 u.M u, the strain energy of all elements, V = -sum of m_a g.r_a."""
    rows = raw.view(ROW)
    f = np.empty(27)
    K = np.empty((1, 1))
    rest = np.zeros(27)
    for n in range(rows.shape[0]):
        row = rows[n]
        for e in range(row.elements):
            start = row.data + ELEMENT * e
            first = 18 * e
            q = state.q[row.iq + first : row.iq + first + 27]
            u = state.u[row.iu + first : row.iu + first + 27]
            strain, _ = beam_element(data, start, q, rest, 0.0, 0.0, f, K)
            work.energy[0].strain += strain
            for m in range(3):
                for i in range(3):
                    work.energy[0].potential -= data[start + 28 + m] * row.gravity[i] * q[9 * m + i]
                for k in range(3):
                    for v in range(3):
                        for i in range(3):
                            work.energy[0].kinetic += (
                                0.5 * data[start + 1 + 9 * v + 3 * m + k] * u[9 * m + 3 * v + i] * u[9 * k + 3 * v + i]
                            )
