"""`disturbed`: a model whose start is moved a little along a velocity that its joints permit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmb.errors import CompileError, ModelError
from flexmb.math.rotations import euler_to_matrix
from flexmb.model.described import is_number
from flexmb.model.model import Model
from flexmb.system import assemble_as_drawn
from flexmb.system.branching import STEP, Neighbourhood

__all__ = ["disturbed"]

TRIES = 20


def disturbed(model: Model, *, size: float = STEP, seed: int = 0) -> Model:
    """Return the model with its bodies moved a little, onto its joints again: a start beside a singular one.

    The direction is random: in a singular configuration another `seed` may lead onto another branch. Velocities turn
    with their bodies, and become the nearest ones that the joints permit there. Bodies made of nodes keep their shape,
    place and velocities as described; assembly closes them.

    Parameters
    ----------
    model : Model
    size : float, -
        Largest motion, relative to the length of the assembly, or rad.
    seed : int

    Raises
    ------
    CompileError
        If no motion of that size is possible.
    """
    if not is_number(size) or not 0.0 < size <= 0.5:
        raise ModelError(
            "disturbed",
            found=f"size = {size!r}",
            expected="a number above 0, at most 0.5 (of the model's length, or rad)",
            remedy="Leave it out for 0.01",
        )
    system, state = assemble_as_drawn(model)
    near, rng = Neighbourhood(system, state, system.workspace()), np.random.default_rng(seed)
    for _ in range(TRIES):
        way = near.any_velocity(rng)
        if way is None:
            continue
        beside, changed, reached = near.closed(size * way, state.t)
        if beside is not None and np.max(np.abs(reached * system.units)) > 0.1 * size and changed < 1.0:
            break
    else:
        raise CompileError(
            f"Model '{model.name}'",
            found=f"no motion of {size:g} of its size goes on from the start",
            expected="a mechanism that can move",
            remedy="Look at flexmb.check(model): a flat toggle has a velocity, but no motion",
        )
    moving = near.moving(beside.q, state.u)
    bodies = []
    for body in model.bodies:
        own, known = system.body_slices[body.name], body.fields()
        q, u = beside.q[own[0]], moving[own[1]]
        if body.has_frame and "rotation" in known and len(q):
            R = np.empty((3, 3))
            euler_to_matrix(q[3:7], R)
            velocities = {"velocity": tuple(R @ u[:3]), "angular_velocity": tuple(R @ u[3:6])} if len(u) else {}
            bodies.append(body.replaced(at=tuple(q[:3]), rotation=R, **velocities))
        elif len(q) == 3 and "at" in known:
            bodies.append(body.replaced(at=tuple(q), velocity=tuple(u)))
        else:
            bodies.append(body)
    return replace(model, bodies=tuple(bodies))
