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

States of controllers are many blocks of one or two rows, and what a block costs by itself is more than their
multiplications: neighbours in the order that share columns become one block (relaxed supernodes, Ashcraft & Grimes,
The influence of relaxed supernode partitions on the multifrontal method, ACM TOMS 15, 1989). States that only states
read go before all else, see `flexmb.system.one_way`.
"""

from __future__ import annotations

from collections.abc import Sequence
from heapq import heapify, heappop, heappush
from itertools import combinations

import numpy as np

from flexmb.math.block_pattern import PARENT, BlockPattern
from flexmb.system.one_way import both_ways, filled, states_first

__all__ = ["block_pattern", "cheapest_order", "elimination_order", "joined_blocks", "multiplications"]

FEW = 6
"""Neighbours of a node up to which they are asked for each other."""
OF_A_BLOCK = 160.0
"""What a block costs beside its multiplications, and what each of those that it changes costs, in multiplications."""


def elimination_order(
    sizes: list[int], n_bodies: int, neighbours: list[set[int]], waiting: set[int], leaves: bool = False
) -> tuple[list[int], list[list[int]]]:
    """Return the order of the nodes and for each node its later neighbours including fill.

    Nodes below `n_bodies` are bodies, the others joints; `neighbours` is the symmetric adjacency, which is consumed.
    Joints in `waiting` come after all their bodies. With `leaves` nodes that fill nothing in come first.
    """
    todo = _Elimination(sizes, n_bodies, neighbours, waiting, leaves)
    after: dict[int, list[int]] = {}
    heap = [(todo.weight(node), node) for node in range(len(sizes)) if todo.permitted(node)]
    heapify(heap)
    while heap:
        claimed, node = heappop(heap)
        if todo.done[node] or not todo.permitted(node):
            continue
        if claimed != todo.weight(node):
            heappush(heap, (todo.weight(node), node))
            continue
        after[node] = sorted(neighbours[node])
        for k in todo.take(node):
            if not todo.done[k] and todo.permitted(k):
                heappush(heap, (todo.weight(k), k))
    return list(after), list(after.values())


class _Elimination:
    """What is left of a graph of bodies and joints while its nodes are taken out one by one."""

    __slots__ = (
        "bodies_of",
        "done",
        "joints_of",
        "leaves",
        "n_bodies",
        "neighbours",
        "rows",
        "sizes",
        "standing",
        "used",
        "waiting",
    )

    def __init__(self, sizes: list[int], n_bodies: int, neighbours: list[set[int]], waiting: set[int], leaves: bool):
        self.sizes, self.n_bodies, self.neighbours = sizes, n_bodies, neighbours
        self.waiting, self.leaves = waiting, leaves
        self.bodies_of = {j: {b for b in neighbours[j] if b < n_bodies} for j in range(n_bodies, len(sizes))}
        self.standing = dict.fromkeys(self.bodies_of, 0)  # bodies of a joint that are not eliminated
        for j, bodies in self.bodies_of.items():
            self.standing[j] = len(bodies)
        self.joints_of = [{j for j in neighbours[b] if j >= n_bodies} for b in range(n_bodies)]  # not eliminated
        self.rows = [sum(sizes[k] for k in around) for around in neighbours]  # around every node
        self.done = [False] * len(sizes)
        self.used = [False] * n_bodies  # bodies that a joint was eliminated after

    def permitted(self, node: int) -> bool:
        """Is the pivot of a node certain to be regular now?"""
        if node < self.n_bodies:
            return True
        if self.standing[node] == 0:
            return True
        return node not in self.waiting and any(self._held_only_by(node, b) for b in self.bodies_of[node])

    def _held_only_by(self, joint: int, body: int) -> bool:
        """Is a joint the last one of a body that is eliminated, and not larger than it?"""
        if not self.done[body] or self.used[body] or self.sizes[joint] > self.sizes[body]:
            return False
        return len(self.joints_of[body]) == (joint in self.joints_of[body])

    def weight(self, node: int) -> int:
        """Return how many rows are around a node; 0 of one that fills nothing in, if those come first."""
        around = self.neighbours[node]
        if self.leaves and len(around) <= FEW and all(b in self.neighbours[a] for a, b in combinations(around, 2)):
            return 0
        return self.rows[node]

    def take(self, node: int) -> set[int]:
        """Eliminate a node, which joins its neighbours; return the nodes that this may permit or make lighter."""
        later, neighbours, sizes = self.neighbours[node], self.neighbours, self.sizes
        self.done[node] = True
        for k in later:
            new = later - neighbours[k]
            new.discard(k)
            neighbours[k].discard(node)
            neighbours[k] |= new
            self.rows[k] += sum(sizes[other] for other in new) - sizes[node]
        if node < self.n_bodies:
            for j in self.joints_of[node]:
                self.standing[j] -= 1
            return later | self.joints_of[node]
        touched = set(later)
        for b in self.bodies_of[node]:
            self.used[b] |= self.done[b]
            self.joints_of[b].discard(node)
            if len(self.joints_of[b]) == 1:  # the last one may have become permitted
                touched |= self.joints_of[b]
        return touched


def multiplications(sizes: list[int], order: list[int], after: list[list[int]]) -> float:
    """Return how many multiplications an elimination takes."""
    count = 0.0
    for node, later in zip(order, after, strict=True):
        width = sum(sizes[k] for k in later)
        count += _of_block(sizes[node], width, width)
    return count


def _of_block(size: int, width: int, readers: int) -> float:
    """Return how many multiplications a block of so many rows takes that has so many columns behind its own, which so
    many later rows read.
    """
    return size**3 / 3.0 + size * (0.5 * size * (width + readers) + width * readers)


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


def joined_blocks(
    sizes: list[int], order: list[int], after: list[list[int]], states: range
) -> tuple[list[list[int]], list[list[int]]]:
    """Return the nodes of every block, in the order of elimination, and the later blocks of each, including fill.

    `states` : nodes that may share a block with those beside them.
    """
    groups, laters = _grouped(sizes, order, after, after, states)
    block_of = {node: k for k, group in enumerate(groups) for node in group}
    later_blocks = [{block_of[node] for node in later} for later in laters]
    if len(groups) < len(order):
        for later in later_blocks:  # what a block leaves behind knows each other
            for k in later:
                later_blocks[k] |= {other for other in later if other > k}
    return groups, [sorted(later) for later in later_blocks]


def _grouped(sizes, order, after, readers, states: range) -> tuple[list[list[int]], list[set[int]]]:
    """Return the nodes of every block, and the later nodes of each; `readers` : later nodes that read a node."""
    groups: list[list[int]] = []
    laters: list[set[int]] = []
    read_by: list[set[int]] = []

    def multiplications_of(rows: int, later: set[int], by: set[int]) -> float:
        return _of_block(rows, sum(sizes[k] for k in later), sum(sizes[k] for k in by))

    for node, later_nodes, by_nodes in zip(order, after, readers, strict=True):
        later, by = set(later_nodes), set(by_nodes)
        if groups and node in states and groups[-1][-1] in states:
            before, by_before = laters[-1], read_by[-1]
            both, by_both, shared = (before | later) - {node}, (by_before | by) - {node}, by_before & by
            rows = sum(sizes[k] for k in groups[-1])
            more = multiplications_of(rows + sizes[node], both, by_both)
            more -= multiplications_of(rows, before, by_before) + multiplications_of(sizes[node], later, by)
            alike = shared or (before & later) or node in before or node in by_before
            if alike and more < OF_A_BLOCK * (1 + len(shared) + (node in by_before)):
                groups[-1].append(node)
                laters[-1], read_by[-1] = both, by_both
                continue
        groups.append([node])
        laters.append(later)
        read_by.append(by)
    return groups, laters


def _one_way_blocks(
    sizes: list[int], n_bodies: int, reads: list[set[int]], waiting: set[int], states: range
) -> tuple[list[list[int]], list[list[int]], list[list[int]]]:
    """Return the nodes of every block, in the order of elimination, and the earlier and later blocks in its rows."""
    left = [set(columns) for columns in reads]
    first, later, readers = states_first(sizes, states, left)
    order, after = cheapest_order(sizes, n_bodies, both_ways(left, first), waiting)
    taken = set(first)
    rest = [(node, columns) for node, columns in zip(order, after, strict=True) if node not in taken]
    groups = _grouped(sizes, first, later, readers, states)[0]
    groups += joined_blocks(sizes, [node for node, _ in rest], [columns for _, columns in rest], states)[0]
    earlier, after_all = filled(groups, reads)
    return groups, earlier, after_all


def block_pattern(
    unknowns: list[list[int]],
    n_bodies: int,
    neighbours: list[set[int]],
    waiting: set[int],
    states: range = range(0),
    ways: Sequence[tuple[int, int]] = (),
):
    """Return the pattern of the factors and ``place``: a function (node, node) -> positions of the rows in S.

    Parameters
    ----------
    unknowns : list of lists of int
        The unknowns of every node; nodes below `n_bodies` are bodies, the others joints.
    neighbours : list of sets
        Adjacency; consumed.
    waiting : set of int
        Joints that are eliminated after all their bodies.
    states : range
        Nodes below `n_bodies` that are states.
    ways : sequence of (int, int)
        Nodes with rows that have columns of another one, and not the other way round.
    """
    widths = [len(node) for node in unknowns]
    # blocks are numbered by their place in the order, so that what is appended in turn is sorted
    if ways:
        for reader, read in ways:
            neighbours[reader].add(read)
        groups, earlier, later = _one_way_blocks(widths, n_bodies, neighbours, waiting, states)
    else:
        groups, later = joined_blocks(widths, *cheapest_order(widths, n_bodies, neighbours, waiting), states)
        earlier = [[] for _ in groups]
        for k, others in enumerate(later):
            for other in others:
                earlier[other].append(k)
    position = {node: k for k, group in enumerate(groups) for node in group}
    within = {node: sum(widths[other] for other in group[:k]) for group in groups for k, node in enumerate(group)}
    sizes = [sum(widths[node] for node in group) for group in groups]
    first = np.concatenate([[0], np.cumsum(sizes)])
    width, offset, segments = _segments(sizes, first, earlier, later)
    row_block = np.repeat(np.arange(len(groups)), sizes)
    pattern = BlockPattern(
        order=np.array([unknown for group in groups for node in group for unknown in unknowns[node]], np.int64),
        row_start=np.concatenate([[0], np.cumsum(np.array(width, np.int64)[row_block])]),
        row_block=row_block,
        block_start=first,
        own=np.array([offset[k][k] for k in range(len(groups))], np.int64),
        **segments,
        **_steps(later, earlier, sizes, offset),
        scratch=np.zeros(2 * first[-1]),
    )
    begin = first.tolist()

    def place(row_node: int, column_node: int) -> np.ndarray:
        k = position[row_node]
        row = begin[k] + within[row_node]
        return pattern.row_start[row : row + widths[row_node]] + offset[k][position[column_node]] + within[column_node]

    return pattern, place


def _segments(sizes, first, earlier, later) -> tuple[list[int], list[dict[int, int]], dict[str, np.ndarray]]:
    """Return of every block the width of its rows and where in them the others begin, and the segments of columns."""
    width, segment_start, column, length = [], [0], [], []
    own_segment: list[int] = []
    offset: list[dict[int, int]] = []
    for k in range(len(sizes)):
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
    segments = {
        "segment_start": np.array(segment_start, np.int64),
        "column": first[column],
        "length": np.array(length, np.int64),
        "own_segment": np.array(own_segment, np.int64),
    }
    return width, offset, segments


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
