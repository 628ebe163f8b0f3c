"""The search for dependent equations: row by row for the first ones that span all, without dense matrices.

Joints that no state of self-stress can reach are removed: joints whose equations are independent on one body that no
other joint holds, repeatedly, from the leaves of a tree to its root. For the rest, the joints of loops, A^T is
triangularised front by front (multifrontal QR: Davis, Direct Methods for Sparse Linear Systems, 2006, ch. 5; with
dependent columns left out as they appear: Heath, Some extensions of an algorithm for sparse linear least squares
problems, 1982). A front is one joint: the velocities that enter here for the first time, and what the fronts before
have left over. The pivot of an equation is its distance from the span of all earlier ones. The factor is not kept.
Joints come in the order of the model, as "the latest equations" are those to be named: an order with less fill would
find as many, but others. Pivots tell less than singular values where small ones are spread over several: what they
leave is looked at once more, by inverse iteration.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.linalg.lapack import dgeqrf, dormqr

from flexmb.errors import CompileError

__all__ = ["combinations", "dependent_rows"]

ITERATIONS = 4
"""Of the search for the least singular value: what counts is a thousand times smaller than the next."""
CROWDED = 2
"""A front's leftover with so many times more rows than columns is made triangular."""


def dependent_rows(A: sparse.csr_matrix, joints: np.ndarray, bodies: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the latest rows that can be left out so that none of the others lies within `tolerance` of their span.

    Parameters
    ----------
    A : (n, m) csr
        Rows of length one, or empty.
    joints : (n,) of int
        Rows of one number belong to one joint.
    bodies : (m,) of int
        Columns of one number belong to one body, or one node of an elastic body.
    """
    A = A.tocsr(copy=True)
    A.eliminate_zeros()
    rows = np.flatnonzero(_in_loops(A, joints, bodies, tolerance))
    if not len(rows):
        return rows
    others = np.delete(rows, _latest(A[rows], joints[rows], tolerance))
    while (near := _nearest(A[others], tolerance)) >= 0:
        others = np.delete(others, near)
    return np.setdiff1d(rows, others)


def _in_loops(A: sparse.csr_matrix, joints: np.ndarray, bodies: np.ndarray, tolerance: float) -> np.ndarray:
    """Return which rows remain when joints on bodies of their own are taken away, (n,) of bool."""
    _, joint = np.unique(joints, return_inverse=True)
    _, body = np.unique(bodies, return_inverse=True)
    n_bodies = int(body.max(initial=0)) + 1
    pairs, firm = _hold(A, joint, body, n_bodies, tolerance)
    holding, held_by = np.divmod(pairs, n_bodies)
    count = np.bincount(held_by, minlength=n_bodies).tolist()
    total = (
        np.bincount(held_by, weights=holding, minlength=n_bodies).astype(np.int64).tolist()
    )  # with one left: the joint
    starts = np.searchsorted(holding, np.arange(int(joint.max(initial=-1)) + 2)).tolist()
    held = held_by.tolist()
    waiting = [b for b, k in enumerate(count) if k == 1]
    remains = np.ones(len(starts) - 1, bool)
    while waiting:
        b = waiting.pop()
        span = range(starts[total[b]], starts[total[b] + 1]) if count[b] == 1 else ()
        if not any(held[p] == b and firm[p] for p in span):
            continue
        gone = total[b]
        remains[gone] = False
        for p in span:
            count[held[p]] -= 1
            total[held[p]] -= gone
            if count[held[p]] == 1:
                waiting.append(held[p])
    return remains[joint]


def _hold(
    A: sparse.csr_matrix, joint: np.ndarray, body: np.ndarray, n_bodies: int, tolerance: float
) -> tuple[np.ndarray, list[bool]]:
    """Return the pairs joint * n_bodies + body, sorted, and whether the joint's rows are independent on that body.

    They are if the least eigenvalue of B B^T is above `tolerance`: B is the joint's block on the body. Then no row of
    the joint is nearer than its root to the span of all other rows.
    """
    size = np.bincount(joint)
    order = np.argsort(joint, kind="stable")
    place = np.empty(len(joint), np.int64)
    place[order] = np.arange(len(joint)) - np.repeat(np.cumsum(size) - size, size)
    row = np.repeat(np.arange(A.shape[0]), np.diff(A.indptr))
    pairs, pair = np.unique(joint[row] * n_bodies + body[A.indices], return_inverse=True)
    width = int(size.max(initial=1))
    _, column = np.unique(pair * A.shape[1] + A.indices, return_inverse=True)
    B = sparse.csr_matrix((A.data, (pair * width + place[row], column)), shape=(len(pairs) * width, len(A.data)))
    product = (B @ B.T).tocoo()
    gram = np.zeros((len(pairs), width, width))
    gram[product.row // width, product.row % width, product.col % width] = product.data
    absent = np.arange(width) >= size[pairs // n_bodies][:, None]
    gram[:, np.arange(width), np.arange(width)] += absent
    return pairs, (np.linalg.eigvalsh(gram)[:, 0] > tolerance).tolist()


def combinations(A: sparse.csr_matrix):
    """Return the solver of A A^T y = b: a function b (n,) or (n, k) -> (A^T y, y).

    It solves [1, A^T; A, 0] (x, y) = (0, -b), x = -A^T y: a body that holds many joints fills A A^T, not this.
    """
    from scipy.sparse.linalg import splu

    m = A.shape[1]
    try:
        factor = splu(sparse.block_array([[sparse.identity(m), A.T], [A, None]], format="csc"))
    except (RuntimeError, ValueError):  # rows that masses near 1e300 have made zero, infinite or no numbers
        raise CompileError(
            "Constraints",
            found="equations that vanish or overflow when they are divided by the roots of the masses",
            expected="masses and moments of inertia whose powers are finite",
            remedy="Check the exponents of masses, moments of inertia and places of markers",
        ) from None

    def solve(b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        both = factor.solve(np.concatenate([np.zeros((m, *b.shape[1:])), -b]))
        return -both[:m], both[m:]

    return solve


def _nearest(A: sparse.csr_matrix, tolerance: float) -> int:
    """Return the latest of the rows within `tolerance` of the span of all others, or -1.

    With |A^T y| = s the row k is nearer than s / |y_k| to the others; inverse iteration finds the y of the least s.
    """
    if not A.shape[0]:
        return -1
    solve = combinations(A)
    y = np.random.default_rng(0).normal(size=A.shape[0])
    for _ in range(ITERATIONS):
        x, y = solve(y / np.linalg.norm(y))
    return int(np.max(np.flatnonzero(np.abs(y) * tolerance >= np.linalg.norm(x)), initial=-1))


def _latest(A: sparse.csr_matrix, joints: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the dependent rows: every front drops those whose pivots vanish."""
    bounds = np.flatnonzero(np.diff(joints, prepend=-1, append=-1))  # fronts: runs of rows of one joint
    front_of = np.repeat(np.arange(len(bounds) - 1), np.diff(bounds))
    columns = A.tocsc()
    columns.sort_indices()
    columns = columns[:, np.flatnonzero(np.diff(columns.indptr))]
    entering = front_of[columns.indices[columns.indptr[:-1]]]
    order = np.argsort(entering, kind="stable")
    columns = columns[:, order]
    enter = np.searchsorted(entering[order], np.arange(len(bounds)))
    waiting: list[list[tuple[np.ndarray, np.ndarray]]] = [[] for _ in bounds]
    dependent: list[int] = []
    for k, own in enumerate(bounds[:-1]):
        size = bounds[k + 1] - own
        at, F = _front(columns, enter[k], enter[k + 1], np.arange(own, own + size), waiting[k])
        waiting[k] = []
        dead, rest = _without_pivots(F, size, tolerance)
        dependent += [own + d for d in dead]
        if rest.size:
            waiting[front_of[at[size]]].append((at[size:], rest))
    return np.sort(np.array(dependent, int))


def _front(
    columns: sparse.csc_matrix, first: int, last: int, own: np.ndarray, children
) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of equations of a front, its own first, and its matrix:
    velocities and leftovers by equations.
    """
    start, stop = columns.indptr[first], columns.indptr[last]
    entries = columns.indices[start:stop]
    at = np.unique(np.concatenate([own, entries, *(equations for equations, _ in children)]))
    rows = last - first
    F = np.zeros((rows + sum(len(block) for _, block in children), len(at)), order="F")
    line = np.repeat(np.arange(rows), np.diff(columns.indptr[first : last + 1]))
    F[line, np.searchsorted(at, entries)] = columns.data[start:stop]
    for equations, block in children:
        F[rows : rows + len(block), np.searchsorted(at, equations)] = block
        rows += len(block)
    return at, F


def _without_pivots(F: np.ndarray, size: int, tolerance: float) -> tuple[list[int], np.ndarray]:
    """Triangularise the first `size` columns; return those without a pivot, and what is left of the others below."""
    live, dead = list(range(size)), []
    if not len(F):
        return live, F[:, size:]
    while live:
        factor, tau, _, _ = dgeqrf(F[:, live])
        pivots = np.abs(factor.diagonal())
        weak = np.flatnonzero(pivots <= tolerance)
        if not len(weak) and len(live) <= len(F):
            break
        dead.append(live.pop(int(weak[0]) if len(weak) else len(F)))
    rest = F[:, size:]
    if live and rest.size:
        rest = dormqr("L", "T", factor, tau, rest, 64 * rest.shape[1])[0][len(live) :]
    if len(rest) > CROWDED * rest.shape[1] > 0:
        rest = np.triu(dgeqrf(rest)[0][: rest.shape[1]])
    return dead, rest
