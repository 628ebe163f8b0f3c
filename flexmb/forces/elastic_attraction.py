"""The attraction of a body of some size: a field over the moments of its mass, rigid or elastic.

With phi the potential of the field at the body's frame, g, H and T its first three derivatives in body axes, s(eta) the
first and J(eta) the second moments of mass about the frame, the potential is exact to second order in the size of the
body (Hughes 1986, chapter 8; the trace of H is zero in vacuum):

    V = m phi + s . g - J : H / 2.

s is linear and J quadratic in eta, both known from the reduction (theory: floating frame), so the forces on all
coordinates, -dV, cost nothing that grows with the mesh. The uniform part of the field is taken relative to an
origin that falls.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.forces.attraction import inertia_of
from flexmb.forces.rows import require_center_of_mass
from flexmb.math.harmonic_field import fourth, hessian, third
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.tables import STIFF
from flexmb.math.vectors import cross
from flexmb.model.kinds import Force

__all__ = ["BodyAttraction", "act_elastic", "attract_elastic", "attracted_row"]


def moments_of(data) -> np.ndarray:
    """Return mass, s (3,), its rates (3, m), J (3, 3), its linear (m, 3, 3) and quadratic part (m, m, 3, 3), flat."""
    i = data.invariants
    m = data.n_modes
    second = 0.5 * (i.ww2 + np.swapaxes(i.ww2, 0, 1)) if m else np.zeros((0, 0, 3, 3))
    arrays = [
        [i.vv[0, 0]],
        np.asarray(data.center_of_mass) * i.vv[0, 0],
        i.vn,
        _symmetric(i.ww0),
        _symmetric(i.ww1),
        _symmetric(second),
    ]
    return np.concatenate([np.asarray(a, float).ravel() for a in arrays])


def attracted_row(compiler, name: str, source: int | None = None) -> dict[str, Any]:
    """Return the fields of a row that say what is attracted: `modes` is -1 for a rigid body or point.

    `source` is the number of the marker from which a rigid body's place counts, if there is one.
    """
    body = compiler.model.body(name)
    reduced = body.reduced
    if reduced is not None:
        row = {"marker": compiler.marker(f"{name}.{next(iter(body.marker_poses()))}"), "pair": 0}
        row |= {"mass": float(reduced.mass), "inertia": np.zeros((3, 3)), "modes": reduced.n_modes}
        return row | {"iq": compiler.coordinate(name), "moments": compiler.bulk(moments_of(reduced))}
    marker, mass, inertia = compiler.marker(f"{name}.center"), float(body.mass), inertia_of(body)
    pair = compiler.pair(marker if source is None else source, marker, STIFF)
    row = {"marker": marker, "pair": pair, "mass": mass, "inertia": inertia, "modes": -1, "iq": 0}
    return row | {"moments": compiler.bulk(np.concatenate([[mass], np.zeros(3), _symmetric(inertia).ravel()]))}


def _symmetric(J) -> np.ndarray:
    return 0.5 * (np.asarray(J) + np.swapaxes(np.asarray(J), -1, -2))


def _require_unstiffened(force, model) -> None:
    """Raise ModelError if inertia loads stiffen the body that a force attracts."""
    body = model.body(force.body)
    if body.reduced is not None and "inertia" in body.stiffening_groups and body.reduced.geometric is not None:
        raise ModelError(
            force.title,
            found=f"'{force.body}', whose inertia loads stiffen it",
            expected="a body without stiffening by inertia loads: free fall loads nothing, and the "
            "acceleration of the frame would count as a load",
            remedy=f"Give '{force.body}' geometric_stiffness=('interface', 'loads', 'preload'), or False",
        )


@inner_kernel
def _contract(A, B):
    total = 0.0
    for i in range(3):
        for j in range(3):
            total += A[i, j] * B[i, j]
    return total


@inner_kernel
def _add_moment(J, H, out):
    """Add the moment epsilon_ijk (J H)_jk."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        for m in range(3):
            out[i] += J[j, m] * H[m, k] - J[k, m] * H[m, j]


@inner_kernel
def _add_force(H, T, s, J, out):
    """Add -H s + T : J / 2."""
    for i in range(3):
        out[i] += 0.5 * _contract(T[i], J) - H[i, 0] * s[0] - H[i, 1] * s[1] - H[i, 2] * s[2]


@inner_kernel
def _turned(H, T, c, dH, dT):
    """Write the changes of second and third derivatives in axes that turn about their axis c: each index as v x e_c."""
    i, j = (c + 1) % 3, (c + 2) % 3  # v x e_c has +v_j at i and -v_i at j
    dH[:], dT[:] = 0.0, 0.0
    for a in range(3):
        dH[i, a] += H[j, a]
        dH[j, a] -= H[i, a]
        dH[a, i] += H[a, j]
        dH[a, j] -= H[a, i]
        for b in range(3):
            dT[i, a, b] += T[j, a, b]
            dT[j, a, b] -= T[i, a, b]
            dT[a, i, b] += T[a, j, b]
            dT[a, j, b] -= T[a, i, b]
            dT[a, b, i] += T[a, b, j]
            dT[a, b, j] -= T[a, b, i]


