"""`Orbit`: the origin of W falls along an ellipse about a centre, so that coordinates stay as small as a spacecraft."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import Described, is_number
from flexmb.model.pose import vector3

__all__ = ["Orbit", "check_origin", "elements_of"]

EARTH = 3.986004418e14
TITLE = "Orbit"


@dataclass(frozen=True, eq=False)
class Orbit(metaclass=Described):
    """The motion of the origin of W about the centre of attraction; the axes of W do not turn.

    Parameters
    ----------
    place : (3,), m
        The origin of W from the centre at t = 0.
    velocity : (3,), m/s
        Its velocity then.
    mu : float, N m2/kg
        Gravitational constant times the mass of the centre; by default that of the Earth.

    Source: Vallado 2013, algorithms 2, 9 and 10.
    """

    place: Any
    velocity: Any
    mu: float = EARTH

    def __post_init__(self):
        for name in ("place", "velocity"):
            object.__setattr__(self, name, vector3(getattr(self, name), TITLE, name))
        if not is_number(self.mu) or not self.mu > 0.0:
            raise ModelError(
                TITLE,
                found=f"mu = {self.mu!r}",
                expected="a number > 0, N m2/kg",
                remedy="Leave it out for the Earth",
            )
        r, v = np.array(self.place), np.array(self.velocity)
        far, turning = float(np.linalg.norm(r)), float(np.linalg.norm(np.cross(r, v)))
        if turning <= 1e-6 * far * max(float(np.linalg.norm(v)), (self.mu / far) ** 0.5 if far else 1.0):
            raise ModelError(
                TITLE,
                found=f"place {self.place} m and velocity {self.velocity} m/s along one line",
                expected="a motion around the centre",
                remedy="Give the velocity across the place; fmb.Orbit.circular(radius) makes a circle",
            )
        if not float(v @ v) < 2.0 * self.mu / far * (1.0 - 1e-6):
            raise ModelError(
                TITLE,
                found=f"{np.linalg.norm(v):.6g} m/s at {far:.6g} m from the centre",
                expected=f"less than the speed of escape, {np.sqrt(2.0 * self.mu / far):.6g} m/s",
                remedy="Give the orbit of a body that stays near the centre",
            )

    @classmethod
    def circular(
        cls, radius: float, *, inclination: float = 0.0, node: float = 0.0, argument: float = 0.0, mu: float = EARTH
    ) -> Orbit:
        """Return a circle of a `radius` (m): `inclination`, `node` and `argument` of the start from it are in rad.

        Without angles it lies in the plane x-y, and begins on the x-axis towards y.
        """
        for name, value in (("radius", radius), ("mu", mu)):
            if not is_number(value) or not value > 0.0:
                raise ModelError(TITLE, found=f"{name} = {value!r}", expected="a number > 0", remedy=f"Give {name}")
        ci, si, cn, sn = np.cos(inclination), np.sin(inclination), np.cos(node), np.sin(node)
        along, across = np.array((cn, sn, 0.0)), np.array((-ci * sn, ci * cn, si))
        c, s = np.cos(argument), np.sin(argument)
        return cls(radius * (c * along + s * across), np.sqrt(mu / radius) * (c * across - s * along), mu)

    def __repr__(self):
        return f"Orbit(a = {self.semi_major_axis:.6g} m, e = {self.elements['eccentricity']:.3g})"

    def fields(self) -> dict[str, Any]:
        """Return the fields by name."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @property
    def semi_major_axis(self) -> float:
        """Half of the ellipse's long axis, m."""
        r, v = np.array(self.place), np.array(self.velocity)
        return float(1.0 / (2.0 / np.linalg.norm(r) - v @ v / self.mu))

    @property
    def period(self) -> float:
        """Duration of one turn, s."""
        return 2.0 * np.pi / self.elements["motion"]

    @cached_property
    def elements(self) -> dict[str, Any]:
        """Fields of `flexmb.math.kepler.ELEMENTS`."""
        r, v, mu, a = np.array(self.place), np.array(self.velocity), self.mu, self.semi_major_axis
        far, normal = np.linalg.norm(r), np.cross(r, v)
        to_pericentre = np.cross(v, normal) / mu - r / far
        e = float(np.linalg.norm(to_pericentre))
        # of a circle every point is the pericentre: the start is taken
        P = to_pericentre / e if e > 1e-11 else r / far
        e = e if e > 1e-11 else 0.0
        Q = np.cross(normal / np.linalg.norm(normal), P)
        b = a * np.sqrt((1.0 - e) * (1.0 + e))
        E = np.arctan2((r @ Q) / b, (r @ P) / a + e)
        motion = float(np.sqrt(mu / a) / a)
        anomaly = float(E - e * np.sin(E))
        return {
            "follows": 1,
            "motion": motion,
            "eccentricity": e,
            "anomaly": anomaly,
            "major": a * P,
            "minor": b * Q,
        }

    def at(self, t) -> tuple[np.ndarray, np.ndarray]:
        """Return place (m) and velocity (m/s) of the origin of W from the centre at times `t` (nt,): both (nt, 3)."""
        from flexmb.math.kepler import ELEMENTS, follow_orbit

        times = np.atleast_1d(np.asarray(t, float))
        r, v = np.empty((len(times), 3)), np.empty((len(times), 3))
        row = np.zeros(1, ELEMENTS)
        for name, value in self.elements.items():
            row[name] = value
        for k, time in enumerate(times):
            follow_orbit(time, row[0], r[k], v[k])
        return (r[0], v[0]) if np.ndim(t) == 0 else (r, v)


