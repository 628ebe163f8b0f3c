"""`assembled`: the FE model of a `Deck`: elements summed, links eliminated, freedoms without stiffness held."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse

from flexmb.errors import MeshError
from flexmb.fem.deck.blocks import beam_blocks, rod_blocks, shell_blocks, solid_blocks
from flexmb.fem.deck.contents import Deck, Lumped
from flexmb.fem.deck.links import LinkRows, eliminated
from flexmb.fem.fe_model import FEModel, ReferencePoint
from flexmb.fem.links.links import LinkedBlock
from flexmb.fem.links.stiffness import RigidLinkBlock
from flexmb.fem.meshes.facets import oriented_facet_sets
from flexmb.fem.solids.block import SolidBlock
from flexmb.model.numbering import Numbering

__all__ = ["assembled"]

MESH_ALONE = "a mesh without properties: fem.solid(fem.read_mesh(...), material), flexmb reduce ... --material steel"
"""What else a file may be whose elements have no section: programs that draw write such ones."""
STIFFLESS = 1e-12
"""A freedom whose stiffness is below this share of the largest of its kind (translation, rotation) has none."""


def assembled(deck: Deck, lumped: bool) -> FEModel:
    """Return the FE model of a deck; what was held for want of stiffness is added to its inventory."""
    part = f"Deck '{deck.name}'"
    points, links = deck.points.copy(), list(deck.links)
    labelled: list = [*solid_blocks(deck, part), *shell_blocks(deck, part), *rod_blocks(deck, part)]
    points, beams, ends = beam_blocks(deck, points, part)
    labelled += beams
    links += ends
    blocks = [block for block, _ in labelled]
    if not blocks and not deck.lumped_parts:
        left = "; ".join(f"{count} {name}" for name, count in deck.inventory.left_out.most_common(3))
        raise MeshError(
            part,
            found=f"no structural elements; left out: {left:.200}" if left else "no structural elements",
            expected="solids, shells, beams, rods, springs or masses",
            remedy="Give elements of these kinds, with a section and a material, or the main file of the deck"
            + (f"; {MESH_ALONE}" if "no section" in left else ""),
        )
    n = len(points)
    blocks = [_grown(block, n) for block in blocks]
    dofs = _freedoms(blocks, deck.lumped_parts, links, n)
    K, M, C = _sums(blocks, deck, dofs, n, lumped)
    if deck.mass_factor != 1.0:
        M = M * deck.mass_factor
    mask, transfer = eliminated(part, links, 6 * n, _numbering(deck).node_name)
    rigid = _rigid_links(ends, K, dofs, points)
    rigid += _rigid_links(links[: len(links) - len(ends)], _with_ends(part, ends, K, dofs, n), dofs, points)
    flat = 6 * dofs[:, 0] + dofs[:, 1]
    kept = flat[~mask[flat]]
    present = np.zeros(6 * n, bool)
    present[kept] = True
    motion = transfer[flat][:, kept].tocsr()
    K, M, C = ((motion.T @ matrix @ motion).tocsr() for matrix in (K, M, C))
    held = _without_stiffness(K, M, kept)
    _say_held(deck, M, kept, held)
    free = np.flatnonzero(~held)
    kept = kept[free]
    K, M, C = (0.5 * (matrix + matrix.T)[free][:, free] for matrix in (K, M, C))
    expansion = transfer[:, kept].tocsr() if mask.any() else None
    own = np.stack(np.divmod(kept, 6), axis=1)
    if expansion is not None:
        blocks = [LinkedBlock(block=b, own_nodes=n, dofs=own, expansion=expansion) for b in [*blocks, *rigid]]
    return _finished(deck, points, own, K, M, C, blocks, expansion, tuple(labels for _, labels in labelled))


def _finished(deck: Deck, points, dofs, K, M, C, blocks, expansion, cell_labels) -> FEModel:
    solids = [(block.cell_type, block.nodes) for block in deck.solids]
    facets = dict(deck.facet_sets)
    if solids:
        facets = oriented_facet_sets(solids, deck.node_sets, facets, len(points))
    every = np.arange(len(points))
    return FEModel(
        nodes=points,
        dofs=dofs,
        K=K.tocsr(),
        M=M.tocsr(),
        C=C.tocsr() if C.nnz else None,
        node_sets=dict(deck.node_sets),
        facet_sets=facets,
        blocks=tuple(blocks),
        name=deck.name,
        expansion=expansion,
        numbering=_numbering(deck).of(every, cell_labels),
        supports=dict(deck.supports),
        slanted={name: _rows(pairs, 6 * len(points)) for name, pairs in deck.slanted.items()},
        reference_points={
            name: ReferencePoint(node=at.node, averaged=at.averaged, weights=at.weights)
            for name, at in deck.references.items()
        },
    )


def _numbering(deck: Deck) -> Numbering:
    return Numbering(nodes=deck.labels, instances=deck.instances, instance_of=deck.instance_of)


def _rows(pairs: list[tuple[int, np.ndarray]], size: int) -> sparse.csr_matrix:
    """Return directions of nodes as rows (r, 6 n)."""
    columns = np.array([6 * node + np.arange(6) for node, _ in pairs]).ravel()
    values = np.concatenate([row for _, row in pairs])
    rows = sparse.csr_matrix((values, (np.repeat(np.arange(len(pairs)), 6), columns)), shape=(len(pairs), size))
    rows.eliminate_zeros()
    return rows


def _grown(block, number_of_nodes: int):
    """Return a block that knows the number of all nodes, offset beam ends included."""
    if hasattr(block, "number_of_nodes"):
        return block if block.number_of_nodes == number_of_nodes else replace(block, number_of_nodes=number_of_nodes)
    missing = number_of_nodes - len(block.nodes)
    return block if not missing else replace(block, nodes=np.vstack([block.nodes, np.zeros((missing, 3))]))


def _freedoms(blocks, parts: list[Lumped], links: list[LinkRows], n: int) -> np.ndarray:
    """Return node and direction (ndof, 2) of all freedoms that an element, a mass, a spring or a link needs."""
    needed = np.zeros((n, 6), bool)
    for block in blocks:
        count = 3 if isinstance(block, SolidBlock) else 6
        needed[np.unique(block.connectivity), :count] = True
    flat = needed.ravel()
    for lump in parts:
        rows = (6 * np.array(lump.nodes)[:, None] + np.arange(6)).ravel()
        flat[rows[np.abs(lump.matrix).sum(axis=1) > 0.0]] = True
    for link in links:
        for block in (*link.dependent, *link.columns):
            flat[block] = True
    return np.stack(np.divmod(np.flatnonzero(flat), 6), axis=1)


def _sums(blocks, deck: Deck, dofs: np.ndarray, n: int, lumped: bool):
    """Return K, M and C (ndof, ndof) of all parts, before links."""
    size = len(dofs)
    none = sparse.csr_matrix((size, size))
    K, M = (
        _sum(list(own)) for own in zip((none, none), *(block.matrices(dofs, lumped) for block in blocks), strict=True)
    )
    row = np.full(6 * n, -1)
    row[6 * dofs[:, 0] + dofs[:, 1]] = np.arange(size)
    sums = {"stiffness": K, "mass": M, "damping": sparse.csr_matrix((size, size))}
    for kind in sums:
        i, j, values = [], [], []
        for lump in deck.lumped_parts:
            if lump.kind != kind:
                continue
            at = row[(6 * np.array(lump.nodes)[:, None] + np.arange(6)).ravel()]
            a, b = np.nonzero(lump.matrix)
            i.append(at[a])
            j.append(at[b])
            values.append(lump.matrix[a, b])
        if i:
            sums[kind] = sums[kind] + sparse.csr_matrix(
                (np.concatenate(values), (np.concatenate(i), np.concatenate(j))), shape=(size, size)
            )
    return sums["stiffness"], sums["mass"], sums["damping"]


def _sum(matrices: list[sparse.csr_matrix]) -> sparse.csr_matrix:
    """Return the sum, two neighbours at a time: one after another, a thousand parts take a thousand times as long."""
    while len(matrices) > 1:
        pairs = zip(matrices[::2], matrices[1::2], strict=False)
        matrices = [a + b for a, b in pairs] + matrices[len(matrices) // 2 * 2 :]
    return matrices[0]


def _without_stiffness(K: sparse.csr_matrix, M: sparse.csr_matrix, kept: np.ndarray) -> np.ndarray:
    """Return which freedoms have no stiffness (ndof,), as a program's automatic supports hold them.

    A translation with mass stays: holding it would change what the body weighs.
    """
    diagonal, turns = K.diagonal(), kept % 6 >= 3
    held = np.zeros(len(kept), bool)
    for kind in (turns, ~turns):
        if kind.any():
            held[kind] = diagonal[kind] <= STIFFLESS * max(diagonal[kind].max(), 0.0)
    return held & (turns | ~(M.diagonal() > 0.0))


def _say_held(deck: Deck, M: sparse.csr_matrix, kept: np.ndarray, held: np.ndarray) -> None:
    if not held.any():
        return
    heavy = held & (M.diagonal() > 0.0)
    deck.inventory.approximated["freedoms without stiffness, held"] += int(held.sum())
    if heavy.any():
        node = int(kept[np.flatnonzero(heavy)[0]]) // 6
        label = int(deck.labels[node]) if node < len(deck.labels) else 0
        text = f"freedoms with mass but without stiffness, held (the first at node {label})"
        deck.inventory.approximated[text] += int(heavy.sum())


def _with_ends(part: str, ends: list[LinkRows], K: sparse.csr_matrix, dofs: np.ndarray, n: int) -> sparse.csr_matrix:
    """Return K with the forces on offset beam ends passed on to their nodes, which other links may hold."""
    if not ends:
        return K
    mask, transfer = eliminated(part, ends, 6 * n, str)
    flat = 6 * dofs[:, 0] + dofs[:, 1]
    return (transfer[flat][:, flat].T @ K).tocsr() if mask.any() else K


def _rigid_links(links: list[LinkRows], K: sparse.csr_matrix, dofs: np.ndarray, points: np.ndarray) -> list:
    """Return the geometric stiffness of rigid links, from the forces K u that hold their nodes."""
    row = np.full((len(points), 6), -1)
    row[dofs[:, 0], dofs[:, 1]] = np.arange(len(dofs))
    out = []
    for link in links:
        if link.rigid is None:
            continue
        dependent = link.rigid[1]
        of = np.broadcast_to(np.asarray(link.rigid[0]), dependent.shape)
        which, directions = np.nonzero(row[dependent, :3] >= 0)
        nodes = dependent[which]
        out.append(
            RigidLinkBlock(
                nodes=of[which],
                number_of_nodes=len(points),
                dofs=dofs,
                stiffness=K[row[nodes, directions]],
                directions=directions,
                arms=points[nodes] - points[of[which]],
            )
        )
    return out
