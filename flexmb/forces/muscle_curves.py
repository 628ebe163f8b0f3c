"""The curves of Thelen's muscle, without dimensions, with their slopes and integrals.

Forces are over the greatest isometric force, lengths of fibres over their optimum, strains of the tendon over its slack
length. Source: Thelen 2003, Adjustment of muscle mechanics model parameters to simulate dynamic contractions in older
adults, Journal of Biomechanical Engineering 125, eq. 1 to 7; damping of the fibre: Millard et al. 2013, eq. 7.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel

__all__ = ["active_force", "contraction", "passive_force", "shortening", "tendon_force"]

WIDTH = 0.45
"""Of the bell of the active force, gamma."""
PASSIVE = 5.0
"""Exponent of the passive force, k_PE."""
TOE, TOE_FORCE, TOE_STRAIN, LINEAR = 3.0, 0.33, 0.609, 1.712
"""Of the tendon: exponent, force and strain (over that at full force) where it becomes linear, slope from there on."""
HILL = 0.25
"""Shape of the curve of force and velocity, A_f."""


@kernel
def active_force(x):
    """Return the active force of a fibre of length x, and its slope."""
    f = np.exp(-((x - 1.0) ** 2) / WIDTH)
    return f, -2.0 * (x - 1.0) / WIDTH * f


@kernel
def passive_force(x, strain):
    """Return the passive force of a fibre of length x, its slope and its integral; 1 at the length 1 + strain."""
    if x <= 1.0:
        return 0.0, 0.0, 0.0
    grown, scale = np.exp(PASSIVE * (x - 1.0) / strain), np.exp(PASSIVE) - 1.0
    return (
        (grown - 1.0) / scale,
        PASSIVE / strain * grown / scale,
        (strain / PASSIVE * (grown - 1.0) - (x - 1.0)) / scale,
    )


@kernel
def tendon_force(e, strain):
    """Return the force of a tendon at the strain e, its slope and its integral; `strain` is that at force 1."""
    if e <= 0.0:
        return 0.0, 0.0, 0.0
    toe, scale = TOE_STRAIN * strain, TOE_FORCE / (np.exp(TOE) - 1.0)
    if e <= toe:
        grown = np.exp(TOE * e / toe)
        return scale * (grown - 1.0), scale * TOE / toe * grown, scale * (toe / TOE * (grown - 1.0) - e)
    slope, x = LINEAR / strain, e - toe
    below = scale * (toe / TOE * (np.exp(TOE) - 1.0) - toe)
    return TOE_FORCE + slope * x, slope, below + TOE_FORCE * x + 0.5 * slope * x * x


@kernel
def shortening(z, lengthening):
    """Return the factor of the active force at the velocity z < 0 of shortening or z > 0 of lengthening, and its slope.

    The velocity is over that at which the fibre shortens without force. Thelen's equation for the velocity, solved for
    the force; `lengthening` is the limit for fast lengthening.
    """
    if z <= 0.0:
        below = 1.0 - z / HILL
        return (1.0 + z) / below, (1.0 + 1.0 / HILL) / (below * below)
    c = (2.0 + 2.0 / HILL) / (lengthening - 1.0)
    below = 1.0 + c * z
    return (1.0 + c * lengthening * z) / below, c * (lengthening - 1.0) / (below * below)


@kernel
def contraction(force, active, damping, lengthening):
    """Return the velocity z (see `shortening`) at which active force and damping make a force of the fibre.

    The root of ``active shortening(z) + damping z = force``, in closed form for both branches. Without damping there
    is none beyond the limits of the curve: the result is not finite, or of the wrong sign.
    """
    missing = active - force
    if missing >= 0.0:
        p, q = damping / HILL, active + damping + force / HILL
        return -2.0 * missing / (q + (q * q + 4.0 * p * missing) ** 0.5)
    c = (2.0 + 2.0 / HILL) / (lengthening - 1.0)
    p, q = damping * c, active * c * lengthening + damping - force * c
    return -2.0 * missing / (q + (q * q - 4.0 * p * missing) ** 0.5)
