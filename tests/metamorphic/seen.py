"""Ways to look at one mechanism: other units, another place, a mirror, other axes of bodies, other names and orders."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

MIRROR = np.diag((1.0, 1.0, -1.0))


@dataclass(frozen=True, kw_only=True, eq=False)
class Seen:
    """How a mechanism is written down; quantities of mechanics become numbers, and numbers of results quantities again.

    Parameters
    ----------
    length, mass, time : float
        Size of one metre, kilogram and second in the units of the description.
    R, d : (3, 3), (3,) m
        Turn and displacement of the whole, after the reflection.
    mirror : bool
        Reflected at the x-y plane of W. Axes of bodies and markers are reflected on both sides, so that they stay
        right-handed; turns about a marker's z keep their sign, slides along it change it.
    C, c : (3, 3), (3,) m
        Other axes and origin in every rigid body.
    prefix : str
        Before every name.
    order : random generator, optional
        Shuffles parts of a family.
    t : float, s
        When the motion begins.
    """

    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0
    R: np.ndarray = field(default_factory=lambda: np.eye(3))
    d: np.ndarray = field(default_factory=lambda: np.zeros(3))
    mirror: bool = False
    C: np.ndarray = field(default_factory=lambda: np.eye(3))
    c: np.ndarray = field(default_factory=lambda: np.zeros(3))
    prefix: str = ""
    order: int | None = None
    t: float = 0.0

    @property
    def S(self) -> np.ndarray:
        """The reflection."""
        return MIRROR if self.mirror else np.eye(3)

    @property
    def force(self) -> float:
        """Size of one newton."""
        return self.mass * self.length / self.time**2

    @property
    def energy(self) -> float:
        """Size of one joule, or newton metre."""
        return self.force * self.length

    def name(self, name: str) -> str:
        """Return the name of a part; the ground keeps its own."""
        return name if name.startswith("ground") else self.prefix + name

    def point(self, p) -> np.ndarray:
        """Return a place in W."""
        return self.length * (self.R @ self.S @ np.asarray(p, float) + self.d)

    def vector(self, v, size: float) -> np.ndarray:
        """Return a vector in W of a quantity with this unit."""
        return size * (self.R @ self.S @ np.asarray(v, float))

    def rotation(self, A) -> np.ndarray:
        """Return axes in W."""
        return self.R @ self.S @ A @ self.S

    def within(self, s) -> np.ndarray:
        """Return a place in body axes."""
        return self.length * (self.S @ np.asarray(s, float))

    def axes_within(self, A) -> np.ndarray:
        """Return axes in body axes."""
        return self.S @ A @ self.S

    def inertia(self, J) -> np.ndarray:
        """Return an inertia in body axes."""
        return self.mass * self.length**2 * self.S @ np.asarray(J, float) @ self.S

    def shuffled(self, parts) -> list:
        """Return parts in another order, the same for the same parts."""
        parts = list(parts)
        if self.order is not None:
            np.random.default_rng(self.order + len(parts)).shuffle(parts)
        return parts

    # results, back in the metres, kilograms, seconds and axes of the plain description

    def place_back(self, p) -> np.ndarray:
        """Return places (n, 3), m."""
        return (np.asarray(p) / self.length - self.d) @ self.R @ self.S

    def vector_back(self, v, size: float) -> np.ndarray:
        """Return vectors (n, 3)."""
        return np.asarray(v) / size @ self.R @ self.S

    def moment_back(self, N) -> np.ndarray:
        """Return moments (n, 3), N m, which a reflection turns as well."""
        return np.linalg.det(self.S) * self.vector_back(N, self.energy)

    def but(self, **changes) -> Seen:
        """Return another way with some things changed."""
        return replace(self, **changes)


PLAIN = Seen()
Change = Callable[[np.random.Generator], Seen]


def turn(rng) -> np.ndarray:
    """Return random axes."""
    Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return Q * np.linalg.det(Q)


def unit(rng) -> float:
    """Return the size of a unit, 1e-6 to 1e6."""
    return float(10.0 ** rng.uniform(-6.0, 6.0))


CHANGES: dict[str, Change] = {
    "length": lambda rng: Seen(length=unit(rng)),
    "mass": lambda rng: Seen(mass=unit(rng)),
    "time": lambda rng: Seen(time=unit(rng)),
    "units": lambda rng: Seen(length=10.0 ** rng.uniform(-3, 3), mass=unit(rng), time=10.0 ** rng.uniform(-3, 3)),
    "place": lambda rng: Seen(d=rng.normal(size=3) * 3.0),
    "turn": lambda rng: Seen(R=turn(rng)),
    "mirror": lambda rng: Seen(mirror=True, R=turn(rng)),
    "names": lambda rng: Seen(prefix="z_"),
    "order": lambda rng: Seen(order=int(rng.integers(1000))),
    "axes": lambda rng: Seen(C=turn(rng), c=rng.normal(size=3) * 0.2),
    "start": lambda rng: Seen(t=float(rng.uniform(1.0, 10.0))),
}
"""What must not matter, or must scale."""
