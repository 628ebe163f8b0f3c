"""`beside`: FE models as one, each for itself, with places between them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy import sparse

from flexmb.fem.fe_model import FEModel
from flexmb.fem.joined import PlacedBlock
from flexmb.fem.meshes.groups import stacked

__all__ = ["beside"]


def beside(models: Mapping[str, FEModel], places: np.ndarray, name: str) -> tuple[FEModel, dict[str, tuple[int, int]]]:
    """Return models as one, none of whose nodes are common, and the first node and freedom of each.

    Parameters
    ----------
    models : mapping of name to FEModel
        The names come before the names of their sets: "left.skin".
    places : (k, 3), m
        More nodes, without freedoms, behind all others.
    """
    starts: dict[str, tuple[int, int]] = {}
    nodes, freedoms = 0, 0
    for key, fe in models.items():
        starts[key] = nodes, freedoms
        nodes, freedoms = nodes + len(fe.nodes), freedoms + fe.ndof
    blocks: list[PlacedBlock] = []
    node_sets: dict[str, np.ndarray] = {}
    facet_sets: dict[str, np.ndarray] = {}
    for key, fe in models.items():
        number = starts[key][0] + np.arange(len(fe.nodes))
        blocks += [PlacedBlock(block=block, number=number, number_of_nodes=nodes + len(places)) for block in fe.blocks]
        node_sets |= {f"{key}.{label}": number[members] for label, members in fe.node_sets.items()}
        filled = np.append(number, -1)  # the filler -1 of mixed facet rows stays -1
        facet_sets |= {f"{key}.{label}": stacked([filled[np.asarray(f, int)]]) for label, f in fe.facet_sets.items()}
    parts = list(models.values())
    expansion = None
    if any(fe.expansion is not None for fe in parts):
        each = [fe.expansion if fe.expansion is not None else _own_motion(fe) for fe in parts]
        expansion = sparse.vstack([sparse.block_diag(each), sparse.csr_matrix((6 * len(places), freedoms))]).tocsr()
    whole = FEModel(
        nodes=np.vstack([*(fe.nodes for fe in parts), places]),
        dofs=np.vstack([fe.dofs + np.array([starts[key][0], 0]) for key, fe in models.items()]),
        K=sparse.block_diag([fe.K for fe in parts]).tocsr(),
        M=sparse.block_diag([fe.M for fe in parts]).tocsr(),
        node_sets=node_sets,
        facet_sets=facet_sets,
        blocks=tuple(blocks),
        name=name,
        expansion=expansion,
        warnings=tuple(dict.fromkeys(words for fe in parts for words in fe.warnings)),
    )
    return whole, starts


def _own_motion(fe: FEModel) -> sparse.csr_matrix:
    """Return the motion (6 n, ndof) of nodes that move by their own freedoms only."""
    row = 6 * fe.dofs[:, 0] + fe.dofs[:, 1]
    return sparse.csr_matrix((np.ones(fe.ndof), (row, np.arange(fe.ndof))), shape=(6 * len(fe.nodes), fe.ndof))
