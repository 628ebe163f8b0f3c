"""Fill-reducing order by geometric nested dissection, and the tree of dense fronts that follows from it.

The nodes are halved along the best of the coordinate axes and their own long axis; the smallest set of nodes that
cuts all edges between the halves (vertex cover by bipartite matching, Koenig's theorem) becomes the separator, which
is eliminated after both halves (George 1973; Liu, Math. Comp. 1990, for separators from matchings).
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from flexmb.math.kernel import inner_kernel, kernel

__all__ = ["dissect", "front_tree", "node_graph", "pseudo_coordinates"]


@kernel
def _collapse(indptr, indices, start, freedoms, node_of, out_start, out):
    """Adjacent nodes of each node, from the rows of its freedoms; fills `out` if it is long enough, counts else."""
    n = len(start) - 1
    mark = np.full(n, -1, np.int64)
    total = 0
    for a in range(n):
        mark[a] = a
        for f in range(start[a], start[a + 1]):
            row = freedoms[f]
            for e in range(indptr[row], indptr[row + 1]):
                b = node_of[indices[e]]
                if mark[b] != a:
                    mark[b] = a
                    if len(out):
                        out[total] = b
                    total += 1
        out_start[a + 1] = total
    return total


def node_graph(K: sparse.csr_matrix, node_of: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the symmetric adjacency (start, neighbours) of the n nodes whose freedoms K couples.

    The pattern is symmetrised: a stored zero may be there in one triangle only, and a front tree built from an
    unsymmetric pattern gives a wrong factor without a warning.
    """
    freedoms = np.argsort(node_of, kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(node_of, minlength=n))])
    out_start = np.zeros(n + 1, np.int64)
    arguments = (K.indptr, K.indices, start, freedoms, node_of)
    neighbours = np.empty(_collapse(*arguments, out_start, np.empty(0, np.int64)), np.int64)
    if len(neighbours):
        _collapse(*arguments, out_start, neighbours)
    graph = sparse.csr_matrix((np.ones(len(neighbours), np.int8), neighbours, out_start), shape=(n, n))
    graph = (graph + graph.T).tocsr()
    return graph.indptr.astype(np.int64), graph.indices.astype(np.int64)


@kernel
def pseudo_coordinates(start, neighbours):
    """Distances (in edges) from three far-apart nodes: coordinates for a graph that has none, (n, 3)."""
    n = len(start) - 1
    x = np.zeros((n, 3))
    root = 0
    for k in range(3):
        for sweep in range(2 if k == 0 else 1):
            seen = np.full(n, -1, np.int64)
            queue = np.empty(n, np.int64)
            queue[0], seen[root] = root, 0
            head, tail = 0, 1
            while head < tail:
                a = queue[head]
                head += 1
                for e in range(start[a], start[a + 1]):
                    b = neighbours[e]
                    if seen[b] < 0:
                        seen[b] = seen[a] + 1
                        queue[tail] = b
                        tail += 1
            if k == 0 and sweep == 0:
                root = queue[tail - 1]
        x[:, k] = seen
        root = np.argmax(x[:, 0] * 1.0 if k == 0 else np.minimum(x[:, 0], x[:, 1]))
    return x


@inner_kernel
def _match(left, start, neighbours, side, right_mark, pair, visited, counter):
    """Maximum matching of the cut edges (augmenting paths from each left node), in `pair` (node -> node or -1)."""
    path = np.empty(len(left) + 1, np.int64)
    edge = np.empty(len(left) + 1, np.int64)
    for a0 in left:  # cheap start: any free partner
        for e in range(start[a0], start[a0 + 1]):
            b = neighbours[e]
            if side[b] == right_mark and pair[b] < 0:
                pair[a0], pair[b] = b, a0
                break
    for a0 in left:
        if pair[a0] >= 0:
            continue
        counter[1] += 1
        stamp = counter[1]
        depth = 0
        path[0], edge[0] = a0, start[a0]
        while depth >= 0:
            a = path[depth]
            descended = False
            while edge[depth] < start[a + 1]:
                b = neighbours[edge[depth]]
                edge[depth] += 1
                if side[b] != right_mark or visited[b] == stamp:
                    continue
                visited[b] = stamp
                if pair[b] < 0:  # augment along the path
                    while depth >= 0:
                        a = path[depth]
                        before = pair[a]
                        pair[a], pair[b] = b, a
                        b = before
                        depth -= 1
                    descended = True
                    break
                depth += 1
                path[depth], edge[depth] = pair[b], start[pair[b]]
                descended = True
                break
            if not descended:
                depth -= 1


