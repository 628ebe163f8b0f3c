"""Velocities after impacts: impulses of the contact and of all joints, together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexmb.errors import IntegrationError
from flexmb.math.block_lu import lu_factor, lu_solve
from flexmb.math.weights import weigh_mass
from flexmb.system import compile as compile_model
from flexmb.system import observe
from flexmb.system.program import evaluate

__all__ = ["Impulse", "impulses", "velocities_after"]


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


@dataclass(frozen=True, kw_only=True, eq=False)
class Impulse:
    """What passed in an impact.

    Parameters
    ----------
    event : str
        Name of the event.
    t : float, s
    markers : (str, str)
        Of the impact.
    impulse : float, N s
        Of the contact, on the body of the second marker along the normal, and its opposite on the first; 0 if they
        separated already.
    joints : mapping of joint to (6,), N s and N m s
        Force and moment impulse that the joint exerts on the body of its second marker, at that marker, in W.
    """

    event: str
    t: float
    markers: tuple[str, str]
    impulse: float
    joints: Mapping[str, np.ndarray]


def impulses(solution) -> tuple[Impulse, ...]:
    """Return the impulses of all impacts of a solution, in their order.

    They follow from the velocities before and after, so any solution has them, also one that was read from a file.

    Examples
    --------
    >>> ball = fmb.PointMass("ball", mass=2.0, at=(0, 0, 0.5), velocity=(0, 0, -3.0))
    >>> gap = fmb.Distance("gap", markers=("ground.origin", "ball.center"), along="z")
    >>> impact = fmb.Impact(("ground.origin", "ball.center"), restitution=0.5, along="z")
    >>> hit = fmb.Event("hit", sensor="gap", below=0.0, then=impact)
    >>> model = fmb.Model(bodies=[fmb.Ground(), ball], sensors=[gap], events=[hit])
    >>> round(fmb.impulses(fmb.simulate(model, 0.3))[0].impulse, 6)
    9.0
    """
    found = []
    for phase in solution.phases:
        event = next((e for e in phase.model.events if e.name == phase.ended), None)
        if event is None or not any(action.strikes for action in event.then):
            continue
        system = compile_model(phase.model) if phase.system is None else phase.system
        t, q = float(phase.t[-1]), phase.q[-1]
        _, struck = _strike(system, event, t, q, phase.u[-1])
        for action, P, joints in struck:
            still = np.zeros((2, 1, system.nu))
            seen = observe(system, [t], q[None], still[0], still[1], joints[None]).reaction[0]
            reactions = {name: seen[k] for name, k in system.joint_index.items()}
            found.append(Impulse(event=event.name, t=t, markers=action.markers, impulse=P, joints=reactions))
    return tuple(found)


def velocities_after(system, event, t: float, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Return the velocities (nu,) after the impacts of an event, in their order; `u` if it has none.

    Raises
    ------
    IntegrationError
        If nothing can move the two markers relative to each other.
    """
    return _strike(system, event, t, q, u)[0]


def _strike(system, event, t: float, q: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, list]:
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
