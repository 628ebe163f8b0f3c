"""Row kernels of plates: markers on the surface, inertia and elasticity with the exact tangent, energies."""

from __future__ import annotations

import numpy as np

from flexmb.bodies.line.director_frame import frame_stiffness, place_frame, spin_gradient
from flexmb.bodies.plate.element import HEAD, add_pressure, plate_element
from flexmb.bodies.rows import HEADER, add_to_residual
from flexmb.math.kernel import inner_kernel
from flexmb.math.tables import row_kernel

__all__ = ["ROW", "energy", "inertia", "place"]

ROW = np.dtype(
    [
        *HEADER,
        ("vectors", np.int64),  # per node: 3 (r, r_s, r_t) or 2 (r, d)
        ("elements", np.int64),
        ("size", np.int64),  # numbers per element in the bulk data
        ("data", np.int64),  # elements in the bulk data
        ("geometry", np.int64),  # markers in the bulk data: where each begins, then the markers
        ("couplings", np.int64),  # of pairs of nodes, in work.rows
        ("first_load", np.int64),  # pressure along the normal, then dead loads along x, y, z of W
        ("poisson", float),
        ("damping", float),  # s
        ("gravity", float, 3),  # m/s2, in W
    ],
    align=True,
)


@inner_kernel
def _sums(data, at, vectors, count, first, x, p, a, b):
    """Write position and the two directions of a marker, sums over its nodes of coordinates or velocities x."""
    p[:] = 0.0
    a[:] = 0.0
    b[:] = 0.0
    stride = 1 + 3 * vectors
    for k in range(count):
        node = int(data[at + stride * k])
        for v in range(vectors):
            w = at + stride * k + 1 + 3 * v
            source = first + 3 * (vectors * node + v)
            for i in range(3):
                p[i] += data[w] * x[source + i]
                a[i] += data[w + 1] * x[source + i]
                b[i] += data[w + 2] * x[source + i]


@inner_kernel
def _place_marker(marker, data, at, vectors, q, u, work):
    """Write the kinematics of one marker; `q`, `u` begin at its first node."""
    count = int(data[at + 1])
    a = np.empty(3)
    b = np.empty(3)
    da = np.empty(3)
    db = np.empty(3)
    _sums(data, at + 11, vectors, count, 0, q, marker.r, a, b)
    _sums(data, at + 11, vectors, count, 0, u, marker.v, da, db)
    E = np.empty((3, 3))
    length, across, along = place_frame(marker, b, a, db, da, data[at + 2 : at + 11], E)
    ga = np.empty(3)
    gb = np.empty(3)
    torque = np.empty(3)
    stride = 1 + 3 * vectors
    for i in range(3):
        # row i of the Jacobian is the force of a unit torque along axis i of W
        torque[0], torque[1], torque[2] = E[0, i], E[1, i], E[2, i]
        ga[:] = 0.0
        gb[:] = 0.0
        spin_gradient(E, length, across, along, torque, gb, ga)
        for k in range(count):
            node = int(data[at + 11 + stride * k])
            for v in range(vectors):
                weight = at + 11 + stride * k + 1 + 3 * v
                column = marker.iJ + 3 * (vectors * node + v)
                work.J[column + i * marker.nu + i] = data[weight]
                for j in range(3):
                    work.J[column + (3 + i) * marker.nu + j] = data[weight + 1] * ga[j] + data[weight + 2] * gb[j]


@row_kernel
def place(raw, data, state, work):
    """Position and frame of every marker."""
    rows = raw.view(ROW)
    for n in range(rows.shape[0]):
        row = rows[n]
        for k in range(row.n_markers):
            marker = work.markers[row.marker + k]
            at = row.geometry + int(data[row.geometry + k])
            first = 3 * row.vectors * int(data[at])
            _place_marker(marker, data, at, row.vectors, state.q[row.iq + first :], state.u[row.iu + first :], work)


@inner_kernel
def _row_start(row, data, at):
    """Return where in work.rows a node's rows begin in the columns of another one."""
    stored = int(data[at])
    return row.iu - 3 * row.vectors * (stored + 1) if stored < 0 else row.couplings + stored


@inner_kernel
def _add_marker_tangent(row, data, state, work, ck):
    """Add the derivative of the moments on marker frames, by complex step."""
    p = np.empty(3)
    a = np.empty(3)
    b = np.empty(3)
    H = np.empty((6, 6))
    for k in range(row.n_markers):
        moment = work.markers[row.marker + k].wrench[3:6]
        if moment[0] == 0.0 and moment[1] == 0.0 and moment[2] == 0.0:
            continue
        at = row.geometry + int(data[row.geometry + k])
        _sums(data, at + 11, row.vectors, int(data[at + 1]), row.iq + 3 * row.vectors * int(data[at]), state.q, p, a, b)
        frame_stiffness(b, a, moment, ck, H)
        _spread(row, data, at, H, work)


