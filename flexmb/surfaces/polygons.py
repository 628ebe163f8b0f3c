"""Polygons that are cut: Sutherland & Hodgman 1974, Reentrant polygon clipping."""

from __future__ import annotations

from flexmb.math.kernel import kernel
from flexmb.math.vectors import dot

__all__ = ["cut_polygon"]


@kernel
def cut_polygon(polygon, count, side, border, on, out):
    """Write the part of a polygon (count, 3) with side.x <= border to `out`; return its number of corners.

    Corners beyond by up to `on` stay, and no new one is made between two that lie so near the border.
    """
    made = 0
    for m in range(count):
        p, q = polygon[m], polygon[(m + 1) % count]
        above, next_above = dot(side, p) - border, dot(side, q) - border
        if above <= on:
            out[made] = p
            made += 1
        if (above < -on and next_above > on) or (above > on and next_above < -on):
            part = above / (above - next_above)
            for i in range(3):
                out[made, i] = p[i] + part * (q[i] - p[i])
            made += 1
    return made
