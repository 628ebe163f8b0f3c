"""What detection reads and writes.

A surface in the bulk data begins with a `HEADER` of numbers: the code of its shape, the radius of the ball around it
(`FAR` for a half-space), number and place of its samples, number and place of its corners, the radius by which the
corners are rounded, the place of the tree over the samples, 1 if it is convex, and its thickness (m, `FAR` for a
half-space). Places count from the header. Then come the numbers of the shape, the samples (place, outward normal, area:
7 each), the corners (3 each) and the nodes of the tree, all in the axes of the marker.
"""

from __future__ import annotations

import numpy as np

__all__ = [
    "CODE",
    "CONTACT",
    "CONVEX",
    "CORNERS",
    "CORNERS_AT",
    "FAR",
    "HEADER",
    "PATCH",
    "REACH",
    "ROUNDED",
    "SAMPLES",
    "SAMPLES_AT",
    "THICKNESS",
    "TREE_AT",
]

HEADER = 10
CODE, REACH, SAMPLES, SAMPLES_AT, CORNERS, CORNERS_AT, ROUNDED, TREE_AT, CONVEX, THICKNESS = range(10)
FAR = 1e100
"""m, from where on a surface has no end."""
PATCH = 9
"""Code of points without a solid, from which everything is `FAR`."""

CONTACT = np.dtype(
    [
        ("x", float, 3),  # m, the point on the surface of b
        ("n", float, 3),  # unit normal from a to b
        ("gap", float),  # m, below zero: penetration
        ("area", float),  # m2, or 1.0 of a contact at a point
        ("X", float, (3, 6)),  # derivative of x by (d, psi)
        ("N", float, (3, 6)),  # derivative of n
        ("A", float, 6),  # derivative of the area
        ("sample", np.int64),  # of an area: 1 + the number of the sample of b in its table, or -1 - that of a
    ],
    align=True,
)
"""A place where two surfaces touch or nearly touch, in the axes of the marker of a, from this marker.

d is the place of the marker of b, psi turns b relative to a. The place on a is x - gap n. The gap changes by
n.(dd + dpsi x (x - d)).
"""
