"""`Numbering`: the numbers that nodes and elements have in the file a body comes from."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from flexmb.errors import ModelError

__all__ = ["Numbering", "named_numbers"]

NAMED = re.compile(r"^\s*(node|element)\s+(?:(.+)\.)?(\d+)(?:\s+of the deck)?\s*$", re.IGNORECASE)
"""Words for a node or element of a file: "node 63241", "element wing-1.812"."""


def named_numbers(text: str) -> tuple[str, str, int] | None:
    """Return "node" or "element", the instance ("" for none) and the number that a text names; None for other text."""
    match = NAMED.match(text)
    return (match[1].lower(), match[2] or "", int(match[3])) if match else None


@dataclass(frozen=True, kw_only=True, eq=False)
class Numbering:
    """Numbers of the file.

    Parameters
    ----------
    nodes : (n,) int
        Number of every node; 0 for nodes that are not in the file.
    cells : tuple of (ne,) int
        Number of every cell, one array per block of cells; 0 for cells that are not in the file.
    instances : tuple of str
        Instances of parts, where the file numbers the nodes of each by themselves.
    instance_of : (n,) int or None
        Which of the instances a node belongs to, -1 for none; a cell belongs to its first node's.
    """

    nodes: np.ndarray
    cells: tuple[np.ndarray, ...] = ()
    instances: tuple[str, ...] = ()
    instance_of: np.ndarray | None = None

    def node_name(self, node: int) -> str:
        """Return "node 63241 of the deck", "node wing-1.17 of the deck", or "node 12" for one that is not in it."""
        label = int(self.nodes[node]) if 0 <= node < len(self.nodes) else 0
        return f"node {self._owner(node)}{label} of the deck" if label else f"node {int(node)}"

    def cell_name(self, block: int, row: int, first_node: int) -> str:
        """Return words for a cell, a row of a block of cells."""
        label = int(self.cells[block][row]) if block < len(self.cells) and row < len(self.cells[block]) else 0
        return f"element {self._owner(first_node)}{label} of the deck" if label else f"element {int(row)}"

    def _owner(self, node: int) -> str:
        number = -1 if self.instance_of is None else int(self.instance_of[node])
        return f"{self.instances[number]}." if number >= 0 else ""

    def nodes_of(self, text: str, cells: tuple[np.ndarray, ...], part: str, error: type = ModelError) -> np.ndarray:
        """Return the nodes (k,) that "node 63241" or "element 812" names; `error` where there is none, or several.

        Parameters
        ----------
        text : str
            For which `named_numbers` is not None.
        cells : tuple of (ne, c) int
            Connectivity of the blocks of cells.
        """
        kind, instance, number = named_numbers(text)  # type: ignore[misc]
        if kind == "node":
            found = [np.array([k]) for k in np.flatnonzero(self.nodes == number)]
        else:
            rows = [(np.asarray(block)[labels == number]) for block, labels in zip(cells, self.cells) if len(labels)]
            found = [row for table in rows for row in table]
        owners = [self._owner(int(nodes[0])).removesuffix(".") for nodes in found]
        chosen = [k for k, owner in enumerate(owners) if not instance or owner.lower() == instance.lower()]
        several = sorted({owners[k] for k in chosen})
        if len(several) > 1:
            raise error(
                part,
                found=f"'{text}', a number that {len(several)} instances use",
                expected=f"{kind} INSTANCE.{number} with one of: {', '.join(several[:12])}",
                remedy=f"Write '{kind} {several[0]}.{number}'",
            )
        if not chosen:
            raise error(
                part,
                found=f"'{text}', which the deck does not have",
                expected=f"numbers of {kind}s as the deck gives them, {self._range(kind)}",
                remedy="Look it up in the deck: nodes and elements have numbers of their own",
            )
        return np.unique(np.concatenate([found[k] for k in chosen]))

    def _range(self, kind: str) -> str:
        labels = self.nodes if kind == "node" else np.concatenate([np.zeros(0, np.int64), *self.cells])
        labels = labels[labels > 0]
        return f"{labels.min()} to {labels.max()}" if len(labels) else "none are known"

    def of(self, nodes: np.ndarray, cells: tuple[np.ndarray, ...]) -> Numbering:
        """Return the numbering of chosen nodes (k,) in a new order, with the given numbers of cells."""
        kept = np.asarray(nodes, int)
        inside = kept < len(self.nodes)
        labels, owner = np.zeros(len(kept), np.int64), np.full(len(kept), -1)
        labels[inside] = self.nodes[kept[inside]]
        if self.instance_of is not None:
            owner[inside] = self.instance_of[kept[inside]]
        return Numbering(
            nodes=labels,
            cells=cells,
            instances=self.instances,
            instance_of=None if self.instance_of is None else owner,
        )

    def padded(self, number_of_nodes: int, counts: list[int]) -> Numbering:
        """Return the numbering of a model that grew: nodes and blocks of `counts` cells behind these have no number."""
        cells = tuple(
            self.cells[k] if k < len(self.cells) and len(self.cells[k]) == count else np.zeros(count, np.int64)
            for k, count in enumerate(counts)
        )
        return self.of(np.arange(number_of_nodes), cells)
