"""`LinkRows`: freedoms of a deck that follow others, and their elimination.

Every link becomes rows ``u_d = sum c_j u_j`` with one dependent freedom each. Links that hang on other links are
followed to freedoms that are free. A freedom is numbered ``6 node + direction``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import linalg, sparse
from scipy.sparse.linalg import splu

from flexmb.errors import MeshError

__all__ = ["Equation", "Frames", "LinkRows", "arm", "eliminated", "follow", "mean_motion", "rows_of", "solved_together"]

Frames = dict[int, np.ndarray]
"""Axes (3, 3) of the displacements of a node, rows 1, 2, 3, where they are not the basic ones."""

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
        self.rigid: tuple[ArrayLike, np.ndarray] | None = None
        """Reference node (one, or one for each) and dependent nodes (in all translations) of a rigid link, for its
        geometric stiffness."""
        self._count = 0

    def add(self, dependent: ArrayLike, columns: ArrayLike, matrix: np.ndarray) -> None:
        """Add explicit rows: ``u[dependent] = matrix @ u[columns]``."""
        matrix = np.asarray(matrix, float)
        i, j = np.nonzero(np.abs(matrix) > NEGLIGIBLE * max(np.abs(matrix).max(initial=0.0), 1e-300))
        self.dependent.append(np.asarray(dependent, np.int64))
        self.rows.append(self._count + i)
        self.columns.append(np.asarray(columns, np.int64)[j])
        self.values.append(matrix[i, j])
        self._count += len(matrix)

    def add_equations(self, columns: ArrayLike, matrix: np.ndarray, candidates: ArrayLike, part: str) -> None:
        """Add ``matrix @ u[columns] = 0`` (r, k): r of the candidate freedoms become dependent, the best conditioned.

        Columns of rotations are weighed like translations after scaling to unit size.
        """
        matrix, columns = np.asarray(matrix, float), np.asarray(columns, np.int64)
        may = np.flatnonzero(np.isin(columns, np.asarray(candidates)))
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
                remedy="Choose other dependent components, or remove redundant equations",
            )
        chosen = may[order[: len(matrix)]]
        rest = np.setdiff1d(np.arange(len(columns)), chosen)
        self.add(columns[chosen], columns[rest], -np.linalg.solve(scaled[:, chosen], scaled[:, rest]))


@dataclass(frozen=True)
class Equation:
    """``row @ u[columns] = 0``, in which one of the freedoms `first`, all of one node, follows the others."""

    name: str
    who: str
    columns: np.ndarray
    row: np.ndarray
    first: np.ndarray

    @staticmethod
    def of(
        name: str, who: str, columns: Sequence[np.ndarray], rows: Sequence[np.ndarray], first: np.ndarray
    ) -> Equation:
        """Return the equation of terms that may name a freedom more than once.

        Raises
        ------
        MeshError
            Nothing is left of the first term.
        """
        every, inverse = np.unique(np.concatenate(columns), return_inverse=True)
        merged = np.zeros(len(every))
        np.add.at(merged, inverse.ravel(), np.concatenate(rows))
        used = np.abs(merged) > 0.0
        if not np.isin(first, every[used]).any():
            raise MeshError(
                who,
                found="a first term with the factor 0, or whose factors cancel",
                expected="a first term that follows the others",
                remedy="Put a term with another factor first, or remove the equation",
            )
        return Equation(name, who, every[used], merged[used], first)


def solved_together(equations: Iterable[Equation]) -> list[LinkRows]:
    """Return the links of equations; those that free one node with turned axes of freedoms are solved together.

    There a component is a mixture of the basic freedoms, and one by one two equations could choose the same of them.
    """
    groups: dict[int, list[Equation]] = {}
    for equation in equations:
        groups.setdefault(int(equation.first[0]) // 6, []).append(equation)
    out = []
    for group in groups.values():
        parts = [group] if any(len(equation.first) > 1 for equation in group) else [[one] for one in group]
        for part in parts:
            columns = np.unique(np.concatenate([equation.columns for equation in part]))
            matrix = np.zeros((len(part), len(columns)))
            for k, equation in enumerate(part):
                matrix[k, np.searchsorted(columns, equation.columns)] = equation.row
            link = LinkRows(_listed([equation.name for equation in part]))
            who = _listed([equation.who for equation in part])
            link.add_equations(columns, matrix, np.concatenate([e.first for e in part]), who)
            out.append(link)
    return out


def _listed(names: Sequence[str]) -> str:
    """Return the different names, the first four of many."""
    words = list(dict.fromkeys(names))
    if len(words) > 5:
        words = [*words[:4], f"{len(words) - 4} others"]
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def eliminated(
    part: str, links: Sequence[LinkRows], size: int, node_name: Callable[[int], str]
) -> tuple[np.ndarray, sparse.csr_matrix]:
    """Return which freedoms (size,) depend on others, and G (size, size): the motion of all from the rest.

    Rows of independent freedoms of G are rows of the identity; columns of dependent ones are empty.

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
    _refuse_twice(part, follows, of, names, node_name)
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


