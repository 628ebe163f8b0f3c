"""Rigid surfaces that lie in each other where a motion begins."""

from __future__ import annotations

import numpy as np

from flexmb.errors import ModelError
from flexmb.integrate.nonsmooth.points import Touching
from flexmb.system.program import evaluate

__all__ = ["TOUCHING", "require_apart", "require_drawn_apart"]

TOUCHING = 1e-9
"""Distance, relative to the reach of the smallest surface, that counts as none."""
DEEP = 1e-4
"""Penetration, relative to the same, that is an error where a motion begins."""


def require_drawn_apart(system, state, step: float) -> None:
    """Raise ModelError where rigid surfaces overlap as they are drawn; `state` is assembled, at any time."""
    touching = Touching(system)
    if touching.forces:
        work = system.workspace()
        evaluate(system.program, state, work)
        require_apart(system, touching, work, step, 0.0)


def require_apart(system, touching: Touching, work, step: float, rebound: float) -> None:
    """Raise ModelError where surfaces overlap at the placed markers of `work`, unless they are about to strike.

    A run that goes on, after an event, at a sample time of a controller or when it is resumed, may stand within a
    rebound: what has struck comes out of its penetration, of `rebound` (m) at most, by itself.
    """
    for point in touching.found(work, 0.0, 0.0):
        a, b = work.markers[point["a"]], work.markers[point["b"]]
        v = [m["v"] + np.cross(m["w"], point["r"] - m["r"]) for m in (a, b)]
        closing = max(0.0, -float(point["axes"][0] @ (v[1] - v[0])))
        if -point["gap"] > max(rebound, DEEP * touching.small + step * closing):
            total = len(touching.place)
            i, j = divmod(int(point["key"]) - int(point["owner"]) * total**2, total)
            names = [touching.surfaces[k].name for k in (i, j)]
            raise ModelError(
                system.model.forces[point["owner"]].title,
                found=f"surfaces '{names[0]}' and '{names[1]}' overlap by {-point['gap']:.3g} m",
                expected=f"rigid surfaces apart, or touching to {DEEP * touching.small:.2g} m",
                remedy="Move one of the bodies, or use a compliant law",
            )
