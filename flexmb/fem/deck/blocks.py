"""The elements of a `Deck` as blocks of an FE model, and the rigid arms of beams that lie off their nodes."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.deck.contents import Beams, Deck, Shells, Solids
from flexmb.fem.deck.curved_shells import held_turns
from flexmb.fem.deck.links import LinkRows
from flexmb.fem.deck.solid_kinds import held_bricks
from flexmb.fem.frames.frame import beam_block
from flexmb.fem.frames.rod_block import RodBlock
from flexmb.fem.shells.laminate_block import LaminateBlock, turned_plane
from flexmb.fem.shells.laminate_shear import turned_compliance
from flexmb.fem.shells.shell import WARPING, flattened
from flexmb.fem.solids.block import SolidBlock
from flexmb.fem.solids.elements import SOLID_ELEMENTS
from flexmb.fem.solids.solid import oriented

__all__ = ["beam_blocks", "rod_blocks", "shell_blocks", "solid_blocks"]

Labelled = tuple[Any, np.ndarray]
"""A block of elements, and their numbers in the deck (ne,)."""


def solid_blocks(deck: Deck, part: str) -> list[Labelled]:
    """Return a block per cell type and material; cells numbered left-handed are renumbered.

    Parts of one material are one block: each block costs time by the nodes of the whole deck.
    """
    out: dict[tuple, tuple[Solids, list[np.ndarray], list[np.ndarray]]] = {}
    for group in held_bricks(deck):
        element = SOLID_ELEMENTS[group.cell_type]
        cells = oriented(f"{part}, {group.group}", deck.points, group.nodes, element, labels=group.labels)
        turned = int((cells != group.nodes).any(axis=1).sum())
        if turned:
            deck.inventory.approximated[f"{group.cell_type} cells numbered left-handed, renumbered"] += turned
        key = (group.cell_type, group.element, group.elasticity.shape, group.elasticity.tobytes(), group.density)
        _, own, labels = out.setdefault(key, (group, [], []))
        own.append(cells)
        labels.append(group.labels)
    return [
        (
            SolidBlock(
                element=group.element or SOLID_ELEMENTS[group.cell_type],
                nodes=deck.points,
                connectivity=np.concatenate(cells),
                elasticity=group.elasticity,
                density=group.density,
            ),
            np.concatenate(labels),
        )
        for group, cells, labels in out.values()
    ]


def shell_blocks(deck: Deck, part: str) -> list[Labelled]:
    """Return a block per layup and number of corners; quadrilaterals too warped to be flat become triangles."""
    out = []
    flat = [group for given in deck.shells for group in _flat(given, deck)]
    for group, spring in zip(flat, held_turns(flat, deck.points), strict=True):
        cell_type = "triangle" if group.nodes.shape[1] == 3 else "quad"
        name = f"{part}, {group.group}"
        axes, corners, heights = flattened(name, cell_type, deck.points, group.nodes, labels=group.labels)
        angle = _angles(group.material_x, axes)
        a, b, d = (turned_plane(m, angle) for m in (group.membrane, group.coupling, group.bending))
        stretch = group.stretch[:, None, None]
        block = LaminateBlock(
            connectivity=group.nodes,
            axes=axes,
            corners=corners,
            heights=heights - group.offset[:, None],
            centers=deck.points[group.nodes].mean(axis=1),
            thickness=group.thickness,
            number_of_nodes=len(deck.points),
            side=deck.stress_side,
            membrane=a * stretch,
            coupling=b * stretch**2,
            bending=d * stretch**3,
            shear=turned_compliance(group.shear, angle) / stretch,
            surface_mass=group.mass,
            faces=np.stack([turned_plane(group.faces[k], angle) for k in range(2)], axis=1),
            depths=group.depths * group.stretch[:, None],
            poisson=group.poisson,
            spring=spring,
            point_masses=group.point_masses,
        )
        out.append((block, group.labels))
    return out


def _angles(direction: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return the angle (ne,) from local x to the part of a direction (ne, 3) in the plane of each element."""
    x, y = (np.einsum("ei,ei->e", direction, axes[:, k]) for k in range(2))
    return np.arctan2(y, x)


def _flat(group: Shells, deck: Deck) -> list[Shells]:
    """Return the group, its strongly warped quadrilaterals split along the shorter diagonal."""
    if group.nodes.shape[1] == 3:
        return [group]
    points = deck.points[group.nodes]
    normal = np.cross(points[:, 2] - points[:, 0], points[:, 3] - points[:, 1])
    area = np.linalg.norm(normal, axis=1)
    unit = normal / np.where(area > 0.0, area, 1.0)[:, None]
    height = np.einsum("eci,ei->ec", points - points.mean(axis=1)[:, None], unit)
    warped = np.abs(height).max(axis=1) > WARPING * np.sqrt(0.5 * area)
    if not warped.any():
        return [group]
    deck.inventory.approximated["warped quadrilaterals, split into two triangles"] += int(warped.sum())
    return [part for part in (group.only(~warped), group.only(warped).split(deck.points)) if len(part.nodes)]


