"""Independent coordinates of linear equations with constraints of places and of velocities, eq. (rolling-variation).

Positions vary as y = N z, which satisfies the equations of places, G y = 0. Those of velocities (rolling) relate rates
and positions, A y' + B y = 0: a wheel that is turned by its steering rolls another way. So

    z' = Q w + F z,   A N Q = 0,   F = -(A N)^+ B N,

and with y' = N z', y'' = N (Q w' + F Q w + F F z) the rest is projected onto P, which no constraint force loads.
Source: Neimark & Fufaev, Dynamics of Nonholonomic Systems, 1972, ch. VI.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag, null_space
from scipy.sparse import csr_matrix

from flexmb.system.mobility import mass_metric
from flexmb.system.program import advance, constraint_velocity, evaluate

__all__ = ["Independent", "independent", "velocity_slopes"]

PROBE = 1e-3
"""rad, or of the length of the assembly: step of the differences, whose error of fourth order is below rounding."""


class Independent(NamedTuple):
    """What spans the motions: N (nu, nz), Q (nz, nw), F (nz, nz), 1/s, and the projection P (nu, nw)."""

    N: np.ndarray
    Q: np.ndarray
    F: np.ndarray
    P: np.ndarray

    @property
    def velocities(self) -> np.ndarray:
        """Rates of the coordinates per unit of w, (nu, nw)."""
        return self.N @ self.Q


def _with_states(of, level: np.ndarray, rank: float, least: np.ndarray, states: int) -> Independent:
    """Return the independent coordinates of the bodies, then the states, which no constraint restricts."""
    n = len(of.M) - states
    bodies = of._replace(M=of.M[:n, :n], L=of.L[:n], G=of.G[:, :n], S=of.S[:, :n])
    own, unit = independent(bodies, level, rank, least[:n]), np.eye(states)
    F = np.zeros_like(unit)
    return Independent(*(block_diag(x, y) for x, y in zip(own, (unit, unit, F, unit), strict=True)))


def independent(of, level: np.ndarray, rank: float, least: np.ndarray, states: int = 0) -> Independent:
    """Return the independent coordinates of `Coefficients`, scaled by inertias.

    Parameters
    ----------
    of : Coefficients
    level : (ng,)
        1 for equations of velocities.
    states : int
        How many of the velocities, the last ones, are first-order states: they are coordinates z by their integrals.
    least : (nu,)
        Inertias by which they are at least scaled: beside a body that hardly resists others would not count.
    rank : float
        Singular values below this, relative to the largest, count as zero.
    """
    if states:
        return _with_states(of, level, rank, least, states)
    scale = 1.0 / np.sqrt(np.maximum(mass_metric(csr_matrix(of.M)), least))
    places, rates = of.G[level == 0] * scale, of.G[level == 1] * scale
    N = null_space(places, rcond=rank) if len(places) else np.eye(len(scale))
    P = null_space((of.L * scale[:, None]).T, rcond=rank) if of.L.shape[1] else np.eye(len(scale))
    nz = N.shape[1]
    if not len(rates):
        return Independent(scale[:, None] * N, np.eye(nz), np.zeros((nz, nz)), scale[:, None] * P)
    rolling = rates @ N
    F = -np.linalg.pinv(rolling, rcond=rank) @ (of.S[level == 1] @ (scale[:, None] * N))
    return Independent(scale[:, None] * N, null_space(rolling, rcond=rank), F, scale[:, None] * P)


def velocity_slopes(system, state, work) -> np.ndarray:
    """Return how the residuals of the equations of velocities change with the configuration, at constant velocities.

    Differences of fourth order along every velocity of the bodies that such an equation touches; the markers of elastic
    bodies move on them. Zero for equations of places.

    Returns
    -------
    (ng, nu)
        Derivative of G u + dg/dt in the axes of the bodies.
    """
    found = np.zeros((system.ng, system.nu))
    rows = np.flatnonzero(system.program.equation_level == 1)
    if not len(rows):
        return found
    legs = work.legs[np.isin(work.legs["equation"], rows)]
    touched = np.unique(work.markers["body"][legs["marker"]]).tolist()
    scale = PROBE / system.units
    work.weights[0].wanted = 0
    q, rate, unit = np.zeros(system.nq), np.zeros(system.ng), np.zeros(system.nu)
    for body in (system.model.bodies[k] for k in touched):
        span = system.body_slices[body.name][1]
        for j in range(span.start, span.stop):
            unit[j] = scale[j]
            for way, weight in ((1.0, 8.0), (-1.0, -8.0), (2.0, -1.0), (-2.0, 1.0)):
                advance(system.program, state.q, unit, way, q)
                evaluate(system.program, state._replace(q=q), work)
                constraint_velocity(work, state.u, rate)
                found[rows, j] += weight * rate[rows] / (12.0 * scale[j])
            unit[j] = 0.0
    return found
