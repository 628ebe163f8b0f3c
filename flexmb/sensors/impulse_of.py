"""`ImpulseOf`: what passes between two markers, or through a joint, in the impacts of events."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from flexmb.model.kinds import Sensor
from flexmb.model.part_names import marker_pair

__all__ = ["ImpulseOf"]


@dataclass(frozen=True, eq=False)
class ImpulseOf(Sensor):
    """Impulse of every `Impact` between two markers, (nt,), N s; or of a joint in these impacts, (nt, 6), N s, N m s.

    It stands at the sample of the impact, which is the last one before it; all other samples are zero. Their sum is
    what has passed in all. That of the impact acts on the body of the second marker, along the normal away from the
    first, and its opposite on the other; that of the joint on the body of its second marker, there, in W.

    Impulses of `MoreauJean` at rigid contacts last for a step: `ForceOf` shows them as forces.

    Parameters
    ----------
    name : str
    markers : (str, str)
        Of the impact, "body.marker", in either order.
    joint : str, optional
        Name of a joint whose impulses are meant.
    """

    markers: tuple[str, str]
    _: KW_ONLY
    joint: str | None = None

    known_later: ClassVar[str] = "an impact takes no time"
    absent: ClassVar[float] = 0.0

    def __post_init__(self):
        super().__post_init__()
        object.__setattr__(self, "markers", marker_pair(self.markers, self.title))

    def check(self, model) -> None:
        """Raise ModelError if a marker or the joint does not exist."""
        super().check(model)
        if self.joint is not None:
            model.joint(self.joint, self.title)

    def columns(self, model) -> tuple[str, ...]:
        """Return the titles with units."""
        if self.joint is None:
            return ("impulse [N s]",)
        return ("px [N s]", "py [N s]", "pz [N s]", "lx [N m s]", "ly [N m s]", "lz [N m s]")

    def markers_read(self, model) -> tuple[str, ...]:
        """Return the two markers."""
        return self.markers

    def values(self, series) -> np.ndarray:
        """Return the impulses (nt,), N s, or (nt, 6), N s and N m s."""
        out = np.zeros((len(series.t), 6))
        for action, impulse, joints in series.impacts:
            if set(action.markers) != set(self.markers):
                continue
            if self.joint is None:
                out[-1, 0] += impulse
            elif self.joint in joints:
                out[-1] += joints[self.joint]
        return out[:, 0] if self.joint is None else out
