"""`campbell`: how the frequencies of a rotating structure change with its speed."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flexmb.errors import ModelError, ValidityWarning
from flexmb.integrate.equilibria.statics import statics
from flexmb.integrate.linear.linearize import linearize
from flexmb.model.model import Model

__all__ = ["Campbell", "campbell"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Campbell:
    """Frequencies and damping over the speed; a column is one mode, followed by its shape from speed to speed.

    Parameters
    ----------
    speeds : (ns,), rad/s
    frequencies : (ns, k), Hz
    damping_ratios : (ns, k)
    observer : str
        Whose frequencies they are at the last speed (`Linearization.observer`).
    """

    speeds: np.ndarray
    frequencies: np.ndarray
    damping_ratios: np.ndarray
    observer: str = ""

    @property
    def grows(self) -> np.ndarray:
        """Does a mode grow at a speed? (ns, k)."""
        return ~(self.damping_ratios > -1e-7)

    @property
    def stable(self) -> np.ndarray:
        """Does no mode grow, at each speed? (ns,)."""
        return ~np.any(self.grows, axis=1)

    def critical(self, order: float = 1.0) -> list[tuple[int, float]]:
        """Return (mode, speed in rad/s) where a frequency is `order` times the speed, between the speeds by line.

        In the turning frame order 1 is a force fixed in space, such as gravity; an unbalance has order 0. Where
        frequencies are those in W (`Linearization.observer`) it is the other way round.
        """
        found = []
        for mode, curve in enumerate(2.0 * np.pi * self.frequencies.T):
            gap = curve - order * self.speeds
            for k in np.flatnonzero(gap[:-1] * gap[1:] < 0.0):
                share = gap[k] / (gap[k] - gap[k + 1])
                found.append((mode, float(self.speeds[k] + share * (self.speeds[k + 1] - self.speeds[k]))))
        return found


def campbell(model: Callable[[float], Model], speeds, modes: int = 6) -> Campbell:
    """Return the Campbell diagram: the linear model about the steady motion at each speed.

    Parameters
    ----------
    model : callable (speed, rad/s) -> Model
        The structure turning steadily: ``Drive(..., angle=expression("w * t", w=speed))``.
    speeds : (ns,), rad/s
        In steps small enough for the shapes to be recognised.
    modes : int
        The lowest ones at the first speed.

    Returns
    -------
    Campbell

    Examples
    --------
    ::

        diagram = fmb.campbell(lambda speed: rotor.changed("spin", angle=fmb.expression("w * t", w=speed)),
                               np.linspace(0.0, 300.0, 31))
        diagram.critical(order=1)
    """
    from scipy.optimize import linear_sum_assignment

    speeds = np.atleast_1d(np.asarray(speeds, float))
    if speeds.ndim != 1 or len(speeds) < 2 or np.any(np.diff(speeds) <= 0.0):
        raise ModelError(
            "campbell",
            found=f"{speeds.size} speeds from {speeds.flat[0]:g} to {speeds.flat[-1]:g} rad/s"
            if speeds.size
            else "no speeds",
            expected="at least two, increasing, rad/s",
            remedy="Write np.linspace(0.0, 300.0, 31)",
        )
    before, rows, observers = None, [], {}
    for speed in speeds:
        described = model(float(speed))
        linear = linearize(described, statics(described))
        if speed != 0.0:  # at rest all axes are the same
            observers.setdefault(linear.observer, float(speed))
        shapes = linear.modes / np.linalg.norm(linear.modes, axis=0)
        found = 2.0 * np.pi * linear.frequencies
        if before is None:
            order = np.arange(min(modes, len(found)))
        else:
            shape, frequency = before
            likeness = np.abs(shape.conj().T @ shapes) ** 2
            # of equal shapes (a square shaft has pairs) the one whose frequency is near
            apart = np.abs(found[None, :] - frequency[:, None]) / (frequency[:, None] + np.diff(speeds).max())
            order = linear_sum_assignment(np.minimum(apart, 1.0) - likeness)[1]
        before = shapes[:, order], found[order]
        rows.append((linear.frequencies[order], linear.damping_ratios[order]))
    if len(observers) > 1:
        changes = "; ".join(f"{name} from {speed:.6g} rad/s on" for name, speed in observers.items())
        warnings.warn(
            f"campbell: frequencies are those of different observers: {changes}; expected: one. In axes that turn, a "
            "whirl p is p - speed: curves and critical speeds across the change mean nothing. Stay on one side of it",
            ValidityWarning,
            stacklevel=2,
        )
    frequencies, damping = (np.array(column) for column in zip(*rows))
    return Campbell(speeds=speeds, frequencies=frequencies, damping_ratios=damping, observer=linear.observer)
