"""`Model`: the frozen description of a mechanism."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from flexmb.errors import ModelError, did_you_mean, listed
from flexmb.model.assembly import joined, placed
from flexmb.model.described import Described, check_mapping, entries_of
from flexmb.model.orbit import Orbit, check_origin
from flexmb.model.part import Part
from flexmb.model.part_names import check_names, find_part
from flexmb.model.pose import vector3

__all__ = ["Model"]

GROUND = "ground"
LISTS = {
    "bodies": "Body",
    "surfaces": "Surface",
    "joints": "Joint",
    "forces": "Force",
    "sensors": "Sensor",
    "events": "Event",
}
"""What the lists of a model hold, by the family of their parts."""
FAMILIES = tuple(LISTS)


def _check_place(part, family: str, title: str) -> None:
    """Raise ModelError unless a part belongs into a list of the model."""
    if not isinstance(part, Part):
        raise ModelError(
            title,
            found=f"{family} holds {part!r:.60}",
            expected="parts such as flexmb.RigidBody(...)",
            remedy="Put the parts themselves into the list",
        )
    if part.family != LISTS[family]:
        right = next((name for name, held in LISTS.items() if held == part.family), "")
        raise ModelError(
            title,
            found=f"{family} holds {part.title}, a {type(part).__name__}",
            expected=f"parts of the kind {LISTS[family]}",
            remedy=f"Put it into {right}=[...]" if right else "Give a part that flexmb exports",
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Model(metaclass=Described):
    """A mechanism: bodies, surfaces, joints, forces, sensors and events, all frozen.

    Parameters
    ----------
    bodies, surfaces, joints, forces, sensors, events : sequences of parts
        Names are unique within each family. The model should have one `Ground`, named "ground".
    gravity : (3,), m/s2, in W
        Acceleration of free fall; none unless given.
    origin : Orbit, optional
        The origin of W falls along this orbit about a centre: places and velocities are relative to it, and remain as
        small as the spacecraft. Every body then needs a `CentralGravity`.
    name : str
        Used in messages, reports and file names.

    Raises
    ------
    ModelError
        For a name used twice, or a part that refers to something that does not exist.
    """

    bodies: tuple[Any, ...] = ()
    joints: tuple[Any, ...] = ()
    forces: tuple[Any, ...] = ()
    sensors: tuple[Any, ...] = ()
    events: tuple[Any, ...] = ()
    surfaces: tuple[Any, ...] = ()
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    origin: Orbit | None = None
    name: str = "model"
    parameters: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self):
        title = f"Model '{self.name}'"
        check_mapping(self.parameters, title, "parameters", '{"length": 0.5}')
        object.__setattr__(self, "gravity", vector3(self.gravity, title, "gravity", "(0.0, 0.0, -9.81)"))
        for family in FAMILIES:
            given = getattr(self, family)
            given = entries_of(given) if isinstance(given, np.ndarray) else given
            if isinstance(given, str | Part) or not isinstance(given, Iterable):
                raise ModelError(
                    title, found=f"{family} = {given!r:.60}", expected="a list of parts", remedy=f"Write {family}=[...]"
                )
            parts = tuple(given)
            object.__setattr__(self, family, parts)
            for part in parts:
                _check_place(part, family, title)
            check_names(parts, LISTS[family])
        self._check_ground()
        for family in FAMILIES[1:]:
            for part in getattr(self, family):
                part.check(self)
        check_origin(self)

    def _check_ground(self) -> None:
        """Raise ModelError unless "ground" names the one body that cannot move."""
        for body in self.bodies:
            if body.n_velocities == 0 and body.name != GROUND:
                raise ModelError(
                    body.title,
                    found=f"a ground called '{body.name}'",
                    expected=f"one Ground, which is called '{GROUND}'",
                    remedy="Leave its name out, and put the markers of all grounds into one Ground(markers=...)",
                )
            if body.n_velocities and body.name == GROUND:
                raise ModelError(
                    body.title,
                    found=f"a {type(body).__name__} called '{GROUND}'",
                    expected="another name: this one belongs to the world frame",
                    remedy="Rename the body; a body that cannot move is fmb.Ground",
                )

    def __repr__(self):
        counts = ", ".join(f"{len(getattr(self, family))} {family}" for family in FAMILIES if getattr(self, family))
        return f"Model('{self.name}': {counts})"

    @cached_property
    def _by_name(self) -> dict[str, dict[str, Any]]:
        """Parts by name in each family: looked up many times while a long model is compiled."""
        return {family: {part.name: part for part in getattr(self, family)} for family in FAMILIES}

    @cached_property
    def _poses(self) -> dict[str, dict[str, Any]]:
        """Poses of the markers of each body that was asked for: a skin has hundreds, and asks for each of them."""
        return {}

    @property
    def sensors_by_name(self) -> Mapping[str, Any]:
        """The sensors by name."""
        return self._by_name["sensors"]

    @cached_property
    def turn_drives(self) -> dict[tuple[str, ...], list[Any]]:
        """Joints that prescribe an angle, by the markers between which they do."""
        found: dict[tuple[str, ...], list[Any]] = {}
        for joint in self.joints:
            if getattr(joint, "angle", None) is not None:
                found.setdefault(tuple(joint.resolved_markers(self)), []).append(joint)
        return found

    def body(self, name: str, asker: str = "Model"):
        """Return the body of this name."""
        return find_part(name, self._by_name["bodies"], asker, "body")

    def joint(self, name: str, asker: str = "Model"):
        """Return the joint of this name."""
        return find_part(name, self._by_name["joints"], asker, "joint")

    def surface(self, name: str, asker: str = "Model"):
        """Return the surface of this name."""
        return find_part(name, self._by_name["surfaces"], asker, "surface")

    def force(self, name: str, asker: str = "Model"):
        """Return the force of this name."""
        return find_part(name, self._by_name["forces"], asker, "force")

    def marker(self, name: str, asker: str = "Model"):
        """Return (body, marker pose) of "body.marker"; ModelError with the known markers of that body otherwise."""
        body_name, dot, marker = str(name).partition(".")
        bodies = self._by_name["bodies"]
        if not dot:
            own = [f"'{name}.{marker}'" for marker in bodies[name].marker_poses()] if name in bodies else []
            raise ModelError(
                asker,
                found=f"marker '{name}' names a body without its marker" if own else f"marker '{name}' names no body",
                expected="'body.marker'",
                remedy=f"Write {' or '.join(own[:3])}"
                if own
                else did_you_mean(name, self.marker_names()) or "Write it as 'body.marker'",
            )
        if body_name not in bodies:
            raise ModelError(
                asker,
                found=f"marker '{name}': body '{body_name}' does not exist",
                expected=f"The model has: {listed(body_name, sorted(bodies))}",
                remedy=did_you_mean(body_name, bodies) or "Correct the name",
            )
        if body_name not in self._poses:
            self._poses[body_name] = bodies[body_name].marker_poses()
        poses = self._poses[body_name]
        if marker not in poses:
            near = did_you_mean(marker, poses)
            remedy = near.replace("'" + near.split("'")[1], f"'{body_name}." + near.split("'")[1], 1) if near else ""
            raise ModelError(
                asker,
                found=f"marker '{name}' does not exist",
                expected=f"Body '{body_name}' has: {', '.join(poses) or 'no markers'}",
                remedy=remedy or f"Add the marker to body '{body_name}'",
            )
        return bodies[body_name], poses[marker]

    def marker_names(self) -> list[str]:
        """Return all marker names as "body.marker"."""
        return [f"{b.name}.{m}" for b in self.bodies for m in b.marker_poses()]

    def without(self, *names: str) -> Model:
        """Return the model without the named bodies, surfaces, joints, forces, sensors or events."""
        every = {p.name for family in FAMILIES for p in getattr(self, family)}
        for name in names:
            if name not in every:
                raise ModelError(
                    f"Model '{self.name}'",
                    found=f"there is no part '{name}' to leave out",
                    expected=f"One of: {listed(name, sorted(every))}",
                    remedy=did_you_mean(name, every),
                )
        kept: dict[str, Any] = {f: tuple(p for p in getattr(self, f) if p.name not in names) for f in FAMILIES}
        try:
            return replace(self, **kept)
        except ModelError as error:  # the whole model had none
            raise ModelError(
                error.part,
                found=error.found,
                expected=error.expected,
                remedy=f"It names what is left out ({', '.join(names)}): leave it out as well, or change it before",
            ) from None

    def with_parts(self, **parts: Iterable[Any]) -> Model:
        """Return the model with parts added: ``model.with_parts(forces=[...], sensors=[...])``."""
        longer: dict[str, Any] = {family: (*getattr(self, family), *added) for family, added in parts.items()}
        return replace(self, **longer)

    def changed(self, part: str, **values: Any) -> Model:
        """Return the model with fields of one part replaced: ``model.changed("crank", mass=2.0)``."""
        for family in FAMILIES:
            old = getattr(self, family)
            if any(p.name == part for p in old):
                new: dict[str, Any] = {family: tuple(p.replaced(**values) if p.name == part else p for p in old)}
                return replace(self, **new)
        every = [p.name for family in FAMILIES for p in getattr(self, family)]
        raise ModelError(
            f"Model '{self.name}'",
            found=f"there is no part '{part}' to change",
            expected=f"One of: {listed(part, sorted(every))}",
            remedy=did_you_mean(part, every),
        )

    def placed(self, prefix: str, *, at=(0.0, 0.0, 0.0), rotation: Any = None) -> Model:
        """Return the model with ``prefix_`` before every name, moved by `at` (m) and turned by `rotation` in W.

        Ground markers become "ground.prefix_name"; "ground.prefix_origin" is the placement.
        """
        return placed(self, prefix, at=at, rotation=rotation)

    def __add__(self, other: Model) -> Model:
        """Return the parts of both as one model, with one ground; name and gravity come from the first."""
        return joined(self, other) if isinstance(other, Model) else NotImplemented
