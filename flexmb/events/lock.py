"""`Lock`: a joint jams where it is."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flexmb.constraints import Slide, Turn
from flexmb.errors import ModelError
from flexmb.events.event import Action
from flexmb.joints import Drive, Fixed
from flexmb.model.pose import Pose

__all__ = ["Lock"]


@dataclass(frozen=True)
class Lock(Action):
    """Hold a joint at its present position; a drive of the joint stops acting.

    Parameters
    ----------
    joint : str
        A joint that turns or slides about z is held there; any other is fixed, if one of its bodies is rigid or ground.
    """

    joint: str

    def check(self, model, asker: str) -> None:
        """Raise ModelError if the joint does not exist, or cannot be held."""
        joint = model.joint(self.joint, asker)
        if not set(joint.permits) <= {Turn("z"), Slide("z")} and self._side(model, joint) is None:
            raise ModelError(asker, found=f"joint '{joint.name}' ({type(joint).__name__}) joins two flexible bodies",
                             expected="a joint that turns or slides about z, or one on a rigid body or the ground",
                             remedy="Lock another joint")

    @staticmethod
    def _side(model, joint) -> int | None:
        for side, name in enumerate(joint.resolved_markers(model)):
            if hasattr(model.body(name.partition(".")[0]), "markers") and isinstance(
                    model.body(name.partition(".")[0]).markers, dict):
                return side
        return None

    def apply(self, model, series):
        """Return the model with the joint held."""
        joint = model.joint(self.joint)
        names = joint.resolved_markers(model)
        kept = tuple(j for j in model.joints if not (j.prescribes and getattr(j, "joint", "") == joint.name))
        a, b = (series.marker(name) for name in names)
        R_a, R_b, d = a.R[-1], b.R[-1], b.r[-1] - a.r[-1]
        if set(joint.permits) <= {Turn("z"), Slide("z")}:
            added = []
            if Turn("z") in joint.permits:
                angle = float(np.arctan2(R_a[:, 1] @ R_b[:, 0], R_a[:, 0] @ R_b[:, 0]))
                added.append(Drive(f"{joint.name} locked turn", joint=joint.name, angle=angle))
            if Slide("z") in joint.permits:
                added.append(Drive(f"{joint.name} locked slide", joint=joint.name, displacement=float(R_a[:, 2] @ d)))
            return replace(model, joints=(*kept, *added))
        side = self._side(model, joint)
        here, other = (a, b) if side == 0 else (b, a)
        body, marker = names[side].split(".")
        pose = model.body(body).marker_poses()[marker]
        relative = here.R[-1].T
        at = np.array(pose.at) + pose.matrix @ relative @ (other.r[-1] - here.r[-1])
        held_pose = Pose(tuple(at), pose.matrix @ relative @ other.R[-1])
        held = {**model.body(body).markers, f"{joint.name}_locked": held_pose}
        bodies = tuple(p.replaced(markers=held) if p.name == body else p for p in model.bodies)
        ends = (f"{body}.{joint.name}_locked", names[1 - side])
        fixed = Fixed(joint.name, markers=ends if side == 0 else ends[::-1])
        return replace(model, bodies=bodies, joints=tuple(fixed if j.name == joint.name else j for j in kept))
