"""Links and supports of an Abaqus deck.

*RIGID BODY, *COUPLING, *KINEMATIC COUPLING, *MPC, *EQUATION and *TIE as eliminated freedoms; *BOUNDARY as supports.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flexmb.fem.deck.abaqus_materials import Materials
from flexmb.fem.deck.abaqus_model import Flat
from flexmb.fem.deck.abaqus_surfaces import facets, shape_of, surface_nodes
from flexmb.fem.deck.abaqus_text import Block, is_number
from flexmb.fem.deck.contents import Deck, Reference
from flexmb.fem.deck.links import Equation, Frames, LinkRows, arm, follow, mean_motion, rows_of, solved_together
from flexmb.fem.deck.supports import keep_supports
from flexmb.fem.deck.tie import tie_rows
from flexmb.fem.surface_load import facet_areas

__all__ = ["add_abaqus_links", "add_boundary"]

TIED = "the tie"
NAMED_SUPPORTS = {
    "ENCASTRE": range(6),
    "PINNED": range(3),
    "XSYMM": (0, 4, 5),
    "YSYMM": (1, 3, 5),
    "ZSYMM": (2, 3, 4),
    "XASYMM": (1, 2, 3),
    "YASYMM": (0, 2, 4),
    "ZASYMM": (0, 1, 5),
}


def add_abaqus_links(flat: Flat, deck: Deck, frames: Frames, materials: Materials) -> None:
    """Add what joins the parts; a coupling takes the keyword that follows it as its kind."""
    makers = {
        "RIGID BODY": _rigid_body,
        "KINEMATIC COUPLING": _old_kinematic,
        "DISTRIBUTING COUPLING": _distributing,
        "MPC": _mpc,
    }
    tied: set[int] = set()
    for block, scope in flat.blocks:  # first, since nodes are moved onto the faces they are tied to
        if block.name == "TIE":
            _tie(block, scope, flat, deck, tied)
    equations: list[Equation] = []
    for k, (block, scope) in enumerate(flat.blocks):
        if block.name == "EQUATION":
            equations += _equations(block, scope, flat, deck, frames)
        elif block.name == "COUPLING":
            _coupling(block, scope, [b for b, _ in flat.blocks[k + 1 : k + 3]], flat, deck, frames, materials)
        elif block.name in makers:
            makers[block.name](block, scope, flat, deck, frames)
    deck.links += solved_together(equations)


def _one(flat: Flat, word: str, scope: str, block: Block) -> int:
    nodes = flat.nodes_of(word, scope, block)
    if len(set(nodes)) != 1:
        raise block.wrong(f"'{word}' with {len(set(nodes))} nodes", "one node")
    return nodes[0]


def _name(flat: Flat, word: str, prefix: str) -> str:
    """Return the name of a reference point: the set that names the node, or its number."""
    return word if not is_number(word) else f"{prefix}_{word}"


def _directions(rows: list[list[str]], block: Block) -> list[int]:
    """Return directions 0..5 of lines "first, last"; all six without lines."""
    out: set[int] = set()
    for row in rows:
        numbers = block.integers(row[:2])
        if not numbers or not all(1 <= n <= 6 for n in numbers):
            raise block.wrong(f"directions '{','.join(row)}'", "numbers 1 to 6")
        out |= set(range(numbers[0] - 1, (numbers[1] if len(numbers) > 1 else numbers[0])))
    return sorted(out) or list(range(6))


def _coupling(
    block: Block,
    scope: str,
    after: list[Block],
    flat: Flat,
    deck: Deck,
    frames: Frames,
    materials: Materials,
) -> None:
    """*COUPLING: chosen directions follow, in the axes of its ORIENTATION or of each node."""
    word = block.need("REFNODE")
    reference = _one(flat, word, scope, block)
    surface = flat.full(flat.surfaces, block.need("SURFACE"), scope)
    if surface is None:
        known = ", ".join(sorted(flat.surfaces)[:12]) or "none"
        raise block.wrong(f"the surface '{block.parameters['SURFACE']}', which does not exist", f"One of: {known}")
    nodes = [n for n in surface_nodes(flat, surface).tolist() if n != reference]
    kind = next((b for b in after if b.name in ("KINEMATIC", "DISTRIBUTING")), None)
    if kind is None:
        raise block.wrong(
            "no kind: neither *KINEMATIC nor *DISTRIBUTING follows it",
            "one of them on the next line",
            "Write *KINEMATIC to tie the surface rigidly, *DISTRIBUTING to let the node follow its mean",
        )
    if not nodes:
        raise block.wrong(f"no nodes on the surface '{block.parameters['SURFACE']}'", "a surface with nodes")
    label = block.parameters.get("CONSTRAINTNAME", "") or f"coupling_{word}"
    directions = _directions(kind.rows(), kind)
    own = frames
    if "ORIENTATION" in block.parameters and len(directions) < 6:
        turned = nodes if kind.name == "KINEMATIC" else [reference]
        axes = materials.axes(block.parameters["ORIENTATION"], scope, block, flat, deck.points[turned])
        own = {**frames, **dict(zip(turned, axes, strict=True))}
    link = LinkRows(f"the coupling '{label}'")
    if kind.name == "KINEMATIC":
        for node in nodes:
            follow(link, deck.points, own, node, directions, reference, f"{block.where}, *COUPLING")
        if {0, 1, 2} <= set(directions):
            link.rigid = (reference, np.array(nodes, np.int64))
        at = Reference(node=reference)
    else:
        at = _averaged(link, deck, own, reference, _areas(flat, surface, nodes, deck), directions, block)
    deck.links.append(link)
    deck.references.setdefault(label, at)
    deck.inventory.read[f"*COUPLING ({kind.name.lower()})"] += 1


def _areas(flat: Flat, surface: str, nodes: list[int], deck: Deck) -> dict[int, float]:
    """Return the weights of nodes: their shares of the area of a surface of faces, int N dA; 1 on one of nodes."""
    faces = facets(flat, surface, middles=True)
    if not len(faces):
        return dict.fromkeys(nodes, 1.0)
    share = facet_areas(deck.points, faces)
    return {node: float(share[node]) for node in nodes}


def _averaged(
    link: LinkRows,
    deck: Deck,
    frames: Frames,
    reference: int,
    weights: dict[int, float],
    directions: list[int],
    block: Block,
) -> Reference:
    """Let a reference node follow the weighted mean of others."""
    who = f"{block.where}, *{block.name}"
    groups = [(node, [0, 1, 2], weight) for node, weight in weights.items()]
    columns, mean = mean_motion(deck.points, frames, groups, reference, directions, who)
    rows = rows_of(reference, directions, frames)
    own = 6 * reference + np.arange(6)
    link.add_equations(np.concatenate([own, columns]), np.hstack([rows, -rows @ mean]), own, who)
    order = sorted(weights)
    return Reference(
        node=reference, averaged=np.array(order, np.int64), weights=np.array([weights[node] for node in order])
    )


def _distributing(block: Block, scope: str, flat: Flat, deck: Deck, frames: Frames) -> None:
    """*DISTRIBUTING COUPLING: the node of an element DCOUP3D follows the mean of nodes with given weights."""
    word = block.need("ELSET")
    found = flat.named(flat.element_sets, word, scope, block, "element set")
    if len(found) != 1 or len(flat.elements[found[0]].nodes) != 1:
        raise block.wrong(f"ELSET={word} with {len(found)} elements", "one element DCOUP3D of one node")
    reference = flat.elements[found[0]].nodes[0]
    weights: dict[int, float] = {}
    for row in block.rows():
        value = block.reals(row[1:2], 1, 1.0)[0]
        if not value > 0.0:
            raise block.wrong(f"a weight of {value:g}", "positive weights")
        weights |= {node: value for node in flat.nodes_of(row[0], scope, block) if node != reference}
    if not weights:
        raise block.wrong("no nodes", "a node or set and its weight in every line")
    link = LinkRows(f"the distributing coupling '{word}'")
    at = _averaged(link, deck, frames, reference, weights, list(range(6)), block)
    deck.links.append(link)
    deck.references.setdefault(word, at)
    deck.inventory.read["*DISTRIBUTING COUPLING"] += 1


def _old_kinematic(block: Block, scope: str, flat: Flat, deck: Deck, frames: Frames) -> None:
    word = block.need("REFNODE")
    reference = _one(flat, word, scope, block)
    link = LinkRows(f"the kinematic coupling at node {word}")
    for row in block.rows():
        directions = _directions([row[1:]] if any(row[1:]) else [], block)
        for node in dict.fromkeys(flat.nodes_of(row[0], scope, block)):
            if node != reference:
                follow(link, deck.points, frames, node, directions, reference, f"{block.where}, *{block.name}")
    deck.links.append(link)
    deck.references.setdefault(_name(flat, word, "coupling"), Reference(node=reference))
    deck.inventory.read["*KINEMATIC COUPLING"] += 1


def _rigid_body(block: Block, scope: str, flat: Flat, deck: Deck, frames: Frames) -> None:
    """All nodes follow the reference; CalculiX keeps the rotations in the translations of a ROT NODE."""
    word = block.need("REFNODE")
    reference = _one(flat, word, scope, block)
    nodes: set[int] = set()
    for key in ("ELSET",):
        if key in block.parameters:
            for k in flat.named(flat.element_sets, block.parameters[key], scope, block, "element set"):
                nodes |= set(flat.elements[k].nodes)
    for key in ("NSET", "TIENSET"):
        if key in block.parameters:
            nodes |= set(flat.nodes_of(block.parameters[key], scope, block))
    pinned = set(flat.nodes_of(block.parameters["PINNSET"], scope, block)) if "PINNSET" in block.parameters else set()
    turning: int | None = None
    if "ROTNODE" in block.parameters:
        turning = _one(flat, block.parameters["ROTNODE"], scope, block)
    nodes -= {reference, turning if turning is not None else reference}
    link = LinkRows(f"the rigid body at node {word}")
    for node in sorted(nodes | pinned):
        directions = list(range(3)) if node in pinned and node not in nodes else list(range(6))
        if turning is None:
            follow(link, deck.points, frames, node, directions, reference, f"{block.where}, *RIGID BODY")
        else:
            motion = arm(deck.points, node, reference)
            columns = np.concatenate([6 * reference + np.arange(3), 6 * turning + np.arange(3)])
            link.add(6 * node + np.arange(6), columns, motion)
    if turning is not None:
        link.add(6 * reference + np.arange(3, 6), 6 * turning + np.arange(3), np.eye(3))
    else:
        link.rigid = (reference, np.array(sorted(nodes | pinned), np.int64))
        deck.references.setdefault(_name(flat, word, "rigid"), Reference(node=reference))
    deck.links.append(link)
    deck.inventory.read["*RIGID BODY"] += 1


def _mpc(block: Block, scope: str, flat: Flat, deck: Deck, frames: Frames) -> None:
    for row in block.rows():
        kind, words = row[0].upper(), [word for word in row[1:] if word]
        if kind not in ("BEAM", "TIE", "PIN") or len(words) < 2:
            deck.inventory.left_out[f"*MPC of type {kind or '?'}"] += 1
            continue
        directions = [0, 1, 2] if kind == "PIN" else list(range(6))
        followers, leaders = (flat.nodes_of(word, scope, block) for word in words[:2])
        if len(leaders) == 1:
            leaders = leaders * len(followers)
        if len(leaders) != len(followers):
            raise block.wrong(f"{len(followers)} nodes that follow {len(leaders)}", "sets of one size")
        link = LinkRows(f"*MPC {kind}")
        for node, leader in zip(followers, leaders, strict=True):
            if kind == "BEAM":
                follow(link, deck.points, frames, node, directions, leader, f"{block.where}, *MPC")
            else:
                link.add(6 * node + np.array(directions), 6 * leader + np.array(directions), np.eye(len(directions)))
        deck.links.append(link)
        deck.inventory.read[f"*MPC {kind}"] += 1


def _equations(block: Block, scope: str, flat: Flat, deck: Deck, frames: Frames) -> Iterator[Equation]:
    """Yield the equations of a keyword."""
    if "REMOVE" in block.parameters:
        return
    words = [word for row in block.rows() for word in row if word]
    at = 0
    while at < len(words):
        count = block.integers(words[at : at + 1], 1)[0]
        terms = words[at + 1 : at + 1 + 3 * count]
        if count < 1 or len(terms) < 3 * count:
            raise block.wrong(f"an equation of {count} terms with {len(terms)} words", "node, direction, factor each")
        at += 1 + 3 * count
        sets = [flat.nodes_of(terms[3 * k], scope, block) for k in range(count)]
        size = max(len(s) for s in sets)
        if any(len(s) not in (1, size) for s in sets):
            raise block.wrong("sets of different size in an equation", "single nodes or sets of one size")
        for i in range(size):
            yield _one_equation(block, terms, sets, i, frames)
        deck.inventory.read["*EQUATION"] += 1


def _one_equation(block: Block, terms: list[str], sets: list[list[int]], i: int, frames: Frames) -> Equation:
    columns, row, first = [], [], None
    for k, nodes in enumerate(sets):
        node = nodes[0] if len(nodes) == 1 else nodes[i]
        direction = block.integers(terms[3 * k + 1 : 3 * k + 2], 1)[0]
        if not 1 <= direction <= 6:
            raise block.wrong(f"direction {direction}", "1 to 6")
        factor = block.reals(terms[3 * k + 2 : 3 * k + 3], 1)[0]
        columns.append(6 * node + np.arange(6))
        row.append(factor * rows_of(node, [direction - 1], frames)[0])
        first = columns[-1][np.abs(row[-1]) > 0.0] if first is None else first
    assert first is not None
    return Equation.of("*EQUATION", f"{block.where}, *EQUATION", columns, row, first)


def _tie(block: Block, scope: str, flat: Flat, deck: Deck, tied: set[int]) -> None:
    """Nodes of the first surface follow the faces of the second on which they lie, by projection; those that an earlier
    tie holds, which are in `tied`, follow that one alone.

    Nodes beside their face are moved onto it unless ADJUST=NO, as Abaqus and CalculiX do it; not to faces of shells,
    which lie half a thickness off and whose rotations carry the gap.
    """
    if {"CYCLICSYMMETRY", "MULTISTAGE", "FLUIDPERIODIC", "FLUIDCYCLIC"} & set(block.parameters):
        deck.inventory.left_out["*TIE of a cyclic or periodic structure"] += 1
        return
    for row in block.rows():
        names = [flat.full(flat.surfaces, word, scope) for word in row[:2]]
        if len(names) < 2 or None in names:
            known = ", ".join(sorted(flat.surfaces)[:12]) or "none"
            raise block.wrong(f"surfaces '{', '.join(row[:2])}' that do not exist", f"two of: {known}")
        follower, leader = names
        assert follower is not None
        assert leader is not None
        given = block.parameters.get("POSITIONTOLERANCE", "")
        tolerance = block.reals([given], 1)[0] if given else None
        nodes, rows = surface_nodes(flat, follower), facets(flat, leader, middles=True)
        if not len(rows):
            raise block.wrong(f"the surface '{row[1]}' without faces", "a surface of element faces")
        shells = {n for e in flat.elements if shape_of(e.kind)[0] in ("shell", "beam") for n in e.nodes}
        turning = bool(shells) and set(rows[rows >= 0].tolist()) <= shells
        both = turning and set(nodes.tolist()) <= shells
        name = f"{TIED} '{block.parameters.get('NAME', '')}'"
        found, sides = deck.inventory.approximated, f"nodes of '{row[0]}'"
        tie = tie_rows(name, deck.points, nodes, rows, tolerance, both, turning)
        if again := _followers(tie.link) & tied:
            nodes = np.array([n for n in nodes.tolist() if n not in tied], np.int64)
            tie = tie_rows(name, deck.points, nodes, rows, tolerance, both, turning)
            found[f"*TIE: {sides} that an earlier *TIE holds, tied there alone"] += len(again)
        tied |= _followers(tie.link)
        deck.links.append(tie.link)
        if tie.far:
            found[f"*TIE: {sides} too far from '{row[1]}' to be tied"] += tie.far
        if len(tie.moved) and block.parameters.get("ADJUST", "YES").upper() != "NO":
            deck.points[tie.moved] = tie.places
            found[f"*TIE: {sides} moved onto '{row[1]}', by up to {tie.widest:.3g} of the deck's unit"] += len(
                tie.moved
            )
        elif len(tie.moved):
            found[f"*TIE: {sides} tied over gaps of up to {tie.widest:.3g}, which hinder rotation"] += len(tie.moved)
        deck.inventory.read["*TIE"] += 1


def _followers(link: LinkRows) -> set[int]:
    """Return the nodes that a link moves."""
    return {int(freedom) // 6 for block in link.dependent for freedom in np.ravel(block)}


def add_boundary(flat: Flat, deck: Deck, frames: Frames, steps: list[tuple[Block, str]]) -> None:
    """Keep the supports of the model and of the first step as "boundary"."""
    held: dict[int, set[int]] = {}
    given = [(block, scope) for block, scope in steps if block.name == "BOUNDARY"]
    if not any(block.parameters.get("OP", "").upper() == "NEW" for block, _ in given):  # else the step begins anew
        given = [(block, scope) for block, scope in flat.blocks if block.name == "BOUNDARY"] + given
    for block, scope in given:
        for row in block.rows():
            nodes = flat.nodes_of(row[0], scope, block)
            word = row[1].upper() if len(row) > 1 else ""
            if word in NAMED_SUPPORTS:
                directions = list(NAMED_SUPPORTS[word])
            else:
                numbers = block.integers(row[1:3])
                if not numbers or not all(0 <= n <= 11 for n in numbers):
                    raise block.wrong(f"'{','.join(row)[:60]}'", "a node or set, first and last direction")
                directions = [k for k in range(numbers[0] - 1, numbers[-1]) if 0 <= k < 6]
            for node in nodes:
                held.setdefault(node, set()).update(directions)
    tied = {node for link in deck.links if link.name.startswith(TIED) for node in _followers(link)}
    if both := tied & held.keys():
        what = "*BOUNDARY at nodes that a *TIE holds: it holds their faces too, where CalculiX drops the tie"
        deck.inventory.approximated[what] += len(both)
    if held:
        pairs = [(node, sorted(parts)) for node, parts in sorted(held.items())]
        keep_supports(deck, "boundary", pairs, frames)
