"""Velocities after impacts: impulses of the contact and of all joints, together."""

from __future__ import annotations

import numpy as np

from flexmb.errors import IntegrationError
from flexmb.math.block_lu import lu_factor
from flexmb.math.block_substitution import lu_solve
from flexmb.math.weights import weigh_mass
from flexmb.system.program import evaluate

__all__ = ["strike"]


def _gradient(system, work, action) -> np.ndarray:
    """Return c (nu,): the rate of the gap is c u (+ prescribed motion), and c P the generalised force of an impulse."""
    a, b = (work.markers[system.marker_index[name]] for name in action.markers)
    d = b["r"] - a["r"]
    length = np.linalg.norm(d)
    n = a["R"][:, "xyz".index(action.along)] if action.along else d / (length if length > 0.0 else 1.0)
    c = np.zeros(system.nu)
    # the impulse acts at b on both bodies: on the body of a with the lever d
    for marker, twist in ((a, np.concatenate([-n, np.cross(n, d)])), (b, np.concatenate([n, np.zeros(3)]))):
        nu = marker["nu"]
        J = work.J[marker["iJ"] : marker["iJ"] + 6 * nu].reshape(6, nu)
        c[marker["iu"] : marker["iu"] + nu] += twist @ J
    return c


def strike(system, event, t: float, q: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, list]:
    """Return the velocities (nu,) after an event, and (action, impulse, impulses of the multipliers (ng,)) of each."""
    actions, struck = [action for action in event.then if action.strikes], []
    if not actions:
        return u, struck
    state, work = system.state(t, q, u), system.workspace()
    weigh_mass(work.weights)
    evaluate(system.program, state, work)
    lu_factor(work.S, system.program.pattern)
    u = np.array(u)
    for action in actions:
        c = _gradient(system, work, action)
        response = np.concatenate([c, np.zeros(system.ng)])
        lu_solve(work.S, system.program.pattern, response)
        compliance, rate = float(c @ response[: system.nu]), float(c @ u)
        if not compliance > 1e-12 * float(c @ c):
            raise IntegrationError(
                event.title,
                found=f"an impulse between {' and '.join(action.markers)} moves nothing",
                expected="markers that can move relative to each other along the contact normal",
                remedy="Look at the joints of both bodies, and at the axis `along`",
            )
        P = max(0.0, -(1.0 + action.restitution) * rate / compliance)
        u += P * response[: system.nu]
        struck.append((action, P, P * response[system.nu :]))
    return u, struck
