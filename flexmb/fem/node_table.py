"""Positions of nodes by the numbers that another program gave them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.foreign_files import require_file, understood
from flexmb.fem.matrices.nastran import nastran_cards, nastran_float
from flexmb.fem.meshes.abaqus_cards import read_abaqus_cards
from flexmb.fem.meshes.nastran_cards import read_nastran_cards

__all__ = ["NodeTable", "node_table"]


@dataclass(frozen=True, eq=False)
class NodeTable:
    """Numbers in the file (n,), ascending, positions (n, 3), and named sets of such numbers."""

    labels: np.ndarray
    positions: np.ndarray
    node_sets: Mapping[str, np.ndarray] = field(default_factory=dict)


def node_table(source) -> NodeTable:
    """Return the nodes of an Abaqus or CalculiX (.inp) or Nastran file, or of positions (n, 3) numbered
    from 1."""
    if not isinstance(source, str | Path):
        positions = np.array(source, float)
        if positions.ndim != 2 or positions.shape[1] != 3:
            raise MeshError(
                "Nodes of the matrices",
                found=f"an array of shape {positions.shape}",
                expected="(n, 3)",
                remedy="Give positions in the order of the node numbers, or the mesh file",
            )
        return NodeTable(np.arange(1, len(positions) + 1), positions)
    path = Path(source)
    require_file(f"Mesh file '{path}'", path, "a file", "Check the folder")
    read = _abaqus if path.suffix.lower() == ".inp" else _nastran
    with understood(f"Mesh file '{path}'", "a complete mesh of the matrices", "Write the mesh again", path):
        labels, positions, sets = read(path)
    if len(labels) == 0:
        raise MeshError(
            f"Mesh file '{path}'",
            found="no nodes",
            expected="*NODE blocks (.inp) or GRID cards",
            remedy="Give the mesh that the matrices were made from",
        )
    order = np.argsort(labels)
    return NodeTable(labels[order], positions[order], sets)


def _abaqus(path: Path):
    cards = read_abaqus_cards(path)
    lines = cards.mesh_text.splitlines()[1 : 1 + len(cards.node_ids)]
    numbers = np.array([[float(word) for word in line.split(",")[1:4]] for line in lines])
    return np.array(cards.node_ids), numbers, cards.node_sets


def _nastran(path: Path):
    labels, positions = [], []
    for words in nastran_cards(path):
        if words[0] == "GRID":
            if words[2] not in ("", "0"):
                raise MeshError(
                    f"Mesh file '{path}'",
                    found=f"grid {words[1]} in the coordinate system {words[2]}",
                    expected="all grid points in the basic system",
                    remedy="Export the mesh with its coordinates in the basic (global) system",
                )
            labels.append(int(words[1]))
            positions.append([nastran_float(word) for word in [*words, "", ""][3:6]])
    cards = read_nastran_cards(path, np.array(labels, np.int64), np.zeros(0, np.int64))
    sets = {name: np.asarray(numbers) for name, numbers in cards.node_sets.items()}
    return np.array(labels, int), np.array(positions).reshape(-1, 3), sets
