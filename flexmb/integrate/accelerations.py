"""`accelerations`: accelerations and reactions at a state, by any formulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError, ModelError, did_you_mean
from flexmb.integrate.formulations import Augmented
from flexmb.integrate.impulsive import refuse_impulses
from flexmb.integrate.runs.shared_readers import shared_reactions_act
from flexmb.math.rotations import euler_to_matrix
from flexmb.model.methods import is_formulation
from flexmb.model.model import Model
from flexmb.system import assemble, assemble_as_drawn, observe
from flexmb.system.given_state import given_state
from flexmb.system.system import System

__all__ = ["Accelerations", "accelerations"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Accelerations:
    """Accelerations and reactions at one state.

    ``result["crank"]`` is (6,): acceleration of the body's origin (m/s2) and angular acceleration (rad/s2), in W.

    Parameters
    ----------
    a : (nu,)
        Generalised accelerations, frames in body axes.
    lam : (ng,)
        Multipliers.
    reactions : dict of joint name to (6,)
        Force and moment (N, N m) on the body of the second marker, at that marker, in W.
    """

    system: System
    q: np.ndarray
    u: np.ndarray
    a: np.ndarray
    lam: np.ndarray
    reactions: dict[str, np.ndarray]

    def __repr__(self):
        joints = ", ".join(self.reactions) or "none"
        return (
            f"Accelerations of {self.system.model!r}: [body] for "
            f"{', '.join(self.system.body_slices)}; reactions: {joints}"
        )

    def __getitem__(self, body: str) -> np.ndarray:
        slices = self.system.body_slices
        if body not in slices:
            raise FlexmbError(
                "Accelerations",
                found=f"body '{body}' does not exist",
                expected=f"One of: {', '.join(slices)}",
                remedy=did_you_mean(body, slices),
            )
        q, u = slices[body]
        if not self.system.model.body(body).has_frame:
            return np.concatenate([self.a[u][:3], np.zeros(3)]) if u.stop > u.start else np.zeros(6)
        R = np.empty((3, 3))
        euler_to_matrix(self.q[q][3:7], R)
        v, w, a = self.u[u][:3], self.u[u][3:6], self.a[u]
        return np.concatenate([R @ (a[:3] + np.cross(w, v)), R @ a[3:6]])


def accelerations(model: Model, state: Any = None, formulation: Any = None) -> Accelerations:
    """Return the accelerations and reactions of a model.

    Parameters
    ----------
    model : Model
    state : Instant, optional
        Configuration and velocity (``solution.final``, ``solution.state(t)``); by default the assembled start.
    formulation : Augmented, NullSpace, UdwadiaPhohomsiri, Recursive, Baumgarte
        All give the same accelerations (Baumgarte: where nothing has drifted); multipliers of dependent equations have
        least norm.
    """
    formulation = formulation or Augmented()
    if not is_formulation(formulation):
        raise ModelError(
            "accelerations",
            found=f"formulation = {formulation!r}",
            expected="one of Augmented(), NullSpace(), UdwadiaPhohomsiri(), Recursive(), Baumgarte()",
            remedy="Give an object: formulation=flexmb.Recursive()",
        )
    refuse_impulses(model, "accelerations")
    system, start = (assemble_as_drawn if state is None else assemble)(model)
    if state is not None:
        start = given_state(state, system, "accelerations")
    work = system.workspace()
    a, lam = formulation.accelerate(system, start, work)
    shared_reactions_act(system, start, lam[None])
    seen = observe(system, [start.t], start.q[None], start.u[None], a[None], lam[None])
    reactions = {name: seen.reaction[0, k] for name, k in system.joint_index.items()}
    return Accelerations(system=system, q=start.q, u=start.u, a=a, lam=lam, reactions=reactions)
