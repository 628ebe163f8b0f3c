"""Loads of a body beside those that would change its stiffness, as its joints hold it.

Where a reduction has left out geometric stiffness, they say how much that matters; where it has it, when the body
buckles.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from flexmb.bodies.floating.holders import Holders
from flexmb.bodies.floating.row import invariants, mean_motion
from flexmb.bodies.floating.stiffness import load_scales, mean_acceleration
from flexmb.math.rotations import euler_to_matrix

__all__ = ["LeftOut"]

ALIGNED = 1e-4
"""Size of a rigid motion, of the largest, up to which an equation counts as leaving it free."""
YIELD = 1e-10
"""Compliance of what holds a body, of the body's own there: equations may depend on each other."""
PAIRS = 6
"""Neighbours up to which each two of them are looked at together."""


class LeftOut:
    """Change of stiffness by the loads of one body, from the matrices of its reduction (`ModalNeutralData.left_out`).

    The matrices of all loads, with their signs, make one, whose largest eigenvalue, in size, is the change. What joints
    to the ground hold stands still. Bodies and forces beside it may hold or yield: the body is seen from its mean
    motion, and as if each of them, each two, and all of them held; the largest change counts. With fewer
    conditions a body can take more shapes, so where neighbours hold more than that, the change is told too high. That a
    body buckles is only said where it does so whatever its neighbours hold.

    Parameters
    ----------
    body : FloatingBody
    data, row : its reduced data, as they are in the model, and its row
    causes : sequence of str
        What each load is called.
    system : System
    """

    def __init__(self, body, data, row, causes, system):
        known = data.left_out
        self.row, self.causes = row, causes
        groups = (known.inertia, known.interface.reshape(-1, *known.preload.shape), known.loads, known.preload[None])
        self.matrices = np.concatenate(groups)
        self.motions = np.concatenate([known.translations, known.turns], axis=1)  # (ni, 6, k)
        self.compliance = known.compliance
        self.places = data.marker_positions[: len(known.turns)]
        names = [f"{body.name}.{name}" for name in data.marker_names[: len(known.turns)]]
        self.holders = Holders(body.name, names, system)
        vv, vw, _, _, ww = invariants(system.program.bulk, row["mass"], row["modes"])[:5]
        self.unit_motions = _unit_motions(np.block([[ww, vw.T], [vw, vv]]))

    def share(self, bulk, state, work) -> tuple[float, str, float]:
        """Return the relative change of stiffness, what has the largest part in it, and the largest loss, 1: all."""
        scales, G, R = self._stiffening(bulk, state, work)
        ground, *others = self.holders.rows(R, work)
        found = [self._changes(G, rows) for rows in _views(ground, others)]
        change, shape = max((pair for pairs in found for pair in pairs), key=lambda pair: abs(pair[0]))
        loss = max(0.0, *(-value for pairs in found for value, _ in pairs))
        return abs(change), self._cause(scales, shape, abs), loss

    def loss(self, bulk, state, work) -> tuple[float, str]:
        """Return the share of the stiffness that loads take away whatever neighbours hold, 1: all, and what does so.

        A neighbour that hangs on the body alone holds nothing, where the body stands without it.
        """
        scales, G, R = self._stiffening(bulk, state, work)
        ground, *others = self.holders.rows(R, work)
        loose = [*self.holders.loose, *[False] * (len(others) - len(self.holders.loose))]
        firm = [rows for rows, hangs in zip(others, loose, strict=True) if not hangs]
        if self._stands(np.concatenate([ground, *firm])):
            others = firm
        # where the ground holds all rigid motions, what is held besides can only take shapes away
        views = [np.concatenate([ground, *others])] if self._stands(ground) else _views(ground, others)
        value, shape = max((self._changes(G, rows)[0] for rows in views), key=lambda pair: pair[0])
        return max(0.0, -value), self._cause(scales, shape, lambda part: -part)

    def _stiffening(self, bulk, state, work):
        """Return the size of each load, the matrix of all of them, and the orientation of the body."""
        row, R, fall = self.row, np.empty((3, 3)), np.empty(6)
        iu, first, scales = row["iu"], row["first_load"], np.empty(len(self.matrices))
        A = state.a[iu : iu + 6 + row["modes"]].copy()
        euler_to_matrix(state.q[row["iq"] + 3 : row["iq"] + 7], R)
        A[:3] -= R.T @ row["gravity"]
        mean_acceleration(mean_motion(bulk, row["mass"], row["modes"]), A, fall)
        wrenches = work.markers[row["marker"] : row["marker"] + row["interfaces"]]
        load_scales(state.u[iu : iu + 6], fall, R, wrenches, work.loads[first : first + row["loads"]], scales)
        return scales, np.tensordot(scales, self.matrices, 1), R

    def _cause(self, scales, shape, size) -> str:
        """Return the load that has the largest part, by `size`, in the change of a shape."""
        parts: dict[str, float] = {}
        for cause, part in zip(self.causes, scales * np.einsum("j,ijk,k->i", shape, self.matrices, shape), strict=True):
            parts[cause] = parts.get(cause, 0.0) + part
        return max(parts, key=lambda cause: size(parts[cause]))

    def _rigid(self, rows):
        """Return what rows have of the rigid motions of unit mass, (n, r), and which of these they hold, (r, held)."""
        along, turn = np.split(rows.reshape(len(rows), len(self.places), 6), 2, axis=2)
        rigid = np.hstack([np.sum(turn + np.cross(self.places, along), axis=1), np.sum(along, axis=1)])
        free = rigid @ self.unit_motions
        norms = np.linalg.norm(free, axis=1, keepdims=True)  # rows in m and in rad are compared by direction only
        _, s, axes = np.linalg.svd(free / np.where(norms > 0.0, norms, 1.0), full_matrices=False)
        return free, axes[s > ALIGNED * max(s, default=0.0)].T

    def _stands(self, rows) -> bool:
        """Do these rows hold all rigid motions?"""
        return self._rigid(rows)[1].shape[1] == self.unit_motions.shape[1]

    def _changes(self, G, rows):
        """Return the lowest and the highest change of stiffness, each with its shape with the turn of the body."""
        k = self.motions.shape[2]
        soft = rows @ self.motions.reshape(rows.shape[1], k)
        free, held = self._rigid(rows)  # what is not held has no momentum
        rest = rows @ self.compliance @ rows.T
        size = np.sqrt(np.einsum("ij,ij->i", soft, soft) + np.diag(rest))  # of the body's own motion, in any unit
        size = np.where(size > 0.0, size, np.linalg.norm(free, axis=1))
        size[size == 0.0] = 1.0
        rigid = free @ held / size[:, None]
        unit = np.linalg.norm(rigid, axis=0)
        C = _compliance(soft / size[:, None], rigid / unit, rest / np.outer(size, size) + YIELD * np.eye(len(rows)))
        T = np.zeros((k + 3, len(C)))
        T[:k, :k], T[k:, k:] = np.eye(k), (self.unit_motions @ held / unit)[:3]
        T = T @ C
        values, vectors = np.linalg.eigh(T.T @ G @ T)
        return [(float(values[n]), T @ vectors[:, n]) for n in (0, -1)]


