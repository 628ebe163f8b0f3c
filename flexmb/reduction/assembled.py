"""`assembled`: reduced parts, joined to one model that is reduced again (second level)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg import block_diag, null_space, qr

from flexmb.errors import ReductionError, did_you_mean
from flexmb.fem.beside import beside
from flexmb.fem.fe_model import Condensed, FEModel
from flexmb.model.described import check_kind
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.reduction.interfaces import Coupling
from flexmb.reduction.part_errors import error_of_part
from flexmb.reduction.snapshots import snapshots_of

__all__ = ["assembled", "check_within"]

APART = 1e-6
"""How far joined interfaces may lie apart, relative to the size of the whole."""
INDEPENDENT = 1e-8
"""Smallest singular value, relative to the largest, of interface motions that are independent."""
SMALL, RIGHT = 0.05, 0.01
"""Bound of a part's response and error of its frequencies that say its basis holds."""
BELOW = 0.5
"""Share of the first frequency that a part does not have up to which it holds."""
ALIKE = 1e-3
"""Relative difference of masses and stiffnesses from which on data belong to other elements."""


def assembled(
    parts: Mapping[str, tuple[FEModel, ModalNeutralData]],
    fixed: Sequence[tuple[str, str]] = (),
    name: str = "assembly",
) -> FEModel:
    """Return reduced parts as one FE model of few freedoms: `reduce` makes a reduced body of it like of any other.

    No matrix of the whole mesh is factorised. The freedoms are the motions of all interfaces of the parts, and as many
    of the parts' nodes as they have coordinates beyond these. All else of the parts follows: fields, stress, named sets
    and elements ("left.skin"), inertia and geometric stiffness are those of the whole mesh on the displacements that
    the parts have. So the error comes from the parts' bases.

    Parameters
    ----------
    parts : mapping of name to (FEModel, ModalNeutralData)
        Elements, drawn where they are in the whole, and what `reduce` made of them. Interfaces are rigid or averaging.
        A part may be an assembly itself, with what `reduce` made of it: a third level, and so on.
    fixed : pairs of "part.interface"
        That move together; they are at the same place. Springs come after: ``fem.with_spring(fe, "left.b",
        stiffness, to="right.a")``.

    Returns
    -------
    FEModel
        With a node and a node set for each interface, "left.a": ``reduce(fe, {"a": "left.a"}, 10)``.

    Raises
    ------
    ReductionError
        Unknown or distant interfaces, data of other elements or with a preload, a basis whose interfaces cannot move
        independently.
    """
    _check(parts)
    pieces = {key: _piece(key, fe, data) for key, (fe, data) in parts.items()}
    places = np.vstack([piece.positions for piece in pieces.values()])
    whole, starts = beside({key: _elements(fe) for key, (fe, _) in parts.items()}, places, name)
    node = _reference_nodes(parts, pieces, fixed, whole)
    dofs, columns = _freedoms(pieces, node, starts, whole)
    K, M, C = (np.zeros((len(dofs), len(dofs))) for _ in range(3))
    fields, expansion = [], np.zeros((6 * len(whole.nodes), len(dofs)))
    for key, piece in pieces.items():
        at = columns[key]
        own = np.zeros((len(piece.fields), len(dofs)))
        own[:, at] = piece.fields
        fields.append(own)
        K[np.ix_(at, at)] += piece.K
        M[np.ix_(at, at)] += piece.M
        C[np.ix_(at, at)] += piece.C
    stacked_fields = np.vstack(fields)
    expansion[:] = whole.field(stacked_fields).reshape(expansion.shape)
    held = sorted(set(node.values()))
    for number in held:
        mine = np.flatnonzero(dofs[:, 0] == number)
        expansion[6 * number + dofs[mine, 1], mine] = 1.0
    for key, piece in pieces.items():  # places that parts of parts were joined at have no freedoms any more
        rows = 6 * (starts[key][0] + piece.places)[:, None] + np.arange(6)
        expansion[np.ix_(rows.ravel(), columns[key])] = piece.motions
        held += (starts[key][0] + piece.places).tolist()
    couplings = tuple(one for key, piece in pieces.items() for one in _within(key, piece, starts[key], node))
    return replace(
        whole,
        dofs=dofs,
        K=sparse.csr_matrix(0.5 * (K + K.T)),
        M=sparse.csr_matrix(0.5 * (M + M.T)),
        C=sparse.csr_matrix(C) if C.any() else None,
        expansion=sparse.csr_matrix(expansion),
        node_sets={**whole.node_sets, **{key: np.array([number]) for key, number in node.items()}},
        condensed=Condensed(
            whole,
            stacked_fields,
            couplings,
            np.array(held),
            {key: _reach(*part) for key, part in parts.items()},
            tuple(
                error_of_part(parts[key][1].quality, dofs[columns[key]], piece.K, piece.M)
                for key, piece in pieces.items()
            ),
        ),
    )


