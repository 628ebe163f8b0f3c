"""The work of drives by the reactions of the equations of motion at the ends of steps.

For integrators whose own multipliers have no controlled accuracy between samples.
"""

from __future__ import annotations

import numpy as np

from flexmb.system.accelerations import accelerations

__all__ = ["WorkOfDrives"]


class WorkOfDrives:
    """Sums up the work of the drives, and of equations of the user that move by themselves, from step to step.

    Parameters
    ----------
    system : System
    state : State
        At the start, with its multipliers.
    work : Work
        Scratch.

    Attributes
    ----------
    act : bool
        Are there joints that can do work?
    t, work : float, s and J
        The time that was reached, and the work until then.
    """

    def __init__(self, system, state, work):
        self.system, self.scratch = system, work
        self.act = any(joint.works for joint in system.model.joints)
        self.t, self.work = float(state.t), 0.0
        self._right = np.zeros(system.nu + system.ng)
        self._powers = [(self.t, self._power(state))] if self.act else []

    def go_on(self, state) -> None:
        """Add the work of a step: the integral of the parabola through the powers at its ends and at the start before;
        a parabola is used only where steps are alike, as extrapolation magnifies what a short step rounds.
        """
        power = self._power(state)
        (t0, p0), h = self._powers[-1], state.t - self._powers[-1][0]
        self.work += 0.5 * h * (p0 + power)
        if len(self._powers) > 1:
            t1, p1 = self._powers[-2]
            before = t0 - t1
            if before > 0.1 * h:
                curvature = ((power - p0) / h - (p0 - p1) / before) / (h + before)
                self.work -= curvature * h**3 / 6.0
        self._powers = [*self._powers[-1:], (float(state.t), power)]
        self.t = float(state.t)

    def _power(self, state) -> float:
        sweeps = 12 if self.system.redundant else 2
        accelerations(self.system.program, state, self.scratch, self._right, sweeps)
        return -float(state.lam @ self.scratch.equations["rate"])
