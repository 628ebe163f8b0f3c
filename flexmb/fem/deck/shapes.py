"""Cross-sections of named shapes: constants from rectangles, tubes and rods, in the dimensions of the decks.

Section axes as in `Section`: y up, z to the side, about the area centre; ``inertia_z = int y^2 dA`` is the I1 of
Nastran. Torsion: St-Venant's series for one rectangle, ``sum b t^3 / 3`` for open thin walls, Bredt's formula for one
closed cell (S. Timoshenko & J. N. Goodier, Theory of Elasticity, arts. 109 to 115). Shear areas of compositions: 5/6 of
the walls that lie along the force.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import pi

from flexmb.fem.frames.shapes import torsion_rectangle

__all__ = ["SHAPES", "Constants", "constants"]


@dataclass(frozen=True, kw_only=True)
class Constants:
    """Constants of a section about its area centre; `shear_center` from there, and the stress points (y, z)."""

    area: float
    inertia_y: float
    inertia_z: float
    product_yz: float
    torsion: float
    shear_y: float
    shear_z: float
    shear_center: tuple[float, float] = (0.0, 0.0)
    fibres: tuple[tuple[float, float], ...] = ()


Rectangle = tuple[float, float, float, float]
"""z0, z1, y0, y1."""


def constants(shape: str, d: Sequence[float]) -> Constants:
    """Return the constants of a shape of Nastran's library with the dimensions DIM1, DIM2, ...

    Raises ValueError with words if the dimensions contradict each other, KeyError for an unknown shape.
    """
    count, build = SHAPES[shape]
    if len(d) < count:
        raise ValueError(f"{len(d)} dimensions for {count}")
    if any(not x > 0.0 for x in d[:count] if shape not in ("TUBE",)) or d[0] <= 0.0:
        raise ValueError("dimensions that are not positive")
    return build(*d[:count])


def _round(outer: float, inner: float) -> Constants:
    if not 0.0 <= inner < outer:
        raise ValueError("an inner radius that is not below the outer one")
    area, inertia = pi * (outer**2 - inner**2), pi / 4.0 * (outer**4 - inner**4)
    shear = 0.9 if inner == 0.0 else 0.5
    points = ((outer, 0.0), (0.0, outer), (-outer, 0.0), (0.0, -outer))
    return Constants(
        area=area,
        inertia_y=inertia,
        inertia_z=inertia,
        product_yz=0.0,
        torsion=2.0 * inertia,
        shear_y=shear,
        shear_z=shear,
        fibres=points,
    )


def _walls(
    rectangles: Sequence[Rectangle],
    torsion: float | None = None,
    shear_center: Callable[[float, float], tuple[float, float]] | None = None,
) -> Constants:
    """Return the constants of rectangles that do not overlap; `shear_center` maps the area centre to it (y, z)."""
    for z0, z1, y0, y1 in rectangles:
        if not (z1 > z0 and y1 > y0):
            raise ValueError("walls of no thickness or length")
    areas = [(z1 - z0) * (y1 - y0) for z0, z1, y0, y1 in rectangles]
    area = sum(areas)
    yc = sum(a * (y0 + y1) / 2 for a, (_, _, y0, y1) in zip(areas, rectangles, strict=True)) / area
    zc = sum(a * (z0 + z1) / 2 for a, (z0, z1, _, _) in zip(areas, rectangles, strict=True)) / area
    iz = iy = iyz = open_torsion = along_y = along_z = 0.0
    points = []
    for a, (z0, z1, y0, y1) in zip(areas, rectangles, strict=True):
        y, z, b, h = (y0 + y1) / 2 - yc, (z0 + z1) / 2 - zc, z1 - z0, y1 - y0
        iz += a * h**2 / 12 + a * y**2
        iy += a * b**2 / 12 + a * z**2
        iyz += a * y * z
        open_torsion += max(b, h) * min(b, h) ** 3 / 3
        along_y, along_z = (along_y + a, along_z) if h >= b else (along_y, along_z + a)
        points += [(yy - yc, zz - zc) for yy in (y0, y1) for zz in (z0, z1)]
    single = len(rectangles) == 1
    if single:
        open_torsion = torsion_rectangle(rectangles[0][1] - rectangles[0][0], rectangles[0][3] - rectangles[0][2])
        along_y = along_z = area
    y_s, z_s = (yc, zc) if shear_center is None else shear_center(yc, zc)
    return Constants(
        area=area,
        inertia_y=iy,
        inertia_z=iz,
        product_yz=0.0 if abs(iyz) < 1e-12 * (iy + iz) else iyz,
        torsion=open_torsion if torsion is None else torsion,
        shear_y=5.0 / 6.0 * max(along_y / area, 0.1),
        shear_z=5.0 / 6.0 * max(along_z / area, 0.1),
        shear_center=(y_s - yc, z_s - zc),
        fibres=tuple(dict.fromkeys(points)),
    )


def _bar(width: float, height: float) -> Constants:
    return _walls([(-width / 2, width / 2, -height / 2, height / 2)])


def _box1(width: float, height: float, top: float, bottom: float, right: float, left: float) -> Constants:
    inner = height - top - bottom
    walls = [
        (0.0, width, height - top, height),
        (0.0, width, 0.0, bottom),
        (width - right, width, bottom, bottom + inner),
        (0.0, left, bottom, bottom + inner),
    ]
    b, h = width - (left + right) / 2, height - (top + bottom) / 2
    return _walls(walls, torsion=4.0 * (b * h) ** 2 / (b / top + b / bottom + h / left + h / right))


def _i(height: float, bottom: float, top: float, web: float, t_bottom: float, t_top: float) -> Constants:
    walls = [
        (-bottom / 2, bottom / 2, 0.0, t_bottom),
        (-web / 2, web / 2, t_bottom, height - t_top),
        (-top / 2, top / 2, height - t_top, height),
    ]
    i_bottom, i_top = t_bottom * bottom**3, t_top * top**3
    distance = height - (t_bottom + t_top) / 2
    y_s = t_bottom / 2 + distance * i_top / (i_top + i_bottom)
    return _walls(walls, shear_center=lambda y, z: (y_s, z))


def _i1(flange: float, web: float, inner: float, height: float) -> Constants:
    t = (height - inner) / 2
    return _i(height, flange + web, flange + web, web, t, t)


def _t(width: float, height: float, flange: float, web: float) -> Constants:
    walls = [(-width / 2, width / 2, height - flange, height), (-web / 2, web / 2, 0.0, height - flange)]
    return _walls(walls, shear_center=lambda y, z: (height - flange / 2, z))


def _t1(height: float, length: float, flange: float, web: float) -> Constants:
    walls = [(0.0, flange, -height / 2, height / 2), (-length, 0.0, -web / 2, web / 2)]
    return _walls(walls, shear_center=lambda y, z: (y, flange / 2))


def _t2(width: float, height: float, flange: float, web: float) -> Constants:
    walls = [(-width / 2, width / 2, 0.0, flange), (-web / 2, web / 2, flange, height)]
    return _walls(walls, shear_center=lambda y, z: (flange / 2, z))


def _l(width: float, height: float, lower: float, upright: float) -> Constants:
    walls = [(0.0, width, 0.0, lower), (0.0, upright, lower, height)]
    return _walls(walls, shear_center=lambda y, z: (lower / 2, upright / 2))


def _chan(width: float, height: float, web: float, flange: float) -> Constants:
    walls = [
        (0.0, web, 0.0, height),
        (web, width, 0.0, flange),
        (web, width, height - flange, height),
    ]
    b, h = width - web / 2, height - flange
    behind = 3.0 * b**2 * flange / (h * web + 6.0 * b * flange)  # of the middle of the web
    return _walls(walls, shear_center=lambda y, z: (y, web / 2 - behind))


def _chan1(flange: float, web: float, inner: float, height: float) -> Constants:
    return _chan(flange + web, height, web, (height - inner) / 2)


def _chan2(leg: float, base: float, height: float, width: float) -> Constants:
    walls = [
        (-width / 2, width / 2, 0.0, base),
        (-width / 2, -width / 2 + leg, base, height),
        (width / 2 - leg, width / 2, base, height),
    ]
    b, h = height - base / 2, width - leg
    below = 3.0 * b**2 * leg / (h * base + 6.0 * b * leg)
    return _walls(walls, shear_center=lambda y, z: (base / 2 - below, z))


def _z(flange: float, web: float, inner: float, height: float) -> Constants:
    t = (height - inner) / 2
    walls = [
        (-web / 2, web / 2, -inner / 2, inner / 2),
        (-web / 2 - flange, web / 2, inner / 2, inner / 2 + t),
        (-web / 2, web / 2 + flange, -inner / 2 - t, -inner / 2),
    ]
    return _walls(walls)


def _h(inner: float, legs: float, height: float, web: float) -> Constants:
    walls = [
        (-inner / 2, inner / 2, -web / 2, web / 2),
        (-inner / 2 - legs / 2, -inner / 2, -height / 2, height / 2),
        (inner / 2, inner / 2 + legs / 2, -height / 2, height / 2),
    ]
    return _walls(walls)


def _cross(arms: float, web: float, height: float, flange: float) -> Constants:
    walls = [
        (-web / 2, web / 2, -height / 2, height / 2),
        (-web / 2 - arms / 2, -web / 2, -flange / 2, flange / 2),
        (web / 2, web / 2 + arms / 2, -flange / 2, flange / 2),
    ]
    return _walls(walls)


def _hat(height: float, t: float, top: float, brim: float) -> Constants:
    inner = height - 2 * t
    walls = [
        (-top / 2, top / 2, height - t, height),
        (-top / 2, -top / 2 + t, t, t + inner),
        (top / 2 - t, top / 2, t, t + inner),
        (-top / 2 - brim, -top / 2 + t, 0.0, t),
        (top / 2 - t, top / 2 + brim, 0.0, t),
    ]
    return _walls(walls)


def _hexagon(corner: float, width: float, height: float) -> Constants:
    """Return a hexagon: a rectangle (width - 2 corner) by height with a triangle at either side."""
    box = width - 2.0 * corner
    if not box > 0.0:
        raise ValueError("corners wider than the hexagon")
    area = height * (box + corner)
    iz = box * height**3 / 12 + 4 * (corner * (height / 2) ** 3 / 12)
    triangle, arm = corner * height / 2, box / 2 + corner / 3
    iy = height * box**3 / 12 + 2 * (height * corner**3 / 36 + triangle * arm**2)
    return Constants(
        area=area,
        inertia_y=iy,
        inertia_z=iz,
        product_yz=0.0,
        torsion=area**4 / (40.0 * (iy + iz)),  # St-Venant's estimate for full convex sections
        shear_y=5.0 / 6.0,
        shear_z=5.0 / 6.0,
        fibres=((height / 2, box / 2), (-height / 2, box / 2), (0.0, width / 2), (0.0, -width / 2)),
    )


SHAPES: dict[str, tuple[int, Callable[..., Constants]]] = {
    "ROD": (1, lambda radius: _round(radius, 0.0)),
    "TUBE": (2, _round),
    "TUBE2": (2, lambda outer, wall: _round(outer, outer - wall)),
    "BAR": (2, _bar),
    "BOX": (4, lambda width, height, flange, web: _box1(width, height, flange, flange, web, web)),
    "BOX1": (6, _box1),
    "I": (6, _i),
    "I1": (4, _i1),
    "T": (4, _t),
    "T1": (4, _t1),
    "T2": (4, _t2),
    "L": (4, _l),
    "CHAN": (4, _chan),
    "CHAN1": (4, _chan1),
    "CHAN2": (4, _chan2),
    "Z": (4, _z),
    "H": (4, _h),
    "CROSS": (4, _cross),
    "HAT": (4, _hat),
    "HEXA": (3, _hexagon),
}
"""Number of dimensions and constructor by name, as in the property cards PBARL and PBEAML."""
