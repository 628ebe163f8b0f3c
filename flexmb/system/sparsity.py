"""The pattern of the iteration matrix, and where in it every contribution goes."""

from __future__ import annotations

from itertools import product

import numpy as np

from flexmb.math.tables import EQUATION, LEG, PAIR
from flexmb.system.pattern import block_pattern

__all__ = ["sparsity"]


class _Nodes:
    """The nodes of the elimination: the blocks of all bodies, then the joints (a drive shares its joint's)."""

    def __init__(self, model, compiler, layout, constraints, markers):
        self.width = [body.block_size for body in model.bodies]
        self.width += [len(group.names) for group in compiler.states.values()]
        self.unknowns: list[list[int]] = []
        self.first: dict[int, int] = {}
        for k in range(len(self.width)):
            if layout.size(k):
                self.first[k] = len(self.unknowns)
                for start in range(layout.iu[k], layout.iu[k + 1], self.width[k]):
                    self.unknowns.append(list(range(start, start + self.width[k])))
            if k == len(model.bodies) - 1:
                self.of_bodies = len(self.unknowns)
        self.n_blocks = len(self.unknowns)
        self.layout, self.couplings = layout, []
        for k, body in enumerate(model.bodies):
            pairs = body.couplings() if k in self.first else ()
            self.couplings += [(self.first[k] + int(a), self.first[k] + int(b)) for a, b in pairs]
        leader = {j.name: getattr(j, "joint", j.name) if j.prescribes else j.name for j in constraints.joints}
        groups: dict[str, list[int]] = {}
        for number, joint in enumerate(constraints.joints):
            groups.setdefault(leader[joint.name], []).append(number)
        of_joint = {number: self.n_blocks + k for k, group in enumerate(groups.values()) for number in group}
        self.of_equation = [of_joint[joint] for joint, _ in constraints.owners]
        self.unknowns += [[] for _ in groups]
        for equation, node in enumerate(self.of_equation):
            self.unknowns[node].append(layout.iu[-1] + equation)
        self.gaps = compiler.marker_gaps
        # an equation of two joints may vanish on one of its bodies: it waits for all of them
        self.waiting = {of_joint[number] for number, joint in enumerate(constraints.joints) if joint.couples}
        # and so do equations on a block that cannot turn in every direction
        split = {k for k in self.first if self.width[k] < layout.size(k)}
        self.waiting |= {self.of_equation[e] for m, e in constraints.legs if compiler.marker_body[m] in split}
        self.velocities = markers["nu"].tolist()
        places = zip(markers["body"].tolist(), markers["iu"].tolist(), self.velocities, strict=True)
        self.of_marker = [self._moving(marker, *place) for marker, place in enumerate(places)]

    def _moving(self, marker: int, body: int, iu: int, nu: int) -> list[int]:
        """Return the nodes that move a marker, none for the ground.

        Others may lie among them, with zeros in the Jacobian: in their place stands a node that does move it.
        """
        if not nu:
            return []
        first = self.first[body] + (iu - self.layout.iu[body]) // self.width[body]
        nodes = list(range(first, first + nu // self.width[body]))
        if marker not in self.gaps:
            return nodes
        gaps = {self.first[body] + block for block in self.gaps[marker]}
        moving = next(node for node in nodes if node not in gaps)
        return [moving if node in gaps else node for node in nodes]

    def neighbours(self, constraints, compiler) -> list[set[int]]:
        """Return the adjacency."""
        found: list[set[int]] = [set() for _ in self.unknowns]

        def connect(i, j):
            if i != j:
                found[i].add(j)
                found[j].add(i)

        for a, b in self.couplings:
            connect(a, b)
        for marker, equation in constraints.legs:
            for node in self.of_marker[marker]:
                connect(node, self.of_equation[equation])
        for (a, b, _), index in compiler.pairs.items():
            if index in compiler.active_pairs:
                nodes = self.of_marker[a] + self.of_marker[b]
                for i, j in product(nodes, nodes):
                    connect(i, j)
        return found


def _rows(nodes: _Nodes, nu: int, place) -> tuple[np.ndarray, np.ndarray]:
    """Return the positions of own blocks and couplings, and how many columns each has."""
    rows, widths = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    own = [(node, node) for node in range(nodes.n_blocks)]
    both = [pair for a, b in nodes.couplings for pair in ((a, b), (b, a))]
    for i, j in own[: nodes.of_bodies] + both + own[nodes.of_bodies :]:
        at = place(i, j)
        rows.append(at)
        widths.append(np.full(len(at), len(nodes.unknowns[j])))
    return np.concatenate(rows), np.concatenate(widths)


def _equations(nodes: _Nodes, nu: int, place):
    """Return the table of equations, and the place of each within its node."""
    equations = np.zeros(len(nodes.of_equation), EQUATION)
    within = np.zeros(len(equations), np.int64)
    for group in nodes.unknowns[nodes.n_blocks :]:
        for k, unknown in enumerate(group):
            within[unknown - nu] = k
    equations["diagonal"] = [
        place(node, node)[k] + k for node, k in zip(nodes.of_equation, within.tolist(), strict=True)
    ]
    return equations, within


def _legs(nodes: _Nodes, constraints, equations, within, place):
    """Return the table of legs, and the positions of G^T and of the blocks of G."""
    legs = np.zeros(len(constraints.legs), LEG)
    transposed: list[np.ndarray] = [np.zeros(0, np.int64)]
    for marker, equation in constraints.legs:
        joint, k = nodes.of_equation[equation], within[equation]
        transposed += [place(node, joint) + k for node in nodes.of_marker[marker]]
        transposed.append(np.array([place(joint, node)[k] for node in nodes.of_marker[marker]], np.int64))
    legs["marker"], legs["equation"] = np.array(constraints.legs, np.int64).reshape(-1, 2).T
    moved = np.array(nodes.velocities, np.int64)[legs["marker"]]
    size = moved + np.array([len(of) for of in nodes.of_marker], np.int64)[legs["marker"]]
    legs["iT"] = np.cumsum(size) - size
    legs["iS"] = legs["iT"] + moved
    equations["legs"] = np.bincount(legs["equation"], minlength=len(equations))
    equations["leg"] = np.searchsorted(legs["equation"], np.arange(len(equations)))  # those of one follow each other
    return legs, np.concatenate(transposed)


def _pairs(nodes: _Nodes, compiler, place):
    """Return the table of pairs, and the positions of their blocks: by row, then by block of columns."""
    pairs = np.zeros(len(compiler.pairs), PAIR)
    positions: list[np.ndarray] = [np.zeros(0, np.int64)]
    at = 0
    for (a, b, _), k in compiler.pairs.items():
        pairs[k]["a"], pairs[k]["b"], pairs[k]["iS"] = a, b, at
        pairs[k]["active"] = compiler.active_pairs.get(k, 0)
        if k not in compiler.active_pairs:
            continue
        ends = nodes.of_marker[a], nodes.of_marker[b]
        for rows, columns in product(ends, ends):
            if rows and columns:
                for i in rows:
                    positions.append(np.stack([place(i, j) for j in columns], axis=1).ravel())
                    at += len(positions[-1])
    return pairs, np.concatenate(positions)


def sparsity(model, compiler, layout, constraints, markers):
    """Return the pattern of the factors, and the tables of equations, legs, pairs and all positions in the matrix."""
    nodes = _Nodes(model, compiler, layout, constraints, markers)
    pattern, place = block_pattern(
        nodes.unknowns, nodes.n_blocks, nodes.neighbours(constraints, compiler), nodes.waiting
    )
    nu = layout.iu[-1]
    rows, widths = _rows(nodes, nu, place)
    equations, within = _equations(nodes, nu, place)
    legs, transposed = _legs(nodes, constraints, equations, within, place)
    pairs, pair_rows = _pairs(nodes, compiler, place)
    return pattern, {
        "equations": equations,
        "legs": legs,
        "pairs": pairs,
        "rows": rows,
        "widths": widths,
        "transposed": transposed,
        "pair_rows": pair_rows,
    }
