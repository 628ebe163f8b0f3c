"""The order and the fill of a matrix in which some blocks read others that do not read them.

The rate of a controller's state reads places of bodies and other states; bodies move by those states alone that a
force follows. So most states stand in rows of states only. Eliminated first, from the last one of a chain to the first,
such a state changes the rows of those that read it and of nobody else, and the bodies' part of the matrix is what it
was.

A pattern that is symmetric, as that of bodies and joints is, would have a place wherever a state is read by what it
reads, and the elimination would fill all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from heapq import heapify, heappop, heappush

__all__ = ["both_ways", "filled", "states_first"]


def states_first(
    sizes: Sequence[int], states: Sequence[int], reads: list[set[int]]
) -> tuple[list[int], list[set[int]], list[set[int]]]:
    """Return the states that only states read, in the order of their elimination; of each what it then reads, and who
    reads it.

    The one with the fewest products of rows that read it and columns that it reads goes first (Markowitz 1957); among
    equals one that the last has read, so that chains stay together.

    Parameters
    ----------
    sizes : sequence of int
        Rows of every node.
    states : sequence of int
        Nodes that are states.
    reads : list of sets of int
        The columns of every row, without its own; what is left of them after the elimination is written here.
    """
    readers: dict[int, set[int]] = {k: set() for k in states}
    for row, columns in enumerate(reads):
        for k in columns & readers.keys():
            readers[k].add(row)
    left = {k for k in states if readers[k] <= readers.keys()}

    def weight(k: int) -> int:
        return sum(sizes[i] for i in readers[k]) * sum(sizes[j] for j in reads[k])

    weights = {k: weight(k) for k in left}
    order: list[int] = []
    near: set[int] = set()
    while left:
        node = min(left, key=lambda k: (weights[k], k not in near, k))
        left.discard(node)
        order.append(node)
        near = reads[node]
        for row in readers[node]:
            reads[row] |= near
            reads[row] -= {node, row}
        for k in near & readers.keys():
            readers[k] |= readers[node]
            readers[k] -= {node, k}
        for k in (near | readers[node]) & left:
            weights[k] = weight(k)
    return order, [reads[k] for k in order], [readers[k] for k in order]


def both_ways(reads: list[set[int]], without: Sequence[int]) -> list[set[int]]:
    """Return the adjacency that has every place on both sides of the diagonal; none of the nodes `without`."""
    gone = set(without)
    found: list[set[int]] = [set() for _ in reads]
    for row, columns in enumerate(reads):
        if row not in gone:
            for k in columns - gone:
                found[row].add(k)
                found[k].add(row)
    return found


def filled(groups: list[list[int]], reads: list[set[int]]) -> tuple[list[list[int]], list[list[int]]]:
    """Return the earlier and the later blocks in the rows of every block, including fill.

    Parameters
    ----------
    groups : list of lists of int
        The nodes of every block, in the order of elimination.
    reads : list of sets of int
        The columns of every node's rows in the matrix.
    """
    block_of = {node: k for k, group in enumerate(groups) for node in group}
    earlier: list[list[int]] = []
    later: list[list[int]] = []
    for k, group in enumerate(groups):
        known = {block_of[column] for node in group for column in reads[node]} - {k}
        before = [j for j in known if j < k]
        heapify(before)
        taken = []
        while before:
            j = heappop(before)
            taken.append(j)
            for new in later[j]:
                if new != k and new not in known:
                    known.add(new)
                    if new < k:
                        heappush(before, new)
        earlier.append(taken)
        later.append(sorted(j for j in known if j > k))
    return earlier, later
