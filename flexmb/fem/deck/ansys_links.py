"""Links, springs, masses and supports of an Ansys archive: CE, CP, MPC184, MASS21, COMBIN14, D."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from flexmb.fem.deck.ansys_elements import Group
from flexmb.fem.deck.ansys_text import Archive, Command
from flexmb.fem.deck.contents import Deck, Lumped, Reference
from flexmb.fem.deck.links import Equation, Frames, LinkRows, follow, rows_of, solved_together
from flexmb.fem.deck.supports import keep_supports

__all__ = ["add_equations", "add_rigid", "add_springs_and_masses", "add_supports"]

FREEDOMS = {"UX": 0, "UY": 1, "UZ": 2, "ROTX": 3, "ROTY": 4, "ROTZ": 5}
OTHER = frozenset(("TEMP", "VOLT", "PRES", "WARP", "MAG", "HDSP", "VX", "VY", "VZ", "AX", "AY", "AZ"))


def add_springs_and_masses(groups: list[Group], deck: Deck, frames: Frames) -> None:
    """Add MASS21 and COMBIN14 with their real constants."""
    for group in groups:
        if group.family == "mass":
            _masses(group, deck, frames)
        elif group.family == "spring":
            _springs(group, deck, frames)


def _masses(group: Group, deck: Deck, frames: Frames) -> None:
    """MASS21: KEYOPT(3) = 0 three masses and three inertias, 2 one mass without inertia."""
    kind, r = group.options.get(3, 0), [*group.real, *[0.0] * 6]
    if group.options.get(1, 0) == 1 or kind not in (0, 2):
        raise group.refused(f"KEYOPT(1) = {group.options.get(1, 0)}, KEYOPT(3) = {kind}", "three-dimensional masses")
    values = np.array([r[0]] * 3 + [0.0] * 3 if kind == 2 else r[:6])
    if (values < 0.0).any() or not values.any():
        raise group.refused(f"the real constants {group.real}", "a mass above zero (R or RLBLOCK)")
    for node, label in zip(group.nodes[:, 0].tolist(), group.labels.tolist(), strict=True):
        turn = rows_of(node, range(6), frames if group.options.get(2, 0) == 1 else {})
        _lump(deck, "mass", (node,), turn.T @ np.diag(values) @ turn, f"MASS21 {label}")


def _springs(group: Group, deck: Deck, frames: Frames) -> None:
    """COMBIN14: along its line (KEYOPT(3) = 0), about it (1), or in one nodal direction (KEYOPT(2) = 1 .. 6)."""
    single, kind = group.options.get(2, 0), group.options.get(3, 0)
    if single not in range(7) or (single == 0 and kind not in (0, 1)):
        raise group.refused(f"KEYOPT(2) = {single}, KEYOPT(3) = {kind}", "a spring of three-dimensional models")
    values = [*group.real, 0.0, 0.0]
    for (a, b), label in zip(group.nodes[:, :2].tolist(), group.labels.tolist(), strict=True):
        if single:
            rows = [rows_of(node, [single - 1], frames)[0] for node in (a, b)]
        else:
            along = deck.points[b] - deck.points[a]
            size = float(np.linalg.norm(along))
            if not size > 0.0:
                raise group.refused(f"element {label} without length", "two places, or KEYOPT(2)")
            unit = np.zeros(6)
            unit[3 * kind : 3 * kind + 3] = along / size
            rows = [unit, unit]
        row = np.concatenate([-rows[0], rows[1]])
        for what, value in (("stiffness", values[0]), ("damping", values[1])):
            if value:
                _lump(deck, what, (a, b), value * np.outer(row, row), f"COMBIN14 {label}")


def _lump(deck: Deck, kind: str, nodes: tuple[int, ...], matrix: np.ndarray, name: str) -> None:
    deck.lumped_parts.append(Lumped(kind=kind, nodes=nodes, matrix=matrix, name=name))


def add_rigid(groups: list[Group], deck: Deck) -> None:
    """Add MPC184: rigid beams that hang together follow the node with most of them, rigid links keep their length."""
    beams = []
    for group in groups:
        if group.family != "rigid":
            continue
        kind = group.options.get(1, 0)
        if kind == 1:
            beams.append(group.nodes[:, :2])
        elif kind == 0:
            _rods(group, deck)
        else:
            deck.inventory.read[group.name] -= len(group.labels)
            deck.inventory.left_out[f"MPC184 with KEYOPT(1) = {kind}: joints"] += len(group.labels)
    if beams:
        _bodies(np.vstack(beams), deck)


def _bodies(pairs: np.ndarray, deck: Deck) -> None:
    used, local = np.unique(pairs, return_inverse=True)
    local = local.reshape(pairs.shape)
    graph = sparse.coo_matrix((np.ones(len(pairs)), (local[:, 0], local[:, 1])), shape=(len(used),) * 2)
    count, part = connected_components(graph, directed=False)
    degree = np.bincount(local.ravel(), minlength=len(used))
    for k in range(count):
        members = np.flatnonzero(part == k)
        reference = int(used[members[degree[members].argmax()]])
        name = f"mpc184_{int(deck.labels[reference])}"
        link = LinkRows(f"the rigid beams at node {int(deck.labels[reference])}")
        others = [int(node) for node in used[members] if node != reference]
        for node in others:
            follow(link, deck.points, {}, node, list(range(6)), reference, name)
        link.rigid = (reference, np.array(others, np.int64))
        deck.links.append(link)
        deck.references.setdefault(name, Reference(node=reference))


def _rods(group: Group, deck: Deck) -> None:
    for (a, b), label in zip(group.nodes[:, :2].tolist(), group.labels.tolist(), strict=True):
        along = deck.points[b] - deck.points[a]
        if not np.linalg.norm(along) > 0.0:
            raise group.refused(f"element {label} without length", "two nodes at different places")
        link = LinkRows(f"MPC184 {label}")
        columns = np.concatenate([6 * a + np.arange(3), 6 * b + np.arange(3)])
        link.add_equations(columns, np.concatenate([-along, along])[None, :], columns[3:], f"{group.part}, MPC184")
        deck.links.append(link)


def add_equations(archive: Archive, deck: Deck, frames: Frames) -> None:
    """Add CE (the first freedom follows the others, as CERIG and RBE3 write them) and CP (all follow the first)."""
    equations: dict[int, tuple[Command, list[tuple[str, str, str]]]] = {}
    every: list[Equation] = []
    current = 0
    for command in archive.commands:
        if command.name == "CE":
            current = _equation(command, equations, current, deck)
        elif command.name == "CP":
            every += _coupled(command, deck, frames)
    for number, (command, terms) in equations.items():
        every.append(_one_equation(number, command, terms, deck, frames))
        deck.inventory.read["CE"] += 1
    deck.links += solved_together(every)


def _equation(command: Command, equations: dict, current: int, deck: Deck) -> int:
    """Collect the terms of an equation: CE,R5.0,DEFI and CE,R5.0,NODE, or CE, number, constant, three terms."""
    form = command.text(1) if command.text(0).startswith("R") else ""
    if form == "DEFI":
        current = command.integer(3)
        equations[current] = (command, [])
        constant = command.real(4, 0.0)
    elif form == "NODE":
        constant = 0.0
        if current not in equations:
            raise command.wrong("terms before CE,R5.0,DEFI", "the definition first")
        equations[current][1].extend(_terms(command, 2))
    else:
        current = command.integer(0)
        constant = command.real(1, 0.0)
        equations.setdefault(current, (command, []))[1].extend(_terms(command, 2))
    if constant:
        deck.inventory.left_out["constants of constraint equations (CE)"] += 1
    return current


def _terms(command: Command, first: int) -> list[tuple[str, str, str]]:
    words = [command.text(k) for k in range(first, len(command.words))]
    return [(*words[k : k + 3],) for k in range(0, len(words) - 2, 3) if words[k] and words[k] != "0"]  # type: ignore[misc]


def _row(command: Command, word: str, label: str, deck: Deck, frames: Frames) -> tuple[np.ndarray, np.ndarray]:
    """Return the six freedoms of a node and the row of one of its nodal directions over them."""
    if label not in FREEDOMS:
        raise command.wrong(
            f"the freedom '{label}'", f"One of: {', '.join(FREEDOMS)}", "Remove the freedom: only structures are read"
        )
    if not word.lstrip("+").isdecimal():
        raise command.wrong(f"the node '{word}'", "a node number")
    node = int(deck.numbers([int(word)], f"{command.where}, {command.name}")[0])
    return 6 * node + np.arange(6), rows_of(node, [FREEDOMS[label]], frames)[0]


def _one_equation(number: int, command: Command, terms: list, deck: Deck, frames: Frames) -> Equation:
    rows = []
    for word, label, factor in terms:
        columns, row = _row(command, word, label, deck, frames)
        try:
            rows.append((columns, float(factor.replace("D", "E")) * row))
        except ValueError:
            raise command.wrong(f"the factor '{factor}' in equation {number}", "a number") from None
    if not rows or not any(row.any() for _, row in rows):
        raise command.wrong(f"equation {number} without terms", "two terms or more")
    first = next(columns[np.abs(row) > 0.0] for columns, row in rows if row.any())
    columns, factors = zip(*rows, strict=True)
    return Equation.of(f"CE {number}", f"{command.where}, CE {number}", columns, factors, first)


def _coupled(command: Command, deck: Deck, frames: Frames) -> list[Equation]:
    """Return the equations of CP, set, label, nodes: all nodes move alike in one nodal direction."""
    equations = []
    if not command.text(0).isdecimal():
        raise command.wrong(f"'{command.text(0)}'", "CP, set, label, nodes", "Write the couplings as CE (CPLGEN no)")
    label, words = command.text(1), [command.text(k) for k in range(2, len(command.words)) if command.text(k)]
    labels = [label] if label != "ALL" else list(FREEDOMS)
    words = [word for word in words if word != "0"]
    for name in labels:
        if name in OTHER:
            deck.inventory.unused[f"CP of {name}"] += 1
            continue
        first = [(words[0], name, "1.0")] if words else []
        for word in words[1:]:
            terms = [(word, name, "-1.0"), *first]
            equations.append(_one_equation(int(command.text(0)), command, terms, deck, frames))
    deck.inventory.read["CP"] += 1
    return equations


def add_supports(archive: Archive, deck: Deck, frames: Frames) -> None:
    """Keep the freedoms held by D as the support "d"."""
    held: dict[int, set[int]] = {}
    for command in archive.commands:
        if command.name != "D":
            continue
        word, label = command.text(0), command.text(1)
        names = [label, *(command.text(k) for k in range(6, 11) if command.text(k) in FREEDOMS)]
        if label not in FREEDOMS and label != "ALL":
            deck.inventory.unused[f"D of {label or '?'}"] += 1
            continue
        if not word.isdecimal():
            deck.inventory.left_out[f"D,{word}: supports of a selection"] += 1
            continue
        node = int(deck.numbers([int(word)], f"{command.where}, D")[0])
        parts = range(6) if label == "ALL" else [FREEDOMS[name] for name in names]
        held.setdefault(node, set()).update(parts)
        deck.inventory.read["D"] += 1
    if held:
        pairs = [(node, sorted(parts)) for node, parts in sorted(held.items())]
        keep_supports(deck, "d", pairs, frames)
