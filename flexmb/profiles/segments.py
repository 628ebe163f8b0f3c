"""Segments of plane profiles as numbers that kernels read: lines, arcs, cubics and involutes.

A table is flat: number of segments, 1.0 if closed, then WIDTH numbers for each segment: kind, box (least and largest x,
least and largest y), and what the kind needs. A place on segment i is h from 0 to 1. The material lies to the left.

- LINE: start (2), vector to the end (2);
- ARC: centre (2), radius, angle of the start, sweep (positive: counter-clockwise);
- CUBIC: x = a0 + a1 h + a2 h^2 + a3 h^3, then y likewise;
- INVOLUTE: centre (2), base radius, angle of its root on the base circle, side (+1: the string unwinds as its angle
  grows), rolls t at the start and at the end: ``r_b e(g) + side r_b t (sin g, -cos g)``, ``g = root + side t``.
"""

from __future__ import annotations

import math

import numpy as np

from flexmb.math.kernel import kernel

LARGEST = 1e15
"""m, largest length and coordinate of a profile."""

__all__ = ["ARC", "CUBIC", "INVOLUTE", "LINE", "WIDTH", "evaluate_segment", "pack_segments", "place_of", "wrapped"]

LINE, ARC, CUBIC, INVOLUTE = 0.0, 1.0, 2.0, 3.0
WIDTH = 14


@kernel
def place_of(i):
    """Return where segment i begins in a table."""
    return 2 + WIDTH * i


@kernel
def wrapped(angle, low):
    """Return the angle by whole turns in [low, low + 2 pi)."""
    return angle - 2.0 * np.pi * np.floor((angle - low) / (2.0 * np.pi))


@kernel
def evaluate_segment(table, i, h, out):
    """Write the point of segment i at h, its first and second derivative by h, to `out` (3, 2)."""
    at = place_of(i)
    kind = table[at]
    s = table[at + 5 : at + WIDTH]
    if kind == LINE:
        for k in range(2):
            out[0, k], out[1, k], out[2, k] = s[k] + h * s[2 + k], s[2 + k], 0.0
    elif kind == ARC:
        angle, r = s[3] + h * s[4], s[2]
        c, d = r * math.cos(angle), r * math.sin(angle)
        out[0, 0], out[0, 1] = s[0] + c, s[1] + d
        out[1, 0], out[1, 1] = -d * s[4], c * s[4]
        out[2, 0], out[2, 1] = -c * s[4] * s[4], -d * s[4] * s[4]
    elif kind == CUBIC:
        for k in range(2):
            a0, a1, a2, a3 = s[4 * k], s[4 * k + 1], s[4 * k + 2], s[4 * k + 3]
            out[0, k] = ((a3 * h + a2) * h + a1) * h + a0
            out[1, k] = (3.0 * a3 * h + 2.0 * a2) * h + a1
            out[2, k] = 6.0 * a3 * h + 2.0 * a2
    else:
        r, side, speed = s[2], s[4], s[6] - s[5]
        t = s[5] + h * speed
        g = s[3] + side * t
        c, d = math.cos(g), math.sin(g)
        out[0, 0], out[0, 1] = s[0] + r * (c + side * t * d), s[1] + r * (d - side * t * c)
        out[1, 0], out[1, 1] = r * t * c * speed, r * t * d * speed
        out[2, 0] = r * (c - side * t * d) * speed * speed
        out[2, 1] = r * (d + side * t * c) * speed * speed


def pack_segments(segments: list[tuple[float, np.ndarray]], closed: bool) -> np.ndarray:
    """Return the table of segments, each with its kind and what the kind needs; boxes are computed here."""
    table = np.zeros(2 + WIDTH * len(segments))
    table[0], table[1] = len(segments), float(closed)
    for i, (kind, numbers) in enumerate(segments):
        at = place_of(i)
        table[at] = kind
        table[at + 5 : at + 5 + len(numbers)] = numbers
        extremes = np.array([_point(table, i, h) for h in (0.0, 1.0, *_turning(kind, np.asarray(numbers, float)))])
        low, high = extremes.min(axis=0), extremes.max(axis=0)
        table[at + 1 : at + 5] = low[0], high[0], low[1], high[1]
    return table


def _point(table: np.ndarray, i: int, h: float) -> np.ndarray:
    out = np.empty((3, 2))
    evaluate_segment(table, i, h, out)
    return out[0]


def _turning(kind: float, s: np.ndarray) -> list[float]:
    """Return the places inside a segment at which x or y turns."""
    found: list[float] = []
    if kind == ARC:
        first, sweep = s[3], s[4]
        for quarter in range(int(np.floor(abs(sweep) / (np.pi / 2.0))) + 2):
            angle = np.pi / 2.0 * (np.ceil(first / (np.pi / 2.0)) + quarter * np.sign(sweep) - (sweep < 0.0))
            found.append(float((angle - first) / sweep))
    elif kind == CUBIC:
        for k in range(2):
            roots = np.roots(np.array([3.0 * s[4 * k + 3], 2.0 * s[4 * k + 2], s[4 * k + 1]]))
            found.extend(float(r.real) for r in roots if abs(r.imag) < 1e-12)
    elif kind == INVOLUTE:  # x' = r t cos g: where the angle of the string is a multiple of a quarter
        first, last = s[3] + s[4] * s[5], s[3] + s[4] * s[6]
        low, high = min(first, last), max(first, last)
        for n in range(int(np.ceil(low / (np.pi / 2.0))), int(np.floor(high / (np.pi / 2.0))) + 1):
            found.append(float((n * np.pi / 2.0 - first) / (last - first)))
    return [h for h in found if 0.0 < h < 1.0]
