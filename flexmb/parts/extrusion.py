"""`Extrusion`: a solid of constant thickness from an outline, bosses and bores: plates, tubes, lugs, levers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.fem.fe_model import FEModel
from flexmb.fem.meshes.gmsh_solids import Profile, extruded
from flexmb.fem.solids.solid import solid
from flexmb.model.described import Described, finite_array, is_number, named_arguments
from flexmb.parts.limits import check_count, largest_size
from flexmb.parts.materials import material_of

__all__ = ["Bore", "Boss", "Extrusion"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Boss(metaclass=Described):
    """A disc that is added to the outline.

    Parameters
    ----------
    at : (2,), m
        Centre.
    diameter : float, m
        Of the disc.
    """

    at: Any
    diameter: float

    def __post_init__(self):
        _check_circle("Boss", self)


@dataclass(frozen=True, kw_only=True, eq=False)
class Bore(metaclass=Described):
    """A round hole through the solid; its surface is a set.

    Parameters
    ----------
    name : str
        Of the set of its surface.
    at : (2,), m
        Centre.
    diameter : float, m
        Of the hole.
    """

    name: str
    at: Any
    diameter: float

    def __post_init__(self):
        _check_circle(f"Bore '{self.name}'", self)


@dataclass(frozen=True, kw_only=True, eq=False)
class Extrusion(metaclass=Described):
    """A solid of quadratic tetrahedra: a plane figure in x and y, extruded from z = 0 to z = depth.

    The figure is the union of `outline` and `bosses` without the `bores`. The mesh is made by Gmsh (``pip install
    flexmb[mesh]``); a part that is in the cache already does not need it.

    Parameters
    ----------
    depth : float, m
        Thickness, along z.
    material : Material, OrthotropicMaterial, or the name of a material
        "steel", "aluminium", "titanium" and others are ready-made.
    size : float, m
        Largest element.
    outline : (n, 2), m, optional
        Corners of a polygon.
    bosses : list of Boss
        Discs that are added.
    bores : list of Bore
        Holes that are taken away.
    around : int
        Elements around a full circle, at least.
    name : str
        Goes before the names of the sets: "bottom" (z = 0), "top" (z = depth), "sides", the bores', and the straight
        sides one by one: "side_1" from the first to the second corner of the outline, and so on.
    """

    depth: float
    material: Any
    size: float
    outline: Any = ()
    bosses: Any = ()
    bores: Any = ()
    around: int = 16
    name: str = ""

    @property
    def title(self) -> str:
        """How messages call it."""
        return f"Extrusion '{self.name}'" if self.name else "Extrusion"

    @classmethod
    @named_arguments
    def plate(cls, *, length: float, width: float, thickness: float, **others) -> Extrusion:
        """Return a rectangular plate (m), x from 0 to `length`, y from 0 to `width`; `bores` may be given as well.

        Its narrow sides are "side_1" (y = 0), "side_2" (x = length), "side_3" (y = width) and "side_4" (x = 0).

        Parameters
        ----------
        length : float, m
            Along x.
        width : float, m
            Along y.
        thickness : float, m
            Along z.
        """
        _check_lengths("Extrusion.plate", length=length, width=width, thickness=thickness)
        corners = [[0.0, 0.0], [length, 0.0], [length, width], [0.0, width]]
        return cls(depth=thickness, outline=corners, **others)

    @classmethod
    @named_arguments
    def tube(cls, *, outer_diameter: float, wall: float, length: float, **others) -> Extrusion:
        """Return a round tube about the z-axis (m); its inner surface is the set "inside", its ends "bottom" and "top".

        Parameters
        ----------
        outer_diameter : float, m
        wall : float, m
            Thickness.
        length : float, m
            Along z.
        """
        _check_lengths("Extrusion.tube", outer_diameter=outer_diameter, wall=wall, length=length)
        if not 2.0 * wall < outer_diameter:
            raise ModelError(
                "Extrusion.tube",
                found=f"a wall of {wall!r} m in a tube of {outer_diameter!r} m",
                expected="a wall thinner than half the diameter",
                remedy="Give lengths in metres",
            )
        hole = Bore(name="inside", at=(0.0, 0.0), diameter=outer_diameter - 2.0 * wall)
        return cls(depth=length, bosses=[Boss(at=(0.0, 0.0), diameter=outer_diameter)], bores=[hole], **others)

    @classmethod
    @named_arguments
    def lug(cls, *, length: float, width: float, thickness: float, bore: float, **others) -> Extrusion:
        """Return a lug (m): round about the bore "bore" at the origin, with a foot "side_4" of the same width at
        x = -length.

        Parameters
        ----------
        length : float, m
            From the foot to the middle of the bore.
        width : float, m
            Of the foot, and diameter of the round end.
        thickness : float, m
            Along z.
        bore : float, m
            Diameter.
        """
        _check_lengths("Extrusion.lug", length=length, width=width, thickness=thickness, bore=bore)
        half = width / 2.0
        corners = [[-length, -half], [0.0, -half], [0.0, half], [-length, half]]
        round_end, hole = Boss(at=(0.0, 0.0), diameter=width), Bore(name="bore", at=(0.0, 0.0), diameter=bore)
        return cls(depth=thickness, outline=corners, bosses=[round_end], bores=[hole], **others)

    def __post_init__(self):
        _check_lengths(self.title, depth=self.depth)
        largest_size(self.size, self.title)
        object.__setattr__(self, "material", material_of(self.material, self.title, orthotropic=True))
        for field, kind in (("bosses", Boss), ("bores", Bore)):
            given = getattr(self, field)
            made = [kind(**one) if isinstance(one, Mapping) else one for one in given]
            if not all(isinstance(one, kind) for one in made):
                raise ModelError(
                    self.title,
                    found=f"{field} = {given!r:.80}",
                    expected="tables with at and diameter",
                    remedy='Write bores = [{ name = "pin", at = [0, 0], diameter = 0.02 }]',
                )
            object.__setattr__(self, field, tuple(made))
        self._check_figure()
        if not is_number(self.around) or not 4 <= self.around <= 1000:
            raise ModelError(
                self.title,
                found=f"around = {self.around!r}",
                expected="4 to 1000 elements around a circle",
                remedy="Write around = 16",
            )
        low, high = self._box()
        fine = min([self.size, *(np.pi * bore.diameter / self.around for bore in self.bores)])
        check_count(6.0 * float(np.prod(high - low)) * self.depth / self.size**3, self.title, "tetrahedra")
        check_count(float(np.max(np.append(high - low, self.depth))) / fine, self.title, "elements in a row")

    def _check_figure(self) -> None:
        outline = finite_array(self.outline) if len(self.outline) else np.zeros((0, 2))
        if outline.ndim != 2 or outline.shape[1:] != (2,) or len(outline) in (1, 2):
            raise ModelError(
                self.title,
                found=f"outline = {self.outline!r:.80}",
                expected="three corners or more, each of two numbers, m",
                remedy="Write outline = [[0, 0], [0.2, 0], [0.2, 0.1], [0, 0.1]]",
            )
        object.__setattr__(self, "outline", outline)
        if not len(outline) and not self.bosses:
            raise ModelError(
                self.title,
                found="neither an outline nor a boss",
                expected="a figure",
                remedy="Give outline = [...], or bosses = [{ at = [0, 0], diameter = 0.1 }]",
            )
        if len(outline) and not abs(_area(outline)) > 1e-12 * np.prod(np.ptp(outline, axis=0) + 1e-300):
            raise ModelError(
                self.title,
                found="an outline without area",
                expected="corners that span a figure",
                remedy="Look at the corners, and at the parameters that give them",
            )
        names = [bore.name for bore in self.bores]
        taken = ("bottom", "top", "sides", *(f"side_{k}" for k in range(1, len(outline) + 1)))
        twice = next((name for name in names if names.count(name) > 1 or name in taken), None)
        if twice is not None:
            raise ModelError(
                f"{self.title}, bore '{twice}'",
                found="a name that is taken",
                expected="a name of its own, not bottom, top, sides or side_1",
                remedy="Rename the bore",
            )
        for k, bore in enumerate(self.bores):
            self._check_bore(bore, self.bores[:k])

    def _check_bore(self, bore: Bore, before: tuple[Bore, ...]) -> None:
        """Raise ModelError for a bore that leaves the figure or meets another one."""
        circle = np.asarray(bore.at) + bore.diameter / 2.0 * _ring(32)
        if not np.all(self._inside(circle)):
            raise ModelError(
                f"{self.title}, bore '{bore.name}'",
                found=f"a diameter of {bore.diameter:.6g} m at {list(bore.at)} m, which leaves the figure",
                expected="a bore inside the outline and the bosses",
                remedy="Make the bore smaller, or the boss around it larger",
            )
        for other in before:
            gap = np.linalg.norm(np.subtract(bore.at, other.at)) - (bore.diameter + other.diameter) / 2.0
            if gap <= 0.0:
                raise ModelError(
                    f"{self.title}, bore '{bore.name}'",
                    found=f"it meets the bore '{other.name}' ({-gap:.3g} m deep)",
                    expected="material between bores",
                    remedy="Move one of them, or make it smaller",
                )

    def _inside(self, points: np.ndarray) -> np.ndarray:
        """Return which points (n, 2) lie inside the outline or a boss."""
        found = np.zeros(len(points), bool)
        for boss in self.bosses:
            found |= np.linalg.norm(points - np.asarray(boss.at), axis=1) < boss.diameter / 2.0 * (1.0 - 1e-9)
        x, y = points.T
        crossings = np.zeros(len(points), int)
        for (ax, ay), (bx, by) in zip(self.outline, np.roll(self.outline, -1, axis=0)):
            spans = (ay > y) != (by > y)
            with np.errstate(divide="ignore", invalid="ignore"):
                crossings += spans & (x < ax + (y - ay) / (by - ay) * (bx - ax))
        return found | (crossings % 2 == 1)

    def _box(self) -> tuple[np.ndarray, np.ndarray]:
        points = [self.outline, *(np.asarray(boss.at) + boss.diameter / 2.0 * _ring(8) for boss in self.bosses)]
        every = np.vstack(points)
        return every.min(axis=0), every.max(axis=0)

    def finite_elements(self) -> FEModel:
        """Return the FE model of the solid."""
        circle = lambda one: (float(one.at[0]), float(one.at[1]), one.diameter / 2.0)  # noqa: E731
        figure = Profile(
            outline=self.outline,
            bosses=tuple(circle(boss) for boss in self.bosses),
            bores={bore.name: circle(bore) for bore in self.bores},
            edges=tuple(f"side_{k}" for k in range(1, len(self.outline) + 1)),
        )
        mesh = extruded(figure, float(self.depth), float(self.size), int(self.around), self.title)
        return solid(mesh, self.material)


def _ring(count: int) -> np.ndarray:
    """Return points (count, 2) of the unit circle, those on the axes among them."""
    angle = np.arange(count) * 2.0 * np.pi / count
    return np.column_stack([np.cos(angle), np.sin(angle)])


def _area(corners: np.ndarray) -> float:
    x, y = corners.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def _check_circle(title: str, circle: Any) -> None:
    at = finite_array(circle.at)
    if at.shape != (2,):
        raise ModelError(title, found=f"at = {circle.at!r}", expected="two numbers, m", remedy="Write at = [0.1, 0]")
    object.__setattr__(circle, "at", tuple(at.tolist()))
    _check_lengths(title, diameter=circle.diameter)


def _check_lengths(title: str, **lengths: Any) -> None:
    for name, value in lengths.items():
        if not is_number(value) or value <= 0.0:
            raise ModelError(
                title,
                found=f"{name} = {value!r} m",
                expected="a positive number",
                remedy="Give lengths in metres",
            )
