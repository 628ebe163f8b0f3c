"""`moving_load`: the forces of a load that travels along a track of a reduced body."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.errors import ModelError, did_you_mean
from flexmb.forces.pressure import Pressure
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.model.signal import as_signal
from flexmb.model.table_signal import table

__all__ = ["moving_load"]

STEP = 1e-3
"""Part of the space between two nodes over which a load comes onto the track at its end."""


def moving_load(name: str, load: str, amount: Any, *, data: ModalNeutralData, along: Any) -> tuple[Pressure, ...]:
    """Return the forces of a load that stands `along` a track, m from its first node, at each time.

    Between two nodes it is shared like a lever. Off the ends of the track it is zero, and a run
    says so. Give them to the model:
    ``forces=[*fmb.moving_load("roller", "beam.rail", -2e3, data=data, along=fmb.ramp(rate=3.0))]``.

    Parameters
    ----------
    name : str
        The forces are called "roller 0", "roller 1", ...
    load : str
        "body.track": reduced with ``loads={"rail": reduction.Track(...)}``.
    amount : signal, N
    data : ModalNeutralData
        Of the body.
    along : signal or joint's name
        Distance from the first node, m: of time, or the slide of a joint.

    Raises
    ------
    ModelError
        The data have no such track.
    """
    track = load.partition(".")[2] if isinstance(load, str) else ""
    tracks = data.quality.get("tracks", {})
    if track not in tracks:
        raise ModelError(
            f"Moving load '{name}'",
            found=f"body data '{data.name}' have no track '{track}'",
            expected=f"'body.track' with one of: {', '.join(tracks)}" if tracks else "data with a track",
            remedy=did_you_mean(track, tracks) or 'Reduce with loads={"rail": reduction.Track("rail_nodes")}',
        )
    body, size = load.partition(".")[0], as_signal(amount, f"Moving load '{name}'", "amount")
    places = np.array(tracks[track]["places"])
    ends = STEP * np.diff(places)[[0, -1]]
    knots = np.concatenate([[places[0] - ends[0]], places, [places[-1] + ends[1]]])
    return tuple(
        Pressure(
            f"{name} {k}",
            load=f"{body}.{shape}",
            amount=size * table(knots[k : k + 3], [0.0, 1.0, 0.0], of=along, kind="linear"),
        )
        for k, shape in enumerate(tracks[track]["loads"])
    )
