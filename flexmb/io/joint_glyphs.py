"""How joints and springs look: small solids in the axes of the first marker, z along the joint's axis.

What a joint permits decides what is drawn, so that a new joint needs no entry here. A set of freedoms that `SOLIDS`
does not name is a ball.
"""

from __future__ import annotations

from flexmb.io.solids import Surface, box, coil, joined, sphere, tube

__all__ = ["joint_glyphs", "joint_solids", "spring_glyph"]


def _pin(e):
    return tube((0, 0, -1.6 * e), (0, 0, 1.6 * e), e)


def _sleeve(e):
    return joined([tube((0, 0, -2.6 * e), (0, 0, 2.6 * e), 0.55 * e), tube((0, 0, -1.2 * e), (0, 0, 1.2 * e), e)])


def _shaft(e):
    return tube((0, 0, -1.6 * e), (0, 0, 1.6 * e), 0.6 * e)


# what is permitted, in words of the freedoms' roles: the solids at marker a, and those at marker b, of size e
SOLIDS = {
    "turn": (_pin, None),
    "slide, turn": (_sleeve, None),
    "screw": (_sleeve, None),
    "slide": (None, lambda e: box((1.8 * e, 1.8 * e, 3.6 * e))),
    "slide, slide, turn": (None, lambda e: box((3.2 * e, 3.2 * e, 0.6 * e))),
    "ball": (lambda e: sphere(1.2 * e), None),
    "turn, turn_b": (_shaft, _shaft),
    "bend": (
        lambda e: joined([sphere(1.2 * e), tube((0, 0, 0), (0, 0, 2 * e), 0.6 * e)]),
        lambda e: tube((0, 0, 0), (0, 0, 2 * e), 0.6 * e),
    ),
    "nothing": (lambda e: box((1.5 * e, 1.5 * e, 1.5 * e)), None),
}
OTHER = (lambda e: sphere(0.9 * e), None)


def joint_solids(joint) -> tuple:
    """Return what makes the solids of a joint (or of a class of joints) at its markers a and b; None: nothing."""
    permits = joint.permits
    if not isinstance(permits, tuple):
        return OTHER  # a class whose fields decide
    if not permits:
        return SOLIDS["nothing"] if joint.forbids else OTHER
    return SOLIDS.get(", ".join(freedom.role or type(freedom).__name__.lower() for freedom in permits), OTHER)


def joint_glyphs(joint, e: float) -> list[tuple[str, Surface]]:
    """Return what is drawn for a joint, of size `e` (m): (carrier, surface), carrier "a", "b" or "link".

    A "link" runs from marker a to marker b; its surface has the length 1 along z.
    """
    if joint.drawn == "link":
        return [("link", tube((0, 0, 0), (0, 0, 1), 0.5 * e)), ("a", sphere(0.9 * e)), ("b", sphere(0.9 * e))]
    if joint.drawn == "shapes" or joint.prescribes:
        return []  # a drive moves along a joint that is drawn
    return [(end, make(e)) for end, make in zip("ab", joint_solids(joint), strict=True) if make is not None]


def spring_glyph(e: float) -> Surface:
    """Return a coil of the length 1 along z."""
    return coil(0.9 * e, 0.22 * e)
