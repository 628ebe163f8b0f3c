"""`Orbit`: the origin of W falls along an ellipse about a centre, so that coordinates stay as small as a spacecraft."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import Described, is_number
from flexmb.model.pose import vector3

__all__ = ["Orbit", "check_origin", "elements_of", "require_orbit"]

EARTH = 3.986004418e14
RADIUS = 6378137.0
TITLE = "Orbit"
ROWS, SUBSTEPS = 240, 80
"""Rows of the table for a turn at the speed of the pericentre, and steps between two: 1e-8 m and 1e-6 m in a turn."""
MOST = 2_000_000
"""Rows of the longest table."""


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
        Gravitational constant times the mass of the centre; by default the Earth's.
    j2 : float, -
        Flattening of the centre that the origin feels, 1.0826267e-3 for the Earth; 0: it follows an ellipse. Every
        body then needs an `OblateGravity` too, and gets the difference to what the origin feels.
    radius : float, m
        Equatorial radius that belongs to j2; by default the Earth's.
    axis : (3,)
        Axis of the flattened centre, in W.
    turns : float, -
        For how long the motion about a flattened centre is computed, in periods of the ellipse at the start.

    Source: Vallado 2013, algorithms 2, 9 and 10.
    """

    place: Any
    velocity: Any
    mu: float = EARTH
    j2: float = 0.0
    radius: float = RADIUS
    axis: Any = (0.0, 0.0, 1.0)
    turns: float = 20.0

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
        self._check_flattening()
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
        if self.j2 and not self.span / self.spacing <= MOST:
            raise ModelError(
                TITLE,
                found=f"turns = {self.turns:g}: a table of {self.span / self.spacing:.3g} rows",
                expected=f"at most {MOST} rows; a turn of this orbit takes {self.period / self.spacing:.0f}",
                remedy=f"Give turns={0.99 * MOST * self.spacing / self.period:.4g} or fewer",
            )

    def _check_flattening(self) -> None:
        object.__setattr__(self, "axis", vector3(self.axis, TITLE, "axis"))
        for name, least in (("j2", 0.0), ("radius", 1e-300), ("turns", 1e-300)):
            value = getattr(self, name)
            if not is_number(value) or not value >= least:
                raise ModelError(
                    TITLE,
                    found=f"{name} = {value!r}",
                    expected="a number " + (">= 0" if least == 0.0 else "> 0"),
                    remedy=f"Leave {name} out",
                )
        if not any(self.axis):
            raise ModelError(TITLE, found="an axis without length", expected="a direction", remedy="Leave axis out")

    @classmethod
    def circular(
        cls,
        radius: float,
        *,
        inclination: float = 0.0,
        node: float = 0.0,
        argument: float = 0.0,
        mu: float = EARTH,
        **flattening: Any,
    ) -> Orbit:
        """Return a circle of a `radius` (m): `inclination`, `node` and `argument` of the start from it are in rad.

        Without angles it lies in the plane x-y, and begins on the x-axis towards y. Further fields are those of a
        flattened centre, about which it begins like a circle.
        """
        for name, value in (("radius", radius), ("mu", mu)):
            if not is_number(value) or not value > 0.0:
                raise ModelError(TITLE, found=f"{name} = {value!r}", expected="a number > 0", remedy=f"Give {name}")
        ci, si, cn, sn = np.cos(inclination), np.sin(inclination), np.cos(node), np.sin(node)
        along, across = np.array((cn, sn, 0.0)), np.array((-ci * sn, ci * cn, si))
        c, s = np.cos(argument), np.sin(argument)
        return cls(radius * (c * along + s * across), np.sqrt(mu / radius) * (c * across - s * along), mu, **flattening)

    def __repr__(self):
        flat = f", J2 = {self.j2:.6g}" if self.j2 else ""
        return f"Orbit(a = {self.semi_major_axis:.6g} m, e = {self.ellipse['eccentricity']:.3g}{flat})"

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
        """Duration of one turn, s; about a flattened centre, of the ellipse at the start."""
        return 2.0 * np.pi / self.ellipse["motion"]

    @cached_property
    def ellipse(self) -> dict[str, Any]:
        """What of `flexmb.math.kepler.ELEMENTS` describes the ellipse at the start."""
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

    @property
    def strength(self) -> float:
        """What its flattening attracts with, mu J2 R^2 / 2, m5/s2."""
        return 0.5 * self.mu * self.j2 * self.radius**2

    @property
    def span(self) -> float:
        """Until when the motion is known, s."""
        return self.turns * self.period if self.j2 else np.inf

    @cached_property
    def spacing(self) -> float:
        """Time between two rows of the table, s."""
        e = self.ellipse["eccentricity"]
        return self.period * (1.0 - e * e) ** 1.5 / (1.0 + e) ** 2 / ROWS

    @cached_property
    def table(self) -> np.ndarray:
        """Rows of `flexmb.math.kepler.KNOT` numbers, (nr, 9); none of an ellipse."""
        from flexmb.math.kepler import KNOT, tabulate_orbit

        table = np.zeros((int(np.ceil(self.span / self.spacing)) + 2 if self.j2 else 0, KNOT))
        if self.j2:
            table[0, :6] = *self.place, *self.velocity
            axis = np.array(self.axis) / np.linalg.norm(self.axis)
            tabulate_orbit(self.mu, axis, self.strength, self.spacing, SUBSTEPS, table)
        return table

    @property
    def elements(self) -> dict[str, Any]:
        """Fields of `flexmb.math.kepler.ELEMENTS`; the table begins at zero."""
        own = {"knots": len(self.table), "table": 0, "spacing": self.spacing, "strength": self.strength}
        return {**self.ellipse, **own}

    def require(self, t: float) -> None:
        """Raise ModelError unless the motion is known at a time, s."""
        if self.j2 and t < 0.0:
            raise ModelError(
                TITLE,
                found=f"t = {t:.6g} s, and the motion about a flattened centre is computed from t = 0 on",
                expected="times that are not negative",
                remedy="Give place and velocity at the earliest time, and let that be t = 0",
            )
        if t > self.span * (1.0 + 1e-9):
            raise ModelError(
                TITLE,
                found=f"t = {t:.6g} s, and the motion about a flattened centre is computed until {self.span:.6g} s",
                expected=f"times of at most {self.turns:g} turns of {self.period:.6g} s",
                remedy=f"Give the orbit turns={1.01 * t / self.period:.4g}",
            )

    def at(self, t) -> tuple[np.ndarray, np.ndarray]:
        """Return place (m) and velocity (m/s) of the origin of W from the centre at times `t` (nt,): both (nt, 3)."""
        from flexmb.math.kepler import ELEMENTS, follow_orbit

        times = np.atleast_1d(np.asarray(t, float))
        for end in (np.min(times, initial=0.0), np.max(times, initial=0.0)):
            self.require(float(end))
        r, v = np.empty((len(times), 3)), np.empty((len(times), 3))
        row, data = np.zeros(1, ELEMENTS), self.table.ravel()
        for name, value in self.elements.items():
            row[name] = value
        for k, time in enumerate(times):
            follow_orbit(time, row[0], data, r[k], v[k])
        return (r[0], v[0]) if np.ndim(t) == 0 else (r, v)