@inner_kernel
def _spread(row, data, at, H, work):
    """Add the matrix H (6, 6) of the two directions of a marker, the second first, to its nodes' matrix."""
    count, vectors = int(data[at + 1]), row.vectors
    stride = 1 + 3 * vectors
    table = at + 11 + stride * count
    for m in range(count):
        for n in range(count):
            start = _row_start(row, data, table + count * m + n)
            for v in range(vectors):
                left = at + 11 + stride * m + 2 + 3 * v
                for w in range(vectors):
                    right = at + 11 + stride * n + 2 + 3 * w
                    for i in range(3):
                        target = work.rows[start + 3 * v + i] + 3 * w
                        for j in range(3):
                            for s in range(2):
                                for t in range(2):
                                    work.S[target + j] += (
                                        data[left + s] * data[right + t] * H[3 * (1 - s) + i, 3 * (1 - t) + j]
                                    )


@inner_kernel
def _gather(row, data, start, first, source, out):
    """Copy the vectors of an element's nodes from `source`, beginning at `first`, to `out` (V, 3)."""
    vectors = row.vectors
    for k in range(4):
        node = first + 3 * vectors * int(data[start + k])
        for v in range(vectors):
            for i in range(3):
                out[vectors * k + v, i] = source[node + 3 * v + i]


@inner_kernel
def _add_inertia(row, data, start, a, cm, f, K):
    """Add M (a - g) to f, and cm M to K."""
    V = a.shape[0]
    for s in range(V):
        moment = data[start + HEAD + V * V + s]
        for i in range(3):
            f[s, i] -= moment * row.gravity[i]
        for t in range(V):
            mass = data[start + HEAD + V * s + t]
            for i in range(3):
                f[s, i] += mass * a[t, i]
            if cm != 0.0:
                for i in range(3):
                    K[3 * s + i, 3 * t + i] += cm * mass


@inner_kernel
def _add_loads(row, data, start, q, u, work, ck, f, K):
    """Subtract pressure and dead loads per area as drawn from f; add to the power of loads."""
    V = q.shape[0]
    before = f.copy()
    pressure = work.loads[row.first_load]
    if pressure != 0.0:
        add_pressure(data, start, pressure, q, ck, f, K)
    for i in range(3):
        amount = work.loads[row.first_load + 1 + i]
        if amount != 0.0:
            for s in range(V):
                f[s, i] -= amount * data[start + HEAD + V * V + V + s]
    for s in range(V):
        for i in range(3):
            work.energy[0].load_power += (before[s, i] - f[s, i]) * u[s, i]


@inner_kernel
def _scatter(row, data, start, f, K, tangent, work):
    """Add f and K of an element to residual and matrix."""
    size = 3 * row.vectors
    for m in range(4):
        target = row.iu + size * int(data[start + m])
        for i in range(size):
            work.residual[target + i] += f[row.vectors * m + i // 3, i % 3]
        if tangent:
            for n in range(4):
                at = _row_start(row, data, start + 4 + 4 * m + n)
                for i in range(size):
                    to = work.rows[at + i]
                    for j in range(size):
                        work.S[to + j] += K[size * m + i, size * n + j]


@row_kernel
def inertia(raw, data, state, work):
    """M (a - g) + elastic and damping forces - loads; constant mass, no quadratic velocity terms."""
    rows = raw.view(ROW)
    weights = work.weights[0]
    tangent = weights.wanted == 1
    cm, cd, ck = (weights.mass, weights.damping, weights.stiffness) if tangent else (0.0, 0.0, 0.0)
    for n in range(rows.shape[0]):
        row = rows[n]
        V = 4 * row.vectors
        q = np.empty((V, 3))
        u = np.empty((V, 3))
        a = np.empty((V, 3))
        f = np.empty((V, 3))
        K = np.zeros((3 * V, 3 * V))
        for e in range(row.elements):
            start = row.data + row.size * e
            _gather(row, data, start, row.iq, state.q, q)
            _gather(row, data, start, row.iu, state.u, u)
            _gather(row, data, start, row.iu, state.a, a)
            K[:] = 0.0
            _, power = plate_element(data, start, row.poisson, row.damping, q, u, ck, cd, f, K)
            work.energy[0].dissipation += power
            _add_loads(row, data, start, q, u, work, ck, f, K)
            _add_inertia(row, data, start, a, cm, f, K)
            _scatter(row, data, start, f, K, tangent, work)
        for k in range(row.n_markers):
            marker = work.markers[row.marker + k]
            add_to_residual(work, marker.iu, marker)
        if ck != 0.0:
            _add_marker_tangent(row, data, state, work, ck)


@row_kernel
def energy(raw, data, state, work):
    """T = 1/2 u.M u, the strain energy of all elements, V = -sum of m_s g.q_s."""
    rows = raw.view(ROW)
    K = np.empty((1, 1))
    for n in range(rows.shape[0]):
        row = rows[n]
        V = 4 * row.vectors
        q = np.empty((V, 3))
        u = np.empty((V, 3))
        f = np.empty((V, 3))
        rest = np.zeros((V, 3))
        for e in range(row.elements):
            start = row.data + row.size * e
            _gather(row, data, start, row.iq, state.q, q)
            _gather(row, data, start, row.iu, state.u, u)
            strain, _ = plate_element(data, start, row.poisson, row.damping, q, rest, 0.0, 0.0, f, K)
            work.energy[0].strain += strain
            for s in range(V):
                for i in range(3):
                    work.energy[0].potential -= data[start + HEAD + V * V + s] * row.gravity[i] * q[s, i]
                    for t in range(V):
                        work.energy[0].kinetic += 0.5 * data[start + HEAD + V * s + t] * u[s, i] * u[t, i]
