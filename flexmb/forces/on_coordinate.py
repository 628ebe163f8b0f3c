"""Forces on one coordinate: a freedom of a joint, or the distance or an offset between two markers."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from flexmb.constraints import Coordinate, joint_coordinate
from flexmb.errors import ModelError, did_you_mean
from flexmb.model.kinds import Force
from flexmb.model.signal import Constant, Product

__all__ = ["OnCoordinate", "check_number", "checked_limits", "joint_of_tables", "signal_and_table"]


class OnCoordinate(Force):
    """A force that acts on a coordinate of a joint (fields ``joint``, ``freedom``) or of two markers (``along``)."""

    freedom: str | None
    holds_turns: ClassVar[bool] = True
    motion: ClassVar[str | None] = None
    """"turn" or "slide" if the force acts on one of them only."""

    def require_place(self) -> None:
        """Raise ModelError unless exactly one of `joint` and `markers` is given, and `along` is known."""
        joint, markers = getattr(self, "joint", None), getattr(self, "markers", None)
        if (joint is None) == (markers is None):
            raise ModelError(
                self.title,
                found="both markers and joint" if joint else "neither markers nor joint",
                expected="markers=(a, b), or the joint on whose freedom the force acts",
                remedy="Give one of the two",
            )
        along = getattr(self, "along", "line")
        if along not in ("line", "x", "y", "z"):
            raise ModelError(
                self.title,
                found=f"along = {along!r}",
                expected="'line', 'x', 'y' or 'z'",
                remedy=did_you_mean(str(along), ("line",)) or "The axes belong to the first marker",
            )
        if markers is not None:
            self.require_marker_pair()

    def place(self, model) -> tuple[Coordinate, tuple[str, str]]:
        """Return the coordinate and the names of its two markers."""
        fields: Any = self
        if getattr(self, "joint", None) is not None:
            joint = model.joint(fields.joint, self.title)
            return joint_coordinate(joint, self.title, self.freedom, self.motion), joint.markers
        along = getattr(self, "along", "line")
        coordinate = Coordinate("distance") if along == "line" else Coordinate("slide", along)
        return coordinate, fields.markers

    def check(self, model) -> None:
        """Raise ModelError if the joint or a marker does not exist, or the joint has no such freedom."""
        _, markers = self.place(model)
        for marker in markers:
            model.marker(marker, self.title)

    def measure(self, model) -> str:
        """Return the second marker."""
        return self.place(model)[1][1]

    def coordinate_row(self, compiler, counts: bool = True) -> dict[str, Any]:
        """Return the row of the coordinate."""
        coordinate, markers = self.place(compiler.model)
        a, b = (compiler.marker(m) for m in markers)
        return coordinate.record(compiler, a, b, counts=counts)

    def described(self, compiler) -> float:
        """Return the coordinate as described."""
        coordinate, markers = self.place(compiler.model)
        return coordinate.value(compiler, *(compiler.marker(m) for m in markers))


def checked_limits(part, remedy: str) -> tuple[float, float] | None:
    """Return the field `limits` as two numbers, the smaller one first, or None; ModelError if it is neither."""
    if part.limits is None:
        return None
    try:
        limits = np.asarray(part.limits, float)
    except (TypeError, ValueError, OverflowError):
        limits = np.empty(0)
    if limits.shape != (2,) or not limits[0] < limits[1]:
        raise ModelError(part.title, found=f"limits = {part.limits!r}", expected="(smallest, largest)", remedy=remedy)
    return float(limits[0]), float(limits[1])


def check_number(part, field: str, low: float, expected: str, remedy: str) -> None:
    """Raise ModelError if a field is not a finite number >= `low`."""
    value = getattr(part, field)
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value < float("inf"):
        raise ModelError(part.title, found=f"{field} = {value!r}", expected=expected, remedy=remedy)


def _factors(signal) -> tuple[Any, ...]:
    """Return the factors of a product, also of products in it."""
    return tuple(f for term in signal.terms for f in _factors(term)) if isinstance(signal, Product) else (signal,)


def signal_and_table(component) -> tuple[Any, Any]:
    """Return a component of a load as a signal of time and a table over a joint's coordinate (or None)."""
    terms = _factors(component)
    tables = [term for term in terms if getattr(term, "joint", None)]
    rest = tuple(term for term in terms if not getattr(term, "joint", None))
    signal = Constant(1.0) if not rest else rest[0] if len(rest) == 1 else Product(rest)
    return signal, tables[0] if len(tables) == 1 else Product(tuple(tables)) if tables else None


def joint_of_tables(part, components) -> str | None:
    """Return the joint over which the components of a load have tables; ModelError if it is not one."""
    tables = [signal_and_table(component)[1] for component in components]
    joints = {getattr(table, "joint", None) for table in tables if table is not None}
    if len(joints) > 1 or None in joints:
        raise ModelError(
            part.title,
            found="tables over several joints, or a product of two such tables",
            expected="tables over one joint",
            remedy=f"Make one {type(part).__name__} for each joint",
        )
    if part.freedom is not None and not joints:
        raise ModelError(
            part.title,
            found=f"freedom = {part.freedom!r} without a table over a joint",
            expected="a table over the coordinate of a joint",
            remedy='Write fmb.table(..., of="hinge"), or leave freedom out',
        )
    return next(iter(joints), None)