@dataclass(frozen=True, eq=False)
class _Piece:
    """A part in the motions of its interfaces and of some nodes.

    fields : (ndof of its elements, n), the motions first, six of each interface
    rows : freedoms of its elements that are coordinates
    couplings : its interfaces that hold several nodes
    places, motions : nodes at which parts of it are joined, and their motions (6 k, n)
    within : where its parts are held there, and the node with their motion
    """

    names: tuple[str, ...]
    positions: np.ndarray
    fields: np.ndarray
    rows: np.ndarray
    K: np.ndarray
    M: np.ndarray
    C: np.ndarray
    couplings: tuple[Coupling, ...]
    places: np.ndarray
    motions: np.ndarray
    within: tuple[tuple[Coupling, int], ...]


def _reach(fe: FEModel, data: ModalNeutralData) -> float | None:
    """Return the frequency, Hz, up to which the basis of a part holds, as far as its report tells.

    The band of its bound, if this is small; else up to where its free-free frequencies are right.
    """
    quality, own = data.quality, None
    rows = quality.get("frequencies", [])
    if "transfer" in quality and quality["transfer"]["relative"] <= SMALL:
        own = quality["transfer"]["frequencies"][-1]
    elif rows:
        wrong = [row["full"] for row in rows if row["error"] > RIGHT]
        kept = quality["fixed_interface_frequencies"][-1:]
        own = BELOW * wrong[0] if wrong else max(rows[-1]["full"], *(BELOW * f for f in kept), 0.0)
    elif quality.get("basis") == "CraigBampton()":
        own = BELOW * max(quality["fixed_interface_frequencies"], default=0.0)
    inner = [] if fe.condensed is None else [own, *fe.condensed.reach.values()]
    known = [one for one in inner if one is not None]
    return min(known) if known else own


def _elements(fe: FEModel) -> FEModel:
    """Return a part with the freedoms of all its elements; those of an assembly stand behind it."""
    return fe if fe.condensed is None else replace(fe.condensed.whole, node_sets=fe.node_sets)


def _piece(key: str, fe: FEModel, data: ModalNeutralData) -> _Piece:
    """Return a part in its own coordinates: six rigid motions and the shapes, changed to motions of places."""
    m, n, own = data.n_modes, data.n_interfaces, _elements(fe)
    known = _motions(own, data)
    motions = np.zeros((n, 6, 6 + m))
    for k, place in enumerate(data.marker_positions[:n]):
        motions[k, :3, :3] = motions[k, 3:, 3:6] = np.eye(3)
        motions[k, :3, 3:6] = [[0.0, place[2], -place[1]], [-place[2], 0.0, place[0]], [place[1], -place[0], 0.0]]
    motions[:, :3, 6:], motions[:, 3:, 6:] = data.marker_translations[:n], data.marker_rotations[:n]
    scale = 1.0 / np.maximum(np.abs(known).max(axis=0), 1e-300)
    read = motions.reshape(6 * n, -1)
    rank = np.linalg.matrix_rank(read * scale, tol=INDEPENDENT * np.linalg.norm(read * scale, 2)) if n else 0
    if rank < 6 * n:
        raise ReductionError(
            f"Part '{key}'",
            found=f"{6 * n} motions of its interfaces, of which {rank} are independent in its basis",
            expected="interfaces that move independently: parts are joined there",
            remedy="Reduce the part with CraigBampton(), whose interfaces do",
        )
    _check_alike(key, fe, data, _motions(fe, data))
    rest = (known * scale) @ null_space(read * scale)
    rows = np.sort(qr(rest.T, mode="r", pivoting=True)[1][: 6 + m - 6 * n]) if rest.shape[1] else np.zeros(0, int)
    change = np.linalg.inv(np.vstack([read, known[rows]]) * scale) * scale[:, None]
    fields = known @ change
    w = 2.0 * np.pi * data.frequencies
    damping = block_diag(np.zeros((6, 6)), np.diag(2.0 * data.damping_ratios * w))
    couplings = _held(own, data)
    places, at_places, within = _joined_before(fe, data, couplings)
    return _Piece(
        data.marker_names[:n],
        data.marker_positions[:n],
        fields,
        rows,
        change.T @ block_diag(np.zeros((6, 6)), data.stiffness) @ change,
        fields.T @ (own.M @ fields),
        change.T @ damping @ change,
        couplings,
        places,
        at_places @ change,
        within,
    )