RESTING = {
    "follows": 0,
    "motion": 0.0,
    "eccentricity": 0.0,
    "anomaly": 0.0,
    "major": np.zeros(3),
    "minor": np.zeros(3),
    "knots": 0,
    "table": 0,
    "spacing": 0.0,
    "strength": 0.0,
}
"""Elements of an origin that is the centre itself."""


def elements_of(compiler) -> dict[str, Any]:
    """Return the fields of `flexmb.math.kepler.ELEMENTS` for the origin of a model that is compiled."""
    orbit = compiler.model.origin
    if orbit is None:
        return RESTING
    return {**orbit.elements, "table": compiler.bulk(orbit.table)} if len(orbit.table) else orbit.elements


def require_orbit(model, t: float) -> None:
    """Raise ModelError unless the motion of the origin, if it moves, is known at a time, s."""
    if model.origin is not None:
        model.origin.require(t)


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
    attracted = _one_of_each(model, "attracts")
    if orbit.j2:
        _check_flattened(model, _one_of_each(model, "flattens"))
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


def _one_of_each(model, what: str) -> dict[str, Any]:
    """Return the forces of a kind by the names of their bodies; ModelError if a body has two."""
    found: dict[str, Any] = {}
    for force in (force for force in model.forces if getattr(force, what)):
        if force.body in found:
            raise ModelError(
                force.title,
                found=f"body '{force.body}' is attracted by {found[force.body].title} already",
                expected="one attraction for each body: the origin falls only once",
                remedy="Leave one of them out; ThirdBody is for other centres, OblateGravity for what J2 adds",
            )
        found[force.body] = force
    return found


def _check_flattened(model, flattened: dict[str, Any]) -> None:
    """Raise ModelError unless every body feels the flattening that the origin feels."""
    orbit = model.origin
    for force in flattened.values():
        axis = model.marker(force.source, force.title)[1].matrix[:, 2]
        own, given = (force.mu, force.j2, force.radius), (orbit.mu, orbit.j2, orbit.radius)
        turned = np.linalg.norm(np.cross(axis, orbit.axis)) > 1e-12 * np.linalg.norm(orbit.axis)
        if own != given or turned:
            raise ModelError(
                force.title,
                found=f"mu, J2 and radius {own}, axis {tuple(axis)}, and the origin falls with {given}, {orbit.axis}",
                expected="one flattened centre for all",
                remedy="Give both the same numbers",
            )
    for body in model.bodies:
        if body.n_velocities and body.name not in flattened:
            raise ModelError(
                body.title,
                found=f"no flattening, in a model whose origin feels J2 = {orbit.j2:g}",
                expected="an OblateGravity for every body: axes that fall are no inertial ones",
                remedy=f"Add flexmb.OblateGravity('J2 on {body.name}', body='{body.name}'), with the orbit's numbers, "
                "or leave j2 out of the orbit",
            )
