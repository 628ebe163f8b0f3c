"""Nodes of a part by name, number or place, in the order in which lists of values belong to them."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.fem.fe_model import FEModel
from flexmb.model.described import entries_of, finite_array
from flexmb.reduction.selection import is_point, nodes_of, points_of

__all__ = ["check_near", "chosen_nodes", "components"]


def chosen_nodes(fe: FEModel, where: Any, title: str, *, single: bool = False) -> np.ndarray:
    """Return node numbers, ascending, of a set, of numbers or of coordinates; with `single` exactly one."""
    nodes = nodes_of(fe, where, title, moving=False)
    if single and len(nodes) != 1:
        raise ModelError(
            title,
            found=f"{len(nodes)} nodes in {where!r:.60}",
            expected="one node",
            remedy="Name a set of one node, or give its coordinates",
        )
    return nodes


def components(value: Any, count: int, title: str, field: str) -> np.ndarray:
    """Return (count, 3) from three components, each a number for all nodes or a list with one for each."""
    given = entries_of(value) if isinstance(value, list | tuple | np.ndarray) else ()
    columns = [finite_array(entry) for entry in given]
    if len(columns) != 3 or any(column.shape not in ((), (count,)) for column in columns):
        raise ModelError(
            f"{title}, {field}",
            found=f"{value!r:.100}",
            expected=f"three components, each a number or a list of {count}, one for each node",
            remedy=f"Write {field} = [0, 0, 1.5], or a list of {count} numbers for a component",
        )
    return np.column_stack([np.broadcast_to(column, (count,)) for column in columns])


def check_near(fe: FEModel, where: Any, title: str) -> None:
    """Raise ModelError if coordinates are further from the elements than the part is large: another unit, or frame.

    A station needs no node, and may be in a bore or on an arm, but then the part reaches around it or nearly to it.
    """
    if not is_point(where) or len(points_of(where)) != 1:
        return
    point = points_of(where)[0]
    distance = float(np.linalg.norm(fe.nodes - point, axis=1).min())
    size = float(np.linalg.norm(np.ptp(fe.nodes, axis=0)))
    if distance > size:
        raise ModelError(
            title,
            found=f"{point.tolist()} m, {distance:.4g} m away from the nearest node of a part of {size:.4g} m",
            expected="a place on the elements, or near them",
            remedy="Give coordinates in the axes of the part, in metres",
        )