def _motions(fe: FEModel, data: ModalNeutralData) -> np.ndarray:
    """Return six rigid motions and the shapes of a body in the freedoms of an FE model, (ndof, 6 + m)."""
    rigid = fe.rigid_motions()
    return np.hstack([rigid, snapshots_of(fe, data, np.eye(data.n_modes))]) if data.n_modes else rigid


def _joined_before(fe: FEModel, data: ModalNeutralData, couplings: Sequence[Coupling]):
    """Return the nodes at which parts of an assembly are joined, their motions (6 k, 6 + m), and where parts are held.

    What an interface of the assembly holds now, with all its nodes, is one of its own couplings.
    """
    if fe.condensed is None:
        return np.zeros(0, int), np.zeros((0, 6 + data.n_modes)), ()
    places = fe.condensed.places
    motions = np.zeros((len(places), 6, 6 + data.n_modes))
    motions[:, :3, :3] = motions[:, 3:, 3:6] = np.eye(3)
    motions[:, :3, 3:6] = np.cross(np.eye(3)[None], fe.nodes[places][:, None]).transpose(0, 2, 1)
    motions[:, :3, 6:] = data.shapes[places]
    if data.rotation_shapes is not None:
        motions[:, 3:, 6:] = data.rotation_shapes[places]
    within = tuple(
        (coupling, number)
        for coupling, number in fe.condensed.couplings
        if not any(np.isin(coupling.nodes, outer.nodes).all() for outer in couplings)
    )
    return places, motions.reshape(6 * len(places), -1), within


def _check_alike(key: str, fe: FEModel, data: ModalNeutralData, known: np.ndarray) -> None:
    """Refuse data that do not belong to the elements: rescaled, or of another material; known (ndof, 6 + m)."""
    shapes = known[:, 6:]
    pairs = {
        "mass": (known[:, :3], fe.M, np.diag(data.invariants.vv)),
        "modal mass": (shapes, fe.M, np.diag(data.invariants.nn)),
        "modal stiffness": (shapes, fe.K, np.diag(data.stiffness)),
    }
    for what, (columns, matrix, stored) in pairs.items():
        own = np.einsum("ij,ij->j", columns, matrix @ columns)
        apart = np.abs(own - stored) - ALIKE * (np.abs(stored) + 1e-6 * np.abs(stored).max(initial=0.0))
        if np.any(apart > 0.0):
            k = int(apart.argmax())
            raise ReductionError(
                f"Part '{key}'",
                found=f"a {what} of {own[k]:.6g} of its elements, of {stored[k]:.6g} in its data",
                expected="the data that reduce made of these elements",
                remedy="Reduce the part once more as it is",
            )


def _held(fe: FEModel, data: ModalNeutralData) -> tuple[Coupling, ...]:
    """Return the interfaces of a part that hold several nodes, whose forces stiffen it where they turn with them.

    They are found from the shapes: nodes of a rigid interface follow its marker in every one of them.
    """
    found = []
    field = np.concatenate([data.shapes, np.zeros_like(data.shapes)], axis=1)
    size = max(float(np.abs(field).max(initial=0.0)), 1e-300)
    moved = np.unique(fe.dofs[:, 0])
    for k in range(data.n_interfaces):
        at = data.marker_positions[k]
        arm = data.nodes - at
        turned = np.cross(data.marker_rotations[k].T[:, None, :], arm[None]).transpose(1, 2, 0)
        follows = np.abs(data.shapes - data.marker_translations[k] - turned).max(axis=(1, 2), initial=0.0) < 1e-9 * size
        nodes = np.intersect1d(np.flatnonzero(follows), moved)
        if data.n_modes and len(nodes) > 1:
            rows = np.flatnonzero(np.isin(fe.dofs[:, 0], nodes))
            found.append(Coupling(data.marker_names[k], at, nodes, rows, np.zeros((len(rows), 0)), np.zeros(0, int)))
    return tuple(found)