def rod_blocks(deck: Deck, part: str) -> list[Labelled]:
    """Return a block per group of rods."""
    out = []
    for group in deck.rods:
        axes, lengths = _line_axes(part, deck.points, group.nodes, group.labels)
        block = RodBlock(
            connectivity=group.nodes,
            axes=axes,
            lengths=lengths,
            axial=group.axial,
            torsion=group.torsion,
            mass_per_length=group.mass,
            polar=group.polar,
            point_masses=group.point_masses,
            number_of_nodes=len(deck.points),
        )
        out.append((block, group.labels))
    return out


def _line_axes(part: str, points: np.ndarray, nodes: np.ndarray, labels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    along = points[nodes[:, 1]] - points[nodes[:, 0]]
    lengths = np.linalg.norm(along, axis=1)
    if (lengths <= 0.0).any():
        raise MeshError(
            part,
            found=f"element {int(labels[int(np.argmin(lengths))])} has no length",
            expected="two nodes at different places",
            remedy="Correct its nodes, or use a spring",
        )
    x = along / lengths[:, None]
    other = np.eye(3)[np.abs(x).argmin(axis=1)]
    y = np.cross(other, x)
    y /= np.linalg.norm(y, axis=1)[:, None]
    return np.stack([x, y, np.cross(x, y)], axis=1), lengths


def beam_blocks(deck: Deck, points: np.ndarray, part: str) -> tuple[np.ndarray, list[Labelled], list[LinkRows]]:
    """Return all nodes, offset and released beam ends behind the others, the blocks, and the ends' links."""
    blocks, links, grown = [], [], [points]
    count = len(points)
    for group in deck.beams:
        nodes, new, arms = group.nodes.copy(), [], []
        axes_of = _beam_axes(points, group)
        for k, (label, ends) in enumerate(zip(group.labels, group.released, strict=True)):
            for end in range(2):
                released, offset = ends[end], group.offsets[k, end]
                if not released and not offset.any():
                    continue
                arms.append((int(nodes[k, end]), count + len(new), offset, released, axes_of[k], int(label)))
                new.append(points[nodes[k, end]] + offset)
                nodes[k, end] = count + len(new) - 1
        if new:
            grown.append(np.array(new))
            count += len(new)
            links += _ends(arms, part)
        every = np.vstack(grown)
        who, lumped = f"{part}, {group.group}", group.point_masses
        block = beam_block(who, every, nodes, group.sections, group.material, group.y_axis, lumped)
        blocks.append((block, group.labels))
    return np.vstack(grown), blocks, links


def _beam_axes(points: np.ndarray, group: Beams) -> np.ndarray:
    """Return the local axes (ne, 3, 3) of beams between their offset ends."""
    ends = points[group.nodes] + group.offsets
    x = ends[:, 1] - ends[:, 0]
    x /= np.maximum(np.linalg.norm(x, axis=1), 1e-300)[:, None]
    y = group.y_axis - np.einsum("ei,ei->e", group.y_axis, x)[:, None] * x
    y /= np.maximum(np.linalg.norm(y, axis=1), 1e-300)[:, None]
    return np.stack([x, y, np.cross(x, y)], axis=1)


def _ends(arms: list, part: str) -> list[LinkRows]:
    """Return the links of beam ends to their nodes: rigid arms, without the directions that pins release."""
    rigid = LinkRows("the offset of a beam")
    out, levers = [rigid], []
    for node, end, (x, y, z), released, axes, label in arms:
        follow = np.eye(6)
        follow[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
        columns = 6 * node + np.arange(6)
        if not released & {0, 1, 2}:
            levers.append((node, end))
        if not released:
            rigid.add(6 * end + np.arange(6), columns, follow)
            continue
        turn = np.zeros((6, 6))
        turn[:3, :3] = turn[3:, 3:] = axes
        kept = [k for k in range(6) if k not in released]
        pinned = LinkRows(f"the pinned end of beam {label}")
        own = 6 * end + np.arange(6)
        matrix = np.hstack([turn[kept], -turn[kept] @ follow])
        pinned.add_equations(np.concatenate([own, columns]), matrix, own, f"{part}, beam {label}")
        out.append(pinned)
    if levers:
        nodes, ends = np.array(levers).T
        rigid.rigid = (nodes, ends)
    return out
