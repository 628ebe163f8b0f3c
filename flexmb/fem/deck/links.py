"""`LinkRows`: freedoms of a deck that follow others, and their elimination.

Every link becomes rows ``u_d = sum c_j u_j`` with one dependent freedom each. Links that hang on other links are
followed to freedoms that are free. A freedom is numbered ``6 node + direction``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import linalg, sparse
from scipy.sparse.linalg import splu

from flexmb.errors import MeshError

__all__ = ["LinkRows", "eliminated"]

SINGULAR = 1e-9
"""A pivot smaller than this share of the largest coefficient of its link makes the link indeterminate."""
NEGLIGIBLE = 1e-12
"""Coefficients of a link below this share of its largest are rounding of a turned coordinate system."""
DEEPEST = 64
"""Links upon links are followed by substitution this far, beyond it by one factorisation."""


class LinkRows:
    """Rows of one kind of link: dependent freedoms, and who they follow.

    Parameters
    ----------
    name : str
        Of the card, for messages: "RBE2 1001".
    """

    def __init__(self, name: str):
        self.name = name
        self.dependent: list[np.ndarray] = []
        self.rows: list[np.ndarray] = []
        self.columns: list[np.ndarray] = []
        self.values: list[np.ndarray] = []
        self.rigid: tuple[int, np.ndarray] | None = None
        """Reference node and dependent nodes (in all translations) of a rigid link, for its geometric stiffness."""
        self._count = 0

    def add(self, dependent: Sequence[int], columns: Sequence[int], matrix: np.ndarray) -> None:
        """Add explicit rows: ``u[dependent] = matrix @ u[columns]``."""
        matrix = np.asarray(matrix, float)
        i, j = np.nonzero(np.abs(matrix) > NEGLIGIBLE * max(np.abs(matrix).max(initial=0.0), 1e-300))
        self.dependent.append(np.asarray(dependent, np.int64))
        self.rows.append(self._count + i)
        self.columns.append(np.asarray(columns, np.int64)[j])
        self.values.append(matrix[i, j])
        self._count += len(matrix)

    def add_equations(self, columns: Sequence[int], matrix: np.ndarray, candidates: Sequence[int], part: str) -> None:
        """Add ``matrix @ u[columns] = 0`` (r, k): r of the candidate freedoms become dependent, the best conditioned.

        Columns of rotations are weighed like those of translations after scaling to unit size.
        """
        matrix, columns = np.asarray(matrix, float), np.asarray(columns, np.int64)
        may = np.flatnonzero(np.isin(columns, candidates))
        scale = np.abs(matrix).max(axis=1, keepdims=True)
        scaled = matrix / np.where(scale > 0.0, scale, 1.0)
        if len(may) < len(matrix):
            raise MeshError(
                part,
                found=f"{len(matrix)} equations for {len(may)} freedoms that may follow",
                expected="as many freedoms as equations at least",
                remedy="Correct the dependent components of the card",
            )
        triangle, order = linalg.qr(scaled[:, may], mode="r", pivoting=True)
        pivots = np.abs(np.diag(triangle))
        if not pivots.min(initial=1.0) > SINGULAR * max(pivots.max(initial=1.0), 1e-300):
            raise MeshError(
                part,
                found="equations that do not determine the dependent freedoms",
                expected="independent equations in the dependent components",
                remedy="Choose other dependent components, or remove what repeats",
            )
        chosen = may[order[: len(matrix)]]
        rest = np.setdiff1d(np.arange(len(columns)), chosen)
        self.add(columns[chosen], columns[rest], -np.linalg.solve(scaled[:, chosen], scaled[:, rest]))


def eliminated(part: str, links: Sequence[LinkRows], size: int) -> tuple[np.ndarray, sparse.csr_matrix]:
    """Return which freedoms (size,) depend on others, and G (size, size): the motion of all from that of the rest.

    Rows of independent freedoms of G are those of the identity; columns of dependent ones are empty.

    Raises
    ------
    MeshError
        A freedom that follows two links, or links that follow each other in a circle.
    """
    dependent, rows, columns, values, owner, names = [], [], [], [], [], []
    count = 0
    for link in links:
        for block, i, j, value in zip(link.dependent, link.rows, link.columns, link.values, strict=True):
            dependent.append(block)
            rows.append(count + i)
            columns.append(j)
            values.append(value)
        owner.append(np.full(link._count, len(names)))
        names.append(link.name)
        count += link._count
    mask = np.zeros(size, bool)
    if not count:
        return mask, sparse.identity(size, format="csr")
    follows = np.concatenate(dependent)
    of = np.concatenate(owner)
    _refuse_twice(part, follows, of, names)
    mask[follows] = True
    direct = sparse.csr_matrix(
        (np.concatenate(values), (follows[np.concatenate(rows)], np.concatenate(columns))), shape=(size, size)
    )
    free = sparse.diags((~mask).astype(float), format="csr")
    bound = sparse.diags(mask.astype(float), format="csr")
    onto_free, onto_bound = (direct @ free).tocsr(), (direct @ bound).tocsr()
    onto_bound.eliminate_zeros()
    total, carried = onto_free, onto_bound
    for _ in range(DEEPEST):
        if not carried.nnz:
            return mask, (free + total).tocsr()
        total = total + carried @ onto_free
        carried = (carried @ onto_bound).tocsr()
        carried.eliminate_zeros()
    try:
        solved = splu((sparse.identity(size) - onto_bound).tocsc()).solve(onto_free.toarray())
    except (RuntimeError, MemoryError):
        at = int(carried.nonzero()[0][0])
        raise MeshError(
            part,
            found=f"{names[of[int(np.flatnonzero(follows == at)[0])]]} follows itself through other links",
            expected="links that end at free nodes",
            remedy="Break the circle: one of its nodes must be free",
        ) from None
    return mask, (free + sparse.csr_matrix(solved)).tocsr()


def _refuse_twice(part: str, follows: np.ndarray, of: np.ndarray, names: list[str]) -> None:
    order = np.argsort(follows, kind="stable")
    twice = np.flatnonzero(np.diff(follows[order]) == 0)
    if len(twice):
        first, second = of[order[twice[0]]], of[order[twice[0] + 1]]
        freedom = int(follows[order[twice[0]]])
        raise MeshError(
            part,
            found=f"direction {freedom % 6 + 1} of the node with index {freedom // 6} depends on {names[first]} "
            f"and on {names[second]}",
            expected="each freedom dependent in one link at most",
            remedy="Remove it from one of the two links",
        )