def _views(ground, others):
    """Yield, for each choice of neighbours that hold, what is held: rows (n, 6 ni) on the interfaces' motions."""
    for size in sorted({0, min(1, len(others)), 2 if 2 <= len(others) <= PAIRS else 0, len(others)}):
        for chosen in combinations(others, size):
            yield np.concatenate([ground, *chosen])


def _compliance(soft, turns, rest) -> np.ndarray:
    """Return a factor C, C C^T the compliance of shapes (n, k) and rigid motions (n, r) that supports (n, n) hold."""
    k, r = soft.shape[1], turns.shape[1]
    both = np.block([[np.eye(k), np.zeros((k, r)), soft.T], [np.zeros((r, k + r)), turns.T], [soft, turns, -rest]])
    w, axes = np.linalg.eigh(np.linalg.inv(both)[: k + r, : k + r])
    return axes * np.sqrt(np.maximum(w, 0.0))


def _unit_motions(mass: np.ndarray) -> np.ndarray:
    """Return rigid motions (6, r), turns first, of unit mass and without mutual momenta; a plane lacks some."""
    scale = 1.0 / np.sqrt(np.where(np.diag(mass) > 0.0, np.diag(mass), 1.0))
    w, axes = np.linalg.eigh(mass * np.outer(scale, scale))
    some = w > 1e-12 * w[-1]
    return scale[:, None] * axes[:, some] / np.sqrt(w[some])
