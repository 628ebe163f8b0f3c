"""When an explicit method has drifted off the constraints, and when its steps get nowhere."""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel
from flexmb.system.program import constraint_velocity

__all__ = ["PATIENCE", "VANISHING", "drifted"]

VANISHING, PATIENCE = 1e-9, 30
"""So many steps in a row that are shorter than this part of the run: the method has come to a singular configuration.
"""


@kernel
def drifted(work, u, bounds, lengths):
    """Has the state evaluated last, with velocities u, left the constraints, at the level of position or of velocity?

    `bounds` (ng,) are residuals, or per radian of the fastest motion their rates; `lengths` (ng,), m, of the bodies
    that an equation relates make it an angle.
    """
    rate = np.empty(len(bounds))
    constraint_velocity(work, u, rate)
    fastest, spin = 0.0, 0.0
    for m in range(len(work.markers)):
        for i in range(3):
            fastest, spin = max(fastest, abs(work.markers[m].v[i])), max(spin, abs(work.markers[m].w[i]))
    for n in range(len(bounds)):
        if abs(work.equations[n].g) > bounds[n] or abs(rate[n]) > bounds[n] * max(spin, fastest / lengths[n]):
            return True
    return False
