"""Row kernels of cables: markers on the centre line, inertia and elasticity with the exact tangent, energies."""

from __future__ import annotations

import numpy as np

from flexmb.bodies.line.cable_element import ELEMENT, cable_element
from flexmb.bodies.line.tangent_frame import add_frame_stiffness, tangent_frame
from flexmb.bodies.rows import HEADER, add_to_residual
from flexmb.math.kernel import inner_kernel
from flexmb.math.tables import row_kernel

__all__ = ["MARKER_SIZE", "ROW", "energy", "inertia", "place"]

ROW = np.dtype(
    [
        *HEADER,
        ("elements", np.int64),
        ("nodes", np.int64),
        ("data", np.int64),  # elements in the bulk data
        ("geometry", np.int64),  # markers in the bulk data
        ("couplings", np.int64),  # of the elements' nodes, in work.rows
        ("gravity", float, 3),  # m/s2, in W
    ],
    align=True,
)

MARKER_SIZE = 22
"""Numbers per marker: first and second node (2), coefficients of r and r' on (r_a, r'_a, r_b, r'_b) (8), direction of
reference (3), axes in the tangent frame (9)."""


@inner_kernel
def _interpolate(x, first, data, at, a, b, out):
    """Write the sum of the four coefficients times the vectors of the nodes a and b, from x[first:], to `out`."""
    for i in range(3):
        out[i] = (
            data[at] * x[first + 6 * a + i]
            + data[at + 1] * x[first + 6 * a + 3 + i]
            + data[at + 2] * x[first + 6 * b + i]
            + data[at + 3] * x[first + 6 * b + 3 + i]
        )


@row_kernel
def place(raw, data, state, work):
    """Position and tangent frame of every marker: r = N q, w = B(r') N' u."""
    rows = raw.view(ROW)
    rho = np.empty(3)
    rate = np.empty(3)
    B = np.empty((3, 3))
    for n in range(rows.shape[0]):
        row = rows[n]
        for k in range(row.n_markers):
            marker = work.markers[row.marker + k]
            at = row.geometry + MARKER_SIZE * k
            a, b = int(data[at]), int(data[at + 1])
            _interpolate(state.q, row.iq, data, at + 2, a, b, marker.r)
            _interpolate(state.u, row.iu, data, at + 2, a, b, marker.v)
            _interpolate(state.q, row.iq, data, at + 6, a, b, rho)
            _interpolate(state.u, row.iu, data, at + 6, a, b, rate)
            axes = data[at + 13 : at + 22].reshape((3, 3))
            tangent_frame(data[at + 10 : at + 13], axes, rho, rate, marker.R, marker.w, marker.bias[3:6], B)
            for s in range(4):
                node = a if s < 2 else b
                if data[at + 2 + s] == 0.0 and data[at + 6 + s] == 0.0:
                    continue
                column = marker.iJ + row.iu + 6 * node + 3 * (s % 2) - marker.iu
                for i in range(3):
                    for j in range(3):
                        work.J[column + i * marker.nu + j] = data[at + 2 + s] if i == j else 0.0
                        work.J[column + (3 + i) * marker.nu + j] = data[at + 6 + s] * B[i, j]


@inner_kernel
def _entry(row, rows, e, s, t):
    """Return the coupling's first place in work.rows for the vectors s and t of element e, and the column in it."""
    a, b = e, (e + 1) % row.nodes
    if s // 2 == t // 2:
        return row.iu + 6 * (a if s < 2 else b) + 3 * (s % 2), 3 * (t % 2)
    return row.couplings + 12 * e + (0 if s < 2 else 6) + 3 * (s % 2), 3 * (t % 2)


@inner_kernel
def _add_element_matrix(row, work, element, e, K, cm):
    """Add the mass and stiffness of element e to the iteration matrix; K (9, 9) belongs to (d, r'_a, r'_b)."""
    S, rows, inverse = work.S, work.rows, 1.0 / element[0]
    a, b, coupling = row.iu + 6 * e, row.iu + 6 * ((e + 1) % row.nodes), row.couplings + 12 * e
    for i in range(3):
        # rows of r_a, r'_a, r_b, r'_b: in the block of their own node, and in the other's
        ra, ta, rb, tb = S[rows[a + i] :][:6], S[rows[a + 3 + i] :][:6], S[rows[b + i] :][:6], S[rows[b + 3 + i] :][:6]
        rab, tab = S[rows[coupling + i] :][:6], S[rows[coupling + 3 + i] :][:6]
        rba, tba = S[rows[coupling + 6 + i] :][:6], S[rows[coupling + 9 + i] :][:6]
        for j in range(3):
            dd, da, db = K[i, j] * inverse * inverse, K[i, 3 + j] * inverse, K[i, 6 + j] * inverse
            ad, bd = K[3 + i, j] * inverse, K[6 + i, j] * inverse
            ra[j] += dd
            ra[3 + j] -= da
            rab[j] -= dd
            rab[3 + j] -= db
            ta[j] -= ad
            ta[3 + j] += K[3 + i, 3 + j]
            tab[j] += ad
            tab[3 + j] += K[3 + i, 6 + j]
            rba[j] -= dd
            rba[3 + j] += da
            rb[j] += dd
            rb[3 + j] += db
            tba[j] -= bd
            tba[3 + j] += K[6 + i, 3 + j]
            tb[j] += bd
            tb[3 + j] += K[6 + i, 6 + j]
        for t in range(2):
            ra[3 * t + i] += cm * element[1 + t]
            rab[3 * t + i] += cm * element[3 + t]
            ta[3 * t + i] += cm * element[5 + t]
            tab[3 * t + i] += cm * element[7 + t]
            rba[3 * t + i] += cm * element[9 + t]
            rb[3 * t + i] += cm * element[11 + t]
            tba[3 * t + i] += cm * element[13 + t]
            tb[3 * t + i] += cm * element[15 + t]


