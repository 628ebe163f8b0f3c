"""Where on a reduced body: nodes by the name of a set, by their number in the deck or the data, or by their place."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.errors import ModelError, did_you_mean
from flexmb.model.described import is_number, whole
from flexmb.model.modal_arrays import ModalArrays
from flexmb.model.numbering import named_numbers

__all__ = ["nodes_named", "place_of"]

MANY = 12
NEAR = 1e-6
"""Distance from a node up to which coordinates name it, relative to the largest extent of the body."""


def place_of(where: Any) -> tuple[float, float, float] | None:
    """Return the coordinates that are meant: three numbers of which one is no whole number by its type; else None."""
    given = where.tolist() if isinstance(where, np.ndarray) and where.shape == (3,) else where
    if not isinstance(given, list | tuple) or len(given) != 3 or not all(is_number(x) for x in given):
        return None
    if not any(isinstance(x, float | np.floating) for x in given):
        return None
    return float(given[0]), float(given[1]), float(given[2])


def nodes_named(data: ModalArrays, where: Any, part: str) -> np.ndarray:
    """Return the node numbers (k,) of a set name, "node 63241", "element 812", a number, coordinates (3,) of a node, m,
    of which one has a decimal point, or a sequence of these.
    """
    if isinstance(where, str):
        return _of_text(data, where, part)
    if (place := place_of(where)) is not None:
        return _at(data, np.array(place), part)
    if isinstance(where, list | tuple) and any(isinstance(one, str) or place_of(one) is not None for one in where):
        return np.unique(np.concatenate([nodes_named(data, one, part) for one in where]))
    try:
        nodes = np.atleast_1d(np.asarray(whole(where)))
    except ValueError:  # rows of different lengths
        nodes = np.empty((1, 1))
    n = len(data.nodes)
    if nodes.ndim != 1 or (nodes.size and (nodes.dtype.kind not in "iu" or nodes.min() < 0 or nodes.max() >= n)):
        raise ModelError(
            part,
            found=f"node = {where!r}",
            expected=f"node numbers 0 to {n - 1}, the name of a set, a number of the deck, or the place of a node, m",
            remedy='Write node="node 63241" for the deck number, or (0.2, 0.0, 0.005) for the node there',
        )
    if isinstance(where, list | tuple) and len(nodes) == 3 and len(set(nodes.tolist())) < 3:
        raise ModelError(
            part,
            found=f"node = {where!r}, three node numbers or a place",
            expected="node numbers, each once, or coordinates with a decimal point",
            remedy=f"Write {tuple(map(float, nodes))} for the place",
        )
    return nodes if nodes.size else nodes.astype(int)


def _at(data: ModalArrays, point: np.ndarray, part: str) -> np.ndarray:
    """Return the nodes at a point (3,), m: one, or those that lie on one another there."""
    distance = np.linalg.norm(data.nodes - point, axis=1)
    near = np.flatnonzero(distance <= NEAR * float(np.ptp(data.nodes, axis=0).max(initial=0.0)))
    if len(near):
        return near
    nearest = int(np.argmin(distance)) if len(distance) else -1
    there = ", ".join(f"{x:.9g}" for x in data.nodes[nearest]) if nearest >= 0 else ""
    raise ModelError(
        part,
        found=f"no node at ({', '.join(f'{x:.6g}' for x in point)}) m"
        + (f"; the nearest is {distance[nearest]:.3g} m away, at ({there})" if there else ""),
        expected="the place of a node, in the axes of the mesh",
        remedy=f"Write node = {nearest} for that one" if there else "Reduce a body with nodes",
    )


def _of_text(data: ModalArrays, text: str, part: str) -> np.ndarray:
    if text in data.node_sets:
        return np.asarray(data.node_sets[text], int)
    if named_numbers(text) and data.numbering is not None:
        return data.numbering.nodes_of(text, tuple(cells for _, cells in data.cells), part)
    known = sorted(data.node_sets)
    listed = ", ".join(known[:MANY]) + (f" and {len(known) - MANY} more" if len(known) > MANY else "")
    numbers = 'or "node 63241", "element 812" of the deck' if data.numbering is not None else "or node numbers"
    raise ModelError(
        part,
        found=f"'{text}', which is no set of '{data.name}'",
        expected=f"One of: {listed or 'none (the body has no sets)'}, {numbers}",
        remedy=did_you_mean(text, known) or "Data reduced by earlier releases have no sets: reduce the part again",
    )
