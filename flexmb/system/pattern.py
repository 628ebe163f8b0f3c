"""The order of elimination and the pattern of the factors of the iteration matrix.

Nodes of the graph are the bodies (their velocities) and the joints (their multipliers, a drive together with its
joint). A multiplier has a zero on the diagonal, so it may be eliminated only when its pivot is certain to be regular:
after all its bodies, or, as the last joint of a body, after that body alone (the equations of one joint are independent
on one body that no other joint holds). The second rule condenses trees from their leaves, as the O(n) recursions do.
In a loop it would count the rest of the model as fixed, and take freedoms twice; there joints wait for all their
bodies. Among the permitted nodes the one with the smallest neighbours goes first.

Where bodies are larger than joints, as those with modes are, that rule leaves a tree near its root. A second order
takes nodes whose neighbours all know each other before all others: they fill nothing in, so trees go from their
leaves to the last joint. The order with fewer multiplications is used.
"""

from __future__ import annotations

from heapq import heappop, heappush
from itertools import combinations

import numpy as np

from flexmb.math.block_pattern import PARENT, BlockPattern

__all__ = ["block_pattern", "cheapest_order", "elimination_order", "multiplications"]

FEW = 6
"""Neighbours of a node up to which they are asked for each other."""


def elimination_order(
    sizes: list[int], n_bodies: int, neighbours: list[set[int]], waiting: set[int], leaves: bool = False
) -> tuple[list[int], list[list[int]]]:
    """Return the order of the nodes and for each node its later neighbours including fill.

    Nodes below `n_bodies` are bodies, the others joints; `neighbours` is the symmetric adjacency, which is consumed.
    Joints in `waiting` come after all their bodies. With `leaves` nodes that fill nothing in come first.
    """
    bodies_of = {j: {b for b in neighbours[j] if b < n_bodies} for j in range(n_bodies, len(sizes))}
    joints_of = [{j for j in neighbours[b] if j >= n_bodies} for b in range(n_bodies)]
    done = np.zeros(len(sizes), bool)
    used = np.zeros(n_bodies, bool)
    after: dict[int, list[int]] = {}
    order: list[int] = []

    def permitted(node):
        if node < n_bodies:
            return True
        bodies = bodies_of[node]
        if all(done[b] for b in bodies):
            return True
        return node not in waiting and any(held_only_by(node, b) for b in bodies)

    def held_only_by(joint, body):
        others = all(done[j] for j in joints_of[body] if j != joint)
        return done[body] and not used[body] and others and sizes[joint] <= sizes[body]

    def weight(node):
        around = neighbours[node]
        if leaves and len(around) <= FEW and all(b in neighbours[a] for a, b in combinations(around, 2)):
            return 0
        return sum(sizes[k] for k in around)

    heap: list[tuple[int, int]] = []
    for node in range(len(sizes)):
        if permitted(node):
            heappush(heap, (weight(node), node))
    while heap:
        claimed, node = heappop(heap)
        if done[node] or not permitted(node):
            continue
        if claimed != weight(node):
            heappush(heap, (weight(node), node))
            continue
        done[node] = True
        order.append(node)
        later = neighbours[node]
        after[node] = sorted(later)
        for k in later:
            neighbours[k].discard(node)
            neighbours[k] |= later
            neighbours[k].discard(k)
        bodies = bodies_of.get(node, {node})
        for b in bodies - {node}:
            used[b] |= done[b]
        for k in later.union(*(joints_of[b] for b in bodies)):
            if not done[k] and permitted(k):
                heappush(heap, (weight(k), k))
    return order, [after[node] for node in order]


def multiplications(sizes: list[int], order: list[int], after: list[list[int]]) -> float:
    """Return how many multiplications an elimination takes."""
    count = 0.0
    for node, later in zip(order, after, strict=True):
        size, width = sizes[node], sum(sizes[k] for k in later)
        count += size**3 / 3.0 + size * width * (size + width)
    return count


