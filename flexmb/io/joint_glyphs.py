"""How joints and springs look: small solids in the axes of the first marker, z along the joint's axis."""

from __future__ import annotations

import numpy as np

from flexmb import joints
from flexmb.io.solids import Surface, box, coil, joined, sphere, tube

__all__ = ["joint_glyphs", "spring_glyph"]

ALONG_X = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def _pin(e):
    return tube((0, 0, -1.6 * e), (0, 0, 1.6 * e), e)


def _sleeve(e):
    return joined([tube((0, 0, -2.6 * e), (0, 0, 2.6 * e), 0.55 * e), tube((0, 0, -1.2 * e), (0, 0, 1.2 * e), e)])


# kind: the solids at marker a, and those at marker b, of size e
GLYPHS = {
    "Revolute": (_pin, None),
    "Cylindrical": (_sleeve, None),
    "Screw": (_sleeve, None),
    "Prismatic": (None, lambda e: box((1.8 * e, 1.8 * e, 3.6 * e))),
    "Planar": (None, lambda e: box((3.2 * e, 3.2 * e, 0.6 * e))),
    "Spherical": (lambda e: sphere(1.2 * e), None),
    "Universal": (
        lambda e: tube((0, 0, -1.6 * e), (0, 0, 1.6 * e), 0.6 * e),
        lambda e: tube((0, 0, -1.6 * e), (0, 0, 1.6 * e), 0.6 * e),
    ),
    "ConstantVelocity": (
        lambda e: joined([sphere(1.2 * e), tube((0, 0, 0), (0, 0, 2 * e), 0.6 * e)]),
        lambda e: tube((0, 0, 0), (0, 0, 2 * e), 0.6 * e),
    ),
    "GearPair": (None, None),  # the shapes of the wheels show it
    "Fixed": (lambda e: box((1.5 * e, 1.5 * e, 1.5 * e)), None),
}


def joint_glyphs(joint, e: float) -> list[tuple[str, Surface]]:
    """Return what is drawn for a joint, of size `e` (m): (carrier, surface), carrier "a", "b" or "link".

    A "link" runs from marker a to marker b; its surface has the length 1 along z.
    """
    if isinstance(joint, joints.Rod):
        return [("link", tube((0, 0, 0), (0, 0, 1), 0.5 * e)), ("a", sphere(0.9 * e)), ("b", sphere(0.9 * e))]
    if joint.prescribes:
        return []  # a drive moves along a joint that is drawn
    unknown = (lambda size: sphere(0.9 * size), None)
    pair = GLYPHS.get(type(joint).__name__, unknown)
    return [(end, make(e)) for end, make in zip("ab", pair) if make is not None]


def spring_glyph(e: float) -> Surface:
    """Return a coil of the length 1 along z."""
    return coil(0.9 * e, 0.22 * e)