RESTING = {
    "follows": 0,
    "motion": 0.0,
    "eccentricity": 0.0,
    "anomaly": 0.0,
    "major": np.zeros(3),
    "minor": np.zeros(3),
}
"""Elements of an origin that is the centre itself."""


def elements_of(model) -> dict[str, Any]:
    """Return the fields of `flexmb.math.kepler.ELEMENTS` for the origin of a model."""
    return RESTING if model.origin is None else model.origin.elements


def check_origin(model) -> None:
    """Raise ModelError unless everything in a model whose origin falls along an orbit falls in the same field."""
    orbit, title = model.origin, f"Model '{model.name}'"
    if orbit is None:
        return
    if not isinstance(orbit, Orbit):
        raise ModelError(
            title,
            found=f"origin = {orbit!r:.60}",
            expected="flexmb.Orbit(place, velocity)",
            remedy="Leave it out for an origin that rests",
        )
    if any(model.gravity):
        raise ModelError(
            title,
            found=f"gravity {model.gravity} m/s2 and an origin that falls along an orbit",
            expected="one of them",
            remedy="Leave gravity out: CentralGravity attracts each body",
        )
    attracted: dict[str, Any] = {}
    for force in (force for force in model.forces if force.attracts):
        if force.body in attracted:
            raise ModelError(
                force.title,
                found=f"body '{force.body}' is attracted by {attracted[force.body].title} already",
                expected="one attraction for each body: the origin falls only once",
                remedy="Leave one of them out; ThirdBody is for other centres, OblateGravity for what J2 adds",
            )
        attracted[force.body] = force
    for force in attracted.values():
        if force.mu != orbit.mu:
            raise ModelError(
                force.title,
                found=f"mu = {force.mu:.9g} N m2/kg, and origin falls with mu = {orbit.mu:.9g}",
                expected="one centre for all",
                remedy="Give both the same number",
            )
    for body in model.bodies:
        if body.n_velocities and body.name not in attracted:
            raise ModelError(
                body.title,
                found="no attraction, in a model whose origin falls along an orbit",
                expected="a CentralGravity for every body: axes that fall are no inertial ones",
                remedy=f"Add flexmb.CentralGravity('pull on {body.name}', body='{body.name}'"
                + ("" if orbit.mu == EARTH else f", mu={orbit.mu:.9g}")
                + ")",
            )
