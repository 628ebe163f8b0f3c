"""Observers of a steady motion: the axes in which its linear equations have constant coefficients.

Where all bodies turn together, or each about an axis of symmetry, own axes will do: a rotor blade. A rotor in a casing
that stands still does not: their joint couples axes that turn against each other. Seen from W (or from another body)
the rotor looks the same at all times if it is round, and the coefficients are constant there. Variations change by dx =
T dy, eq. (observer),

    dx' = T dy' + T1 dy,   dx'' = T dy'' + 2 T1 dy' + T2 dy,
    T = R^T Q,   T1 = R^T (O~ - w~) Q,   T2 = R^T (w~ w~ - 2 w~ O~ + O~ O~ - w'~) Q

with the angular velocities w of the body and O of the observer in W, R' = w~ R, Q' = O~ Q; O is constant. A top that
precesses is steady for the observer who goes round with it: w' = O x w.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.linalg import null_space

from flexmb.integrate.linear.independent import velocity_slopes
from flexmb.integrate.linear.steady import SteadyMotion, steady_motion
from flexmb.integrate.matrices import adjoint, tangent_at
from flexmb.math.rotations import euler_to_matrix, rotation_matrix
from flexmb.system.accelerations import accelerations, settled_accelerations
from flexmb.system.mobility import mass_metric
from flexmb.system.program import advance

__all__ = ["OWN_AXES", "Coefficients", "Observer", "coefficients", "constant_observer"]

ANGLE = 1e-2
"""Turn (rad) forwards and back, over which coefficients are compared."""
CHANGING = 1e-3
"""Change of coefficients per radian, relative to their size, from which they are not constant."""


class Coefficients(NamedTuple):
    """M dx'' + C dx' + K dx - L dlam = 0; G dx = 0 of places, G dx' + S dx = 0 of velocities.

    Dense (nu, nu), L (nu, ng), G and S (ng, nu). Entries of K are sums, of which `summed` (nu, nu) has the sizes: where
    they cancel, as the load and the acceleration of a body that falls do, rounding of the sums is left.
    """

    M: np.ndarray
    C: np.ndarray
    K: np.ndarray
    L: np.ndarray
    G: np.ndarray
    S: np.ndarray
    summed: np.ndarray


def coefficients(system, state, work, motion: SteadyMotion) -> Coefficients:
    """Return the coefficients in axes that turn with the bodies."""
    tangent = tangent_at(system, state, work)
    M, D, K, L, G = (getattr(tangent, name).toarray() for name in ("M", "D", "K", "L", "G"))
    centripetal = (motion.centripetal + adjoint(system, state.a)).toarray()
    C = D + M @ motion.swinging.toarray()
    turning = motion.turning.toarray()
    rolling = (system.program.equation_level == 1)[:, None]
    S = np.where(rolling, G @ turning, 0.0) + velocity_slopes(system, state, work)
    summed = np.abs(K) + np.abs(D) @ np.abs(turning) + np.abs(M) @ np.abs(centripetal)
    return Coefficients(M, C, K + D @ turning + M @ centripetal, L, G, S, summed)


@dataclass(frozen=True, kw_only=True, eq=False)
class Observer:
    """Axes in which variations are seen.

    Parameters
    ----------
    name : str
        "each body" for own axes, "W", the title of the body with which they turn, or of the one with whose precession.
    velocity : (3,), rad/s, in W, or None for own axes
    """

    name: str
    velocity: np.ndarray | None

    def seen(self, system, state, motion: SteadyMotion, of: Coefficients, dt: float = 0.0):
        """Return the coefficients in the axes of the observer, and T (nu, nu); `dt` after they coincided with W."""
        if self.velocity is None and dt == 0.0:
            return of, sparse.identity(system.nu, format="csr")
        blocks: tuple[list, list, list] = ([], [], [])
        for body in (body for body in system.model.bodies if body.n_velocities):
            iq, iu = system.body_slices[body.name]
            vectors = 2 if body.has_frame else body.n_velocities // 3
            rest = np.eye(body.n_velocities - 3 * vectors)
            R, w = _turn(body, state.q[iq]), motion.spins.get(body.name, np.zeros(3))
            rate = R @ state.a[iu][3:6] if body.has_frame else np.zeros(3)
            of_vector = self._of_vector(body.has_frame, R, w, rate, dt)
            for family, block, others in zip(blocks, of_vector, (rest, 0.0 * rest, 0.0 * rest), strict=True):
                family += [block] * vectors + [others]
        n = int(np.sum(system.is_state))
        for family, block in zip(blocks, (np.eye(n), np.zeros((n, n)), np.zeros((n, n))), strict=True):
            family.append(block)
        T, first, second = (sparse.block_diag(family, format="csr") for family in blocks)
        C = T.T @ (of.C @ T + 2.0 * of.M @ first)
        K = T.T @ (of.K @ T + of.C @ first + of.M @ second)
        rolling = (system.program.equation_level == 1)[:, None]
        S = of.S @ T + np.where(rolling, of.G @ first, 0.0)
        summed = abs(T).T @ (of.summed @ abs(T)) + np.abs(K)
        return Coefficients(T.T @ (of.M @ T), C, K, T.T @ of.L, of.G @ T, S, summed), T

    def _of_vector(
        self, framed: bool, R: np.ndarray, w: np.ndarray, rate: np.ndarray, dt: float
    ) -> tuple[np.ndarray, ...]:
        """Return T, T1 and T2 (3, 3) of the vectors of a body with the angular velocity w and its rate in W."""
        if self.velocity is None:
            return np.eye(3) if framed else rotation_matrix(w * dt), np.zeros((3, 3)), np.zeros((3, 3))
        W, O, Q = _crossing(w), _crossing(self.velocity), rotation_matrix(self.velocity * dt)
        return R.T @ Q, R.T @ (O - W) @ Q, R.T @ (W @ W - 2.0 * W @ O + O @ O - _crossing(rate)) @ Q


OWN_AXES = Observer(name="each body", velocity=None)


def _crossing(w: np.ndarray) -> np.ndarray:
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def _turn(body, q: np.ndarray) -> np.ndarray:
    """Return the axes (3, 3) of a body with a frame, else the axes of W."""
    R = np.eye(3)
    if body.has_frame:
        euler_to_matrix(q[3:7], R)
    return R


def _precession(system, body, state, w: np.ndarray) -> np.ndarray | None:
    """Return the angular velocity about the direction of gravity with which w turns, w' = O x w, or None."""
    gravity = np.asarray(system.model.gravity, float)
    if not body.has_frame or not np.any(gravity):
        return None
    iq, iu = system.body_slices[body.name]
    rate, axis = _turn(body, state.q[iq]) @ state.a[iu][3:6], gravity / np.linalg.norm(gravity)
    across = np.cross(axis, w)
    if across @ across <= 1e-12 * (w @ w):
        return None
    found = (rate @ across) / (across @ across) * axis
    turns = np.linalg.norm(np.cross(found, w) - rate) <= 1e-6 * np.linalg.norm(rate)
    return found if np.any(rate) and turns else None