@kernel
def _separator(nodes, count, start, neighbours, side, pair, visited, counter):
    """Smallest vertex cover of the edges between the first `count` nodes and the others (Koenig)."""
    counter[0] += 2
    left_mark, right_mark = counter[0], counter[0] + 1
    for i in range(len(nodes)):
        side[nodes[i]] = left_mark if i < count else right_mark
        pair[nodes[i]] = -1
    touching = 0
    left = np.empty(count, np.int64)
    for i in range(count):
        a = nodes[i]
        for e in range(start[a], start[a + 1]):
            if side[neighbours[e]] == right_mark:
                left[touching] = a
                touching += 1
                break
    left = left[:touching]
    _match(left, start, neighbours, side, right_mark, pair, visited, counter)
    counter[1] += 1
    stamp = counter[1]
    cover = np.empty(2 * touching, np.int64)
    queue = np.empty(touching, np.int64)
    tail = 0
    for a in left:
        if pair[a] < 0:
            visited[a] = stamp
            queue[tail] = a
            tail += 1
    head, size = 0, 0
    while head < tail:  # alternating paths from free left nodes
        a = queue[head]
        head += 1
        for e in range(start[a], start[a + 1]):
            b = neighbours[e]
            if side[b] == right_mark and visited[b] != stamp:
                visited[b] = stamp
                cover[size] = b
                size += 1
                if visited[pair[b]] != stamp:
                    visited[pair[b]] = stamp
                    queue[tail] = pair[b]
                    tail += 1
    for a in left:
        if visited[a] != stamp:
            cover[size] = a
            size += 1
    return cover[:size]


def _directions(x: np.ndarray) -> list[np.ndarray]:
    """Directions worth a cut: the coordinate axes of nearly the largest extent, and the long axis of a slanted part."""
    extent = np.ptp(x, axis=0)
    directions = [np.eye(3)[k] for k in range(3) if extent[k] >= 0.7 * extent.max()]
    d = x - x.mean(axis=0)
    long_axis = np.linalg.eigh(d.T @ d)[1][:, 2]
    return directions if np.abs(long_axis).max() > 0.999 else [*directions, long_axis]


def _half(values: np.ndarray) -> int:
    """Where to cut ascending values: between different ones if that leaves 40 % to 60 % on either side."""
    middle, same = len(values) // 2, 1e-9 * (values[-1] - values[0])
    low, high = np.searchsorted(values, [values[middle] - same, values[middle] + same])
    best = low if middle - low <= high - middle else high
    return int(best) if 0.4 * len(values) <= best <= 0.6 * len(values) else middle


