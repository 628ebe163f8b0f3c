"""Vibration inside a body whose frame is clamped to an interface, beside the stiffness that it seems to change.

Geometric stiffness knows the inertia of the mean motion only. What modes accelerate beyond that, the wave along a strut
after a sudden load, pulls and pushes inside the body, and the equations carry it in one place alone: where it acts
on the displaced material, seen from the frame. In the mean frame nothing is left of that to first order. A clamped
frame turns with its interface, by ``theta = -mean eta`` against the mean motion. The moment of the inner forces on the
displacement then works as a stiffness that is not there::

    dK_ij = -theta_i . int rho phi_j x (sum_k phi_k eta''_k - a - alpha x x),      (a, alpha) = mean eta''
"""

from __future__ import annotations

import numpy as np

from flexmb.bodies.floating.row import invariants, mean_motion

__all__ = ["INNER", "InnerInertia"]

INNER = 0.2
"""Change of stiffness that is told: a hinged strut under a sudden load is then 2 to 3 % off."""


class InnerInertia:
    """Apparent change of stiffness of one body by vibration inside it.

    Parameters
    ----------
    row : record of `ROW`
    bulk : array
        Bulk data of the program.
    inverse : (m, m)
        Of the stiffness: ``inverse @ K @ inverse.T = I``.
    """

    def __init__(self, row, bulk, inverse: np.ndarray):
        modes = int(row["modes"])
        self.span = slice(int(row["iu"]) + 6, int(row["iu"]) + 6 + modes)
        _, _, vw1, _, _, ww1, _, wn0, wn1, _ = invariants(bulk, row["mass"], modes)
        mean = mean_motion(bulk, row["mass"], modes)
        W = ww1[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]
        # moments (m, 3, m): of displacement j by the acceleration of mode k, less those by the mean motion of mode k
        moments = wn1 - vw1.transpose(0, 2, 1) @ mean[:3] - 0.5 * W @ mean[3:]
        moments += 0.5 * np.cross(mean[3:].T[None], wn0.T[:, None], axis=2).transpose(0, 2, 1)
        self.moments = np.einsum("ab,bik->aik", inverse, moments)
        self.turns = inverse @ mean[3:].T

    def share(self, a: np.ndarray) -> np.ndarray:
        """Return the change relative to the stiffness, (nt,), for accelerations (nt, n) of the system."""
        acting = np.einsum("aik,tk->tai", self.moments, a[:, self.span])
        K = np.einsum("tai,bi->tab", acting, self.turns)
        return np.abs(np.linalg.eigvalsh(0.5 * (K + K.swapaxes(1, 2)))).max(axis=1, initial=0.0)
