"""Rigid and averaging links of a Nastran deck, and supports.

RBE2, RBE3, RBAR, RBE1 and RROD as eliminated freedoms (MSC Nastran Quick Reference Guide); SPC, SPC1, SPCADD and
the permanent constraints of GRID cards as supports; ASET and the like as reference points.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from flexmb.fem.deck.contents import Deck, Reference
from flexmb.fem.deck.links import Frames, LinkRows, arm, follow, mean_motion, rows_of
from flexmb.fem.deck.nastran_text import Bulk, Card
from flexmb.fem.deck.supports import keep_supports
from flexmb.fem.ranges import LARGEST, RANGE

__all__ = ["add_links", "add_references", "add_supports", "components", "thru"]

Held = dict[int, list[tuple[int, list[int]]]]
"""By set: nodes and the components that are held."""
Across = dict[int, list[tuple[int, np.ndarray]]]
"""By set: supports of scalar points that are directions of nodes."""


def add_links(bulk: Bulk, deck: Deck, frames: Frames) -> None:
    """Add all rigid and averaging links."""
    for card in bulk.of("RBE2"):
        _rbe2(card, deck, frames)
    for card in bulk.of("RBE3"):
        _rbe3(card, deck, frames)
    for card in bulk.of("RBAR"):
        _rbar(card, deck, frames)
    for card in bulk.of("RBE1"):
        _rbe1(card, deck, frames)
    for card in bulk.of("RROD"):
        _rrod(card, deck, frames)


def components(card: Card, i: int) -> list[int]:
    """Return the directions 0..5 of a field such as "123456"; a blank or "0" names the one freedom of a scalar.

    Blanks between the digits do not count: "12 456".
    """
    word = "".join(card.text(i).split())
    if not word or not set(word) <= set("123456"):
        if word in ("", "0"):
            return [0]
        raise card.wrong(i, "digits out of 1 to 6")
    return sorted({int(c) - 1 for c in word})


def _node(card: Card, deck: Deck, i: int) -> int:
    return int(deck.numbers([card.integer(i)], f"{card.where}, {card.name} {card.text(1)}")[0])


def _rbe2(card: Card, deck: Deck, frames: Frames) -> None:
    reference, directions = _node(card, deck, 2), components(card, 3)
    words = [word for word in card.fields[4:] if word]
    if words and not words[-1].isdigit() and "THRU" not in (w.upper() for w in words[-2:]):
        words = words[:-1]  # thermal expansion coefficient
    labels = thru(card, words)
    link = LinkRows(f"RBE2 {card.text(1)}")
    nodes = [n for n in deck.numbers(labels, f"{card.where}, RBE2 {card.text(1)}") if n != reference]
    for node in nodes:
        follow(link, deck.points, frames, int(node), directions, reference, f"{card.where}, RBE2 {card.text(1)}")
    if {0, 1, 2} <= set(directions):
        link.rigid = (reference, np.array(nodes, np.int64))
    deck.links.append(link)
    deck.references.setdefault(f"rbe2_{card.text(1)}", Reference(node=reference))
    deck.inventory.read["RBE2"] += 1


def _rbe3(card: Card, deck: Deck, frames: Frames) -> None:
    """Weighted least squares motion of the reference; UM moves the dependence onto other freedoms."""
    who = f"{card.where}, RBE3 {card.text(1)}"
    reference, directions = _node(card, deck, 3), components(card, 4)
    groups, chosen = _rbe3_groups(card, deck, who)
    columns, mean = mean_motion(deck.points, frames, groups, reference, directions, who)
    link = LinkRows(f"RBE3 {card.text(1)}")
    own = 6 * reference + np.arange(6)
    rows = rows_of(reference, directions, frames)
    equations = np.hstack([rows, -rows @ mean])
    every = np.concatenate([own, columns])
    candidates = chosen if len(chosen) else own
    link.add_equations(every, equations, candidates, who)
    deck.links.append(link)
    nodes = np.unique([node for node, _, _ in groups])
    spread = {int(n): 0.0 for n in nodes}
    for node, _, weight in groups:
        spread[int(node)] = max(spread[int(node)], weight)
    name = f"rbe3_{card.text(1)}"
    deck.references.setdefault(
        name, Reference(node=reference, averaged=nodes, weights=np.array([spread[int(n)] for n in nodes]))
    )
    deck.inventory.read["RBE3"] += 1


def _rbe3_groups(card: Card, deck: Deck, who: str) -> tuple[list[tuple[int, list[int], float]], np.ndarray]:
    """Return (node, directions, weight) of the averaged points, and the freedoms of UM."""
    groups: list[tuple[int, list[int], float]] = []
    chosen: list[int] = []
    words = card.fields
    i, weight, parts, expect = 5, 1.0, [0, 1, 2], "weight"
    while i < len(words):
        word = words[i].upper()
        if word == "UM":
            i += 1
            while i < len(words) and words[i].upper() != "ALPHA":
                if words[i]:
                    node = _node(card, deck, i)
                    chosen += [6 * node + k for k in components(card, i + 1)]
                    i += 1
                i += 1
            break
        if word == "ALPHA":
            break
        if not word:
            i += 1
        elif card.is_real(i) or expect == "weight":
            weight, parts, expect = card.real(i), components(card, i + 1), "node"
            i += 2
        else:
            groups.append((_node(card, deck, i), parts, weight))
            if i + 1 < len(words) and words[i + 1].upper() == "THRU":
                last = card.integer(i + 2)
                for label in range(card.integer(i) + 1, last + 1):
                    groups.append((int(deck.numbers([label], who)[0]), parts, weight))
                i += 2
            i += 1
    if not groups or not sum(w for _, _, w in groups) > 0.0 or min(w for _, _, w in groups) < 0.0:
        raise card.refused("no points with a positive weight", "weights >= 0 and at least one point")
    return groups, np.array(chosen, np.int64)


def _rbar(card: Card, deck: Deck, frames: Frames) -> None:
    a, b = _node(card, deck, 2), _node(card, deck, 3)
    sets = [components(card, k) if card.text(k) and card.text(k) != "0" else [] for k in (4, 5, 6, 7)]
    independent_a, independent_b, dependent_a, dependent_b = sets
    if not dependent_a and not dependent_b:
        dependent_a = [k for k in range(6) if k not in independent_a]
        dependent_b = [k for k in range(6) if k not in independent_b]
    if len(independent_a) + len(independent_b) != 6:
        raise card.refused(
            f"{len(independent_a) + len(independent_b)} independent components", "six that describe a rigid motion"
        )
    _rigid_set(
        card, deck, frames, [(a, independent_a), (b, independent_b)], [(a, dependent_a), (b, dependent_b)], "RBAR"
    )
    for node in (a, b):
        deck.references.setdefault(f"rbar_{card.text(1)}_{deck.labels[node]}", Reference(node=node))


def _rbe1(card: Card, deck: Deck, frames: Frames) -> None:
    words = card.fields
    at = next((k for k, word in enumerate(words) if word.upper() == "UM"), None)
    if at is None:
        raise card.refused("no UM", "independent components, then UM and dependent ones")
    independent = _pairs(card, deck, 2, at)
    dependent = _pairs(card, deck, at + 1, len(words))
    if sum(len(parts) for _, parts in independent) != 6:
        raise card.refused("independent components that are not six", "six that describe a rigid motion")
    _rigid_set(card, deck, frames, independent, dependent, "RBE1")


def _pairs(card: Card, deck: Deck, first: int, last: int) -> list[tuple[int, list[int]]]:
    out, i = [], first
    while i < last:
        if card.text(i) and card.text(i).isdigit():
            out.append((_node(card, deck, i), components(card, i + 1)))
            i += 2
        else:
            i += 1
    return out


def _rigid_set(card: Card, deck: Deck, frames: Frames, independent, dependent, kind: str) -> None:
    """Let dependent components follow the rigid motion that six independent ones describe."""
    who = f"{card.where}, {kind} {card.text(1)}"
    base = independent[0][0]
    given, columns = [], []
    for node, parts in independent:
        if not parts:
            continue
        rows = rows_of(node, parts, frames)
        given.append((rows, node))
        columns.append(6 * node + np.arange(6))
    motion = np.vstack([rows @ arm(deck.points, node, base) for rows, node in given])
    pick = np.zeros((6, 6 * len(given)))
    at = 0
    for k, (rows, _) in enumerate(given):
        pick[at : at + len(rows), 6 * k : 6 * k + 6] = rows
        at += len(rows)
    length = max(float(np.linalg.norm(deck.points[node] - deck.points[base])) for node, _ in [*independent, *dependent])
    scale = np.array([1.0, 1.0, 1.0] + [1.0 / (length or 1.0)] * 3)
    turns = np.array([part >= 3 for _, parts in independent for part in parts])
    rows_scale = np.where(turns, length or 1.0, 1.0)[:, None]  # a rotation counts like its displacement at the far end
    scaled = rows_scale * motion * scale
    if abs(np.linalg.det(scaled)) < 1e-9:
        raise card.refused("independent components that do not describe a rigid motion", "six independent ones")
    body = scale[:, None] * np.linalg.solve(scaled, rows_scale * pick)
    link = LinkRows(f"{kind} {card.text(1)}")
    for node, parts in dependent:
        if not parts:
            continue
        rows = rows_of(node, parts, frames)
        own = 6 * node + np.arange(6)
        every = np.concatenate([own, *columns])
        matrix = np.hstack([rows, -rows @ arm(deck.points, node, base) @ body])
        unique, inverse = np.unique(every, return_inverse=True)  # a node may be on both sides
        merged = np.zeros((len(unique), len(matrix)))
        np.add.at(merged, inverse.ravel(), matrix.T)
        allowed = own[np.abs(rows).max(axis=0) > 1e-9]
        link.add_equations(unique, merged.T, allowed, who)
    deck.links.append(link)
    deck.inventory.read[kind] += 1


def _rrod(card: Card, deck: Deck, frames: Frames) -> None:
    a, b = _node(card, deck, 2), _node(card, deck, 3)
    along = deck.points[b] - deck.points[a]
    size = np.linalg.norm(along)
    if not size > 0.0:
        raise card.refused("two nodes at one place", "a rod of some length")
    row = np.concatenate([along / size, -along / size])[None, :]
    columns = np.concatenate([6 * a + np.arange(3), 6 * b + np.arange(3)])
    part = card.text(5) or card.text(4)
    candidates = 6 * (b if card.text(5) or not card.text(4) else a) + np.arange(3)
    link = LinkRows(f"RROD {card.text(1)}")
    link.add_equations(columns, row, candidates, f"{card.where}, RROD {card.text(1)} {part}")
    deck.links.append(link)
    deck.inventory.read["RROD"] += 1


def thru(card: Card, words: list[str], known: Collection[int] | None = None) -> list[int]:
    """Return the numbers of a list such as ``1 5 THRU 9 20``; MeshError if it is none.

    Of a range that is longer than all `known` numbers, only these; without them a range may have `RANGE` numbers.
    """
    out: list[int] = []
    i = 0
    try:
        while i < len(words):
            if words[i].upper() == "THRU":
                step = int(words[i + 3]) if i + 3 < len(words) and words[i + 2].upper() == "BY" else 1
                last = int(words[i + 1])
                span = range(out[-1] + step, last + 1, step)
                if not 0 <= last - out[-1] < LARGEST or (known is None and len(span) > RANGE):
                    raise ValueError("descending, or too long")
                out += span if known is None or len(span) <= len(known) else sorted(n for n in known if n in span)
                i += 4 if step != 1 or (i + 2 < len(words) and words[i + 2].upper() == "BY") else 2
            else:
                out.append(int(words[i]))
                i += 1
        if any(not 0 < number < LARGEST for number in out):
            raise ValueError("numbers of nodes")
    except (ValueError, IndexError):
        raise card.refused(
            f"the list {' '.join(words)[:60]}", f"numbers and THRU, each over {RANGE} numbers at most"
        ) from None
    return out


def add_supports(bulk: Bulk, deck: Deck, frames: Frames, table) -> None:
    """Add supports by set: "spc_1", and "spc" for the set that the case control chooses."""
    held: Held = {}
    across: Across = {}
    _add_single(bulk, deck, held, across)
    _add_lists(bulk, deck, held, across)
    for card in bulk.of("SPCADD"):
        members = [card.integer(k) for k in range(2, len(card.fields)) if card.text(k)]
        held[card.integer(1)] = [pair for member in members for pair in held.get(member, [])]
        across[card.integer(1)] = [row for member in members for row in across.get(member, [])]
        deck.inventory.read["SPCADD"] += 1
    for number, pairs in held.items():
        keep_supports(deck, f"spc_{number}", pairs, frames, across.get(number, ()))
    if permanent := _permanent(bulk, deck, table):
        keep_supports(deck, "grid_ps", permanent, frames)
    chosen = bulk.choices.get("SPC", next(iter(held)) if len(held) == 1 else None)
    names = [name for name in (f"spc_{chosen}", "grid_ps") if name in deck.supports]
    if names:
        deck.supports["spc"] = np.unique(np.vstack([deck.supports[name] for name in names]), axis=0)
    if rows := [row for name in names for row in deck.slanted.get(name, [])]:
        deck.slanted["spc"] = rows


def _add_single(bulk: Bulk, deck: Deck, held: Held, across: Across) -> None:
    """Add the grid points of SPC cards, two on each."""
    for card in bulk.of("SPC"):
        for at in (2, 5):
            if card.text(at) and card.integer(at) in deck.scalar_points:
                _hold_point(deck, card.integer(at), card, held, across)
            elif card.text(at):
                held.setdefault(card.integer(1), []).append((_node(card, deck, at), components(card, at + 1)))
        deck.inventory.read["SPC"] += 1


def _add_lists(bulk: Bulk, deck: Deck, held: Held, across: Across) -> None:
    """Add the grid points of SPC1 cards, which list them."""
    existing = set(deck.labels.tolist()) | set(deck.scalar_points) if bulk.of("SPC1") else set()
    for card in bulk.of("SPC1"):
        words = [word for word in card.fields[3:] if word]
        labels = thru(card, words, existing)
        if any(word.upper() == "THRU" for word in words):  # Nastran lets THRU pass over points that do not exist
            labels = [n for n in labels if n in existing]
        for label in (n for n in labels if n in deck.scalar_points):
            _hold_point(deck, label, card, held, across)
        labels = [n for n in labels if n not in deck.scalar_points]
        for node in deck.numbers(labels, f"{card.where}, SPC1 {card.text(1)}"):
            held.setdefault(card.integer(1), []).append((int(node), components(card, 2)))
        deck.inventory.read["SPC1"] += 1


def _permanent(bulk: Bulk, deck: Deck, table) -> list[tuple[int, list[int]]]:
    """Return what GRID cards hold themselves, with the default of GRDSET: nodes and components."""
    if table is None:
        return []
    found = []
    for row in np.flatnonzero(~table.blank(7)):
        card = table.card(int(row))
        if card.text(7) != "0":
            found.append((_node(card, deck, 1), components(card, 7)))
    base = bulk.of("GRDSET")[:1]
    if base and base[0].text(7) not in ("", "0"):
        others = deck.numbers(table.integers(1)[table.blank(7)], "GRID cards")
        found += [(int(node), components(base[0], 7)) for node in np.unique(others)]
    return found


def _hold_point(deck: Deck, label: int, card: Card, held: Held, across: Across) -> None:
    """Hold a scalar point: the direction of a node, along a basic axis or across."""
    point, number = deck.scalar_points[label], card.integer(1)
    held.setdefault(number, [])
    if point is None:
        return
    if np.count_nonzero(point.row) > 1:
        across.setdefault(number, []).append((point.node, point.row))
    else:
        held[number].append((point.node, [point.free % 6]))


def add_references(bulk: Bulk, deck: Deck) -> None:
    """Offer ASET, BSET and CSET nodes as interfaces: "aset_17"."""
    existing = set(deck.labels.tolist()) if bulk.of("ASET1", "BSET1", "CSET1") else set()
    for name in ("ASET", "BSET", "CSET", "QSET", "OMIT"):
        for card in bulk.of(name):
            if name in ("ASET", "BSET", "CSET"):
                for at in range(1, len(card.fields), 2):
                    if card.text(at) and card.integer(at) not in deck.scalar_points:
                        _offer(deck, name, [card.integer(at)], card)
            deck.inventory.read[name] += 1
        for card in bulk.of(name + "1"):
            if name in ("ASET", "BSET", "CSET"):
                words = [word for word in card.fields[2:] if word]
                labels = thru(card, words, existing)
                if any(word.upper() == "THRU" for word in words):
                    labels = [n for n in labels if n in existing]
                labels = [n for n in labels if n not in deck.scalar_points]
                _offer(deck, name, labels, card)
            deck.inventory.read[name + "1"] += 1


def _offer(deck: Deck, name: str, labels: list[int], card: Card) -> None:
    for label, node in zip(labels, deck.numbers(labels, f"{card.where}, {card.name}"), strict=True):
        deck.references.setdefault(f"{name.lower()}_{label}", Reference(node=int(node)))