@kernel
def attract_elastic(data, m, eta, P, uniform, wanted, Q, K):
    """Set the forces Q (6 + m,) in body axes and, if wanted, their derivatives K by place, turn and eta; return V.

    P holds the derivatives of the potential at the frame, `uniform` (3,) is the acceleration there that counts, both in
    body axes.
    """
    mass, s0, vn = data[0], data[1:4], data[4 : 4 + 3 * m].reshape((3, m))
    a = 4 + 3 * m
    J0, a = data[a : a + 9].reshape((3, 3)), a + 9
    J1, a = data[a : a + 9 * m].reshape((m, 3, 3)), a + 9 * m
    J2 = data[a : a + 9 * m * m].reshape((m, m, 3, 3))
    s, J, W = s0.copy(), J0.copy(), J1.copy()
    for j in range(m):
        for i in range(3):
            s[i] += vn[i, j] * eta[j]
        for k in range(m):
            W[j] += 2.0 * eta[k] * J2[j, k]
        J += 0.5 * eta[j] * (J1[j] + W[j])
    H, T = np.empty((3, 3)), np.empty((3, 3, 3))
    hessian(P, H)
    third(P, T)
    part = np.empty(3)
    cross(s, uniform, part)
    V = mass * P[0, 0, 0] + s[0] * P[1, 0, 0] + s[1] * P[0, 1, 0] + s[2] * P[0, 0, 1] - 0.5 * _contract(J, H)
    for i in range(3):
        Q[i], Q[3 + i] = mass * uniform[i], part[i]
    _add_force(H, T, s, J, Q[:3])
    _add_moment(J, H, Q[3:6])
    for j in range(m):
        Q[6 + j] = 0.5 * _contract(W[j], H)
        for i in range(3):
            Q[6 + j] += vn[i, j] * uniform[i]
    if wanted == 0:
        return V
    da, ds, unit, other = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    dJ, dH, dT = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3, 3))
    for c in range(6 + m):
        da[:], ds[:], dJ[:], dH[:], dT[:] = 0.0, 0.0, 0.0, 0.0, 0.0
        if c < 3:
            dH[:] = T[c]
            fourth(P, c, dT)
            for i in range(3):
                da[i] = -H[i, c]
        elif c < 6:
            unit[:] = 0.0
            unit[c - 3] = 1.0
            cross(uniform, unit, da)
            _turned(H, T, c - 3, dH, dT)
        else:
            ds[:] = vn[:, c - 6]
            dJ[:] = W[c - 6]
        cross(ds, uniform, part)
        cross(s, da, other)
        for i in range(3):
            K[i, c], K[3 + i, c] = mass * da[i], part[i] + other[i]
        _add_force(dH, dT, s, J, K[:3, c])
        _add_force(H, T, ds, dJ, K[:3, c])
        _add_moment(dJ, H, K[3:6, c])
        _add_moment(J, dH, K[3:6, c])
        for j in range(m):
            K[6 + j, c] = 0.5 * _contract(W[j], dH)
            for i in range(3):
                K[6 + j, c] += vn[i, j] * da[i]
            if c >= 6:
                K[6 + j, c] += _contract(J2[j, c - 6], H)
    return V


@kernel
def act_elastic(row, data, P, uniform, falls, state, work):
    """Subtract the generalised forces from the residual of a reduced body; P and `uniform` as for `attract_elastic`.

    The row has its `marker`, `modes`, `iq` (first coordinate) and `moments` (their place in the bulk data). Where the
    potential moves (`falls`) its power counts as a load's.
    """
    m, iu, weights = row.modes, work.markers[row.marker].iu, work.weights[0]
    eta = state.q[row.iq + 7 : row.iq + 7 + m]
    Q, K = np.empty(6 + m), np.zeros((6 + m, 6 + m))
    wanted = 1 if weights.wanted == 1 and weights.stiffness != 0.0 else 0
    V = attract_elastic(data[row.moments :], m, eta, P, uniform, wanted, Q, K)
    for i in range(6 + m):
        work.residual[iu + i] -= Q[i]
        if falls:
            work.energy[0].load_power += Q[i] * state.u[iu + i]
        if wanted == 1:
            start = work.rows[iu + i]
            for j in range(6 + m):
                work.S[start + j] -= weights.stiffness * K[i, j]
    if not falls:
        work.energy[0].potential += V


class BodyAttraction(Force):
    """A force on the mass of a body (field ``body``) by a centre: all of a rigid body, a point or a reduced body."""

    body: str

    def check(self, model) -> None:
        """Raise ModelError unless the body has a centre of mass, and a centre of attraction is on the ground."""
        require_center_of_mass(self, model, elastic=True)
        _require_unstiffened(self, model)

    def measure(self, model) -> str | None:
        """Return the centre of mass; the field over a reduced body has no place."""
        return None if model.body(self.body).reduced is not None else f"{self.body}.center"
