"""`split`: an FE model cut along its element boundaries into parts, for bodies that deform too much to be one."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Protocol

import numpy as np
from scipy import sparse

from flexmb.errors import MeshError
from flexmb.fem.fe_model import ElementBlock, FEModel
from flexmb.model.numbering import Numbering

__all__ = ["split"]

EQUAL = 1e-9
"""What the matrices of the parts may differ from the whole, relative to the largest entry: rounding."""


class DivisibleBlock(ElementBlock, Protocol):
    """What the split needs of a block of elements beyond an `ElementBlock`."""

    def part(self, chosen: np.ndarray, nodes: np.ndarray, number: np.ndarray) -> DivisibleBlock:
        """Chosen elements (mask, (ne,)) on the given nodes (old numbers), renumbered by `number` (n,)."""

    def matrices(self, dofs: np.ndarray, lumped: bool) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
        """K and M (ndof, ndof) of these elements alone."""


def split(
    fe: FEModel,
    *,
    at: Sequence[float] | None = None,
    normal=(1.0, 0.0, 0.0),
    labels: Sequence | np.ndarray | None = None,
) -> tuple[FEModel, ...]:
    """Return the parts of an FE model; the nodes that parts a and b share are the node set "cut_a_b" of both.

    Parameters
    ----------
    fe : FEModel
        Of solids, shells or frames. Masses, springs, links and supports come after the split, on the parts.
    at : sequence of float, m
        Distances of the cutting planes from the origin along `normal`, increasing; n planes make n + 1 parts. An
        element belongs to the side of its centre, so a cut follows the mesh.
    normal : (3,)
    labels : (ne,) int, or one such array for each block of elements, instead of planes
        The part of every element, counted from 1.

    Returns
    -------
    tuple of FEModel
        In the axes of `fe`, with its node and facet sets as far as they lie in the part.

    Raises
    ------
    MeshError
        A part without elements or without a cut, or matrices that hold more than elements.

    Examples
    --------
    ::

        parts = fem.split(fem.solid(mesh, steel), at=(0.5, 1.0))
        blade = fmb.FloatingBody.split("blade", reduction.split(parts, {"root": "root", "tip": "tip"}, 8))
    """
    part = f"FE model '{fe.name}'"
    if not fe.blocks or fe.expansion is not None:
        raise MeshError(
            part,
            found="links between nodes" if fe.blocks else "matrices without elements",
            expected="solids, shells or frames, not linked yet",
            remedy="Split first, link the parts",
        )
    groups = _planes(fe, at, normal, part) if labels is None else _labels(fe, labels, part)
    numbers = _numbers(groups, at, part)
    members = [
        np.unique(np.concatenate([b.connectivity[g == k].ravel() for b, g in zip(fe.blocks, groups)])) for k in numbers
    ]
    for lumped in (False, True):
        parts = [
            _part(fe, [g == k for g in groups], nodes, f"{fe.name}_{k}", lumped) for k, nodes in zip(numbers, members)
        ]
        if _equal(fe.M, parts, members, "M", fe):
            break
    else:
        raise _more(part, "mass matrix")
    if not _equal(fe.K, parts, members, "K", fe):
        raise _more(part, "stiffness matrix")
    return _with_cuts(parts, members, part)


def _planes(fe, at, normal, part):
    """Return the part of every element by its centre."""
    direction, places = np.asarray(normal, float), np.asarray([] if at is None else at, float)
    if (
        direction.shape != (3,)
        or not np.linalg.norm(direction) > 0.0
        or places.ndim != 1
        or not len(places)
        or np.any(np.diff(places) <= 0.0)
    ):
        raise MeshError(
            part,
            found=f"at = {at!r}, normal = {normal!r}",
            expected="increasing distances, m, along a vector (3,)",
            remedy="Write at=(0.5, 1.0)",
        )
    direction = direction / np.linalg.norm(direction)
    return [1 + np.searchsorted(places, fe.nodes[b.connectivity].mean(axis=1) @ direction) for b in fe.blocks]


def _labels(fe, labels, part):
    """Return the given part of every element, block by block."""
    counts = [len(b.connectivity) for b in fe.blocks]
    whole = len(counts) == 1 or np.ndim(labels[0]) == 0
    flat = np.asarray(labels if whole else np.concatenate([np.asarray(x) for x in labels])).ravel()
    if flat.dtype.kind not in "iu" or len(flat) != sum(counts):
        raise MeshError(
            part,
            found=f"{len(flat)} labels of type {flat.dtype}",
            expected=f"{sum(counts)} integers, one per element",
            remedy="Number the parts from 1",
        )
    return np.split(flat, np.cumsum(counts)[:-1])


def _numbers(groups, at, part) -> np.ndarray:
    """Return the numbers of the parts: two or more, from 1 on, as many as planes make."""
    numbers = np.unique(np.concatenate(groups))
    if (
        not np.array_equal(numbers, np.arange(1, len(numbers) + 1))
        or len(numbers) < 2
        or (at is not None and len(numbers) != len(at) + 1)
    ):
        raise MeshError(
            part,
            found=f"elements in the parts {numbers.tolist()}",
            expected="elements in each of two or more parts, numbered from 1",
            remedy="Put the planes inside the body, more than an element apart",
        )
    return numbers


def _part(fe: FEModel, chosen, nodes: np.ndarray, name: str, lumped: bool) -> FEModel:
    """Return the FE model of the chosen elements (a mask for each block) with the given nodes."""
    number = np.full(len(fe.nodes), -1)
    number[nodes] = np.arange(len(nodes))
    rows = number[fe.dofs[:, 0]] >= 0
    dofs = np.column_stack([number[fe.dofs[rows, 0]], fe.dofs[rows, 1]])
    divided: Sequence[DivisibleBlock] = fe.blocks  # type: ignore[assignment]
    blocks = tuple(b.part(mask, nodes, number) for b, mask in zip(divided, chosen) if mask.any())
    K, M = (sum(matrices) for matrices in zip(*(b.matrices(dofs, lumped) for b in blocks)))
    sets = {key: number[np.asarray(value)] for key, value in fe.node_sets.items()}
    facets = {
        key: np.where(value < 0, -1, number[value])[np.all((value < 0) | (number[value] >= 0), axis=1)]
        for key, value in fe.facet_sets.items()
    }
    return FEModel(
        nodes=fe.nodes[nodes],
        dofs=dofs,
        K=K.tocsr(),
        M=M.tocsr(),
        blocks=blocks,
        name=name,
        node_sets={key: value[value >= 0] for key, value in sets.items() if np.any(value >= 0)},
        facet_sets={key: value for key, value in facets.items() if len(value)},
        numbering=_numbering(fe, chosen, nodes),
        warnings=fe.warnings,
        source=fe.source,
    )


def _numbering(fe: FEModel, chosen, nodes: np.ndarray) -> Numbering | None:
    """Return the numbers in the file of the nodes and cells of a part."""
    if fe.numbering is None:
        return None
    whole = fe.numbering.padded(len(fe.nodes), [len(mask) for mask in chosen])
    return whole.of(nodes, tuple(labels[mask] for labels, mask in zip(whole.cells, chosen) if mask.any()))


def _equal(whole, parts, members, symbol: str, fe: FEModel) -> bool:
    """Do the parts' matrices add up to the whole?"""
    row = np.full((len(fe.nodes), 6), -1)
    row[fe.dofs[:, 0], fe.dofs[:, 1]] = np.arange(fe.ndof)
    rest = sparse.csr_matrix(whole, copy=True)
    for part, nodes in zip(parts, members):
        place = row[nodes[part.dofs[:, 0]], part.dofs[:, 1]]
        at = sparse.csr_matrix((np.ones(len(place)), (place, np.arange(len(place)))), shape=(fe.ndof, len(place)))
        rest = rest - at @ getattr(part, symbol) @ at.T
    return bool(abs(rest).max() <= EQUAL * abs(whole).max())


def _with_cuts(parts, members, part) -> tuple[FEModel, ...]:
    """Return the parts with the nodes they share as node sets."""
    cuts: list[dict[str, np.ndarray]] = [{} for _ in parts]
    for a, b in combinations(range(len(parts)), 2):
        common = np.intersect1d(members[a], members[b])
        if len(common):
            for k in (a, b):
                cuts[k][f"cut_{a + 1}_{b + 1}"] = np.searchsorted(members[k], common)
    if not all(cuts):
        alone = 1 + next(k for k, cut in enumerate(cuts) if not cut)
        raise MeshError(
            part,
            found=f"part {alone} shares no node with another",
            expected="parts that hang together",
            remedy="Merge coincident nodes of the mesh",
        )
    return tuple(FEModel(**{**vars(p), "node_sets": {**p.node_sets, **cut}}) for p, cut in zip(parts, cuts))


def _more(part: str, what: str) -> MeshError:
    return MeshError(
        part,
        found=f"a {what} that is not the sum of its elements",
        expected="solids, shells or frames alone",
        remedy="Split first; add masses, springs and supports to the parts",
    )
