"""Which nodes the user means: a named set, node numbers, or coordinates."""

from __future__ import annotations

import numpy as np

from flexmb.errors import ReductionError, did_you_mean
from flexmb.fem.fe_model import FEModel
from flexmb.model.described import whole

__all__ = ["is_point", "model_size", "nodes_of", "points_of", "require_place"]

_ON_NODE = 1e-6  # a coordinate names a node when it is this close, relative to the size of the model


def model_size(fe: FEModel) -> float:
    """Diagonal of the bounding box, m (1 for a single node)."""
    return float(np.linalg.norm(np.ptp(fe.nodes, axis=0))) or 1.0


def is_point(where) -> bool:
    """Tell whether `where` gives coordinates: a 3-tuple, or an array of floats (..., 3); integers name nodes."""
    if isinstance(where, str):
        return False
    if isinstance(where, tuple) and len(where) == 3 and all(np.isscalar(x) for x in where):
        return True
    array = _as_array(where)
    return array.dtype.kind == "f" and array.shape[-1:] == (3,)


def _as_array(where) -> np.ndarray:
    """Return a selection as an array, an empty one of objects if it has rows of different lengths."""
    try:
        return np.asarray(where)
    except ValueError:
        return np.empty(1, object)


def points_of(where) -> np.ndarray:
    """Return the coordinates of a point selection as (k, 3), m."""
    return np.atleast_2d(np.asarray(where, float))


def require_place(fe: FEModel, where, part: str) -> None:
    """Raise ReductionError where three whole numbers are three nodes, or most likely so: no place near the part.

    A tuple gives coordinates; where it is three nodes as well as a node's place, or far away, it may be mistaken.
    """
    whole = isinstance(where, tuple) and all(isinstance(x, int | np.integer) for x in where)
    if not whole or not all(0 <= x < len(fe.nodes) for x in where):
        return
    low, high, size = fe.nodes.min(axis=0), fe.nodes.max(axis=0), model_size(fe)
    away = not (np.all(low - size <= where) and np.all(where <= high + size))
    if not away and len(set(where)) < 3:
        return
    raise ReductionError(
        part,
        found=f"{where!r}, a place {size:.3g} m and more away from the part"
        if away
        else f"{where!r}, three nodes or a place",
        expected="coordinates in metres, or node numbers",
        remedy=f"Write {list(where)!r} for three nodes, or ({', '.join(f'{x}.0' for x in where)}) for the place",
    )


def nodes_of(fe: FEModel, where, part: str, *, moving: bool = True) -> np.ndarray:
    """Return sorted node numbers, (k,) int.

    Parameters
    ----------
    fe : FEModel
    where : str, list of str, int, list of int, 3-tuple of float, or (k, 3) float
        Name of a node or facet set or of supports, "node 63241" or "element 812" of a deck, several such names
        together, node numbers, or coordinates of nodes, m.
    part : str
        The thing that asks, for messages: ``"Interface 'a'"``.
    moving : bool
        Whether the nodes must have freedoms of their own; nodes that a link moves may be observed only.
    """
    if isinstance(where, str):
        nodes = _named(fe, where, part)
    elif isinstance(where, list | tuple) and where and all(isinstance(name, str) for name in where):
        nodes = np.concatenate([_named(fe, name, part) for name in where])
    elif is_point(where):
        require_place(fe, where, part)
        nodes = _located(fe, points_of(where), part, moving)
    else:
        nodes = _numbered(fe, whole(where), part)
    nodes = np.unique(nodes)
    if len(nodes) == 0:
        raise ReductionError(
            part,
            found=f"the selection {where!r} has no nodes",
            expected="at least one node",
            remedy="Check the group in the mesh: it may hold cells of another dimension only",
        )
    free = nodes[~np.isin(nodes, fe.dofs[:, 0])]
    if len(free) and moving:
        linked = fe.expansion is not None and fe.expansion[6 * free[0] : 6 * free[0] + 6].nnz > 0
        why = "a link makes them follow other nodes" if linked else "no element gives them stiffness"
        raise ReductionError(
            part,
            found=f"{len(free)} of its nodes have no independent freedoms ({why}), first {fe.node_name(free[0])}",
            expected="nodes of the FE model that move by themselves",
            remedy="Choose the node that the link hangs on; an interface may be at another place than its nodes, "
            "Rigid(where=..., at=(x, y, z))"
            if linked
            else "Choose nodes that belong to elements",
        )
    return nodes


