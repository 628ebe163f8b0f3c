"""`Reaction` and `ForceOf`: force and moment that a joint or a force exerts on the body of its second marker."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.constraints.measured import Measured, in_axes
from flexmb.errors import ModelError
from flexmb.model.kinds import Sensor

__all__ = ["ForceOf", "Reaction"]

WRENCH = ("fx [N]", "fy [N]", "fz [N]", "mx [N m]", "my [N m]", "mz [N m]")


class _Wrench(Sensor):
    """What both sensors share: components in W, or in the axes of a marker."""

    axes: str | None

    def markers_read(self, model) -> tuple[str, ...]:
        """Return the marker whose axes the components refer to."""
        return () if self.axes is None else (self.axes,)

    def _turned(self, series, wrench: np.ndarray) -> np.ndarray:
        """Return force and moment (nt, 6) of W in the axes asked for."""
        if self.axes is None:
            return wrench
        R = series.marker(self.axes).R
        return np.einsum("tji,tkj->tki", R, wrench.reshape(-1, 2, 3)).reshape(-1, 6)


@dataclass(frozen=True, eq=False)
class Reaction(_Wrench):
    """Force and moment that a joint exerts on the body of its second marker, at that marker, in W, (nt, 6), N and N m.

    Zero in phases whose model has lost the joint.

    Parameters
    ----------
    name : str
    joint : str
        Name of the joint (or drive).
    axes : str, optional
        "body.marker" whose axes the components refer to: along a strut that turns, the first one is its axial force.
    """

    _: KW_ONLY
    joint: str
    axes: str | None = None

    titles: ClassVar[tuple[str, ...]] = WRENCH
    reads_reactions: ClassVar[bool] = True
    absent: ClassVar[float] = 0.0

    def check(self, model) -> None:
        """Raise ModelError if the joint or the marker does not exist."""
        model.joint(self.joint, self.title)
        if self.axes is not None:
            model.marker(self.axes, self.title)

    def measured(self, model) -> tuple[Any, ...]:
        """Return the six components, for what samples them."""
        marker = model.joint(self.joint, self.title).resolved_markers(model)[1]
        return in_axes(tuple(Measured("reaction", (marker,), k, part=self.joint) for k in range(6)), self.axes)

    def values(self, series) -> np.ndarray:
        """Return the wrench (nt, 6), N and N m, in W or in the axes asked for."""
        return self._turned(series, series.reaction(self.joint))


@dataclass(frozen=True, eq=False)
class ForceOf(_Wrench):
    """Force and moment that a force exerts on the body of its second (or only) marker, there, in W, (nt, 6), N, N m.

    Zero in phases whose model has lost the force.

    Parameters
    ----------
    name : str
    force : str
        Name of the force.
    axes : str, optional
        "body.marker" whose axes the components refer to.
    """

    _: KW_ONLY
    force: str
    axes: str | None = None

    titles: ClassVar[tuple[str, ...]] = WRENCH
    absent: ClassVar[float] = 0.0

    def check(self, model) -> None:
        """Raise ModelError if the force or the marker does not exist."""
        force = model.force(self.force, self.title)
        if hasattr(force, "spots") and force.measure(model) is None:
            several = hasattr(force, "pairs")
            raise ModelError(
                self.title,
                found=f"{force.title} acts on {'several second surfaces' if several else 'many markers of a skin'}",
                expected="one marker whose wrench is meant",
                remedy=("Divide the contact into one for each second surface, or use" if several else "Use")
                + " ContactState",
            )
        if self.axes is not None:
            model.marker(self.axes, self.title)

    def measured(self, model) -> tuple[Any, ...]:
        """Return the six components."""
        if model.force(self.force, self.title).measure(model) is None:
            raise ModelError(
                self.title,
                found=f"force '{self.force}', which acts on no marker of its own",
                expected="a force between markers, or on one",
                remedy="Measure the motion that it makes",
            )
        return in_axes(tuple(Measured("wrench", axis=k, part=self.force) for k in range(6)), self.axes)

    def values(self, series) -> np.ndarray:
        """Return the wrench (nt, 6), N and N m, in W or in the axes asked for."""
        return self._turned(series, series.force(self.force))
