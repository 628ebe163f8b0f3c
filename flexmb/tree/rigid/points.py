"""Point masses as links: which bodies are points, and which are too light for a closure by inverse masses."""

from __future__ import annotations

import numpy as np

from flexmb.errors import CompileError
from flexmb.model.kinds import Body
from flexmb.tree.any_body.light_points import LightPoints
from flexmb.tree.any_body.store import new_store
from flexmb.tree.coordinates.motions import POINTS

__all__ = ["is_point", "require_heavy_points"]


def is_point(body: Body) -> bool:
    """Is a body without a frame one point, which tells its mass?"""
    return body.n_velocities == 3 and type(body).rest_inertia is not Body.rest_inertia


def require_heavy_points(tree, work, mobility: np.ndarray) -> None:
    """Raise CompileError if cut joints hold a point whose mass is too small beside what they hold with it.

    `work` holds an evaluation with the mass matrix, `mobility` (nc,) is that of the cut equations between free bodies.
    """
    tables = tree.tree.tables
    if not len(mobility) or not np.any(tree.rows["held"] == POINTS):
        return
    light = LightPoints(tables, work, new_store(tables), tree.system, mobility)
    if len(light.velocities):
        name = next(name for name, iu in zip(tree.tree.order, tables.iu, strict=True) if iu == light.velocities[0])
        raise CompileError(
            f"Body '{name}'",
            found=f"{light.mass[0]:.3g} kg between joints that hold far heavier bodies",
            expected="more than some thousandth of their mass",
            remedy="Use fmb.accelerations(model, formulation=fmb.Recursive()), which takes points without mass",
        )
