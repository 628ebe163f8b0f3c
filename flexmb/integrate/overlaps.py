"""Surfaces that overlap when a run begins."""

from __future__ import annotations

import numpy as np

from flexmb.errors import ModelError
from flexmb.integrate.runs.switching import PassedOver, new_switching
from flexmb.math.switches import GAP
from flexmb.surfaces.distances import signed_distance
from flexmb.system.program import evaluate

__all__ = ["overlaps"]

DEEP = 0.01
"""Penetration, in radii of the smaller surface, that a load at rest hardly explains."""
OF_A_BALL = 0.1
"""The same of a `Contact`, in radii of its ball, where soft ones may be pressed a bit; no law holds at this depth."""
SAME = 1e-6
"""Distance of two places, in radii of the smaller surface, that counts as none."""
LISTED = 6


def overlaps(system, state) -> list[str]:
    """Return a sentence for each contact whose surfaces overlap far at a state."""
    model = system.model
    touching = [force for force in model.forces if hasattr(force, "spots") and not force.impulsive]
    balls = [force for force in model.forces if hasattr(force, "depth_of_ball")]
    if not touching and not balls:
        return []
    work = system.workspace()
    evaluate(system.program, state, work)
    now = new_switching(system, state, work, PassedOver()).now
    owners = np.array(system.switch_owners)
    told = [text for force in balls for text in _overlap_of_ball(force, now[owners == force.title][0])]
    for force in touching:
        rows = now[owners == force.title]
        if not hasattr(force, "crowded"):
            told += _overlap_of_skins(force, system, work, *rows[0, :2])
            continue
        found = []
        gaps = force.gaps(model, rows)
        middles = _depths_of_middles(force, system, work, [pair for pair, _ in gaps])
        for ((a, b), gap), middle in zip(gaps, middles, strict=True):
            size, gap = min(a.shape.extent, b.shape.extent), min(gap, -middle)
            if gap < -DEEP * size:
                found.append(f"'{a.name}' and '{b.name}' by {-gap:.4g} m")
        if found:
            more = f" and {len(found) - LISTED} more" if len(found) > LISTED else ""
            told.append(
                f"{force.title}: at the start {', '.join(found[:LISTED])}{more} overlap; expected: surfaces that are "
                "apart or lightly pressed. Move the bodies apart, or let them come to rest with statics first"
            )
    return told


def _depths_of_middles(force, system, work, pairs) -> np.ndarray:
    """Return how far the middle of one surface lies inside both of a pair, m; 0 where it does not.

    Samples do not tell it where normals of both surfaces have one direction, as in bodies that coincide. Where both
    middles are one place there is no way out of each other, which is an error, as surfaces are that are the same.
    """
    depths = np.zeros(len(pairs))
    numbers = np.array([[system.marker_index[s.marker] for s in pair] for pair in pairs], np.int64).reshape(-1, 2)
    places = work.markers["r"][numbers]
    apart = np.linalg.norm(places[:, 1] - places[:, 0], axis=1)
    for k in np.flatnonzero([way < max(s.shape.reach for s in pair) for way, pair in zip(apart, pairs, strict=True)]):
        for x, y in ((0, 1), (1, 0)):
            inner, outer = pairs[k][x], pairs[k][y]
            z = work.markers["R"][numbers[k, y]].T @ (places[k, x] - places[k, y])
            depths[k] = max(depths[k], min(_inside(inner, np.zeros(3)), _inside(outer, z)))
        size = min(s.shape.extent for s in pairs[k])
        there = apart[k] <= SAME * size
        if there and (depths[k] > DEEP * size or _coincide(pairs[k], work.markers["R"][numbers[k]])):
            raise ModelError(
                force.title,
                found=f"surfaces '{pairs[k][0].name}' and '{pairs[k][1].name}' around one place, one in the other",
                expected="bodies beside each other: nothing says in which direction these are to be pushed apart",
                remedy="Move one of the bodies",
            )
    return depths


def _coincide(pair, axes: np.ndarray) -> bool:
    """Are two surfaces at one place, with the axes (2, 3, 3) of their markers, the same?"""
    a, b = (surface.shape for surface in pair)
    return (
        a.code == b.code
        and np.allclose(axes[0], axes[1], rtol=0.0, atol=SAME)
        and np.array_equal(a.numbers(), b.numbers())
    )


def _inside(surface, z: np.ndarray) -> float:
    """Return how deep a place in the axes of its marker lies inside a surface, m; negative outside."""
    return -signed_distance(surface.packed, 0, z, np.inf, np.empty(3), np.empty((3, 3)))


def _overlap_of_ball(force, gap: np.ndarray) -> list[str]:
    """Return a sentence if the ball of a `Contact` lies far inside what it touches, of which this is the switch."""
    deep, distance = force.depth_of_ball(gap)
    if distance <= SAME * force.radius:
        raise ModelError(
            force.title,
            found=f"both markers at one place: the ball lies {deep:.3g} m deep",
            expected="bodies beside each other: nothing says in which direction these are to be pushed apart",
            remedy="Move one of the bodies",
        )
    if deep <= OF_A_BALL * force.radius:
        return []
    return [
        f"{force.title}: at the start the ball lies {deep:.4g} m deep; expected: a ball of {force.radius:.4g} m that "
        "is apart or lightly pressed. Move the bodies apart, or let them come to rest with statics first"
    ]


def _overlap_of_skins(force, system, work, kind: float, gap: float) -> list[str]:
    """Return a sentence if the deepest point of one skin lies far below the faces of the other."""
    sizes = []
    for body, skin in force.sides(system.model):
        names = [f"{body.name}.{patch.marker}" for patch in body.skin_patches[skin]]
        places = work.markers["r"][[system.marker_index[name] for name in names]]
        sizes.append(0.5 * float(np.linalg.norm(np.ptp(places, axis=0))))
    if kind != GAP or gap >= -DEEP * min(sizes):
        return []
    return [
        f"{force.title}: at the start '{force.surfaces[0]}' lies in '{force.surfaces[1]}' by {-gap:.4g} m; expected: "
        "skins that are apart or lightly pressed. Move the bodies apart, or let them come to rest with statics first"
    ]