def _refuse_twice(
    part: str, follows: np.ndarray, of: np.ndarray, names: list[str], node_name: Callable[[int], str]
) -> None:
    order = np.argsort(follows, kind="stable")
    twice = np.flatnonzero(np.diff(follows[order]) == 0)
    if len(twice):
        first, second = of[order[twice[0]]], of[order[twice[0] + 1]]
        freedom = int(follows[order[twice[0]]])
        raise MeshError(
            part,
            found=f"direction {freedom % 6 + 1} of {node_name(freedom // 6)} depends on {names[first]} "
            f"and on {names[second]}",
            expected="each freedom dependent in one link at most",
            remedy="Remove it from one of the two links",
        )


def rows_of(node: int, directions: Iterable[int], frames: Frames) -> np.ndarray:
    """Return (k, 6): directions of a node in its displacement system, as rows over its six basic freedoms."""
    axes = frames.get(node)
    turn = np.eye(6)
    if axes is not None:
        turn[:3, :3] = turn[3:, 3:] = axes
    return turn[list(directions)]


def arm(points: np.ndarray, node: int, reference: int) -> np.ndarray:
    """Return (6, 6): the motion of a node from the motion of a rigid body at the reference."""
    x, y, z = points[node] - points[reference]
    matrix = np.eye(6)
    matrix[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    return matrix


def follow(
    link: LinkRows, points: np.ndarray, frames: Frames, node: int, directions: list[int], reference: int, who: str
) -> None:
    """Let directions of a node, in its displacement system, follow a reference node rigidly."""
    own, columns = 6 * node + np.arange(6), 6 * reference + np.arange(6)
    motion = arm(points, node, reference)
    if node not in frames or ({0, 1, 2} <= set(directions) and len(directions) in (3, 6)):
        link.add(own[directions], columns, motion[directions])
        return
    rows = rows_of(node, directions, frames)
    link.add_equations(np.concatenate([own, columns]), np.hstack([rows, -rows @ motion]), own, who)


def mean_motion(
    points: np.ndarray,
    frames: Frames,
    groups: list[tuple[int, list[int], float]],
    reference: int,
    directions: list[int],
    who: str,
) -> tuple[np.ndarray, np.ndarray]:
    """Return freedoms (k,) and the weighted least-squares rigid motion (6, k) at a reference of what they do.

    `groups` are (node, directions, weight). Rotations among the directions count with the square of the distance of
    the farthest point, so that weights keep their meaning in any unit of length.
    """
    moves, blocks, weights = [], [], []
    for node, parts, weight in groups:
        rows = rows_of(node, parts, frames)
        moves.append(rows @ arm(points, node, reference))
        blocks.append(rows)
        weights += [weight] * len(parts)
    motion = np.vstack(moves)
    columns = np.concatenate([6 * node + np.arange(6) for node, _, _ in groups])
    pick = sparse.block_diag(blocks, format="csr")
    nodes = np.array([node for node, _, _ in groups])
    length = float(np.linalg.norm(points[nodes] - points[reference], axis=1).max()) or 1.0
    scale = np.array([1.0, 1.0, 1.0, 1.0 / length, 1.0 / length, 1.0 / length])
    turn = np.array([direction >= 3 for _, parts, _ in groups for direction in parts])
    w = np.where(turn, np.array(weights) * length**2, weights)
    scaled = motion * scale
    values, vectors = np.linalg.eigh(scaled.T @ (w[:, None] * scaled))
    firm = values > 1e-10 * values[-1]
    needed = rows_of(reference, directions, frames) * scale
    if not firm.all() and (np.abs(needed @ vectors[:, ~firm]) > 1e-6).any():
        raise MeshError(
            who,
            found=f"{len(groups)} points that do not determine the motion of the reference (on one line?)",
            expected="points off one line, or rotations among their components",
            remedy="Add points or components",
        )
    inverse = (vectors[:, firm] / values[firm]) @ vectors[:, firm].T
    return columns, (pick.T @ (scale[:, None] * (inverse @ (scaled.T * w))).T).T
