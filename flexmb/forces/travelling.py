"""Where a load that travels over a track stands in a run: what `moving_load` has made is recognised by its tables."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.constraints import joint_coordinate
from flexmb.model.input_signal import inputs_of
from flexmb.model.measurement import Measurement
from flexmb.model.signal import Product, Signal
from flexmb.model.table_signal import Table

__all__ = ["Travelling", "travelling"]

ONE_NODE = (0.0, 1.0, 0.0)
"""Share of a travelling load that a node of its track takes: before the node, at it, and behind."""


@dataclass(frozen=True, eq=False)
class Travelling:
    """One of the forces of a load that travels: the share of one node.

    Parameters
    ----------
    load, track : str
        "roller", "beam.rail".
    begins, at, ends : float, m
        Along the track: from where to where this node takes a share, and where it lies.
    given : bool
        Is the place a function of time alone?
    places : callable (series) -> (nt,), m, or None
        Where the load stands along the track at each sample; None where nothing but the run itself can tell.
    """

    load: str
    track: str
    begins: float
    at: float
    ends: float
    given: bool
    places: Callable[[Any], np.ndarray] | None


def travelling(force: Any, model: Any) -> Travelling | None:
    """Return where the load of which a `Pressure` is the share of one node travels; None if it is no such share."""
    body, _, shape = force.load.partition(".")
    data = getattr(model.body(body), "reduced", None)
    tracks = {} if data is None else data.quality.get("tracks", {})
    track = next((name for name, one in tracks.items() if shape in one["loads"]), None)
    terms = force.amount.terms if isinstance(force.amount, Product) else (force.amount,)
    share = next((one for one in terms if isinstance(one, Table) and one.of is not None and one.y == ONE_NODE), None)
    if track is None or share is None:
        return None
    places, load = (
        _places(force, share.of if share.joint is None else share.joint, model),
        force.name.rpartition(" ")[0],
    )
    given = share.joint is None and not share.of.follows and not inputs_of(share.of)
    begins, at, ends = share.x
    return Travelling(load or force.name, f"{body}.{track}", begins, at, ends, given, places)


def _places(force: Any, of: Any, model: Any) -> Callable[[Any], np.ndarray] | None:
    """Return what reads the place along a track, a signal or a joint's slide, from a series."""
    if isinstance(of, str):
        joint = model.joint(of, force.title)
        coordinate = joint_coordinate(joint, force.title, force.freedom)
        if coordinate.kind != "slide":  # a turn counts its rounds while it runs
            return None
        axis, names = "xyz".index(coordinate.axis), tuple(joint.markers)

        def slid(series: Any) -> np.ndarray:
            a, b = (series.marker(name) for name in names)
            return np.einsum("ti,ti->t", a.R[:, :, axis], b.r - a.r)

        return slid
    if isinstance(of, Measurement) and not of.rate:
        sensor = of.of if not isinstance(of.of, str) else next((s for s in model.sensors if s.name == of.of), None)
        return None if sensor is None else lambda series: _column(sensor.values(series), of.column)
    if not isinstance(of, Signal) or of.follows or inputs_of(of):
        return None
    return lambda series: of.sample(series.t)[:, 0]


def _column(values: Any, column: int) -> np.ndarray:
    values = np.asarray(values, float)
    return values if values.ndim == 1 else values[:, column]
