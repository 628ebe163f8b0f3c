"""`Skin`: what of a deforming body can touch, as points that move with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any, NamedTuple

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import Described, check_mapping, is_number

__all__ = [
    "MOST_PATCHES",
    "MOST_POINTS",
    "Skin",
    "SkinFacets",
    "SkinPatch",
    "check_count",
    "checked_skins",
    "count_along",
]

MOST_PATCHES = 5000
"""Each is a marker of its body: its motion and Jacobian are computed in every evaluation."""
MOST_POINTS = 1_000_000
"""Of the rings of a tube, all together."""


WHOLE = (0.0, 1.0)
"""From one end of a line to the other."""


@dataclass(frozen=True, eq=False)
class Skin(metaclass=Described):
    """Points of the surface of a deforming body, each with an area and a normal that turns with the body there.

    Parameters
    ----------
    spacing : float, m
        Distance of the points; facets of a mesh have one point at least.
    nodes : name of a set or node numbers, optional
        Of a reduced body: the facets of its free surface whose nodes all belong to it; by default all.
    radius : float, m, optional
        Of a cable or beam: of the round tube about its line. Of a reduced shell: half its thickness.
    between : (float, float)
        Of a cable or beam: from and to, fractions of its length.
    faces : bool
        Give it markers at the corners between its points too, so that points of another skin can meet its faces: for
        the second skin of a `SkinContact`.
    """

    _: KW_ONLY
    spacing: float
    nodes: Any = None
    radius: float | None = None
    between: Any = WHOLE
    faces: bool = False

    def __post_init__(self):
        for name in ("spacing", "radius"):
            value = getattr(self, name)
            if name == "radius" and value is None:
                continue
            if not is_number(value) or value <= 0.0:
                raise ModelError("Skin", found=f"{name} = {value!r}", expected="a length > 0, m", remedy=f"{name}=0.01")
        ends = self.between
        good = isinstance(ends, list | tuple) and len(ends) == 2 and all(is_number(x) for x in ends)
        if not good or not 0.0 <= ends[0] < ends[1] <= 1.0:
            raise ModelError(
                "Skin",
                found=f"between = {ends!r}",
                expected="two fractions of the length, 0 <= from < to <= 1",
                remedy="Write between=(0.0, 1.0)",
            )


class SkinFacets(NamedTuple):
    """The faces of a skin between markers of its body."""

    corners: tuple[str, ...]
    """Names of the markers."""
    facets: np.ndarray
    """(n, 3), numbers of corners, counter-clockwise from outside; of a line between two corners the last is -1."""
    radius: float
    """m, by which faces and lines are thickened to all sides: of a tube, half a thickness, or 0."""


class SkinPatch(NamedTuple):
    """A piece of a skin that moves with one marker, in its axes."""

    marker: str
    """Name of the marker on the body."""
    places: np.ndarray
    """(n, 3), m"""
    normals: np.ndarray
    """(n, 3), outward"""
    areas: np.ndarray
    """(n,), m2"""
    radius: float
    """m, by which the marker's own place is rounded: of a tube, half a thickness, or 0."""


def checked_skins(given: Any, title: str, *, needs: tuple[str, ...], lacks: tuple[str, ...]) -> Mapping[str, Skin]:
    """Return the skins of a body by name; ModelError if one lacks a field of `needs` or has one of `lacks`."""
    given = {} if given is None else given
    check_mapping(given, title, "skins", '{"top": fmb.Skin(spacing=0.01)}')
    for name, skin in given.items():
        if not isinstance(skin, Skin):
            raise ModelError(
                title,
                found=f"skin {name} = {skin!r:.80}",
                expected="a Skin",
                remedy=f"Write skins={{'{name}': fmb.Skin(spacing=0.01)}}",
            )
        for field in needs:
            if getattr(skin, field) is None:
                raise ModelError(
                    title, found=f"skin {name} without {field}", expected=f"its {field}", remedy=f"Write {field}=0.01"
                )
        for field in lacks:
            if _is_given(skin, field):
                raise ModelError(
                    title,
                    found=f"skin {name} with {field} = {getattr(skin, field)!r:.60}",
                    expected=f"no {field} for this kind of body",
                    remedy=f"Leave {field} out",
                )
    return dict(given)


def _is_given(skin: Skin, field: str) -> bool:
    """Does a field of a skin say more than its default?"""
    value = getattr(skin, field)
    return tuple(value) != WHOLE if field == "between" else value is not None


def check_count(count: float, name: str, title: str, most: int = MOST_PATCHES) -> None:
    """Raise ModelError if a skin has more patches (or points of rings: `most`) than are borne; inf is refused too."""
    if not 1 <= count <= most:
        raise ModelError(
            title,
            found=f"skin {name} of {count:.7g} points",
            expected=f"1 to {most} points",
            remedy="Give a larger spacing, or a smaller set of nodes",
        )


def count_along(length: float, spacing: float) -> float:
    """Return how many points at this spacing fit along a length: at least 1, inf beyond all floats."""
    with np.errstate(over="ignore"):
        return float(max(1.0, np.round(np.float64(length) / spacing)))
