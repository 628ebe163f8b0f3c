"""`held_motion`: what is left to move of an FE model whose supports hold freedoms, slanted directions, linked nodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import linalg, sparse
from scipy.sparse.csgraph import connected_components

from flexmb.errors import MeshError
from flexmb.fem.chosen_nodes import as_array, node_numbers
from flexmb.fem.directions import direction_numbers
from flexmb.fem.fe_model import FEModel

__all__ = ["HeldMotion", "held_motion", "held_places", "is_mask"]

REDUNDANT = 1e-9
"""A pivot below this share of the largest says that an equation follows from the others."""


@dataclass(frozen=True, kw_only=True, eq=False)
class HeldMotion:
    """Freedoms (nf,) that stay independent, and the motion (ndof, nf) of all from them; None: others stand still."""

    free: np.ndarray
    motion: sparse.csr_matrix | None = None

    def reduced(self, matrix: sparse.csr_matrix) -> sparse.csr_matrix:
        """Return a matrix (ndof, ndof) on the independent freedoms."""
        if self.motion is None:
            return matrix[self.free][:, self.free]
        return (self.motion.T @ matrix @ self.motion).tocsr()

    def forces(self, load: np.ndarray) -> np.ndarray:
        """Return loads (ndof, k) on the independent freedoms."""
        return load[self.free] if self.motion is None else self.motion.T @ load

    def spread(self, values: np.ndarray, size: int) -> np.ndarray:
        """Return the motion (ndof, k) of all freedoms."""
        if self.motion is not None:
            return self.motion @ values
        out = np.zeros((size, values.shape[1]))
        out[self.free] = values
        return out


def held_places(fe: FEModel, fixed, directions=None, part: str = "") -> np.ndarray:
    """Return the held places ``6 node + direction``, ascending, of what `fixed_freedoms` describes as `fixed`.

    Parameters
    ----------
    directions : text, numbers or None
        Of the nodes; None for all six, and for the freedoms that supports of a deck name. A mapping has its own.
    """
    part = part or f"FE model '{fe.name}'"
    if fixed is None:
        return np.zeros(0, np.int64)
    if isinstance(fixed, Mapping):
        if directions is not None:
            raise MeshError(
                part,
                found=f"directions {directions!r:.40} beside a mapping, which has its own",
                expected="directions in one place",
                remedy='Write {"root": "xyzrxryrz", "tip": "z"} alone',
            )
        blocks = [_of_entry(fe, some, own, f"{part}, {_title(some)}") for some, own in fixed.items()]
        return np.unique(np.concatenate([np.zeros(0, np.int64), *blocks]))
    if is_mask(fixed):
        return _of_mask(fe, np.asarray(fixed), directions, part)
    if isinstance(fixed, str) and fixed in fe.supports and directions is None:
        rows = np.asarray(fe.supports[fixed], np.int64).reshape(-1, 2)
        return np.unique(6 * rows[:, 0] + rows[:, 1])
    chosen = np.arange(6) if directions is None else direction_numbers(directions, part)
    return np.unique((6 * node_numbers(fe, fixed)[:, None] + chosen).ravel()).astype(np.int64)


def _of_entry(fe: FEModel, some, directions, part: str) -> np.ndarray:
    """Return the held places of one entry of a mapping: None would be read as all, or as those of the deck."""
    if directions is None:
        raise MeshError(
            part,
            found="directions None",
            expected="directions for each entry of a mapping",
            remedy=f"Give '{some}' alone, not in a mapping: its directions are those of the deck"
            if isinstance(some, str) and some in fe.supports
            else 'Write "xyzrxryrz" for all six',
        )
    return held_places(fe, some, directions, part)


def is_mask(fixed) -> bool:
    """Tell whether supports are given as true and false, one for each freedom."""
    if isinstance(fixed, str | Mapping):
        return False
    array = as_array(fixed)
    return array.ndim > 0 and array.dtype == bool


def _of_mask(fe: FEModel, mask: np.ndarray, directions, part: str) -> np.ndarray:
    if mask.shape != (fe.ndof,) or mask.dtype != bool or directions is not None:
        raise MeshError(
            part,
            found="a mask with directions beside it" if directions is not None else f"a mask of the shape {mask.shape}",
            expected=f"({fe.ndof},), one entry per freedom",
            remedy="Or give node numbers",
        )
    return np.sort(6 * fe.dofs[mask, 0] + fe.dofs[mask, 1]).astype(np.int64)


def _title(some) -> str:
    return f"set '{some}'" if isinstance(some, str) else f"nodes {some!r:.40}"


def held_motion(fe: FEModel, fixed, mask: np.ndarray) -> HeldMotion:
    """Return what may move where the freedoms of `mask` (ndof,) stand still, and all else that `fixed` names.

    Directions across the basic axes, and nodes that follow others by links, give equations over the freedoms:
    one freedom of each follows the others.
    """
    free = np.flatnonzero(~mask)
    if fixed is None or is_mask(fixed):
        return HeldMotion(free=free)
    equations = _equations(fe, fixed)
    if equations is None:
        return HeldMotion(free=free)
    equations = equations[:, free].tocsr()
    size = abs(equations).max(axis=1).toarray().ravel()
    equations = equations[size > 0.0]
    if not equations.shape[0]:
        return HeldMotion(free=free)
    equations = sparse.diags(1.0 / size[size > 0.0]) @ equations
    dependent, follows, values = _solved(equations.tocsc())
    kept = np.setdiff1d(np.arange(len(free)), dependent)
    place = np.full(len(free), -1)
    place[kept] = np.arange(len(kept))
    rows = np.concatenate([free[kept], *(np.full(len(f), free[d]) for d, f in zip(dependent, follows, strict=True))])
    columns = np.concatenate([np.arange(len(kept)), *(place[f] for f in follows)])
    entries = np.concatenate([np.ones(len(kept)), *values])
    motion = sparse.csr_matrix((entries, (rows, columns)), shape=(fe.ndof, len(kept)))
    return HeldMotion(free=free[kept], motion=motion)


def _equations(fe: FEModel, fixed) -> sparse.csr_matrix | None:
    """Return equations (r, ndof) of what is held beside freedoms of its own; None if there are none."""
    size = 6 * len(fe.nodes)
    if fe.expansion is not None:
        motion = fe.expansion
    else:
        rows = 6 * fe.dofs[:, 0] + fe.dofs[:, 1]
        motion = sparse.csr_matrix((np.ones(fe.ndof), (rows, np.arange(fe.ndof))), shape=(size, fe.ndof))
    found = []
    if fe.expansion is not None:
        own = np.zeros(size, bool)
        own[6 * fe.dofs[:, 0] + fe.dofs[:, 1]] = True
        places = held_places(fe, fixed)
        if len(linked := places[~own[places]]):
            found.append(motion[linked])
    if isinstance(fixed, str) and fixed in fe.slanted:
        slanted = fe.slanted[fixed].copy()
        slanted.resize(slanted.shape[0], size)  # nodes that were added to the deck's
        found.append(slanted @ motion)
    return sparse.vstack(found, format="csr") if found else None


def _solved(equations: sparse.csc_matrix) -> tuple[list[int], list[np.ndarray], list[np.ndarray]]:
    """Return freedoms that follow, whom each follows, and with which factors; equations that repeat others fall out.

    Equations that share freedoms are solved together, by QR with pivoting.
    """
    rows = equations.tocsr()
    _, group = connected_components(abs(rows) @ abs(rows).T, directed=False)
    dependent: list[int] = []
    follows: list[np.ndarray] = []
    values: list[np.ndarray] = []
    order = np.argsort(group, kind="stable")
    for own in np.split(order, np.flatnonzero(np.diff(group[order])) + 1):
        part = rows[own]
        columns = np.unique(part.indices)
        triangle, pivots = linalg.qr(part[:, columns].toarray(), mode="r", pivoting=True)
        diagonal = np.abs(np.diag(triangle))
        rank = int((diagonal > REDUNDANT * diagonal.max(initial=0.0)).sum())
        factors = -linalg.solve_triangular(triangle[:rank, :rank], triangle[:rank, rank:])
        for k in range(rank):
            used = np.flatnonzero(np.abs(factors[k]) > 0.0)
            dependent.append(int(columns[pivots[k]]))
            follows.append(columns[pivots[rank:]][used])
            values.append(factors[k, used])
    return dependent, follows, values
