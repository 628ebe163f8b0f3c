"""Velocities after impacts: impulses of the contact and of all joints, together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.system.impact import strike

__all__ = ["Impulse", "impulses", "velocities_after"]


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

    They follow from the velocities before and after, so any solution has them, also one that was read from a file
    with its model.

    Raises
    ------
    FlexmbError
        The solution was read without its model.

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
    if any(phase.model is None for phase in solution.phases):
        raise FlexmbError(
            "Solution",
            found="impulses asked of a file that was read without its model",
            expected="the model, whose events say what strikes",
            remedy='Give it: Solution.load(path, model=fmb.load_model("run/model.toml")), or read a sensor ImpulseOf',
        )
    return tuple(
        Impulse(event=phase.ended, t=float(phase.t[-1]), markers=action.markers, impulse=P, joints=reactions)
        for number, phase in enumerate(solution.phases)
        for action, P, reactions in solution.series(number).impacts
    )


def velocities_after(system, event, t: float, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Return the velocities (nu,) after the impacts of an event, in their order; `u` if it has none.

    Raises
    ------
    IntegrationError
        If nothing can move the two markers relative to each other.
    """
    return strike(system, event, t, q, u)[0]
