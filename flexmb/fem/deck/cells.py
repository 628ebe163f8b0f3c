"""Cells of decks that flexmb has no element for: missing midside nodes, pyramids, shells of second order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.fem.deck.contents import Deck, Inventory
from flexmb.fem.deck.links import LinkRows
from flexmb.fem.solids.elements import HEX_EDGES, TET_EDGES, WEDGE_EDGES

__all__ = ["SECOND_ORDER", "SolidCells", "first_order_shells", "some"]

PYRAMID_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4))
EDGES = {"tetra10": TET_EDGES, "hexahedron20": HEX_EDGES, "wedge15": WEDGE_EDGES, "pyramid13": PYRAMID_EDGES}
"""Corners of the edge on which each midside node lies, by cell type."""

SECOND_ORDER = "of second order, divided into flat elements on all their nodes"
"""What became of shells, in the inventory and in a warning."""


def some(table: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return ascending rows of a table; the table itself where they are all of them, since it may be large."""
    return table if len(rows) == len(table) else table[rows]


@dataclass(frozen=True, eq=False)
class SolidCells:
    """Solid cells as a deck writes them: nodes (ne, count) in meshio's order, -1 where a midside node is left out."""

    low: str
    high: str
    corners: int
    nodes: np.ndarray
    labels: np.ndarray

    def parts(self, deck: Deck) -> list[tuple[str, np.ndarray, np.ndarray]]:
        """Return (cell type, nodes, element numbers) of cells that have an element.

        A midside node that is left out becomes a node in the middle of its edge that follows the two corners. A
        pyramid becomes two tetrahedra.
        """
        middles = self.nodes[:, self.corners :] >= 0
        first, out = ~middles.any(axis=1), []
        if first.any():
            low, labels = some(self.nodes, np.flatnonzero(first))[:, : self.corners], self.labels[first]
            if self.low == "pyramid":
                deck.inventory.approximated["pyramids, split into two tetrahedra"] += len(low)
                out.append(("tetra", np.vstack([low[:, [0, 1, 2, 4]], low[:, [0, 2, 3, 4]]]), np.tile(labels, 2)))
            else:
                out.append((self.low, low, labels))
        if not first.all():
            high, labels = self._completed(self.nodes[~first], deck), self.labels[~first]
            if self.high == "pyramid13":
                deck.inventory.approximated["pyramids, split into two tetrahedra"] += len(high)
                high, labels = _split_pyramids(high, deck), np.tile(labels, 2)
                out.append(("tetra10", high, labels))
            else:
                out.append((self.high, high, labels))
        return out

    def _completed(self, nodes: np.ndarray, deck: Deck) -> np.ndarray:
        missing = np.argwhere(nodes < 0)
        if not len(missing):
            return nodes
        nodes = nodes.copy()
        made: dict[tuple[int, int], int] = {}
        link, new = LinkRows("a midside node that is left out"), []
        for row, column in missing:
            a, b = EDGES[self.high][column - self.corners]
            first, second = sorted((int(nodes[row, a]), int(nodes[row, b])))
            pair = (first, second)
            if pair not in made:
                made[pair] = len(deck.points) + len(new)
                new.append(deck.points[list(pair)].mean(axis=0))
                for k in range(3):
                    link.add([6 * made[pair] + k], [6 * pair[0] + k, 6 * pair[1] + k], np.array([[0.5, 0.5]]))
            nodes[row, column] = made[pair]
        deck.points = np.vstack([deck.points, new])
        deck.links.append(link)
        deck.inventory.approximated["midside nodes left out, in the middle of their edges"] += len(new)
        return nodes


def _split_pyramids(nodes: np.ndarray, deck: Deck) -> np.ndarray:
    """Return two tetrahedra of second order per pyramid of 13 nodes; the middle of the base follows its eight nodes.

    The middle of a serendipity quadrilateral is ``sum(midsides) / 2 - sum(corners) / 4``.
    """
    count = len(deck.points)
    middle = count + np.arange(len(nodes))
    base = deck.points[nodes]
    deck.points = np.vstack([deck.points, 0.5 * base[:, 5:9].sum(axis=1) - 0.25 * base[:, :4].sum(axis=1)])
    link = LinkRows("the middle of the base of a pyramid")
    weights = np.array([[-0.25] * 4 + [0.5] * 4])
    for row, own in zip(nodes[:, [0, 1, 2, 3, 5, 6, 7, 8]], middle, strict=True):
        for k in range(3):
            link.add([6 * own + k], 6 * row + k, weights)
    deck.links.append(link)
    c = [nodes[:, k] for k in range(13)]
    one = np.stack([c[0], c[1], c[2], c[4], c[5], c[6], middle, c[9], c[10], c[11]], axis=1)
    two = np.stack([c[0], c[2], c[3], c[4], middle, c[7], c[8], c[9], c[11], c[12]], axis=1)
    return np.vstack([one, two])


def first_order_shells(nodes: np.ndarray, inventory: Inventory, name: str) -> tuple[list, list]:
    """Return connectivities of triangles and quadrilaterals, and the row of the element each belongs to.

    Six nodes become four triangles, eight nodes four triangles at the corners and a quadrilateral between the
    midsides. Where midside nodes are left out (-1) the corners alone are taken.
    """
    count = nodes.shape[1]
    rows = np.arange(len(nodes))
    if count <= 4:
        return [nodes], [rows]
    corners = 3 if count == 6 else 4
    whole = (nodes >= 0).all(axis=1)
    out, of = [], []
    if not whole.all():
        inventory.approximated[f"{name} without all midside nodes, by their corners"] += int((~whole).sum())
        out.append(nodes[~whole][:, :corners])
        of.append(rows[~whole])
    full, own = nodes[whole], rows[whole]
    if len(full):
        inventory.approximated[f"{name} {SECOND_ORDER}"] += len(full)
        tips = [[0, 3, 5], [1, 4, 3], [2, 5, 4]] if corners == 3 else [[0, 4, 7], [1, 5, 4], [2, 6, 5], [3, 7, 6]]
        triangles = [full[:, tip] for tip in tips] + ([full[:, [3, 4, 5]]] if corners == 3 else [])
        out.append(np.vstack(triangles))
        of.append(np.tile(own, len(triangles)))
        if corners == 4:
            out.append(full[:, [4, 5, 6, 7]])
            of.append(own)
    return out, of
