"""`Momentum`: linear and angular momentum of the whole system."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.math.rotations import euler_to_matrix
from flexmb.model.kinds import Sensor

__all__ = ["Momentum"]


@dataclass(frozen=True, eq=False)
class Momentum(Sensor):
    """Linear momentum and angular momentum about the origin of W, (nt, 6), kg m/s and kg m2/s, in W.

    A body with the momenta ``P = m v + ...``, ``h`` (about its origin), in body axes, adds ``R P`` and
    ``r x R P + R h``; for a floating body they are the first six rows of its mass matrix times its velocity.

    Parameters
    ----------
    name : str
    """

    titles: ClassVar[tuple[str, ...]] = (
        "px [kg m/s]",
        "py [kg m/s]",
        "pz [kg m/s]",
        "Lx [kg m2/s]",
        "Ly [kg m2/s]",
        "Lz [kg m2/s]",
    )

    def values(self, series) -> np.ndarray:
        """Return the momenta (nt, 6)."""
        total = np.zeros((len(series.t), 6))
        for body in series.model.bodies:
            if body.n_velocities:
                total += _momentum(series, body)
        return total


def _momentum(series, body):
    if hasattr(body, "reduced"):
        return _of_floating(body, *series.coordinates(body.name))
    if hasattr(body, "momentum"):
        return body.momentum(*series.coordinates(body.name))
    if not hasattr(body, "mass"):
        raise ModelError(
            body.title,
            found=f"a {type(body).__name__} does not provide its momentum",
            expected="rigid bodies, point masses and floating bodies",
            remedy="Leave the Momentum sensor out of models with this kind of body",
        )
    center = series.marker(f"{body.name}.center")
    P = body.mass * center.v
    L = np.cross(center.r, P)
    if hasattr(body, "inertia"):  # the marker "center" has the axes of the body
        spin = np.einsum("tji,tj->ti", center.R, center.w)
        L += np.einsum("tij,tj->ti", center.R, spin @ np.asarray(body.inertia).T)
    return np.hstack([P, L])


def _of_floating(body, q, u):
    """Rows 1 to 6 of M_b(eta) (v, w, eta')."""
    I = body.reduced.invariants
    eta, v, w, rate = q[:, 7:], u[:, :3], u[:, 3:6], u[:, 6:]
    vw = I.vw0 + np.einsum("tj,jkl->tkl", eta, I.vw1)
    ww = I.ww0 + np.einsum("tj,jkl->tkl", eta, I.ww1)
    ww += np.einsum("ti,tj,ijkl->tkl", eta, eta, I.ww2, optimize=True)
    wn = I.wn0 + np.einsum("tj,jkl->tkl", eta, I.wn1)
    P = v @ I.vv.T + np.einsum("tkl,tl->tk", vw, w) + rate @ I.vn.T
    h = np.einsum("tlk,tl->tk", vw, v) + np.einsum("tkl,tl->tk", ww, w) + np.einsum("tkl,tl->tk", wn, rate)
    R = np.empty((len(q), 3, 3))
    for k in range(len(q)):
        euler_to_matrix(q[k, 3:7], R[k])
    P_W, h_W = np.einsum("tij,tj->ti", R, P), np.einsum("tij,tj->ti", R, h)
    return np.hstack([P_W, np.cross(q[:, :3], P_W) + h_W])
