"""Motion of a point about a centre that attracts it: its place and velocity at any time.

Kepler's equation M = E - e sin E is solved by Newton's method (Vallado 2013, algorithm 2); then

    r = a P (cos E - e) + b Q sin E,   v = E' (b Q cos E - a P sin E),   E' = n / (1 - e cos E).

About a flattened centre there is no closed form: places, velocities and accelerations are tabulated, and between two
times r is the polynomial of degree five through them.
"""

from __future__ import annotations

import math

import numpy as np

from flexmb.math.harmonic_field import falling_oblate
from flexmb.math.kernel import inner_kernel, kernel

__all__ = ["ELEMENTS", "KNOT", "follow_orbit", "tabulate_orbit"]

KNOT = 9
"""Numbers of a row of the table: place, velocity, acceleration."""

ELEMENTS = np.dtype(
    [
        ("follows", np.int64),  # 1: the origin of W moves along the ellipse; 0: it rests at the centre
        ("motion", float),  # mean motion n, rad/s
        ("eccentricity", float),
        ("anomaly", float),  # mean anomaly at t = 0, rad
        ("major", float, 3),  # a P, m: to the pericentre
        ("minor", float, 3),  # b Q, m
        ("knots", np.int64),  # rows of the table; 0: an ellipse
        ("table", np.int64),  # where it begins in the bulk data
        ("spacing", float),  # s, between its rows
        ("strength", float),  # mu J2 R^2 / 2, N m4/kg, of a flattened centre
    ],
    align=True,
)
"""Where the origin of W is, from the centre that attracts."""
BEFORE = 1e-3
"""Part of its spacing by which a table reaches beyond its first row: values just before the start are asked for."""
CLOSE = 1e-15
TURNS = 50


@inner_kernel
def _between(t, orbit, data, r, v):
    """Write place and velocity from the table; no numbers outside of it."""
    k = math.floor(t / orbit.spacing) if t == t else -2
    if k == -1 and t > -BEFORE * orbit.spacing:
        k = 0
    if k < 0 or k > orbit.knots - 2:
        for i in range(3):
            r[i], v[i] = math.nan, math.nan
        return
    h = orbit.spacing
    s = t / h - k
    a, b = orbit.table + KNOT * k, orbit.table + KNOT * (k + 1)
    for i in range(3):
        # r = a + s d, and what is left of the far end: in its value, rate and second rate
        at, rate, bend = data[a + i], h * data[a + 3 + i], h * h * data[a + 6 + i]
        x = data[b + i] - at - rate - 0.5 * bend
        y = h * data[b + 3 + i] - rate - bend
        z = h * h * data[b + 6 + i] - bend
        c3, c4, c5 = 10.0 * x - 4.0 * y + 0.5 * z, -15.0 * x + 7.0 * y - z, 6.0 * x - 3.0 * y + 0.5 * z
        r[i] = at + s * (rate + s * (0.5 * bend + s * (c3 + s * (c4 + s * c5))))
        v[i] = (rate + s * (bend + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))) / h


@inner_kernel
def _pull(r, mu, k, strength, out):
    far = 0.0
    none = np.zeros(3)
    for i in range(3):
        far += r[i] * r[i]
    falling_oblate(none, r, k, strength, out)
    for i in range(3):
        out[i] -= mu / far**1.5 * r[i]


@kernel
def tabulate_orbit(mu, k, strength, spacing, substeps, table):
    """Fill the rows (n, KNOT) from the first one on, whose place and velocity are given, by Runge-Kutta's method.

    k (3,) is the axis of the centre; there are so many steps of fourth order between two rows.
    """
    h = spacing / substeps
    r, v, x, w = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    k1, k2, k3, k4 = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    r[:], v[:] = table[0, :3], table[0, 3:6]
    _pull(r, mu, k, strength, k1)
    for n in range(len(table)):
        if n > 0:
            for _ in range(substeps):
                _pull(r, mu, k, strength, k1)
                for i in range(3):
                    x[i] = r[i] + 0.5 * h * v[i]
                _pull(x, mu, k, strength, k2)
                for i in range(3):
                    x[i] = r[i] + 0.5 * h * v[i] + 0.25 * h * h * k1[i]
                _pull(x, mu, k, strength, k3)
                for i in range(3):
                    x[i] = r[i] + h * v[i] + 0.5 * h * h * k2[i]
                _pull(x, mu, k, strength, k4)
                for i in range(3):
                    w[i] = k1[i] + k2[i] + k3[i]
                    r[i] += h * v[i] + h * h / 6.0 * w[i]
                    v[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i])
            _pull(r, mu, k, strength, k1)
        for i in range(3):
            table[n, i], table[n, 3 + i], table[n, 6 + i] = r[i], v[i], k1[i]


@kernel
def follow_orbit(t, orbit, data, r, v):
    """Write place (3,), m, and velocity (3,), m/s, of the origin from the centre at time t; zero where it rests.

    `data` are the bulk numbers that hold the table.
    """
    if orbit.follows == 0:
        for i in range(3):
            r[i], v[i] = 0.0, 0.0
        return
    if orbit.knots > 0:
        _between(t, orbit, data, r, v)
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
