"""Where on a reduced body: nodes by the name of a set, by their number in the deck, or by their number in the data."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.errors import ModelError, did_you_mean
from flexmb.model.described import whole
from flexmb.model.modal_arrays import ModalArrays
from flexmb.model.numbering import named_numbers

__all__ = ["nodes_named"]

MANY = 12


def nodes_named(data: ModalArrays, where: Any, part: str) -> np.ndarray:
    """Return the node numbers (k,) of a set name, "node 63241", "element 812", a number, or a sequence of these."""
    if isinstance(where, str):
        return _of_text(data, where, part)
    if isinstance(where, list | tuple) and any(isinstance(one, str) for one in where):
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
            expected=f"node numbers 0 to {n - 1}, the name of a set, or a number of the deck",
            remedy='Write node="node 63241" for the deck number, or take the argmin of the distance in data.nodes',
        )
    return nodes if nodes.size else nodes.astype(int)


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
