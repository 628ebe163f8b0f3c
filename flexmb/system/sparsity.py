"""The pattern of the iteration matrix, and where in it every contribution goes."""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np

from flexmb.math.block_pattern import stored
from flexmb.math.tables import EQUATION, LEG, ONE_WAY, PAIR
from flexmb.system.pattern import block_pattern

__all__ = ["sparsity"]

FEW, KEPT, KEPT_OF_MANY = 500, 64, 4
"""Velocities and equations of structures of which KEPT patterns are kept; of larger ones so many."""


class Structure(NamedTuple):
    """What decides where numbers stand in the iteration matrix, and nothing else of a model.

    Parameters
    ----------
    widths : (nb,)
        Velocities of a block of every body and group of states; `couplings` between blocks of one body.
    iu : (nb + 1,)
    n_bodies : int
    leaders : (nj,)
        The name of the joint whose node a joint shares, by its equations.
    coupling : (nj,) of bool
        Does an equation of it belong to several joints?
    owners : (ng,)
        Joint of every equation.
    legs : ((marker, equation), ...)
    gaps : ((marker, blocks), ...)
    markers : ((body, first velocity, velocities), ...)
    pairs : ((a, b, activity), ...)
        What forces write there; None: nothing.
    """

    widths: tuple[int, ...]
    couplings: tuple[tuple[tuple[int, int], ...], ...]
    iu: tuple[int, ...]
    n_bodies: int
    leaders: tuple[str, ...]
    coupling: tuple[bool, ...]
    owners: tuple[int, ...]
    legs: tuple[tuple[int, int], ...]
    gaps: tuple[tuple[int, tuple[int, ...]], ...]
    markers: tuple[tuple[int, int, int], ...]
    pairs: tuple[tuple[int, int, int | None], ...]


def structure_of(model, compiler, layout, constraints, markers) -> Structure:
    """Return the structure of a model that is being compiled."""
    leader = {j.name: getattr(j, "joint", j.name) if j.prescribes else j.name for j in constraints.joints}
    states = compiler.states.values()
    return Structure(
        widths=(*(body.block_size for body in model.bodies), *(len(group.names) for group in states)),
        couplings=tuple(tuple((int(a), int(b)) for a, b in body.couplings()) for body in model.bodies),
        iu=tuple(layout.iu),
        n_bodies=len(model.bodies),
        leaders=tuple(leader[joint.name] for joint in constraints.joints),
        coupling=tuple(bool(joint.couples) for joint in constraints.joints),
        owners=tuple(joint for joint, _ in constraints.owners),
        legs=tuple(constraints.legs),
        gaps=tuple((marker, tuple(blocks)) for marker, blocks in compiler.marker_gaps.items()),
        markers=tuple(zip(*(markers[name].tolist() for name in ("body", "iu", "nu")), strict=True)),
        pairs=tuple((a, b, compiler.active_pairs.get(k)) for (a, b, _), k in compiler.pairs.items()),
    )