def _named(fe: FEModel, name: str, part: str) -> np.ndarray:
    if name in fe.node_sets:
        return np.asarray(fe.node_sets[name], int)
    if name in fe.reference_points:
        return np.array([fe.reference_points[name].node])
    if name in fe.facet_sets:
        facets = np.asarray(fe.facet_sets[name], int).ravel()
        return facets[facets >= 0]  # rows of mixed sets end in -1
    if name in fe.supports:
        slanted = fe.slanted[name].indices // 6 if name in fe.slanted else []
        return np.union1d(fe.supports[name][:, 0], slanted).astype(int)
    if (found := fe.numbered(name, part, ReductionError)) is not None:
        return found
    known = sorted({*fe.node_sets, *fe.facet_sets, *fe.reference_points, *fe.supports})
    raise ReductionError(
        part,
        found=f"the group '{name}' does not exist in FE model '{fe.name}'",
        expected=f"One of: {', '.join(known) or 'none (the model has no groups)'}",
        remedy=did_you_mean(name, known)
        or "Name a group of the mesh, node numbers or coordinates"
        + (', or "node 63241" for a number of the deck' if fe.numbering is not None else ""),
    )


def _numbered(fe: FEModel, where, part: str) -> np.ndarray:
    numbers = np.atleast_1d(_as_array(where))
    if numbers.size == 0:
        return np.zeros(0, int)
    if numbers.dtype.kind not in "iu" or numbers.ndim != 1:
        raise ReductionError(
            part,
            found=f"{where!r}",
            expected="a set name, node numbers (int) or coordinates (x, y, z)",
            remedy="Give coordinates as a 3-tuple of numbers in m",
        )
    if numbers.shape == (3,) and len(set(numbers.tolist())) < 3:
        raise ReductionError(
            part,
            found=f"{where!r:.80}, three node numbers or a place",
            expected="node numbers, each once, or coordinates with a decimal point",
            remedy=f"Write {sorted(set(numbers.tolist()))} for nodes, or {tuple(numbers.astype(float).tolist())} for "
            "the place",
        )
    if numbers.min() < 0 or numbers.max() >= len(fe.nodes):
        raise ReductionError(
            part,
            found=f"node number {numbers.max() if numbers.min() >= 0 else numbers.min()}",
            expected=f"0 to {len(fe.nodes) - 1}",
            remedy="Node numbers are rows of fe.nodes, from zero"
            + (f'; write "node {numbers.max()}" for the deck number' if fe.numbering is not None else ""),
        )
    return numbers.astype(int)


def _located(fe: FEModel, points: np.ndarray, part: str, moving: bool) -> np.ndarray:
    """Return the node at each of the points (k, 3), m; of several at one place the only one that moves by itself."""
    from scipy.spatial import cKDTree

    tree = cKDTree(fe.nodes)
    distance, nearest = tree.query(points)
    worst = int(np.argmax(distance))
    if distance[worst] > _ON_NODE * model_size(fe):
        at = ", ".join(f"{x:.6g}" for x in fe.nodes[nearest[worst]])
        raise ReductionError(
            part,
            found=f"no node at {tuple(float(x) for x in points[worst])} m; the nearest is node "
            f"{nearest[worst]} at ({at}), {distance[worst]:.3g} m away",
            expected="a node there",
            remedy="Give the node's coordinates, or observe the point as a station (it needs no node)",
        )
    for k, near in enumerate(tree.query_ball_point(points, _ON_NODE * model_size(fe))):
        several = sorted(near)
        if moving and len(several) > 1:
            several = [n for n in several if n in fe.dofs[:, 0]] or several
            nearest[k] = several[0]
        if len(several) > 1:
            raise ReductionError(
                part,
                found=f"{len(several)} nodes at {tuple(points[k].tolist())} m: "
                f"{', '.join(map(fe.node_name, several[:6]))}",
                expected="one node there",
                remedy=f"Write their numbers, {several[:6]}, or those of them that are meant",
            )
    return nearest
