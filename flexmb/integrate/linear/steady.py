"""Steady motion: every body keeps its twist in its own axes, as a rotor at constant speed does.

A body with a frame then has no accelerations. The coordinates of others (a point mass, the nodes of a cable) are
vectors in W, positions and gradients, which turn with the body: ``u = v + w x r`` and ``u = w x g`` give ``a = w x u``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from flexmb.integrate.matrices import adjoint, tangent_at
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.tables import DAMPED
from flexmb.system.mobility import mass_metric
from flexmb.system.program import constraint_acceleration, evaluate

__all__ = ["FactoredSaddle", "SteadyMotion", "saddle", "steady_motion", "unsteady_equation"]

HINGED, MOVING = 1e-4, 1e-9
"""Weight of the relative motion in joints, and of the kinetic energy, beside the ends of springs."""
FITTED = 1e-6
"""Weight of the relative motion of bodies where their velocities are known."""
STILL = 1e-18
"""Square of what rounding leaves of a gradient, relative to others in any unit of length: the turn of a cable's end."""
STEADY = 1e-6
"""Acceleration of a constraint that counts as zero, relative to a point turning at the size of the model."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SteadyMotion:
    """Velocities, accelerations and how they change with the configuration.

    Parameters
    ----------
    u, a : (nu,)
    turning : (nu, nu)
        du = dx' + turning dx for a variation dx of the configuration in axes that turn with the bodies.
    swinging, centripetal : (nu, nu)
        da = dx'' + swinging dx' + centripetal dx.
    spins : mapping of body name to (3,), rad/s
        Angular velocities in W; empty if nothing moves.
    """

    u: np.ndarray
    a: np.ndarray
    turning: sparse.csr_matrix
    swinging: sparse.csr_matrix
    centripetal: sparse.csr_matrix
    spins: Mapping[str, np.ndarray]


def saddle(block, L, G, epsilon: float, are_lengths: np.ndarray, least: np.ndarray | float = 0.0) -> sparse.csc_matrix:
    """Return [[block, -L], [G, -r]]; r, a share of G diag(block)^-1 G^T, keeps dependent equations solvable.

    An equation that moves nothing has a share of the largest r. Equations of lengths and of angles (`are_lengths`,
    (ng,)) have their own largest, if they have one: else the unit of length decides how soft one makes the other. The
    diagonal is taken as at least `least` (nu,): a body that hardly resists would make all equations soft.
    """
    r = epsilon * (abs(G).power(2) @ (1.0 / np.maximum(mass_metric(block), least)))
    largest = np.full(len(r), np.max(r, initial=0.0))
    for kind in (are_lengths, ~are_lengths):
        own = np.max(r[kind], initial=0.0)
        if own > STILL * np.max(r, initial=0.0):
            largest[kind] = own
    return sparse.bmat([[block, -L], [G, -sparse.diags(np.maximum(r, 1e-6 * largest))]], format="csc")


class FactoredSaddle:
    """The factors of a `saddle` whose block is a stiffness, (nu, nu).

    Multipliers are counted in units of its size: beside forces per displacement of 1e12, coefficients of 1 would be
    pivots that cost digits.
    """

    def __init__(self, matrix: sparse.csc_matrix, nu: int):
        scale = np.ones(matrix.shape[0])
        scale[nu:] = _usual(np.abs(matrix.diagonal()[:nu]))
        self.scale, scaled = scale, sparse.diags(scale)
        self.factors = splu((scaled @ matrix @ scaled).tocsc())

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Return the displacements and multipliers, for one right side (nu + ng,) or several (nu + ng, n)."""
        scale = self.scale if right.ndim == 1 else self.scale[:, None]
        return scale * self.factors.solve(scale * right)


def _usual(sizes: np.ndarray) -> float:
    """Return the geometric mean of those that are not zero, 1 if it has no value."""
    with np.errstate(over="ignore", invalid="ignore"):
        mean = float(np.exp(np.mean(np.log(sizes[sizes > 0.0])))) if np.any(sizes > 0.0) else 1.0
    return mean if np.isfinite(mean) and mean > 0.0 else 1.0


