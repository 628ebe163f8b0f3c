"""`line_network`: cables or beams along the lines of a mesh, joined where the lines meet."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from flexmb.bodies import AncfBeam, AncfCable
from flexmb.bodies.line.chains import line_chains
from flexmb.errors import ModelError
from flexmb.joints import Fixed, Spherical
from flexmb.model.kinds import Body, Joint

__all__ = ["LineNetwork", "line_network"]


class LineNetwork(NamedTuple):
    """What `line_network` makes; put bodies and joints into a model.

    bodies : one for every chain of lines. joints : where chains meet. markers : "body.marker" of the named nodes of the
    mesh.
    """

    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    markers: Mapping[str, str]


def line_network(
    kind: type,
    name: str,
    mesh: Any,
    *,
    size: float | None = None,
    corner: float = 0.5,
    joint: type | None = None,
    **fields: Any,
) -> LineNetwork:
    """Return cables or beams along all line cells of a mesh, from branch to branch and from corner to corner.

    Each chain of lines is a body, a spline through its nodes; where chains meet, all are joined to the first of them.
    A ring of cables is one closed body, a ring of beams two halves.

    Parameters
    ----------
    kind : AncfCable or AncfBeam
    name : str
        Of the body; several are numbered: ``name_1``, ``name_2``, ...
    mesh : fem.Mesh
        ``fem.read_mesh("frame.msh")``, or ``.only("group")`` of one with other cells.
    size : float, m, optional
        Length of the elements; by default the mean length of the lines.
    corner : float, rad
        A chain ends where its direction turns by more.
    joint : type, optional
        Fixed for beams, Spherical for cables, unless given.
    fields
        Of the bodies: section, material, orientation, damping, ...

    Returns
    -------
    LineNetwork
        With a marker for every set of the mesh that is one node.

    Raises
    ------
    ModelError
        If there are no lines, lines of no length, or double lines.
    """
    title = f"line_network '{name}'"
    if kind not in (AncfCable, AncfBeam):
        raise ModelError(
            title,
            found=f"kind = {kind!r}",
            expected="AncfCable or AncfBeam",
            remedy="Write line_network(flexmb.AncfBeam, 'frame', mesh, section=..., material=...)",
        )
    points, lines = np.asarray(mesh.points, float), mesh.cells_of("line")
    chains = line_chains(points, lines, corner, title)
    if kind is AncfBeam:
        chains = [part for chain in chains for part in _halves(chain)]
    if size is None:
        size = float(np.mean(np.linalg.norm(points[lines[:, 1]] - points[lines[:, 0]], axis=1)))
    named = {int(nodes[0]): label for label, nodes in mesh.node_sets.items() if len(nodes) == 1}
    names = [name] if len(chains) == 1 else [f"{name}_{k + 1}" for k in range(len(chains))]
    bodies, markers = [], {}
    for own, chain in zip(names, chains, strict=True):
        marked = {label: chain.index(node) for node, label in named.items() if node in chain}
        body = _body(kind, own, points[chain], size, fields, marked)
        bodies.append(body)
        first = [label for label in body.markers if label in mesh.node_sets and label not in markers]
        markers.update({label: f"{own}.{label}" for label in first})
    joint = joint or (Fixed if kind is AncfBeam else Spherical)
    return LineNetwork(tuple(bodies), tuple(_joints(joint, name, names, chains)), markers)


def _halves(chain: list[int]) -> list[list[int]]:
    """Return a ring as two halves, and any other chain as it is."""
    middle = len(chain) // 2
    return [chain[: middle + 1], chain[middle:]] if chain[0] == chain[-1] else [chain]


def _body(kind, name, points, size, fields, places):
    """Return one body with markers in the axes of W at its ends, and at the named nodes of its chain."""
    ring = bool(np.allclose(points[0], points[-1], rtol=0.0, atol=0.0))
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    elements = max(3 if ring else 1, round(length[-1] / size))
    closed = {"closed": True} if ring else {}
    own = {**fields, **closed, "points": points[:-1] if ring else points, "elements": elements}
    at = {
        "first": 0.0,
        "last": 1.0,
        **{label: _fraction(kind(name, **own), points, length, k) for label, k in places.items()},
    }
    axes = kind(name, **own, markers=at).marker_poses()
    return kind(name, **own, markers={label: (fraction, axes[label].matrix.T) for label, fraction in at.items()})


def _fraction(body, points, length, k: int) -> float:
    """Return the fraction of the body's length nearest to point k; the spline is a little longer than the lines."""
    from scipy.optimize import minimize_scalar

    if k in (0, len(points) - 1):
        return 0.0 if k == 0 else 1.0
    near = length[[k - 1, k + 1]] / length[-1]
    q = body.initial_state()[0]
    return float(
        minimize_scalar(
            lambda x: np.sum((body.section_axes(q, [x])[0][0] - points[k]) ** 2),
            bounds=near,
            method="bounded",
            options={"xatol": 1e-10},
        ).x
    )


def _joints(joint, name, names, chains):
    """Yield joints of all chains that meet at a node to the first of them."""
    hub: dict[int, str] = {}
    for own, chain in zip(names, chains, strict=True):
        if chain[0] == chain[-1]:
            continue
        for node, marker in ((chain[0], "first"), (chain[-1], "last")):
            if node in hub:
                yield joint(f"{name}_node_{node}_{own}", markers=(hub[node], f"{own}.{marker}"))
            else:
                hub[node] = f"{own}.{marker}"
