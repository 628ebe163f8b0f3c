"""`Lock`: a joint jams where it is; `Unlock`: it comes free again."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flexmb.errors import ModelError
from flexmb.events.event import Action
from flexmb.events.release import without_dependents
from flexmb.joints import Drive, Fixed
from flexmb.model.pose import Pose
from flexmb.sensors import JointCoordinate

__all__ = ["Lock", "Unlock"]


def _drivable(joint) -> tuple[str, ...]:
    """Return the freedoms that drives hold the joint in, or nothing if it has others: then it is replaced."""
    words = tuple(freedom.word for freedom in joint.permits)
    return words if all(words) else ()


def _held_markers(names, series) -> tuple[str, str]:
    """Return the two markers that are held together: of a path through several, the one nearest to the point."""
    point = series.marker(names[1]).r[-1]
    path = (names[0], *names[2:])
    distances = [float(np.sum((series.marker(name).r[-1] - point) ** 2)) for name in path]
    return path[int(np.argmin(distances))], names[1]


def _drive_name(joint, word: str) -> str:
    return f"{joint.name} locked {word}"


@dataclass(frozen=True)
class Lock(Action):
    """Hold a joint at its present position, at once: its parts stop as in a plastic impact. Its drive stops acting.

    Parameters
    ----------
    joint : str
        A joint with turns and slides only is held by drives, "<joint> locked turn" and so on; any other becomes a Fixed
        one, if one of its bodies is rigid or ground: of a path, to the marker of the path that is nearest to the point.
        Drives of it go, with their sensors.
    """

    joint: str

    def check(self, model, asker: str) -> None:
        """Raise ModelError if the joint does not exist, or cannot be held."""
        joint = model.joint(self.joint, asker)
        if joint.prescribes or joint.couples:
            others = [joint.joint] if joint.prescribes else joint.joints
            remedy = " or ".join(f"Lock('{other}')" for other in others)
            raise ModelError(
                asker,
                found=f"Lock of '{joint.name}', which is a {type(joint).__name__}",
                expected="a joint that holds two bodies together",
                remedy=f"{remedy} holds the joint that it acts on",
            )
        if _drivable(joint):
            return
        if self._side(model, joint) is None:
            raise ModelError(
                asker,
                found=f"joint '{joint.name}' ({type(joint).__name__}) joins two flexible bodies",
                expected="a joint that only turns and slides, or one on a rigid body or the ground",
                remedy="Lock another joint",
            )
        fixed = Fixed(joint.name, markers=joint.resolved_markers(model)[:2])
        try:
            free = self._undriven(model)
            replace(free, events=(), joints=tuple(fixed if j.name == joint.name else j for j in free.joints))
        except ModelError as error:
            raise ModelError(
                asker,
                found=f"Lock makes '{joint.name}' ({type(joint).__name__}) a fixed joint, but "
                f"{error.part} needs a freedom of it",
                expected="forces and sensors that a fixed joint may have",
                remedy="Let them refer to markers instead, such as Distance or SpringDamper",
            ) from error

    def _undriven(self, model):
        """Return the model without the drives of the joint, and without what depends on them."""
        for drive in [j.name for j in model.joints if j.prescribes and j.joint == self.joint]:
            model = without_dependents(model, drive)
        return model

    @staticmethod
    def _side(model, joint) -> int | None:
        for side, name in enumerate(joint.resolved_markers(model)[:2]):
            if model.body(name.partition(".")[0]).takes_markers:
                return side
        return None

    def apply(self, model, series):
        """Return the model with the joint held."""
        joint = model.joint(self.joint)
        names = _held_markers(joint.resolved_markers(model), series)
        free, words = self._undriven(model), _drivable(joint)
        if words:
            added = []
            for word in words:
                at = float(JointCoordinate("held", joint=joint.name, freedom=word).values(series)[-1])
                motion = {"angle": at} if word.startswith("turn") else {"displacement": at}
                added.append(Drive(_drive_name(joint, word), joint=joint.name, freedom=word, **motion))
            return replace(free, joints=(*free.joints, *added))
        a, b = (series.marker(name) for name in names)
        side = self._side(model, joint)
        here, other = (a, b) if side == 0 else (b, a)
        body, marker = names[side].split(".")
        pose = model.body(body).marker_poses()[marker]
        relative = here.R[-1].T
        at = np.array(pose.at) + pose.matrix @ relative @ (other.r[-1] - here.r[-1])
        held_pose = Pose(tuple(at), pose.matrix @ relative @ other.R[-1])
        held = {**model.body(body).markers, f"{joint.name}_locked": held_pose}
        bodies = tuple(p.replaced(markers=held) if p.name == body else p for p in free.bodies)
        ends = (f"{body}.{joint.name}_locked", names[1 - side])
        fixed = Fixed(joint.name, markers=ends if side == 0 else ends[::-1])
        joints = tuple(fixed if j.name == joint.name else j for j in free.joints)
        return replace(free, bodies=bodies, joints=joints)


@dataclass(frozen=True)
class Unlock(Action):
    """Let a joint go that `Lock` holds: a brake, a latch, the dwell of a Geneva drive.

    Drives that acted on the joint before it was locked do not come back; a joint that is not locked stays as it is.

    Parameters
    ----------
    joint : str
        A joint with turns and slides only: Revolute, Prismatic, Cylindrical, Planar, Universal or Screw.
    """

    joint: str

    def check(self, model, asker: str) -> None:
        """Raise ModelError if the joint does not exist, or if a lock would not leave it in the model."""
        joint = model.joint(self.joint, asker)
        if not _drivable(joint):
            raise ModelError(
                asker,
                found=f"Unlock of '{joint.name}', which is a {type(joint).__name__}",
                expected="a joint with turns and slides only; others are replaced when they are locked",
                remedy="Lock a Revolute, Prismatic, Cylindrical, Planar, Universal or Screw joint",
            )

    def apply(self, model, series):
        """Return the model without what holds the joint; what depends on that goes with it."""
        joint = model.joint(self.joint)
        for name in (_drive_name(joint, word) for word in _drivable(joint)):
            if any(other.name == name for other in model.joints):
                model = without_dependents(model, name)
        return model
