"""What surfaces a law of contact can be used for."""

from __future__ import annotations

import numpy as np

from flexmb.errors import ModelError

__all__ = ["check_pair", "check_rigid", "check_skins", "check_two_bodies", "kind_of"]


def kind_of(surface) -> str:
    """Return the name of the shape of a surface."""
    return type(surface.shape).__name__


def check_two_bodies(force, groups) -> None:
    """Raise ModelError if all surfaces are on one body."""
    if len({surface.marker.partition(".")[0] for group in groups for surface in group}) == 1:
        raise ModelError(
            force.title,
            found=f"surfaces = {force.surfaces!r:.80}, all on one body",
            expected="surfaces of two bodies",
            remedy="A body does not touch itself: name the surface of another one",
        )


def check_rigid(force, groups) -> None:
    """Raise ModelError if a surface does not exist, or all are on one body or on the ground."""
    check_two_bodies(force, groups)
    endless = [[s for s in group if not np.isfinite(s.shape.reach)] for group in groups]
    if endless[0] and endless[1]:
        check_pair(force, endless[0][0], endless[1][0])
    _check_points(force, groups)


def check_pair(force, a, b) -> None:
    """Raise ModelError if the law cannot be used for two surfaces."""
    if all(not np.isfinite(s.shape.reach) for s in (a, b)):
        raise ModelError(
            force.title,
            found=f"'{a.name}' and '{b.name}' are both half-spaces",
            expected="at most one surface without end",
            remedy="Use a Cuboid",
        )
    if force.law.sampled and a.spacing is None and b.spacing is None:
        raise ModelError(
            force.title,
            found=f"neither '{a.name}' nor '{b.name}' is sampled",
            expected="a spacing of at least one of them: the law acts on areas",
            remedy=f"Give the smaller one a spacing: fmb.Surface('{b.name}', ..., spacing=1e-3)",
        )
    if force.law.code == 1 and (
        {kind_of(a), kind_of(b)} == {"Sphere", "Patch"} or "Sphere" not in (kind_of(a), kind_of(b))
    ):
        raise ModelError(
            force.title,
            found=f"'{a.name}' is a {type(a.shape).__name__}, '{b.name}' a {type(b.shape).__name__}",
            expected="a Sphere with the law of Hertz, and a Surface as the other",
            remedy="Use ElasticFoundation",
        )


def check_skins(force, groups) -> None:
    """Raise ModelError if both sides are pieces of skins."""
    a, b = (next((s for s in group if kind_of(s) == "Patch"), None) for group in groups)
    if a is not None and b is not None:
        raise ModelError(
            force.title,
            found=f"'{a.name}' and '{b.name}' are both points of skins",
            expected="a Surface on one side: points of a skin need the distance from a solid",
            remedy="Two skins meet by a SkinContact",
        )


def _check_points(force, groups) -> None:
    """Raise ModelError if surfaces would meet between the points at which a rigid law acts."""
    for own, others in (groups, groups[::-1]):
        blunt = next((s for s in own if np.isfinite(s.shape.reach) and not len(s.shape.corners()[0])), None)
        fits = ("Sphere", "Patch", "Plane") if blunt and kind_of(blunt) == "Cylinder" else ("Sphere", "Patch")
        rest = next((s for s in others if kind_of(s) not in fits), None)
        if blunt and rest:
            raise ModelError(
                force.title,
                found=f"'{blunt.name}' is a {kind_of(blunt)}, which has no corners; '{rest.name}' a {kind_of(rest)}",
                expected="with a rigid law, which acts at points: corners, a Sphere, or a Cylinder on a Plane",
                remedy="Use a Hull of points on both rims, an ExtrudedProfile of a Disc, or ElasticFoundation",
            )
