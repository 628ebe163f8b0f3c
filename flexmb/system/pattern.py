"""The order of elimination and the pattern of the factors of the iteration matrix.

Nodes of the graph are the bodies (their velocities) and the joints (their multipliers, a drive together with its
joint). A multiplier has a zero on the diagonal, so it may be eliminated only when its pivot is certain to be regular:
after all its bodies, or, as the last joint of a body, after that body alone (the equations of one joint are independent
on one body that no other joint holds). The second rule condenses trees from their leaves, as the O(n) recursions do.
In a loop it would count the rest of the model as fixed, and take freedoms twice; there joints wait for all their bodies.
Among the permitted nodes the one with the least fill goes first.
"""

from __future__ import annotations

from heapq import heappop, heappush

import numpy as np

from flexmb.math.block_lu import BlockPattern

__all__ = ["block_pattern", "elimination_order"]


def elimination_order(sizes: np.ndarray, n_bodies: int, neighbours: list[set[int]],
                      waiting: set[int]) -> tuple[list[int], list[list[int]]]:
    """Return the order of the nodes and for each node its later neighbours including fill.

    Nodes below `n_bodies` are bodies, the others joints; `neighbours` is the symmetric adjacency, which is consumed.
    Joints in `waiting` come after all their bodies.
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
        return int(sum(sizes[k] for k in neighbours[node]))

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
    sizes = np.array([len(node) for node in unknowns], np.int64)
    order, after = elimination_order(sizes, n_bodies, neighbours, waiting)
    position = {node: k for k, node in enumerate(order)}
    first_of = {}
    total = 0
    for node in order:
        first_of[node] = total
        total += int(sizes[node])
    columns: list[list[int]] = [[] for _ in order]
    for k, node in enumerate(order):
        for later in after[k]:
            columns[position[later]].append(node)
    row_start, row_block, segment_start, column, length = [0], [], [0], [], []
    offset_in_row: dict[tuple[int, int], int] = {}
    for k, node in enumerate(order):
        nodes = sorted([*columns[k], node, *after[k]], key=position.__getitem__)
        at = 0
        for other in nodes:
            offset_in_row[node, other] = at
            column.append(first_of[other])
            length.append(int(sizes[other]))
            at += int(sizes[other])
        segment_start.append(len(column))
        for _ in range(int(sizes[node])):
            row_block.append(k)
            row_start.append(row_start[-1] + at)
    steps = _steps(order, after, columns, position, sizes, offset_in_row)
    pattern = BlockPattern(
        order=np.array([unknown for node in order for unknown in unknowns[node]], np.int64),
        row_start=np.array(row_start, np.int64),
        row_block=np.array(row_block, np.int64),
        segment_start=np.array(segment_start, np.int64),
        column=np.array(column, np.int64),
        length=np.array(length, np.int64),
        block_start=np.cumsum([0, *(int(sizes[node]) for node in order)]).astype(np.int64),
        own=np.array([offset_in_row[node, node] for node in order], np.int64),
        own_segment=np.array([segment_start[k] + len(columns[k]) for k in range(len(order))], np.int64),
        **steps,
        inverse=np.zeros(total),
        scratch=np.zeros(total),
    )

    def place(row_node: int, column_node: int) -> np.ndarray:
        start = first_of[row_node]
        rows = pattern.row_start[start : start + int(sizes[row_node])]
        return rows + offset_in_row[row_node, column_node]

    return pattern, place


def _steps(order, after, columns, position, sizes, offset_in_row) -> dict[str, np.ndarray]:
    """Return the elimination steps of every block, and the runs of columns that each changes, neighbours joined."""
    step_start, source, at, run_start = [0], [], [], [0]
    runs: list[tuple[int, int, int]] = []
    for k, node in enumerate(order):
        for earlier in sorted(columns[k], key=position.__getitem__):
            source.append(position[earlier])
            at.append(offset_in_row[node, earlier])
            first = len(runs)
            for other in sorted(after[position[earlier]], key=position.__getitem__):
                to, start, length = offset_in_row[node, other], offset_in_row[earlier, other], int(sizes[other])
                if len(runs) > first and runs[-1][0] + runs[-1][2] == to and runs[-1][1] + runs[-1][2] == start:
                    to, start, length = runs[-1][0], runs[-1][1], runs.pop()[2] + length
                runs.append((to, start, length))
            run_start.append(len(runs))
        step_start.append(len(source))
    table = np.array(runs, np.int64).reshape(-1, 3)
    names = {"step_start": step_start, "source": source, "at": at, "run_start": run_start}
    arrays = {name: np.array(values, np.int64) for name, values in names.items()}
    return {**arrays, "run_to": table[:, 0].copy(), "run_from": table[:, 1].copy(), "run_length": table[:, 2].copy()}
