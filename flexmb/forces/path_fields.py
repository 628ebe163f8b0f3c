"""The fields `through` and `radii` of forces along a way over cylinders: checked, measured and recorded."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flexmb.constraints.rows import pair_blocks
from flexmb.errors import ModelError
from flexmb.forces.cylinders_in_a_row import around_cylinder, contact_angle, passes_behind, places_between, turn_about
from flexmb.forces.wrapped_path import MOST
from flexmb.math.tables import DAMPED
from flexmb.model.described import entries_of, finite_array

__all__ = ["check_path", "described_length", "first_places", "path_record"]


def check_path(part) -> None:
    """Raise ModelError unless the fields `through` and `radii` make a way; store them as tuples."""
    names = entries_of(part.through)
    if not all(isinstance(name, str) for name in names) or not 2 <= len(names) <= MOST or len(set(names)) < len(names):
        raise ModelError(
            part.title,
            found=f"through = {part.through!r:.80}",
            expected=f"2 to {MOST} different names 'body.marker'",
            remedy='Write through=("pelvis.origin", "thigh.knee", "shank.insertion")',
        )
    radii = np.zeros(len(names)) if part.radii is None else finite_array(part.radii)
    if radii.shape != (len(names),):
        raise ModelError(
            part.title,
            found=f"radii = {part.radii!r:.80} for {len(names)} markers",
            expected="a number for each marker, m: 0 where the way goes through it",
            remedy="Write radii=(0, 0.02, 0), or leave radii out",
        )
    if radii[0] or radii[-1]:
        raise ModelError(
            part.title,
            found=f"radii = {tuple(radii.tolist())}",
            expected="cylinders between markers through which the way goes",
            remedy="Put such a marker before the first cylinder, and behind the last one",
        )
    object.__setattr__(part, "through", names)
    object.__setattr__(part, "radii", tuple(radii.tolist()))


def path_record(part, compiler, states: int) -> dict[str, Any]:
    """Return the row of the way of a force with states, by field name.

    Raises
    ------
    ModelError
        A marker is inside a cylinder, or the way goes through one from behind.
    """
    markers = [compiler.marker(name) for name in part.through]
    n = len(markers)
    branches, between = np.full(MOST, -1), np.full(MOST, -1)
    for run in _described(part, compiler):
        for c, angle in zip(run.cylinders, run.angles, strict=True):
            branches[c] = compiler.branch(f"way of {part.name} around {part.through[c]}", angle)
        for j, offset in enumerate(run.places - 0.5 * (run.centers[:-1] + run.centers[1:])):
            c = run.cylinders[j]
            name = f"way of {part.name} between {part.through[c]} and {part.through[c + 1]}"
            between[c], *_ = [compiler.branch(f"{name}, {x}", float(offset[i])) for i, x in enumerate("xyz")]
    whole = np.zeros(MOST, np.int64)
    whole[:n] = markers
    radii = np.zeros(MOST)
    radii[:n] = part.radii
    return {
        "n": n,
        "markers": whole,
        "radii": radii,
        "branches": branches,
        "between": between,
        "cylinders": int(np.count_nonzero(radii)),
        "pairs": compiler.bulk(np.array(pair_blocks(compiler, (*markers, states), DAMPED), float)),
    }


class _Run(NamedTuple):
    """A way over cylinders that follow each other, as described.

    cylinders : numbers of their markers. centers : (m, 3), m, in W. angles : (m,), rad, by which the way turns around
    each. places : (m - 1, 3), m, in W, between them. length : m.
    """

    cylinders: range
    centers: np.ndarray
    angles: np.ndarray
    places: np.ndarray
    length: float


def _described(part, compiler) -> list[_Run]:
    """Return the runs of cylinders of a way.

    Raises
    ------
    ModelError
        A marker is inside a cylinder, the way goes through one from behind, or no way is found.
    """
    markers = [compiler.marker(name) for name in part.through]
    found, k = [], 0
    while k < len(markers) - 1:
        end = k + 1
        while part.radii[end]:
            end += 1
        if end > k + 1:
            found.append(_run(part, compiler, markers, range(k + 1, end)))
        k = end
    return found


def _run(part, compiler, markers, cylinders: range) -> _Run:
    """Return the way from the marker before some cylinders to the one behind them."""
    centers, frames = (np.array(x) for x in zip(*(compiler.pose(markers[c]) for c in cylinders), strict=True))
    radii = np.array([part.radii[c] for c in cylinders])
    first, last = cylinders[0] - 1, cylinders[-1] + 1
    P, S = (np.array(compiler.position(markers[k]), float) for k in (first, last))
    names = [part.through[k] for k in (first, *cylinders, last)]
    for k, place, c in ((0, P, 0), (-1, S, len(radii) - 1)):
        _require_outside(part, names[k], place, names[c + 1], centers[c], frames[c], radii[c])
    near = np.full(len(radii), 0.5 * np.pi)  # as described, between -90 and 270 degrees
    places = first_places(radii, centers, frames, P, S)
    if len(radii) > 1 and not places_between(radii, centers, frames, near, P, S, places):
        raise ModelError(
            part.title,
            found=f"no way over the cylinders at {', '.join(map(repr, names[1:-1]))} one after the other",
            expected="cylinders apart from each other, which the way passes in this order, on the sides that the signs "
            "of their radii say",
            remedy="Change the order or the signs, move the markers, or put one between through which the way goes",
        )
    ends = np.vstack([P, places, S])
    angles, length = np.empty(len(radii)), 0.0
    for j, (radius, center, R) in enumerate(zip(radii, centers, frames, strict=True)):
        one, two = (R.T @ (x - center) for x in ends[j : j + 2])
        angles[j] = turn_about(radius, one, two, near[j])
        if passes_behind(radius, one, two, angles[j]):
            raise ModelError(
                part.title,
                found=f"the straight line from '{names[j]}' to '{names[j + 2]}' cuts the cylinder at '{names[j + 1]}' "
                "on the other side of its axis",
                expected="a way that goes around the z-axis of the cylinder with the sign of its radius",
                remedy=f"Write radii with {-radius:g} m there, or move the markers",
            )
        contact = contact_angle(radius, one, two, angles[j])
        if contact > 0.0:
            length += around_cylinder(radius, one, two, contact, np.empty((2, 3)), np.empty((6, 6)))
        else:
            length += float(np.linalg.norm(two - one))
    return _Run(cylinders, centers, angles, places, length)


def _require_outside(part, name: str, place, cylinder: str, center, R, radius: float) -> None:
    """Raise ModelError if a marker is inside a cylinder."""
    far = float(np.hypot(*(R.T @ (place - center))[:2]))
    if far < abs(radius):
        raise ModelError(
            part.title,
            found=f"marker '{name}' is {far:.6g} m from the axis of the cylinder at '{cylinder}', whose radius is "
            f"{abs(radius):.6g} m",
            expected="a place outside",
            remedy="Move the marker, or give a smaller radius",
        )


def first_places(radii, centers, frames, P, S) -> np.ndarray:
    """Return where to look for the places between cylinders, (m - 1, 3), m: on the sides that the way passes."""
    axes = frames[:, :, 2]
    chord = S - P
    on = []
    for center, z in zip(centers, axes, strict=True):  # of the axis, where the straight line is nearest
        across = np.linalg.pinv(np.column_stack([z, -chord])) @ (P - center)
        on.append(center + across[0] * z)
    touched = np.array(on)
    for _ in range(3):
        line = np.vstack([P, touched, S])
        way = line[2:] - line[:-2]
        sides = np.sign(radii)[:, None] * np.cross(way, axes)
        sides /= np.maximum(np.linalg.norm(sides, axis=1), 1e-300)[:, None]
        touched = np.array(on) + np.abs(radii)[:, None] * sides
    return 0.5 * (touched[:-1] + touched[1:])


def described_length(part, compiler) -> float:
    """Return the length of the way as described, m."""
    at = [np.array(compiler.position(compiler.marker(name)), float) for name in part.through]
    straight = [k for k in range(len(at) - 1) if not part.radii[k] and not part.radii[k + 1]]
    total = sum(float(np.linalg.norm(at[k + 1] - at[k])) for k in straight)
    return total + sum(run.length for run in _described(part, compiler))
