"""Centre of mass and momenta of a whole tree, with their derivatives by its rates: one visit per body.

The momenta of a body are the first six rows of its mass matrix times its velocities. What these rows are per rate of
the tree follows like forces on rates from forces on bodies: from the leaves to the roots, eq. (tree-centroid).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.errors import ModelError
from flexmb.math.kernel import kernel
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.vectors import cross, matvec, matvec_t
from flexmb.math.weights import weigh
from flexmb.system.program import evaluate
from flexmb.tree.coordinates.joint_torques import gather_torques
from flexmb.tree.coordinates.motions import POINTS

__all__ = ["Centroid", "centroid"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Centroid:
    """The centre of mass of a tree and its centroidal momentum (Orin, Goswami & Lee 2013), all in W.

    Parameters
    ----------
    mass : float, kg
    position : (3,), m
        Of the centre of mass.
    inertia : (3, 3), kg m2
        About it, of the tree as it stands.
    jacobian : (3, nv)
        Velocity of the centre of mass per rate.
    momentum_matrix : (6, nv)
        Linear momentum, and angular momentum about the centre of mass, per rate.
    velocity, acceleration : (3,), m/s, m/s2
        Of the centre of mass.
    momentum, momentum_rate : (6,), kg m/s, kg m2/s and per s
        At the rates, and its derivative at the second rates.
    """

    mass: float
    position: np.ndarray
    inertia: np.ndarray
    jacobian: np.ndarray
    momentum_matrix: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    momentum: np.ndarray
    momentum_rate: np.ndarray


@kernel
def _add_mass(rows, counted, state, work, moment, inertia):
    """Add first moment (3,) and inertia (3, 3) of all bodies about the origin of W; return their mass.

    counted : (nb,) 1 for bodies, 0 for states of forces
    """
    R, h, J, turned = np.empty((3, 3)), np.empty(3), np.empty((3, 3)), np.empty(3)
    total = 0.0
    for k in range(len(rows)):
        row, S = rows[k], work.S
        if counted[k] == 0:
            continue
        r, first = state.q[row.q : row.q + 3], work.rows[row.u : row.u + 6]
        h[:] = 0.0
        J[:] = 0.0
        mass = S[first[0]]
        if row.held != POINTS:
            mass = max(mass, S[first[1] + 1], S[first[2] + 2])  # a mesh in a plane may have none along its normal
            euler_to_matrix(state.q[row.q + 3 : row.q + 7], R)
            turned[0], turned[1], turned[2] = S[first[1] + 5], S[first[2] + 3], S[first[0] + 4]
            matvec(R, turned, h)
            for i in range(3):
                for j in range(3):
                    for m in range(3):
                        for n in range(3):
                            J[i, j] += R[i, m] * S[first[3 + m] + 3 + n] * R[j, n]
        total += mass
        hr, rr = 0.0, 0.0
        for i in range(3):
            moment[i] += mass * r[i] + h[i]
            hr += h[i] * r[i]
            rr += r[i] * r[i]
        for i in range(3):
            inertia[i, i] += mass * rr + 2.0 * hr
            for j in range(3):
                inertia[i, j] += J[i, j] - h[i] * r[j] - r[i] * h[j] - mass * r[i] * r[j]
    return total


@kernel
def _write_momenta(rows, counted, state, work, center, out):
    """Write the momenta about a place per velocity of every body, out (6, nu); states of forces have none."""
    R, p, h, d, t = np.empty((3, 3)), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for k in range(len(rows)):
        row, S = rows[k], work.S
        if counted[k] == 0:
            continue
        for i in range(3):
            d[i] = state.q[row.q + i] - center[i]
        points = row.held == POINTS
        if not points:
            euler_to_matrix(state.q[row.q + 3 : row.q + 7], R)
        for j in range(row.modes if points else 6 + row.modes):
            for i in range(3):
                p[i] = S[work.rows[row.u + i] + j]
                h[i] = 0.0 if points else S[work.rows[row.u + 3 + i] + j]
            if not points:
                t[:] = p
                matvec(R, t, p)
                t[:] = h
                matvec(R, t, h)
            cross(d, p, t)
            for i in range(3):
                out[i, row.u + j] = p[i]
                out[3 + i, row.u + j] = h[i] + t[i]


@kernel
def _add_rates(rows, counted, state, work, center, momenta, gravity, out):
    """Add the rates of the momenta (6,) of all bodies about a place that stands still, with the weight taken out."""
    R, f, m, d, t = np.empty((3, 3)), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for k in range(len(rows)):
        row = rows[k]
        if counted[k] == 0:
            continue
        m[:] = 0.0
        for i in range(3):
            d[i] = state.q[row.q + i] - center[i]
            f[i] = work.residual[row.u + i]
        if row.held != POINTS:
            euler_to_matrix(state.q[row.q + 3 : row.q + 7], R)
            matvec_t(R, gravity, t)
            for i in range(6):
                for j in range(3):
                    out[i] += momenta[i, row.u + j] * t[j]
            t[:] = f
            matvec(R, t, f)
            matvec(R, work.residual[row.u + 3 : row.u + 6], m)
        else:
            for i in range(6):
                for j in range(3):
                    out[i] += momenta[i, row.u + j] * gravity[j]
        cross(d, f, t)
        for i in range(3):
            out[i] += f[i]
            out[3 + i] += m[i] + t[i]


def centroid(tree, state, v: np.ndarray) -> Centroid:
    """Return the centre of mass of a `JointTree` at a state of all bodies, with rates v (nv,)."""
    system, work, rows = tree.system, tree.work, tree.rows
    counted = np.array([name in system.body_slices for name in tree.tree.order], np.int64)
    none = np.zeros(0, np.int64)
    alone = system.program._replace(equations=none, forces=none, floor=np.zeros(len(system.program.floor)))
    weigh(work.weights, 1.0, 0.0, 0.0, 0.0, 0, 0)
    evaluate(alone, state, work)
    position, inertia = np.zeros(3), np.zeros((3, 3))
    mass = _add_mass(rows, counted, state, work, position, inertia)
    if not mass > 0.0:
        raise ModelError(
            "JointTree",
            found=f"the moving bodies have the mass {mass:.3g} kg",
            expected="a mass, which has a centre",
            remedy="Give a body mass",
        )
    position /= mass
    inertia -= mass * (position @ position * np.eye(3) - np.outer(position, position))
    momenta, rates = np.zeros((6, system.nu)), np.zeros(6)
    _write_momenta(rows, counted, state, work, position, momenta)
    _add_rates(rows, counted, state, work, position, momenta, np.array(tree.model.gravity, float), rates)
    matrix = np.zeros((6, len(v)))
    for force, row in zip(momenta, matrix, strict=True):
        gather_torques(rows, state, work, force, row, 0)
    jacobian = matrix[:3] / mass
    momentum = matrix @ v
    return Centroid(
        mass=mass,
        position=position,
        inertia=inertia,
        jacobian=jacobian,
        momentum_matrix=matrix,
        velocity=momentum[:3] / mass,
        acceleration=rates[:3] / mass,
        momentum=momentum,
        momentum_rate=rates,
    )