@inner_kernel
def _add_marker_tangent(row, data, state, work, ck):
    """Add the derivative of the moments on tangent frames."""
    rho = np.empty(3)
    block = np.empty((3, 3))
    for k in range(row.n_markers):
        marker = work.markers[row.marker + k]
        moment = marker.wrench[3:6]
        if moment[0] == 0.0 and moment[1] == 0.0 and moment[2] == 0.0:
            continue
        at = row.geometry + MARKER_SIZE * k
        a, b = int(data[at]), int(data[at + 1])
        e = a if (a + 1) % row.nodes == b else b
        _interpolate(state.q, row.iq, data, at + 6, a, b, rho)
        block[:] = 0.0
        add_frame_stiffness(data[at + 10 : at + 13], rho, moment, ck, block)
        for s in range(4):
            for t in range(4):
                f = data[at + 6 + s] * data[at + 6 + t]
                if f != 0.0:
                    first, column = _entry(row, work.rows, e, s, t)
                    for i in range(3):
                        for j in range(3):
                            work.S[work.rows[first + i] + column + j] += f * block[i, j]


@inner_kernel
def _add_element_forces(row, state, work, element, a, b, f):
    """Add the elastic forces f of (d, r'_a, r'_b) and M (a - g) of an element with the nodes at a and b."""
    L, mass = element[0], element[1:]
    at_a, at_b = work.residual[row.iu + a :][:6], work.residual[row.iu + b :][:6]
    a_a, a_b = state.a[row.iu + a :][:6], state.a[row.iu + b :][:6]
    for i in range(3):
        # a line that translates has no gradients: the weight is M times g at both nodes
        w, x, y, z = a_a[i] - row.gravity[i], a_a[3 + i], a_b[i] - row.gravity[i], a_b[3 + i]
        at_a[i] += mass[0] * w + mass[1] * x + mass[2] * y + mass[3] * z - f[i] / L
        at_a[3 + i] += mass[4] * w + mass[5] * x + mass[6] * y + mass[7] * z + f[3 + i]
        at_b[i] += mass[8] * w + mass[9] * x + mass[10] * y + mass[11] * z + f[i] / L
        at_b[3 + i] += mass[12] * w + mass[13] * x + mass[14] * y + mass[15] * z + f[6 + i]


@inner_kernel
def _gather(values, first, a, b, L, z):
    """Write d = (r_b - r_a) / L, r'_a, r'_b of the nodes at a and b, or their rates, to z (3, 3)."""
    x, y = values[first + a :][:6], values[first + b :][:6]
    for i in range(3):
        z[0, i] = (y[i] - x[i]) / L
        z[1, i] = x[3 + i]
        z[2, i] = y[3 + i]


@row_kernel
def inertia(raw, data, state, work):
    """M (a - g) + elastic and damping forces - marker loads; constant mass, no quadratic velocity terms."""
    rows = raw.view(ROW)
    z = np.empty((3, 3))
    rate = np.empty((3, 3))
    f = np.empty(9)
    K = np.empty((9, 9))
    scratch = np.empty((29, 9))
    weights = work.weights[0]
    tangent = weights.wanted == 1
    ck, cd = (weights.stiffness, weights.damping) if tangent else (0.0, 0.0)
    for n in range(rows.shape[0]):
        row = rows[n]
        for e in range(row.elements):
            element = data[row.data + ELEMENT * e :][:ELEMENT]
            a, b = 6 * e, 6 * ((e + 1) % row.nodes)
            _gather(state.q, row.iq, a, b, element[0], z)
            _gather(state.u, row.iu, a, b, element[0], rate)
            if tangent and ck == 0.0:
                K[:] = 0.0
            _, power = cable_element(element, z, rate, ck, cd, f, K, scratch)
            work.energy[0].dissipation += power
            _add_element_forces(row, state, work, element, a, b, f)
            if tangent:
                _add_element_matrix(row, work, element, e, K, weights.mass)
        for k in range(row.n_markers):
            marker = work.markers[row.marker + k]
            add_to_residual(work, marker.iu, marker)
        if tangent and weights.stiffness != 0.0:
            _add_marker_tangent(row, data, state, work, weights.stiffness)


@row_kernel
def energy(raw, data, state, work):
    """T = 1/2 u.M u, the strain energy of all elements, V = -sum of m_a g.q_a."""
    rows = raw.view(ROW)
    z = np.empty((3, 3))
    rest = np.zeros((3, 3))
    f = np.empty(9)
    K = np.empty((9, 9))
    scratch = np.empty((29, 9))
    for n in range(rows.shape[0]):
        row = rows[n]
        for e in range(row.elements):
            start = row.data + ELEMENT * e
            a, b = 6 * e, 6 * ((e + 1) % row.nodes)
            _gather(state.q, row.iq, a, b, data[start], z)
            strain, _ = cable_element(data[start : start + ELEMENT], z, rest, 0.0, 0.0, f, K, scratch)
            work.energy[0].strain += strain
            for s in range(4):
                target = (a if s < 2 else b) + 3 * (s % 2)
                for i in range(3):
                    work.energy[0].potential -= data[start + 17 + s] * row.gravity[i] * state.q[row.iq + target + i]
                    for t in range(4):
                        source = (a if t < 2 else b) + 3 * (t % 2)
                        work.energy[0].kinetic += (
                            0.5
                            * data[start + 1 + 4 * s + t]
                            * state.u[row.iu + target + i]
                            * state.u[row.iu + source + i]
                        )