def cheapest_order(
    sizes: list[int], n_bodies: int, neighbours: list[set[int]], waiting: set[int]
) -> tuple[list[int], list[list[int]]]:
    """Return the order of elimination with fewer multiplications, see `elimination_order`; consumes `neighbours`."""
    again = [set(nodes) for nodes in neighbours]
    one = elimination_order(sizes, n_bodies, neighbours, waiting)
    if all(len(later) <= PARENT for later in one[1]):
        return one
    two = elimination_order(sizes, n_bodies, again, waiting, leaves=True)
    return two if multiplications(sizes, *two) < multiplications(sizes, *one) else one


def block_pattern(unknowns: list[list[int]], n_bodies: int, neighbours: list[set[int]], waiting: set[int]):
    """Return the pattern of the factors and ``place``: a function (node, node) -> positions of the rows in S.

    Parameters
    ----------
    unknowns : list of lists of int
        The unknowns of every node; nodes below `n_bodies` are bodies, the others joints.
    neighbours : list of sets
        Adjacency; consumed.
    waiting : set of int
        Joints that are eliminated after all their bodies.
    """
    order, after = cheapest_order([len(node) for node in unknowns], n_bodies, neighbours, waiting)
    # from here on nodes are numbered by their place in the order, so that what is appended in turn is sorted
    position = dict(zip(order, range(len(order)), strict=True))
    later = [sorted(position[node] for node in nodes) for nodes in after]
    earlier: list[list[int]] = [[] for _ in order]
    for k, others in enumerate(later):
        for other in others:
            earlier[other].append(k)
    sizes = [len(unknowns[node]) for node in order]
    first = np.concatenate([[0], np.cumsum(sizes)])
    width, segment_start, column, length = [], [0], [], []
    own_segment: list[int] = []
    offset: list[dict[int, int]] = []
    for k in range(len(order)):
        at, offsets, end = 0, {}, -1
        for other in (*earlier[k], k, *later[k]):
            offsets[other] = at
            at += sizes[other]
            if other == k:
                own_segment.append(len(column))
            if end == other and k not in (other, other - 1):  # neighbours are one segment, but for the own block
                length[-1] += sizes[other]
            else:
                column.append(other)
                length.append(sizes[other])
            end = other + 1
        offset.append(offsets)
        width.append(at)
        segment_start.append(len(column))
    row_block = np.repeat(np.arange(len(order)), sizes)
    pattern = BlockPattern(
        order=np.array([unknown for node in order for unknown in unknowns[node]], np.int64),
        row_start=np.concatenate([[0], np.cumsum(np.array(width, np.int64)[row_block])]),
        row_block=row_block,
        segment_start=np.array(segment_start, np.int64),
        column=first[column],
        length=np.array(length, np.int64),
        block_start=first,
        own=np.array([offset[k][k] for k in range(len(order))], np.int64),
        own_segment=np.array(own_segment, np.int64),
        **_steps(later, earlier, sizes, offset),
        scratch=np.zeros(2 * first[-1]),
    )
    begin = first.tolist()

    def place(row_node: int, column_node: int) -> np.ndarray:
        k = position[row_node]
        return pattern.row_start[begin[k] : begin[k + 1]] + offset[k][position[column_node]]

    return pattern, place


def _steps(later, earlier, sizes, offset) -> dict[str, np.ndarray]:
    """Return the elimination steps of every block, and the runs of columns that each changes, neighbours joined."""
    step_start, source, at, run_start = [0], [], [], [0]
    runs: list[tuple[int, int, int]] = []
    for k, own in enumerate(offset):
        for before in earlier[k]:
            source.append(before)
            at.append(own[before])
            first = len(runs)
            for other in later[before]:
                to, start, length = own[other], offset[before][other], sizes[other]
                if len(runs) > first and runs[-1][0] + runs[-1][2] == to and runs[-1][1] + runs[-1][2] == start:
                    to, start, length = runs[-1][0], runs[-1][1], runs.pop()[2] + length
                runs.append((to, start, length))
            run_start.append(len(runs))
        step_start.append(len(source))
    table = np.array(runs, np.int64).reshape(-1, 3)
    names = {"step_start": step_start, "source": source, "at": at, "run_start": run_start}
    arrays = {name: np.array(values, np.int64) for name, values in names.items()}
    return {**arrays, "run_to": table[:, 0].copy(), "run_from": table[:, 1].copy(), "run_length": table[:, 2].copy()}