class _RigidMotions:
    """What every body does when it moves rigidly: velocity of a point of it, and angular velocity times the size of the
    model, in W: so all are speeds, and weights beside each other are those of any unit.
    """

    def __init__(self, system, q: np.ndarray):
        self.system, self.size = system, system.lengths.whole
        self.bodies = [body for body in system.model.bodies if body.n_velocities]
        self.number = {body.name: k for k, body in enumerate(self.bodies)}
        self.points = np.zeros((len(self.bodies), 3))
        rows, columns, values = [], [], []
        for k, body in enumerate(self.bodies):
            iq, iu = system.body_slices[body.name]
            block = _framed(q[iq]) if body.has_frame else self._of_vectors(body, q[iq], k)
            block[:, 3:] /= self.size
            if body.has_frame:
                self.points[k] = q[iq][:3]
            i, j = np.nonzero(block)
            rows.append(iu.start + i)
            columns.append(6 * k + j)
            values.append(block[i, j])
        self.B = sparse.csr_matrix(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
            shape=(system.nu, 6 * len(self.bodies)),
        )

    def _of_vectors(self, body, q: np.ndarray, k: int) -> np.ndarray:
        """Return the velocities (n, 6) of positions, the first three of a block, and of gradients, the others."""
        vectors = q.reshape(-1, 3)
        is_position = np.arange(len(vectors)) % (body.block_size // 3) == 0
        self.points[k] = vectors[is_position].mean(axis=0)
        block = np.zeros((len(vectors), 3, 6))
        block[is_position, :, :3] = np.eye(3)
        block[:, :, 3:] = -_crossing(vectors - np.where(is_position[:, None], self.points[k], 0.0))
        return block.reshape(-1, 6)

    def metric(self, work, elastic: float, hinged: float) -> sparse.csr_matrix:
        """Return the weights (6 nb, 6 nb) of the squares of relative motions at springs and in joints."""
        system = self.system
        names = {number: name for name, number in system.marker_index.items()}  # states are nowhere
        found = [
            (elastic, names[pair["a"]], names[pair["b"]])
            for pair in work.pairs
            if pair["active"] == DAMPED and np.any(pair["K"]) and pair["a"] in names and pair["b"] in names
        ]
        found += [(hinged, *joint.markers) for joint in system.model.joints if not (joint.prescribes or joint.couples)]
        blocks, places = [np.zeros((0, 6, 6))], [np.zeros((0, 2), int)]
        for n, (weight, *markers) in enumerate(found):
            at = work.markers[system.marker_index[markers[1]]]["r"]
            for marker, sign in zip(markers, (-1.0, 1.0), strict=True):
                k = self.number.get(marker.rpartition(".")[0])
                if k is not None:
                    block = np.eye(6)
                    block[:3, 3:] = -_crossing((at - self.points[k])[None])[0] / self.size
                    blocks.append(sign * np.sqrt(weight) * block[None])
                    places.append(np.array([[n, k]]))
        i, j = np.indices((6, 6))
        rows, columns = 6 * np.concatenate(places).T[:, :, None, None]
        J = sparse.csr_matrix(
            (np.concatenate(blocks).ravel(), ((rows + i).ravel(), (columns + j).ravel())),
            shape=(6 * len(found), 6 * len(self.bodies)),
        )
        return J.T @ J

    def largest_mass(self, M) -> float:
        """Return the largest mass that these motions have, kg."""
        return float((self.B.multiply(M @ self.B)).sum(axis=0).max())

    def spins(self, q: np.ndarray, u: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        """Return the angular velocities (3,) of the bodies in W."""
        found = {}
        for k, body in enumerate(self.bodies):
            iq, iu = self.system.body_slices[body.name]
            found[body.name] = self._angular(y, k)
            if body.has_frame:
                R = np.empty((3, 3))
                euler_to_matrix(q[iq][3:7], R)
                found[body.name] = R @ u[iu][3:6]
        return found

    def _angular(self, y: np.ndarray, k: int) -> np.ndarray:
        return y[6 * k + 3 : 6 * k + 6] / self.size

    def turns(self, y: np.ndarray) -> sparse.csr_matrix:
        """Return the block diagonal matrix (nu, nu) of w x for every vector of the bodies without frame."""
        rows, columns, values = [np.zeros(0, int)], [np.zeros(0, int)], [np.zeros(0)]
        for k, body in enumerate(self.bodies):
            w = self._angular(y, k)
            if body.has_frame or not np.any(w):
                continue
            span = self.system.body_slices[body.name][1]
            i, j = np.nonzero(_crossing(w[None])[0])
            first = np.arange(span.start, span.stop, 3)[:, None]
            rows.append((first + i).ravel())
            columns.append((first + j).ravel())
            values.append(np.tile(_crossing(w[None])[0][i, j], len(first)))
        return sparse.csr_matrix(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
            shape=(self.system.nu, self.system.nu),
        )


def _framed(q: np.ndarray) -> np.ndarray:
    """Return the velocities (6, 6) of a frame in its axes; the shape is kept."""
    R = np.empty((3, 3))
    euler_to_matrix(q[3:7], R)
    return np.kron(np.eye(2), R.T)


def _crossing(r: np.ndarray) -> np.ndarray:
    """Return the matrices (n, 3, 3) of r x."""
    return np.cross(np.eye(3)[None, :, :], -r[:, None, :]).transpose(0, 2, 1)


def steady_motion(system, state, work, known: bool = False) -> SteadyMotion:
    """Return the steady motion that the drives require, or (`known`) the one that keeps the velocities of `state`.

    Bodies move rigidly, so a reduced one turns with its drive instead of bending at the hub. Of all motions that the
    joints permit, the one with the least relative motion at the ends of springs is taken, then in the joints, then with
    the least kinetic energy. So everything attached to a rotor turns with it. Only where a mechanism cannot move
    without deforming, it deforms.
    """
    work.weights[0].wanted = 0
    evaluate(system.program, state, work)
    rate = work.equations["rate"].copy()
    motions = _RigidMotions(system, state.q)
    states = np.where(system.is_state, state.u, 0.0)
    if not np.any(state.u - states if known else rate):
        still = sparse.csr_matrix((system.nu, system.nu))
        return SteadyMotion(u=states, a=np.zeros(system.nu), turning=still, swinging=still, centripetal=still, spins={})
    tangent = tangent_at(system, state, work)
    if known:
        u = state.u - states
    else:
        u = _driven(system, tangent, motions, motions.metric(work, 1.0, HINGED), rate)
    y = _fitted(tangent.M, motions, motions.metric(work, FITTED, FITTED), u)
    turns = motions.turns(y)
    ad = adjoint(system, u)
    return SteadyMotion(
        u=u + states,
        a=turns @ u,
        turning=ad + turns,
        swinging=ad + 2.0 * turns,
        centripetal=turns @ turns,
        spins=motions.spins(state.q, u, y),
    )


def _driven(system, tangent, motions: _RigidMotions, metric, rate: np.ndarray) -> np.ndarray:
    """Return the velocity (nu,) that satisfies G u + rate = 0, rigid if that is possible."""
    B, M = motions.B, tangent.M / motions.largest_mass(tangent.M)
    kinetic = MOVING * (B.T @ M @ B) + 1e-3 * MOVING * sparse.identity(B.shape[1])
    sizes, are_lengths = system.lengths.equations, system.lengths.are_lengths
    y = _least_motion(metric + kinetic, kinetic, tangent.G @ B, rate, are_lengths)
    u = B @ y
    if np.max(np.abs(tangent.G @ u + rate) / sizes) > 1e-6 * np.max(np.abs(rate) / sizes):
        u = _least_motion(M, 0.0 * M, tangent.G, rate, are_lengths)
    return u


def _least_motion(weight, kinetic, G, rate: np.ndarray, are_lengths: np.ndarray) -> np.ndarray:
    """Return y with G y + rate = 0 of least weight; `are_lengths` as in `saddle`.

    From sweep to sweep, the kinetic part refers to the change. So it only decides where the rest leaves a choice, and
    the regularisation of dependent equations yields to the multipliers.
    """
    matrix = saddle(weight, G.T, G, 1e-12, are_lengths)
    factor, x = splu(matrix), np.zeros(matrix.shape[0])
    n = weight.shape[0]
    soft = matrix.diagonal()[n:]
    for _ in range(5):
        x = factor.solve(np.concatenate([kinetic @ x[:n], soft * x[n:] - rate]))
    return x[:n]


def _fitted(M, motions: _RigidMotions, metric, u: np.ndarray) -> np.ndarray:
    """Return the rigid motions (6 nb,) nearest to velocities; a point turns with its neighbours."""
    B, M = motions.B, M / motions.largest_mass(M)
    factor = splu((B.T @ M @ B + metric + 1e-9 * sparse.identity(B.shape[1])).tocsc())
    y, left = np.zeros(B.shape[1]), u.copy()
    for _ in range(3):  # what the weight of the neighbours takes from the velocities is added again
        y = factor.solve(B.T @ (M @ left) + 1e-9 * y)
        left += u - B @ y
    return y


def unsteady_equation(system, state, work) -> int | None:
    """Return the equation that the continued steady motion violates most, or None if it satisfies all.

    Its second derivative at the velocities and accelerations of `state`, less that at rest: drives that speed up are
    taken at their speed of the moment.
    """
    if not system.ng:
        return None
    found: list[np.ndarray] = []
    for factor in (0.0, 1.0):
        now = state._replace(u=factor * state.u, a=factor * state.a)
        work.weights[0].wanted = 0
        evaluate(system.program, now, work)
        found.append(np.zeros(system.ng))
        constraint_acceleration(work, now.a, found[-1])
        found[-1][system.program.equation_level == 1] = 0.0
    left = np.abs(found[1] - found[0])
    fastest, size = float(np.max(np.abs(work.markers["w"]))), system.lengths.whole
    return int(np.argmax(left)) if left.max() > STEADY * max(fastest**2 * size, 1e-12) else None
