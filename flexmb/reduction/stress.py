"""Stress modes: the nodal stress of every shape, averaged within a material."""

from __future__ import annotations

import numpy as np

from flexmb.fem.fe_model import FEModel

__all__ = ["middle_surface", "stress_modes"]

SAME = 1e-9
"""Relative difference of moduli below which two blocks are of one material."""


def stress_modes(fe: FEModel, field: np.ndarray) -> np.ndarray:
    """Return the stress xx, yy, zz, xy, yz, zx at the nodes, (n, 6, m), Pa, of a nodal field (n, 6, m); zero without
    elements.

    The mean over all cells of one material at a node. Where materials meet the stress jumps, and a mean would belong to
    neither: the node shows the stiffer one, which carries the larger stress along the joint.
    """
    n = len(fe.nodes)
    total, weight, shown = np.zeros(field.shape), np.zeros(n), np.zeros(n)
    for block in sorted(fe.blocks, key=lambda block: -block.modulus):
        stress = block.nodal_stress(field)
        cells = np.bincount(block.connectivity.ravel(), minlength=n)
        there = (cells > 0) & ~np.isnan(stress).any(axis=(1, 2)) & (shown <= block.modulus * (1.0 + SAME))
        total[there] += cells[there, None, None] * stress[there]
        weight[there] += cells[there]
        shown[there] = np.maximum(shown[there], block.modulus)
    return total / np.maximum(weight, 1.0)[:, None, None]


def middle_surface(fe: FEModel) -> str:
    """Return a warning where shells bend, but their stress is the middle's and nobody chose it; else ""."""
    if not any(
        hasattr(b, "side") and b.side is None and np.any(getattr(b, "bending", 1.0)) for b in map(_bare, fe.blocks)
    ):
        return ""
    return (
        f"'{fe.name}': stress of shells is taken at the middle surface, without bending; give stress_side = 1 or -1 (0 "
        "where that is meant) to its plates and shells (Plate, MeshFile, fem.shell), or to its deck (the part that has "
        "one, fem.read_deck, flexmb reduce --stress-side)"
    )


def _bare(block):
    """Return the elements themselves of a block that links or joints with others surround."""
    while hasattr(block, "block"):
        block = block.block
    return block
