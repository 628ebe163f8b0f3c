"""Where what follows measurements goes in the iteration matrix.

A rate of a state that changes with a state is one number, with a place of its own. All else is a product of two
vectors: a wrench along the velocities of its marker, and derivatives by the twist of another. Both are asked for as
pairs of markers, from which the pattern of the matrix follows; kernels get the places alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.constraints.measured_kernels import WHATS
from flexmb.math.tables import DIRECT, ONE_WAY

__all__ = ["LoopPlaces"]

_STATE = WHATS.index("state")


class LoopPlaces:
    """Collects what programs act on, and finds the places when the pattern is known.

    Parameters
    ----------
    compiler : ModelCompiler
    atoms : (n,) of MEASURED
    legs : tuple of int
        Markers that move atoms.
    read : list of lists of int
        The atoms on which every program depends.
    both_sides : bool
        Give what is read a place in the rows of what reads it and the other way round, as the mass matrix has them.
    """

    def __init__(self, compiler, atoms: np.ndarray, legs: tuple[int, ...], read: list[list[int]], both_sides: bool):
        self.compiler, self._atoms, self._read = compiler, atoms, read
        self._starts = np.cumsum([0, *map(len, read)]).tolist()
        self._sides = [
            [(side, legs[leg]) for side, leg in enumerate((atom["leg_a"], atom["leg_b"])) if leg >= 0] for atom in atoms
        ]
        self._more: dict[int, list[int]] = {}  # further atoms with derivatives of one
        for k, source in enumerate(atoms["source"].tolist()):
            self._more.setdefault(source, []).append(k)
        self._first_pair = len(compiler.pairs)
        self._one_way = DIRECT if both_sides else ONE_WAY
        self._own: list[tuple[int, int]] = []
        self._of_own: list[tuple[int, int, int, int]] = []
        self._acts: list[tuple[int, int, int, int]] = []
        self._blocks: list[tuple[int, int, int]] = []
        self._of_blocks: list[tuple[int, int]] = []
        self._terms: list[tuple[int, int, int]] = []
        self._filled: tuple[np.ndarray, ...] = ()
        self._last_pair = 0

    @property
    def most(self) -> int:
        """The most velocities that move a marker of an act or of its blocks."""
        markers = [marker for marker, *_ in (*self._acts, *self._blocks)]
        return max((self._velocities(marker) for marker in markers), default=0)

    def add(self, slot: int, marker: int, component: int = -1, channel: int = -1) -> None:
        """Let a program act on a marker: on a state, a component of its rate, or by the channel of a force."""
        by_marker: dict[int, list[tuple[int, int, int]]] = {}
        for k, atom in enumerate(self._read[slot]):
            number = 1 + self._starts[slot] + k
            for a in (atom, *self._more.get(atom, ())):
                for side, other in self._sides[a]:
                    if component >= 0 and self._atoms[a]["what"] == _STATE:
                        place = marker, component, other, int(self._atoms[a]["axis"])
                        self._own.append((number, self.compiler.pair(marker, other, self._one_way)))
                        self._of_own.append(place)
                    else:
                        by_marker.setdefault(other, []).append((number, a, side))
        if not self._velocities(marker):
            return
        first = len(self._blocks)
        for other, terms in by_marker.items():
            if self._velocities(other):
                self._terms += terms
                of_states = component >= 0 or all(self._atoms[a]["what"] == _STATE for _, a, _ in terms)
                writes = self._one_way if of_states else DIRECT
                self._of_blocks.append((marker, self.compiler.pair(marker, other, writes)))
                self._blocks.append((other, -1, len(self._terms)))
        if len(self._blocks) > first:
            self._acts.append((marker, component, channel, len(self._blocks)))

    def fields(self) -> dict[str, Any]:
        """Return the fields of the row; the places themselves are written by `found`."""
        self._last_pair = len(self.compiler.pairs)
        own, blocks = np.array(self._own, np.int64).ravel(), np.array(self._blocks, np.int64).ravel()
        self._filled = own, blocks
        acts, terms = np.array(self._acts, np.int64).ravel(), np.array(self._terms, np.int64).ravel()
        bulk = self.compiler.bulk
        return {
            "n_own": len(self._own),
            "own": bulk(own.view(float)),
            "n_acts": len(self._acts),
            "acts": bulk(acts.view(float)),
            "blocks": bulk(blocks.view(float)),
            "terms": bulk(terms.view(float)),
        }

    def found(self, markers: np.ndarray, pairs: np.ndarray, pair_rows: np.ndarray) -> int:
        """Write the places into the bulk data; return how many pairs kernels need, the first of the table.

        Parameters
        ----------
        markers : (nm,) of MARKER
        pairs : (np,) of PAIR
        pair_rows : (n,)
            See `flexmb.math.tables`.
        """
        own, blocks = self._filled
        for k, ((_, pair), (marker, i, other, j)) in enumerate(zip(self._own, self._of_own, strict=True)):
            start = _begins(markers, pairs[pair], marker, other)
            own[2 * k + 1] = pair_rows[start + self._within(marker, i)] + self._within(other, j)
        for k, ((other, _, _), (marker, pair)) in enumerate(zip(self._blocks, self._of_blocks, strict=True)):
            blocks[3 * k + 1] = _begins(markers, pairs[pair], marker, other)
        only = pairs["active"][self._first_pair : self._last_pair] <= DIRECT
        return self._first_pair if self._last_pair == len(pairs) and np.all(only) else len(pairs)

    def _velocities(self, marker: int) -> int:
        return self.compiler.span(marker)[2]

    def _within(self, marker: int, component: int) -> int:
        """Return the number of a state in its group."""
        body = self.compiler.marker_body[marker]
        return 6 * (marker - self.compiler.marker_body.index(body)) + component


def _begins(markers: np.ndarray, pair: np.void, a: int, b: int) -> int:
    """Return where the places of the rows of marker a in the columns of b begin among all places of pairs."""
    if a == b or pair["active"] == ONE_WAY:
        return int(pair["iS"])
    return int(pair["iS"] + markers["nu"][a] * (markers["nu"][a] // markers["width"][a]))
