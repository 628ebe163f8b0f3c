"""A cantilever of `AncfBeam` elements under a dead load at its tip."""

from __future__ import annotations

import numpy as np

import flexmb as fmb


def loaded_tip(body, force):
    """Return the displacement (3,), m, of the tip and the solution; the body "b" is clamped at its start."""
    clamp = next(iter(body.marker_poses().values()))
    solution = fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(markers={"clamp": clamp}), body),
            gravity=(0, 0, 0),
            joints=(fmb.Fixed("clamp", markers=("ground.clamp", "b.start")),),
            forces=(fmb.PointLoad("P", marker="b.end", force=force),),
        )
    )
    start, end = (body.line(q, 1.0)[5][0] for q in (body.initial_state()[0], solution.final.q))
    return np.asarray(end - start), solution
