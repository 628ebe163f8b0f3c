"""`Section`: the constants of a beam's cross-section.

Section axes: x along the beam, y and z in the cross-section; the origin is the line of nodes (the reference
axis). Inertias and products are about the area centre: ``inertia_z = int y^2 dA`` resists bending in the
x-y plane.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from math import pi
from typing import Any

from flexmb.errors import MeshError
from flexmb.fem.frames import shapes
from flexmb.model.described import Described, is_number

__all__ = ["Section"]

DIMENSIONS = {"values": 1, "rectangle": 4, "solid_circle": 3, "tube": 4, "box": 6, "i": 6}
"""Entries of `Section.shape`: the constructor, its dimensions, the Poisson number."""

Point = tuple[float, float]
LARGEST = 1e30
"""m, as the coordinates of a mesh: its fourth power is a number."""


@dataclass(frozen=True, kw_only=True)
class Section(metaclass=Described):
    """Constants of a cross-section; make one with `rectangle`, `tube`, `box`, `i`, `solid_circle` or
    `values`.

    Parameters
    ----------
    area : float, m2
    inertia_y, inertia_z : float, m4
        ``int z^2 dA`` and ``int y^2 dA`` about the area centre.
    product_yz : float, m4
        ``int y z dA`` about the area centre; zero when y and z are principal axes.
    torsion : float, m4
        St-Venant torsion constant J: torque = G J times twist per length. Warping is free everywhere.
    shear_y, shear_z : float, -
        Shear factors: effective shear area along y and z divided by the area.
    polar : float, m4 or None
        Polar inertia for the mass about the centre of mass; None takes inertia_y + inertia_z.
    area_center, shear_center, mass_center : (2,), m
        y and z, from the line of nodes, of the area centre (where an axial force does not bend), the shear
        centre (where a transverse force does not twist; the elastic axis) and the centre of mass.
    fibres : tuple of (2,), m
        y and z of the points where the axial stress can be largest, from the area centre.
    line_mass, line_mass_center : float, kg/m and (2,), m
        Mass per length that is not structure (cables, insulation), and its place from the line of nodes.
    shape : tuple
        The constructor and its arguments, so that a taper between two equal shapes interpolates the
        dimensions.

    Examples
    --------
    >>> round(Section.rectangle(0.02, 0.01).inertia_z * 1e9, 3)     # 10 * 20**3 / 12 mm4 = 6667 mm4
    6.667
    """

    area: float
    inertia_y: float
    inertia_z: float
    torsion: float
    shear_y: float = 5.0 / 6.0
    shear_z: float = 5.0 / 6.0
    product_yz: float = 0.0
    polar: float | None = None
    area_center: Point = (0.0, 0.0)
    shear_center: Point = (0.0, 0.0)
    mass_center: Point = (0.0, 0.0)
    fibres: tuple[Point, ...] = ()
    line_mass: float = 0.0
    line_mass_center: Point = (0.0, 0.0)
    shape: tuple = ("values",)

    def __repr__(self):
        made = "".join(f" {x:.4g}" if isinstance(x, float) else f" {x}" for x in self.shape)
        return (
            f"Section({made.strip()}: area {self.area:.4g} m2, inertia {self.inertia_y:.4g} and "
            f"{self.inertia_z:.4g} m4)"
        )

    def __post_init__(self):
        _check_shape(self.shape)
        part = f"Section '{self.shape[0]}'"
        units = {
            "area": "m2",
            "inertia_y": "m4",
            "inertia_z": "m4",
            "torsion": "m4",
            "shear_y": "-",
            "shear_z": "-",
        }
        for name, unit in units.items():
            value = getattr(self, name)
            if not is_number(value) or value <= 0.0:
                raise MeshError(
                    part,
                    found=f"{name} = {value!r} {unit}",
                    expected="a positive number",
                    remedy="Give the dimensions in metres, walls thinner than half the outer size",
                )
        if not is_number(self.line_mass) or self.line_mass < 0.0:
            raise MeshError(
                part,
                found=f"line_mass = {self.line_mass!r} kg/m",
                expected="a number >= 0",
                remedy="Give the non-structural mass per length",
            )
        if self.product_yz**2 >= self.inertia_y * self.inertia_z:
            raise MeshError(
                part,
                found=f"product_yz = {self.product_yz!r} m4",
                expected="product_yz^2 < inertia_y * inertia_z",
                remedy="Give the product of inertia about the area centre",
            )

    @classmethod
    def values(
        cls,
        area: float,
        inertia_y: float,
        inertia_z: float,
        torsion: float,
        shear_y: float = 5.0 / 6.0,
        shear_z: float = 5.0 / 6.0,
        *,
        product_yz: float = 0.0,
        polar: float | None = None,
        area_center: Point = (0.0, 0.0),
        shear_center: Point = (0.0, 0.0),
        mass_center: Point = (0.0, 0.0),
        fibres: tuple[Point, ...] = (),
        line_mass: float = 0.0,
        line_mass_center: Point = (0.0, 0.0),
    ) -> Section:
        """Return a section of given constants (m2, m4, -, m); see the class for their meaning."""
        return cls(
            area=area,
            inertia_y=inertia_y,
            inertia_z=inertia_z,
            torsion=torsion,
            shear_y=shear_y,
            shear_z=shear_z,
            product_yz=product_yz,
            polar=polar,
            area_center=(*area_center,),
            shear_center=(*shear_center,),
            mass_center=(*mass_center,),
            fibres=tuple((*point,) for point in fibres),
            line_mass=line_mass,
            line_mass_center=(*line_mass_center,),
        )

    @classmethod
    def rectangle(cls, width: float, height: float, *, poisson: float = 0.0) -> Section:
        """Return a solid rectangle, width (m) along y and height (m) along z.

        The torsion constant is St-Venant's series (Timoshenko & Goodier, Theory of Elasticity, art. 109);
        the shear factor is Cowper's, 5/6 for ``poisson=0``.

        Parameters
        ----------
        width, height : float, m
            Along y and along z.
        poisson : float, -
            For the shear factor.
        """
        _check_lengths("rectangle", width=width, height=height)
        kappa = shapes.cowper_rectangle(poisson)
        return cls(
            area=width * height,
            inertia_y=width * height**3 / 12,
            inertia_z=height * width**3 / 12,
            torsion=shapes.torsion_rectangle(width, height),
            shear_y=kappa,
            shear_z=kappa,
            fibres=_corners(width, height),
            shape=("rectangle", width, height, poisson),
        )

    @classmethod
    def solid_circle(cls, diameter: float, *, poisson: float = 0.0) -> Section:
        """Return a solid circle.

        Parameters
        ----------
        diameter : float, m
        poisson : float, -
            For the shear factor.
        """
        _check_lengths("solid_circle", diameter=diameter)
        return cls._round("solid_circle", (diameter,), diameter, 0.0, poisson)

    @classmethod
    def tube(cls, diameter: float, wall: float, *, poisson: float = 0.0) -> Section:
        """Return a round tube.

        Parameters
        ----------
        diameter : float, m
            Outer diameter.
        wall : float, m
            Thickness.
        poisson : float, -
            For the shear factor.
        """
        _check_lengths("tube", diameter=diameter, wall=wall)
        _check_wall("tube", wall, diameter)
        return cls._round("tube", (diameter, wall), diameter, diameter - 2.0 * wall, poisson)

    @classmethod
    def box(
        cls, width: float, height: float, wall: float, web: float | None = None, *, poisson: float = 0.0
    ) -> Section:
        """Return a rectangular hollow section.

        Torsion: Bredt's closed cell plus the open part of the walls; shear: Cowper's thin-walled box.

        Parameters
        ----------
        width, height : float, m
            Outer size along y and along z.
        wall : float, m
            Thickness of the two flanges (parallel to y) and, without ``web``, of the two webs.
        web : float, m, optional
            Thickness of the two webs (parallel to z).
        poisson : float, -
            For the shear factors.
        """
        web = wall if web is None else web
        _check_lengths("box", width=width, height=height, wall=wall, web=web)
        _check_wall("box", wall, height)
        _check_wall("box", web, width)
        inner_y, inner_z = width - 2 * web, height - 2 * wall
        return cls(
            area=width * height - inner_y * inner_z,
            inertia_y=(width * height**3 - inner_y * inner_z**3) / 12,
            inertia_z=(height * width**3 - inner_z * inner_y**3) / 12,
            torsion=shapes.torsion_box(width - web, height - wall, wall, web),
            shear_y=shapes.cowper_box(height - wall, width - web, web, wall, poisson),
            shear_z=shapes.cowper_box(width - web, height - wall, wall, web, poisson),
            fibres=_corners(width, height),
            shape=("box", width, height, wall, web, poisson),
        )

    @classmethod
    def i(cls, width: float, height: float, flange: float, web: float, *, poisson: float = 0.0) -> Section:
        """Return a doubly symmetric I.

        Torsion: El Darwish & Johnston 1965; shear along z: Cowper's I, along y: the flanges as rectangles.

        Parameters
        ----------
        width, height : float, m
            Width of the flanges along y, whole height along z.
        flange, web : float, m
            Thicknesses.
        poisson : float, -
            For the shear factors.
        """
        _check_lengths("i", width=width, height=height, flange=flange, web=web)
        _check_wall("i", flange, height)
        if not 0.0 < web <= width:
            raise MeshError(
                "Section 'i'",
                found=f"web = {web!r} m",
                expected=f"0 < web <= width = {width!r} m",
                remedy="Give the dimensions in metres",
            )
        clear = height - 2 * flange
        area = 2 * width * flange + clear * web
        return cls(
            area=area,
            inertia_y=(width * height**3 - (width - web) * clear**3) / 12,
            inertia_z=(2 * flange * width**3 + clear * web**3) / 12,
            torsion=shapes.torsion_i(width, height, flange, web),
            shear_y=shapes.cowper_rectangle(poisson) * 2 * width * flange / area,
            shear_z=shapes.cowper_i(width, height - flange, flange, web, poisson),
            fibres=_corners(width, height),
            shape=("i", width, height, flange, web, poisson),
        )

    @classmethod
    def _round(cls, shape: str, arguments: tuple, outer: float, inner: float, poisson: float) -> Section:
        inertia, kappa = pi / 64 * (outer**4 - inner**4), shapes.cowper_hollow_circle(inner / outer, poisson)
        r = outer / 2.0
        return cls(
            area=pi / 4 * (outer**2 - inner**2),
            inertia_y=inertia,
            inertia_z=inertia,
            torsion=2.0 * inertia,
            shear_y=kappa,
            shear_z=kappa,
            fibres=((r, 0.0), (0.0, r), (-r, 0.0), (0.0, -r)),
            shape=(shape, *arguments, poisson),
        )

    @property
    def polar_inertia(self) -> float:
        """Polar inertia of the mass about its centre, m4."""
        return self.inertia_y + self.inertia_z if self.polar is None else self.polar

    def with_offsets(
        self,
        *,
        area_center: Point | None = None,
        shear_center: Point | None = None,
        mass_center: Point | None = None,
    ) -> Section:
        """Return this section at other places (y, z), m, from the line of nodes; None keeps the place."""
        given = {"area_center": area_center, "shear_center": shear_center, "mass_center": mass_center}
        moved: dict[str, Any] = {name: tuple(point) for name, point in given.items() if point is not None}
        return replace(self, **moved)

    def between(self, other: Section, fraction: float) -> Section:
        """Return the section at a fraction (0..1) of a linear taper from this one to `other`.

        Two equal shapes interpolate their dimensions, others every constant. Offsets interpolate linearly.
        """
        if self == other:
            return self

        def mixed(a, b):
            if isinstance(a, tuple):
                return tuple(mixed(x, y) for x, y in zip(a, b, strict=False))
            return a if isinstance(a, str) or a is None or b is None else (1.0 - fraction) * a + fraction * b

        centers = {
            name: mixed(getattr(self, name), getattr(other, name))
            for name in ("area_center", "shear_center", "mass_center", "line_mass_center")
        }
        line = {"line_mass": mixed(self.line_mass, other.line_mass)}
        if self.shape[0] == other.shape[0] != "values":
            name, *arguments, poisson = mixed(self.shape, other.shape)
            return replace(getattr(Section, name)(*arguments, poisson=poisson), **centers, **line)
        constants = {
            f.name: mixed(getattr(self, f.name), getattr(other, f.name))
            for f in fields(self)
            if f.name not in centers and f.name not in ("shape", "polar", "line_mass")
        }
        return Section(**constants, **centers, **line, polar=mixed(self.polar_inertia, other.polar_inertia))


def _corners(width: float, height: float) -> tuple[Point, ...]:
    y, z = width / 2.0, height / 2.0
    return ((y, z), (-y, z), (-y, -z), (y, -z))


def _check_shape(shape: Any) -> None:
    name = shape[0] if isinstance(shape, tuple | list) and shape else None
    count = DIMENSIONS.get(name) if isinstance(name, str) else None
    if count is None or len(shape) != count or not all(is_number(x) for x in shape[1:]):
        raise MeshError(
            "Section",
            found=f"shape = {shape!r}"[:200],
            expected="the name of a constructor and its arguments",
            remedy=f"Use fem.Section.{', .'.join(list(DIMENSIONS)[1:])}, or leave shape out",
        )


def _check_lengths(shape: str, **lengths: Any) -> None:
    for name, length in lengths.items():
        if not is_number(length) or not 0.0 < length <= LARGEST:
            raise MeshError(
                f"Section '{shape}'",
                found=f"{name} = {length!r:.100} m",
                expected="a positive number",
                remedy="Give the dimensions in metres",
            )


def _check_wall(shape: str, wall: float, outer: float) -> None:
    if not 0.0 < wall < outer / 2.0:
        raise MeshError(
            f"Section '{shape}'",
            found=f"a wall of {wall!r} m",
            expected=f"0 < wall < {outer / 2.0!r} m",
            remedy="Give the dimensions in metres; for a full section use rectangle or solid_circle",
        )
