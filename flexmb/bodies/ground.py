"""`Ground`: the inertial frame W with its markers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, ClassVar

import numpy as np

from flexmb.bodies.shape import checked_shapes
from flexmb.model.kinds import Body
from flexmb.model.pose import Pose, as_pose

__all__ = ["Ground"]


@dataclass(frozen=True, eq=False)
class Ground(Body):
    """The world frame W; its markers do not move.

    Parameters
    ----------
    markers : mapping of name to pose
        Positions (m) and orientations in W. The marker ``origin`` always exists.
    shape : shape or sequence of shapes, optional
        What is drawn of the surroundings: `Box`, `Tube`, `Extrusion`.
    """

    name: str = "ground"
    _: KW_ONLY
    markers: Mapping[str, Any] = field(default_factory=dict)
    shape: Any = ()

    drawn: ClassVar[str] = "supports"
    takes_markers: ClassVar[bool] = True
    has_frame: ClassVar[bool] = False

    def __post_init__(self):
        super().__post_init__()
        poses = {name: as_pose(pose, self.title, f"marker {name}") for name, pose in (self.markers or {}).items()}
        object.__setattr__(self, "markers", poses)
        object.__setattr__(self, "shape", checked_shapes(self))

    def marker_poses(self) -> dict[str, Pose]:
        """Return the markers by name, ``origin`` first."""
        return {"origin": Pose(), **self.markers}

    def initial_state(self):
        """Return empty arrays: the ground has no coordinates."""
        return np.empty(0), np.empty(0)