def constant_observer(system, state, motion: SteadyMotion, own: Coefficients, bases) -> Observer | None:
    """Return the first observer for whom the coefficients are constant.

    Each body's own axes come first, then W, the axes of a body, and those that go round with its precession.

    Parameters
    ----------
    own : Coefficients
        In own axes, at `state`.
    bases : callable Coefficients -> Independent

    Returns
    -------
    Observer or None
        None if they change with time for all of them.
    """
    fastest = max((float(np.linalg.norm(w)) for w in motion.spins.values()), default=0.0)
    observers = [OWN_AXES]
    if fastest == 0.0:
        return observers[0]
    observers.append(Observer(name="W", velocity=np.zeros(3)))
    for body in system.model.bodies:
        w = motion.spins.get(body.name)
        if w is not None and all(
            o.velocity is None or np.linalg.norm(w - o.velocity) > 1e-9 * fastest for o in observers
        ):
            observers.append(Observer(name=body.title, velocity=w))
        precession = None if w is None else _precession(system, body, state, w)
        if precession is not None:
            observers.append(Observer(name=f"the precession of {body.title}", velocity=precession))
    dt = ANGLE / fastest
    around = [_moved(system, state, sign * dt) for sign in (1.0, -1.0)]
    if any(there is None for there in around):
        return None
    for observer in observers:
        now, _ = observer.seen(system, state, motion, own)
        pair = [
            observer.seen(system, later, there, of, sign * dt)[0]
            for (later, there, of), sign in zip(around, (1.0, -1.0), strict=True)
        ]
        if _constant(now, pair, bases(now), fastest):
            return observer
    return None


def _moved(system, state, dt: float):
    """Return state, steady motion and coefficients a time dt later, or None if there are none."""
    work = system.workspace()
    q, u = np.zeros(system.nq), state.u + dt * state.a
    advance(system.program, state.q, 0.5 * (state.u + u), dt, q)
    there = system.state(state.t + dt, q, u)
    right = np.zeros(system.nu + system.ng)
    if accelerations(system.program, there, work, right, 12 if system.redundant else 2) >= 0:
        return None
    if not settled_accelerations(system, there, work, right):
        return None
    motion = steady_motion(system, there, work, known=True)
    return there, motion, coefficients(system, there, work, motion)


def _constant(now: Coefficients, around, bases, fastest: float) -> bool:
    """Are the changes of all coefficients, by directions of motion, small beside what they are?"""
    (after, before), N, motions, P = around, bases.N, bases.velocities, bases.P
    inertia = mass_metric(sparse.csr_matrix(now.M))
    largest = np.abs(now.G / np.sqrt(inertia)).max(initial=0.0)
    if now.G.size and np.abs((after.G - before.G) @ N).max(initial=0.0) / (2.0 * ANGLE) > CHANGING * largest:
        return False
    if now.S.size and np.abs((after.S - before.S) @ N).max(initial=0.0) / (2.0 * ANGLE) > CHANGING * largest * fastest:
        return False
    # columns of N and of P have the norm 1 in the metric of the inertias; P is turned to the velocities
    P = P @ np.linalg.pinv((motions.T * inertia) @ P)
    stiffness = P.T @ now.K @ motions
    values, V = np.linalg.eigh(0.5 * (stiffness + stiffness.T))
    rates = np.sqrt(np.abs(values) + fastest**2)
    # where wheels roll, more places than velocities are free: where it has been, and which way it looks
    places = N @ null_space(bases.Q.T) if bases.Q.shape[0] > bases.Q.shape[1] else N[:, :0]
    wide, all_rates = np.hstack([motions @ V, places]), np.append(rates, np.full(places.shape[1], fastest))
    for X, power, shapes, right in (
        ("M", 0.0, motions @ V, rates),
        ("C", 0.5, motions @ V, rates),
        ("K", 1.0, wide, all_rates),
    ):
        change = V.T @ P.T @ (getattr(after, X) - getattr(before, X)) @ shapes / (2.0 * ANGLE)
        if np.any(np.abs(change) > CHANGING * np.outer(rates**power, right**power)):
            return False
    return True
