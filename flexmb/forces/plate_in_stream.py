"""A flat plate in a stream of particles that do not meet each other: thin gas, or light.

A stream of density rho, with the velocity w against the plate, meets its face where n . w < 0, n the outward normal.
A share s of the particles is mirrored, a share d leaves in all directions (Lambert's law) with the mean normal speed k,
the rest stays (gas) or is absorbed (light):

    F = rho A w_n ((1 - s) w - (2 s w_n + d k) n),   w_n = -n . w.

Gas: k is the mean normal speed of what leaves (Hughes 1986, section 8.1, the limit of a fast stream; Schaaf & Chambré
1961). Light: the pressure replaces rho and the direction replaces w, k = 2/3 (Wertz 1978, eq. 17-49).
"""

from __future__ import annotations

import numpy as np

from flexmb.errors import ModelError
from flexmb.math.kernel import kernel
from flexmb.math.vectors import cross, dot
from flexmb.model.described import is_number

__all__ = ["check_shares", "plate_force", "plate_slopes"]


@kernel
def plate_force(scale, w, n, mirrored, recoil, F):
    """Write the force F (3,), scale = rho A; return w_n, and if <= 0 no force: the stream meets the other face."""
    wn = -dot(n, w)
    for i in range(3):
        F[i] = 0.0
        if wn > 0.0:
            F[i] = scale * wn * ((1.0 - mirrored) * w[i] - (2.0 * mirrored * wn + recoil) * n[i])
    return wn


@kernel
def plate_slopes(scale, w, n, mirrored, recoil, by_w, by_turn):
    """Write the derivatives (3, 3) of the force by the stream w, and by a small turn of the plate; w_n > 0."""
    wn = -dot(n, w)
    e, turned = np.empty(3), np.empty(3)
    for j in range(3):
        e[:] = 0.0
        e[j] = 1.0
        cross(e, n, turned)
        a, b = -n[j], -dot(turned, w)  # of w_n
        for i in range(3):
            push = (1.0 - mirrored) * w[i] - (2.0 * mirrored * wn + recoil) * n[i]
            by_w[i, j] = scale * (a * push + wn * ((1.0 - mirrored) * e[i] - 2.0 * mirrored * a * n[i]))
            change = -2.0 * mirrored * b * n[i] - (2.0 * mirrored * wn + recoil) * turned[i]
            by_turn[i, j] = scale * (b * push + wn * change)


def check_shares(force) -> None:
    """Raise ModelError unless `mirrored` and `diffuse` are shares of one stream, and the area is positive."""
    force.require_positive("area")
    shares = force.mirrored, force.diffuse
    if not all(is_number(x) and 0.0 <= x for x in shares) or not sum(shares) <= 1.0 + 1e-12:
        raise ModelError(
            force.title,
            found=f"mirrored = {force.mirrored!r}, diffuse = {force.diffuse!r}",
            expected="shares from 0 to 1 with a sum of at most 1; the rest is absorbed",
            remedy="Write mirrored=0.1, diffuse=0.3",
        )
