"""Shapes: what bodies look like. They have no mass and touch nothing; pictures and ParaView files show them."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any

from flexmb.errors import ModelError
from flexmb.model.described import Described, entries_of, finite_array, is_number
from flexmb.model.pose import vector3

__all__ = ["VALUES", "Ball", "Box", "Extrusion", "Shape", "Tube", "checked_shapes"]


@dataclass(frozen=True, eq=False)
class Shape(metaclass=Described):
    """A solid that is drawn.

    Parameters
    ----------
    on : str
        Marker of the body in whose axes the shape is given; by default in the axes of the body.
    """

    _: KW_ONLY
    on: str = ""

    def _fail(self, found: str, expected: str, remedy: str) -> None:
        raise ModelError(f"Shape {type(self).__name__}", found=found, expected=expected, remedy=remedy)


@dataclass(frozen=True, eq=False)
class Box(Shape):
    """A box with edges `size` (3,), m, along the axes, its centre `at` (3,), m."""

    size: Any
    at: Any = (0.0, 0.0, 0.0)

    def __post_init__(self):
        for name in ("size", "at"):
            object.__setattr__(self, name, vector3(getattr(self, name), "Shape Box", name))
        if min(self.size) <= 0.0:
            self._fail(f"size = {self.size} m", "three positive lengths", "Write size = (0.4, 0.1, 0.1)")


@dataclass(frozen=True, eq=False)
class Ball(Shape):
    """A ball with the `radius`, m, its centre `at` (3,), m."""

    radius: float
    at: Any = (0.0, 0.0, 0.0)

    def __post_init__(self):
        object.__setattr__(self, "at", vector3(self.at, "Shape Ball", "at"))
        if not is_number(self.radius) or not self.radius > 0.0:
            self._fail(f"radius = {self.radius!r} m", "a positive length", "Write radius = 0.1")


@dataclass(frozen=True, eq=False)
class Tube(Shape):
    """A round bar from `start` to `end` (3,), m, with the outer `radius`, m."""

    start: Any
    end: Any
    radius: float

    def __post_init__(self):
        for name in ("start", "end"):
            object.__setattr__(self, name, vector3(getattr(self, name), "Shape Tube", name))
        if self.start == self.end or not self.radius > 0.0:
            self._fail(
                f"from {self.start} to {self.end} m with the radius {self.radius!r} m",
                "two different ends and a positive radius",
                "Correct the ends or the radius",
            )


@dataclass(frozen=True, eq=False)
class Extrusion(Shape):
    """A plane outline, drawn out along an axis: a plate, a profile, a wing section.

    Parameters
    ----------
    outline : (n, 2), m
        Corners in order, not closed, either way round; the two coordinates belong to the other axes in the order x, y,
        z: (x, z) for the axis "y".
    depth : (2,), m
        From where to where along the axis.
    axis : "x", "y" or "z"
    """

    outline: Any
    depth: Any
    axis: str = "y"

    def __post_init__(self):
        outline, depth = finite_array(self.outline), finite_array(self.depth)
        if outline.ndim != 2 or outline.shape[1] != 2 or len(outline) < 3:
            self._fail(
                f"an outline of the shape {outline.shape}",
                "three or more corners (n, 2), m",
                "Write outline = [(0, 0), (1, 0), (1, 0.2)]",
            )
        if depth.shape != (2,) or depth[0] == depth[1]:
            self._fail(f"depth = {self.depth!r}", "two different numbers, m", "Write depth = (-0.1, 0.1)")
        if self.axis not in ("x", "y", "z"):
            self._fail(f"axis = {self.axis!r}", "'x', 'y' or 'z'", "Name an axis of the body")
        object.__setattr__(self, "outline", outline)
        object.__setattr__(self, "depth", tuple(sorted(depth.tolist())))


VALUES = {kind.__name__: kind for kind in (Ball, Box, Extrusion, Tube)}
"""Shapes by name, for model files: ``shape = [{ kind = "Box", size = [0.4, 0.1, 0.1] }]``."""


def checked_shapes(body) -> tuple[Shape, ...]:
    """Return the field `shape` of a body as a tuple; ModelError if something else is in it, or a marker is unknown."""
    given = entries_of(body.shape)
    if not all(isinstance(shape, Shape) for shape in given):
        raise ModelError(
            body.title,
            found=f"shape = {body.shape!r}",
            expected=f"one or more of {', '.join(VALUES)}",
            remedy="Write shape=fmb.Box(size=(0.4, 0.1, 0.1)), or leave shape out",
        )
    markers = body.marker_poses()
    for shape in given:
        if shape.on and shape.on not in markers:
            raise ModelError(
                body.title,
                found=f"a shape on the marker '{shape.on}'",
                expected=f"The body has: {', '.join(markers)}",
                remedy="Correct the marker of the shape",
            )
    return given