def _within(key: str, piece: _Piece, start: tuple[int, int], node: dict[str, int]) -> list[tuple[Coupling, int]]:
    """Return the interfaces of a part that hold several nodes, in numbers of the whole, and their reference nodes."""
    own = [(c, node[f"{key}.{c.name}"]) for c in piece.couplings]
    inner = [(replace(c, name=f"{key}.{c.name}"), start[0] + number) for c, number in piece.within]
    return [(replace(c, nodes=c.nodes + start[0], rows=c.rows + start[1]), number) for c, number in own + inner]


def _reference_nodes(parts, pieces: dict[str, _Piece], fixed, whole: FEModel) -> dict[str, int]:
    """Return the node of every interface "part.interface"; those that are fixed to each other have the same one."""
    node, first = {}, len(whole.nodes) - sum(len(piece.names) for piece in pieces.values())
    for key, piece in pieces.items():
        for label in piece.names:
            node[f"{key}.{label}"] = first
            first += 1
    size = float(np.linalg.norm(np.ptp(whole.nodes, axis=0)))
    for pair in fixed:
        a, b = (_known(word, node, "Fixed interfaces") for word in pair)
        apart = float(np.linalg.norm(whole.nodes[node[a]] - whole.nodes[node[b]]))
        if apart > APART * size or node[a] == node[b]:
            raise ReductionError(
                f"Fixed interfaces '{a}' and '{b}'",
                found="they are fixed to each other already" if node[a] == node[b] else f"{apart:.3g} m between them",
                expected="two interfaces at the same place",
                remedy="Draw the parts where they are in the whole, or join them by fem.with_spring",
            )
        node |= dict.fromkeys([word for word, number in node.items() if number == node[b]], node[a])
    return node


def _known(word: Any, node: Mapping[str, int], title: str) -> str:
    if word not in node:
        raise ReductionError(
            title,
            found=f"no interface {word!r}",
            expected=f"'part.interface', one of: {', '.join(node)}",
            remedy=did_you_mean(str(word), node) or "Name an interface of a part",
        )
    return word


def _freedoms(pieces: dict[str, _Piece], node: dict[str, int], starts, whole: FEModel):
    """Return the freedoms (n, 2) of the model, and which of them are the coordinates of each part."""
    dofs: list[tuple[int, int]] = []
    place: dict[tuple[int, int], int] = {}
    columns = {}
    for key, piece in pieces.items():
        own = [(node[f"{key}.{label}"], k) for label in piece.names for k in range(6)]
        own += [tuple(whole.dofs[starts[key][1] + row].tolist()) for row in piece.rows]
        for freedom in own:
            if freedom not in place:
                place[freedom] = len(dofs)
                dofs.append(freedom)
        columns[key] = np.array([place[freedom] for freedom in own])
    return np.array(dofs), columns


def _check(parts: Any) -> None:
    if not isinstance(parts, Mapping) or not parts:
        raise ReductionError(
            "Assembly",
            found=f"parts = {type(parts).__name__}",
            expected="a mapping of names to (FEModel, ModalNeutralData)",
            remedy="Write assembled({'left': (fe, data), 'right': (other, its_data)}, fixed=[('left.b', 'right.a')])",
        )
    for key, given in parts.items():
        pair = tuple(given) if isinstance(given, tuple | list) else (given,)
        if len(pair) != 2:
            raise ReductionError(
                f"Part '{key}'",
                found=f"{type(given).__name__}",
                expected="(FEModel, ModalNeutralData)",
                remedy="Give the elements and what reduce made of them",
            )
        check_kind(pair[0], FEModel, f"Part '{key}'", "Give the FE model first", ReductionError)
        check_kind(pair[1], ModalNeutralData, f"Part '{key}'", "Make it with reduction.reduce", ReductionError)
        preloaded = pair[1].geometric is not None and bool(np.any(pair[1].geometric.preload))
        if preloaded:
            raise ReductionError(
                f"Part '{key}'",
                found="data with a preload, whose stiffness would be lost",
                expected="finite elements, and what reduce made of them without a preload",
                remedy="Give the preload to the reduction of the whole",
            )


def check_within(condensed: Condensed, names: Sequence[str], forces: np.ndarray) -> None:
    """Refuse loads (ndof of the whole, nl) on nodes of an inner coupling: how they stiffen it is not known there."""
    for coupling, _ in condensed.couplings:
        loaded = np.flatnonzero(forces[coupling.rows].any(axis=0))
        if len(loaded):
            raise ReductionError(
                f"Load '{names[loaded[0]]}'",
                found=f"forces on nodes of the interface '{coupling.name}' of a part",
                expected="loads beside the interfaces, where geometric stiffness is wanted",
                remedy="Load other nodes, or act on the interface itself",
            )
