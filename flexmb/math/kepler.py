"""Motion of a point along an ellipse about a centre that attracts it: its place and velocity at any time.

Kepler's equation M = E - e sin E is solved by Newton's method (Vallado 2013, algorithm 2); then

    r = a P (cos E - e) + b Q sin E,   v = E' (b Q cos E - a P sin E),   E' = n / (1 - e cos E).
"""

from __future__ import annotations

import math

import numpy as np

from flexmb.math.kernel import kernel

__all__ = ["ELEMENTS", "follow_orbit"]

ELEMENTS = np.dtype(
    [
        ("follows", np.int64),  # 1: the origin of W moves along the ellipse; 0: it rests at the centre
        ("motion", float),  # mean motion n, rad/s
        ("eccentricity", float),
        ("anomaly", float),  # mean anomaly at t = 0, rad
        ("major", float, 3),  # a P, m: to the pericentre
        ("minor", float, 3),  # b Q, m
    ],
    align=True,
)
"""Where the origin of W is, from the centre that attracts."""
CLOSE = 1e-15
TURNS = 50


@kernel
def follow_orbit(t, orbit, r, v):
    """Write place (3,), m, and velocity (3,), m/s, of the origin from the centre at time t; zero where it rests."""
    if orbit.follows == 0:
        for i in range(3):
            r[i], v[i] = 0.0, 0.0
        return
    e = orbit.eccentricity
    mean = (orbit.anomaly + orbit.motion * t) % (2.0 * math.pi)
    E = mean if e < 0.8 else math.pi
    for _ in range(TURNS):
        change = (E - e * math.sin(E) - mean) / (1.0 - e * math.cos(E))
        E -= change
        if abs(change) <= CLOSE * (1.0 + abs(E)):
            break
    c, s = math.cos(E), math.sin(E)
    rate = orbit.motion / (1.0 - e * c)
    for i in range(3):
        r[i] = orbit.major[i] * (c - e) + orbit.minor[i] * s
        v[i] = rate * (orbit.minor[i] * c - orbit.major[i] * s)