def dissect(start: np.ndarray, neighbours: np.ndarray, x: np.ndarray, leaf: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the elimination order of the nodes and the end of each front in it.

    Parameters
    ----------
    start, neighbours : symmetric adjacency of n nodes
    x : (n, 3), node coordinates
    leaf : int, parts of at most so many nodes are not divided

    Returns
    -------
    order : (n,), nodes in elimination order
    ends : (fronts,), end of each front's own nodes in `order`, ascending
    """
    n = len(x)
    order, ends = np.arange(n), []
    side, pair, visited = (np.zeros(n, np.int64) for _ in range(3))
    counter = np.zeros(2, np.int64)  # marks of sides, stamps of visits: they only grow, so nothing is ever cleared
    stack = [(0, n)]
    while stack:
        lo, hi = stack.pop()
        if hi - lo <= leaf:
            ends += [hi] * (hi > lo)
            continue
        nodes = order[lo:hi]
        parts = _divide(nodes, start, neighbours, x[nodes], side, pair, visited, counter)
        if parts is None:  # no cut is smaller than the part: one dense front
            ends.append(hi)
            continue
        left, _, separator = parts
        order[lo:hi] = np.concatenate(parts)
        ends += [hi] * (len(separator) > 0)
        stack += [(lo, lo + len(left)), (lo + len(left), hi - len(separator))]
    return order, np.sort(np.array(ends, np.int64))


def _divide(nodes, start, neighbours, x, side, pair, visited, counter):
    """Return (left, right, separator) of the direction with the smallest separator, or None."""
    best, fewest = None, len(nodes)
    for direction in _directions(x):
        along = x @ direction
        ranked = np.argsort(along, kind="stable")
        count = _half(along[ranked])
        cover = _separator(nodes[ranked], count, start, neighbours, side, pair, visited, counter)
        if len(cover) < fewest:
            best, fewest = (nodes[ranked], count, cover), len(cover)
    if best is None:
        return None
    ranked, count, cover = best
    visited[cover] = -1
    kept = visited[ranked] >= 0
    visited[cover] = 0
    return ranked[:count][kept[:count]], ranked[count:][kept[count:]], cover


def front_tree(start, neighbours, order, ends) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (boundary start, boundary positions, parent) of each front.

    The boundary of a front is what its elimination couples: later neighbours of its own nodes and of its children's
    boundaries, as ascending positions in `order`. The parent is the front that owns the first of them (-1: a root).
    """
    n, fronts = len(order), len(ends)
    position, owner = np.empty(n, np.int64), np.repeat(np.arange(fronts), np.diff(ends, prepend=0))
    position[order] = np.arange(n)
    parent, first_child, next_child, mark = (np.full(k, -1) for k in (fronts, fronts, fronts, n))
    rows_start = np.zeros(fronts + 1, np.int64)
    rows = _boundaries(
        start, neighbours, order, position, owner, ends, rows_start, parent, first_child, next_child, mark
    )
    front = np.repeat(np.arange(fronts), np.diff(rows_start))
    return rows_start, rows[np.lexsort((rows, front))], parent


@kernel
def _boundaries(start, neighbours, order, position, owner, ends, rows_start, parent, first_child, next_child, mark):
    """The boundaries of `front_tree`, in the order in which they are met; fills `rows_start` and `parent`."""
    n, begin = len(order), 0
    rows = np.empty(8 * n + 64, np.int64)
    for f in range(len(ends)):
        total = rows_start[f]
        if total + n > len(rows):
            longer = np.empty(2 * len(rows) + n, np.int64)
            for e in range(total):
                longer[e] = rows[e]
            rows = longer
        lowest = n
        for p in range(begin, ends[f]):
            a = order[p]
            for e in range(start[a], start[a + 1]):
                q = position[neighbours[e]]
                if q >= ends[f] and mark[q] != f:
                    mark[q] = f
                    rows[total] = q
                    lowest = min(lowest, q)
                    total += 1
        child = first_child[f]
        while child >= 0:
            for e in range(rows_start[child], rows_start[child + 1]):
                q = rows[e]
                if q >= ends[f] and mark[q] != f:
                    mark[q] = f
                    rows[total] = q
                    lowest = min(lowest, q)
                    total += 1
            child = next_child[child]
        rows_start[f + 1] = total
        if lowest < n:
            parent[f] = owner[lowest]
            next_child[f] = first_child[parent[f]]
            first_child[parent[f]] = f
        begin = ends[f]
    return rows[: rows_start[len(ends)]]
