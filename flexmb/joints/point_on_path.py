"""`PointOnPath`: a roller or slider follows a track that deforms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass

from flexmb.constraints import OnPath, OnStrip
from flexmb.errors import ModelError, did_you_mean
from flexmb.model.kinds import Joint

__all__ = ["PointOnPath"]


@dataclass(frozen=True, eq=False)
class PointOnPath(Joint):
    """Keep marker b on the cubic spline through marker a and further ones, eq. (on-path): a track that deforms.

    The markers of the path may be stations of a floating body, places of a cable, a beam or a plate, or markers of
    rigid bodies, also of several. The spline passes through them wherever they are, so the track bends with its body,
    and the force of the roller reaches it at the markers near the roller, by the weights of the spline. Two equations
    without a further unknown: the place on the path is the one nearest to the point. Cost grows with the square of the
    number of markers; a curve that does not deform is `PointOnCurve`.

    With `normal`, only the distance along this axis of the path's markers is held, one equation: a roller on a rail,
    free across it. Two rollers one behind the other, and one at the edge with `normal`, make a carriage.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Marker a, where the path begins, and marker b, the point. Reactions are those on the body of marker b.
    through : sequence of str
        The path goes on through these markers, in this order: two or more. Knots of the spline are the distances as
        described.
    ends : "extend" or "error"
        Beyond the ends of the path: continue straight, or stop the simulation with an error.
    normal : "x", "y" or "z", optional
        Hold the point only along this axis of the markers of the path, which is across the path.
    """

    _: KW_ONLY
    through: Sequence[str]
    ends: str = "extend"
    normal: str | None = None

    def __post_init__(self):
        super().__post_init__()
        names = self.through
        if isinstance(names, str) or not isinstance(names, Sequence) or not all(isinstance(n, str) for n in names):
            raise ModelError(
                self.title,
                found=f"through = {names!r:.80}",
                expected="names of markers",
                remedy='Write through=("rail.n1", "rail.n2")',
            )
        object.__setattr__(self, "through", tuple(names))
        if len(self.through) < 2:
            raise ModelError(
                self.title,
                found=f"a path through {1 + len(self.through)} markers",
                expected="three or more",
                remedy="Name two or more markers behind the first one in through",
            )
        if len({self.markers[0], *self.through}) < 1 + len(self.through):
            twice = next(n for k, n in enumerate(self.through) if n in (self.markers[0], *self.through[:k]))
            raise ModelError(
                self.title,
                found=f"the path meets marker '{twice}' twice",
                expected="every marker once",
                remedy="Name each marker of the path once, in the order along it",
            )
        for field, allowed, default in (("ends", ("extend", "error"), "extend"), ("normal", (None, "x", "y", "z"), "")):
            value = getattr(self, field)
            if value not in allowed:
                raise ModelError(
                    self.title,
                    found=f"{field} = {value!r}",
                    expected=" or ".join(repr(a) for a in allowed if a),
                    remedy=did_you_mean(str(value), [a for a in allowed if a])
                    or f"Leave {field} out{f' for {default!r}' if default else ''}",
                )

    def check(self, model) -> None:
        """Raise ModelError if a marker does not exist, the point is on a body of the path, or markers coincide."""
        super().check(model)
        point, _ = model.marker(self.markers[1], self.title)
        for name in self.through:
            body, _ = model.marker(name, self.title)
            if body.name == point.name:
                raise ModelError(
                    self.title,
                    found=f"point '{self.markers[1]}' and path marker '{name}' on body '{point.name}'",
                    expected="a point on a body that does not carry the path",
                    remedy="Joints act between different bodies",
                )

    def resolved(self, positions):
        """Return the joint; ModelError where two neighbouring markers of the path are at one place, m, in W."""
        path = (self.markers[0], *self.through)
        for k in range(1, len(path)):
            one, two = positions[0 if k == 1 else k], positions[k + 1]
            if float(sum((two - one) ** 2)) == 0.0:
                raise ModelError(
                    self.title,
                    found=f"markers '{path[k - 1]}' and '{path[k]}' of the path are at the same place",
                    expected="neighbours at a distance",
                    remedy="Leave one out, or correct its position",
                )
        return self

    def resolved_markers(self, model) -> tuple[str, ...]:
        """Return marker a, marker b, and the others of the path."""
        return (*self.markers, *self.through)

    def equations(self):
        """Return two equations, or the one along the normal."""
        strict = self.ends == "error"
        if self.normal is None:
            return (OnPath(strict, self.name),)
        return (OnStrip(strict, self.name, "xyz".index(self.normal)),)