class _Nodes:
    """The nodes of the elimination: the blocks of all bodies, then the joints (a drive shares its joint's)."""

    def __init__(self, of: Structure):
        self.of, self.width = of, of.widths
        self.unknowns: list[list[int]] = []
        self.first: dict[int, int] = {}
        for k, width in enumerate(self.width):
            if of.iu[k + 1] > of.iu[k]:
                self.first[k] = len(self.unknowns)
                for start in range(of.iu[k], of.iu[k + 1], width):
                    self.unknowns.append(list(range(start, start + width)))
            if k == of.n_bodies - 1:
                self.of_bodies = len(self.unknowns)
        self.n_blocks = len(self.unknowns)
        self.couplings = []
        for k, pairs in enumerate(of.couplings):
            own = pairs if k in self.first else ()
            self.couplings += [(self.first[k] + a, self.first[k] + b) for a, b in own]
        groups: dict[str, list[int]] = {}
        for number, leader in enumerate(of.leaders):
            groups.setdefault(leader, []).append(number)
        of_joint = {number: self.n_blocks + k for k, group in enumerate(groups.values()) for number in group}
        self.of_equation = [of_joint[joint] for joint in of.owners]
        self.unknowns += [[] for _ in groups]
        for equation, node in enumerate(self.of_equation):
            self.unknowns[node].append(of.iu[-1] + equation)
        self.gaps = dict(of.gaps)
        # an equation of two joints may vanish on one of its bodies: it waits for all of them
        self.waiting = {of_joint[number] for number, couples in enumerate(of.coupling) if couples}
        # and so do equations on a block that cannot turn in every direction
        split = {k for k in self.first if self.width[k] < of.iu[k + 1] - of.iu[k]}
        self.waiting |= {self.of_equation[e] for m, e in of.legs if of.markers[m][0] in split}
        self.velocities = [nu for _, _, nu in of.markers]
        self.of_marker = [self._moving(marker, *place) for marker, place in enumerate(of.markers)]

    def _moving(self, marker: int, body: int, iu: int, nu: int) -> list[int]:
        """Return the nodes that move a marker, none for the ground.

        Others may lie among them, with zeros in the Jacobian: in their place stands a node that does move it.
        """
        if not nu:
            return []
        first = self.first[body] + (iu - self.of.iu[body]) // self.width[body]
        nodes = list(range(first, first + nu // self.width[body]))
        if marker not in self.gaps:
            return nodes
        gaps = {self.first[body] + block for block in self.gaps[marker]}
        moving = next(node for node in nodes if node not in gaps)
        return [moving if node in gaps else node for node in nodes]

    def ways(self) -> list[tuple[int, int]]:
        """Return the nodes with rows that have columns of another one, and not the other way round."""
        pairs = [(a, b) for a, b, active in self.of.pairs if active == ONE_WAY]
        found = [(i, j) for a, b in pairs for i, j in product(self.of_marker[a], self.of_marker[b]) if i != j]
        return list(dict.fromkeys(found))

    def neighbours(self) -> list[set[int]]:
        """Return the adjacency of what has places on both sides."""
        found: list[set[int]] = [set() for _ in self.unknowns]

        def connect(i, j):
            if i != j:
                found[i].add(j)
                found[j].add(i)

        for a, b in self.couplings:
            connect(a, b)
        for marker, equation in self.of.legs:
            for node in self.of_marker[marker]:
                connect(node, self.of_equation[equation])
        for a, b, active in self.of.pairs:
            if active not in (None, ONE_WAY):
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


def _legs(nodes: _Nodes, equations, within, place):
    """Return the table of legs, and the positions of G^T and of the blocks of G."""
    legs = np.zeros(len(nodes.of.legs), LEG)
    transposed: list[np.ndarray] = [np.zeros(0, np.int64)]
    for marker, equation in nodes.of.legs:
        joint, k = nodes.of_equation[equation], within[equation]
        transposed += [place(node, joint) + k for node in nodes.of_marker[marker]]
        transposed.append(np.array([place(joint, node)[k] for node in nodes.of_marker[marker]], np.int64))
    legs["marker"], legs["equation"] = np.array(nodes.of.legs, np.int64).reshape(-1, 2).T
    moved = np.array(nodes.velocities, np.int64)[legs["marker"]]
    size = moved + np.array([len(of) for of in nodes.of_marker], np.int64)[legs["marker"]]
    legs["iT"] = np.cumsum(size) - size
    legs["iS"] = legs["iT"] + moved
    equations["legs"] = np.bincount(legs["equation"], minlength=len(equations))
    equations["leg"] = np.searchsorted(legs["equation"], np.arange(len(equations)))  # a joint's follow each other
    return legs, np.concatenate(transposed)


def _pairs(nodes: _Nodes, place):
    """Return the table of pairs, and the positions of their blocks: by row, then by block of columns."""
    pairs = np.zeros(len(nodes.of.pairs), PAIR)
    positions: list[np.ndarray] = [np.zeros(0, np.int64)]
    at = 0
    for k, (a, b, active) in enumerate(nodes.of.pairs):
        pairs[k]["a"], pairs[k]["b"], pairs[k]["iS"] = a, b, at
        pairs[k]["active"] = active or 0
        if active is None:
            continue
        ends = nodes.of_marker[a], nodes.of_marker[b]
        for rows, columns in (ends,) if active == ONE_WAY else product(ends, ends):
            if rows and columns:
                for i in rows:
                    positions.append(np.stack([place(i, j) for j in columns], axis=1).ravel())
                    at += len(positions[-1])
    return pairs, np.concatenate(positions)


def _in_order(pattern, nu: int) -> dict[str, np.ndarray]:
    """Return where the mass part and the gradients stand among the values, with their columns and starts of rows."""
    numbers = stored(np.arange(1.0, 1.0 + pattern.row_start[-1]), pattern)
    parts = {"mass": numbers[:nu, :nu].tocsr(), "gradient": numbers[nu:, :nu].tocsr()}
    found = {f"{name}_at": part.data.astype(np.int64) - 1 for name, part in parts.items()}
    for name, part in parts.items():
        found |= {f"{name}_columns": part.indices, f"{name}_starts": part.indptr}
    row = np.repeat(np.arange(nu), np.diff(found["mass_starts"]))
    on = row == found["mass_columns"]
    return {**found, "diagonal_rows": row[on], "diagonal_at": found["mass_at"][on]}


def _found(of: Structure):
    """Return pattern and tables of a structure: the phases of a run and the variants of a mechanism share them."""
    return (_of_few if of.iu[-1] + len(of.owners) <= FEW else _of_many)(of)


def _made(of: Structure):
    """Make pattern and tables of a structure."""
    nodes = _Nodes(of)
    states = range(nodes.of_bodies, nodes.n_blocks)
    pattern, place = block_pattern(
        nodes.unknowns, nodes.n_blocks, nodes.neighbours(), nodes.waiting, states, nodes.ways()
    )
    nu = of.iu[-1]
    rows, widths = _rows(nodes, nu, place)
    equations, within = _equations(nodes, nu, place)
    legs, transposed = _legs(nodes, equations, within, place)
    pairs, pair_rows = _pairs(nodes, place)
    tables = {
        "equations": equations,
        "legs": legs,
        "pairs": pairs,
        "rows": rows,
        "widths": widths,
        "transposed": transposed,
        "pair_rows": pair_rows,
        **_in_order(pattern, nu),
    }
    return pattern, tables


_of_few, _of_many = lru_cache(maxsize=KEPT)(_made), lru_cache(maxsize=KEPT_OF_MANY)(_made)


def sparsity(model, compiler, layout, constraints, markers):
    """Return the pattern of the factors, and the tables of equations, legs, pairs and all positions in the matrix."""
    pattern, tables = _found(structure_of(model, compiler, layout, constraints, markers))
    own = pattern._replace(scratch=pattern.scratch.copy())
    return own, {name: array.copy() if array.dtype.names else array for name, array in tables.items()}
