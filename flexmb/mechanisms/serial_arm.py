"""`serial_arm`: a chain of rigid bodies on revolute and prismatic joints, from a Denavit-Hartenberg table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.bodies import Ground, RigidBody
from flexmb.errors import ModelError
from flexmb.joints import Prismatic, Revolute
from flexmb.model.model import Model
from flexmb.model.pose import Pose, as_pose

__all__ = ["ModifiedLink", "StandardLink", "serial_arm"]


def _turn(axis: int, angle: float) -> np.ndarray:
    T = np.eye(4)
    T[:3, :3] = Pose((0.0, 0.0, 0.0), tuple(angle if k == axis else 0.0 for k in range(3))).matrix
    return T


def _shift(axis: int, length: float) -> np.ndarray:
    T = np.eye(4)
    T[axis, 3] = length
    return T


@dataclass(frozen=True, kw_only=True)
class _Link:
    """One row of the table; see the two conventions below."""

    mass: float
    inertia: Any
    a: float = 0.0
    alpha: float = 0.0
    d: float = 0.0
    theta: float = 0.0
    slides: bool = False
    center_of_mass: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self):
        for name in ("a", "alpha", "d", "theta"):
            value = getattr(self, name)
            if not isinstance(value, int | float | np.number) or not np.isfinite(value):
                raise ModelError(
                    type(self).__name__,
                    found=f"{name} = {value!r}",
                    expected="a number, m or rad",
                    remedy=f"Give {name} of the table; angles in rad",
                )

    @property
    def _along(self) -> tuple[np.ndarray, np.ndarray]:
        """Return what of the motion along and about z lies before and after the joint."""
        turn, shift = _turn(2, self.theta), _shift(2, self.d)
        return (turn, shift) if self.slides else (np.eye(4), turn @ shift)

    def around_joint(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the poses (4, 4) from the frame before to the joint, and from the joint to the frame of the link."""
        raise TypeError(f"{type(self).__name__} is not one of the two conventions")


@dataclass(frozen=True, kw_only=True)
class StandardLink(_Link):
    """A link in the convention of Denavit & Hartenberg 1955 (Paul 1981): ``R_z(theta) T_z(d) T_x(a) R_x(alpha)``.

    Parameters
    ----------
    a, alpha : float, m and rad
        Length and twist of the link, from the axis of its joint to the next.
    d, theta : float, m and rad
        Offset along and angle about z; the joint coordinate adds to theta, or to d if it slides.
    slides : bool
        Is the joint prismatic?
    mass, center_of_mass, inertia : kg, (3,) m, (3,) or (3, 3) kg m2
        In the axes of the link's frame; the inertia about the centre of mass.
    """

    def around_joint(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the poses (4, 4) from the frame before to the joint, and from the joint to the frame of the link."""
        before, after = self._along
        return before, after @ _shift(0, self.a) @ _turn(0, self.alpha)


@dataclass(frozen=True, kw_only=True)
class ModifiedLink(_Link):
    """A link in the convention of Craig 1986: ``R_x(alpha) T_x(a) R_z(theta) T_z(d)``.

    Parameters
    ----------
    a, alpha : float, m and rad
        Length and twist of the previous link, from its axis to the axis of this joint.
    d, theta, slides, mass, center_of_mass, inertia
        As in `StandardLink`.
    """

    def around_joint(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the poses (4, 4) from the frame before to the joint, and from the joint to the frame of the link."""
        before, after = self._along
        return _turn(0, self.alpha) @ _shift(0, self.a) @ before, after


def _pose(T: np.ndarray) -> Pose:
    return Pose(tuple(T[:3, 3]), T[:3, :3])


def serial_arm(
    links: Sequence[StandardLink | ModifiedLink],
    *,
    gravity=(0.0, 0.0, -9.81),
    base: Any = (0.0, 0.0, 0.0),
    tool: Any = (0.0, 0.0, 0.0),
    name: str = "arm",
) -> Model:
    """Return a chain of rigid bodies, drawn with all joint coordinates zero.

    Bodies are "link_1", "link_2", ... with the frames of the table, joints "joint_1", ...; marker "base" of the ground
    and marker "tool" of the last link are the ends of the chain. The joint coordinates of the table are the coordinates
    of `JointTree`, in order.

    Parameters
    ----------
    links : sequence of StandardLink or ModifiedLink
    gravity : (3,), m/s2, in W
    base : pose
        Of the table's frame 0, in W.
    tool : pose
        In the frame of the last link.
    name : str

    Raises
    ------
    ModelError
        If there is no link, or something else stands among them.

    Examples
    --------
    >>> arm = fmb.serial_arm([fmb.StandardLink(a=0.5, mass=1.0, inertia=(1, 1, 1)) for _ in range(2)])
    >>> fmb.JointTree(arm).pose("link_2.tool", [0.0, np.pi / 2])[0].round(6).tolist()
    [0.5, 0.5, 0.0]
    """
    rows = tuple(links)
    if not rows or not all(isinstance(link, _Link) for link in rows):
        raise ModelError(
            "serial_arm",
            found=f"links = {links!r}",
            expected="at least one StandardLink or ModifiedLink",
            remedy="Write one link for each row of the table",
        )
    around = [link.around_joint() for link in rows]
    seats = [_pose(before) for before, _ in around] + [as_pose(tool, "serial_arm", "tool")]
    start = as_pose(base, "serial_arm", "base")
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = start.matrix, start.at
    bodies: list[Any] = [Ground(markers={"base": start, "out": _pose(T @ around[0][0])})]
    joints: list[Any] = []
    for k, (link, (before, after)) in enumerate(zip(rows, around, strict=True), 1):
        T = T @ before @ after
        last = "tool" if k == len(rows) else "out"
        bodies.append(
            RigidBody(
                f"link_{k}",
                mass=link.mass,
                inertia=link.inertia,
                center_of_mass=link.center_of_mass,
                at=tuple(T[:3, 3]),
                rotation=T[:3, :3],
                markers={"in": _pose(np.linalg.inv(after)), last: seats[k]},
            )
        )
        kind = Prismatic if link.slides else Revolute
        joints.append(kind(f"joint_{k}", markers=(f"{bodies[k - 1].name}.out", f"link_{k}.in")))
    return Model(name=name, gravity=gravity, bodies=tuple(bodies), joints=tuple(joints))
