"""The fields `through` and `radii` of forces along a way over cylinders: checked, measured and recorded."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.constraints.rows import pair_blocks
from flexmb.errors import ModelError
from flexmb.forces.wrapped_path import MOST, around_cylinder, contact_angle, passes_behind
from flexmb.math.tables import DAMPED
from flexmb.model.described import entries_of, finite_array

__all__ = ["check_path", "described_length", "path_record"]


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
    around = np.flatnonzero(radii)
    if len(around) and (radii[0] or radii[-1] or np.any(np.diff(around) < 2)):
        raise ModelError(
            part.title,
            found=f"radii = {tuple(radii.tolist())}",
            expected="cylinders between markers through which the way goes",
            remedy="Put a marker through which it goes before and behind each cylinder",
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
    branches = np.full(MOST, -1)
    for c in range(1, n - 1):
        if part.radii[c]:
            angle = _described_angle(part, compiler, markers, c)
            branches[c] = compiler.branch(f"way of {part.name} around {part.through[c]}", angle)
    whole = np.zeros(MOST, np.int64)
    whole[:n] = markers
    radii = np.zeros(MOST)
    radii[:n] = part.radii
    return {
        "n": n,
        "markers": whole,
        "radii": radii,
        "branches": branches,
        "cylinders": int(np.count_nonzero(radii)),
        "pairs": compiler.bulk(np.array(pair_blocks(compiler, (*markers, states), DAMPED), float)),
    }


def _described_angle(part, compiler, markers, c: int) -> float:
    """Return by how much the way turns about a cylinder as described, between -90 and 270 degrees, rad."""
    center, R = compiler.pose(markers[c])
    P, S = (R.T @ (compiler.position(markers[k]) - center) for k in (c - 1, c + 1))
    r = abs(part.radii[c])
    for k, x in ((c - 1, P), (c + 1, S)):
        if np.hypot(x[0], x[1]) < r:
            raise ModelError(
                part.title,
                found=f"marker '{part.through[k]}' is {np.hypot(x[0], x[1]):.6g} m from the axis of the cylinder at "
                f"'{part.through[c]}', whose radius is {r:.6g} m",
                expected="a place outside",
                remedy="Move the marker, or give a smaller radius",
            )
    angle = float(np.sign(part.radii[c]) * np.arctan2(P[0] * S[1] - P[1] * S[0], P[0] * S[0] + P[1] * S[1]))
    angle += 2.0 * np.pi if angle < -0.5 * np.pi else 0.0
    if passes_behind(part.radii[c], P, S, angle):
        raise ModelError(
            part.title,
            found=f"the straight line from '{part.through[c - 1]}' to '{part.through[c + 1]}' cuts the cylinder at "
            f"'{part.through[c]}' on the other side of its axis",
            expected="a way that goes around the z-axis of the cylinder with the sign of its radius",
            remedy=f"Write radii with {-part.radii[c]:g} m there, or move the markers",
        )
    return angle


def described_length(part, compiler) -> float:
    """Return the length of the way as described, m."""
    markers = [compiler.marker(name) for name in part.through]
    total, k = 0.0, 0
    while k < len(markers) - 1:
        end = k + 1
        if part.radii[end]:
            c, end = end, k + 2
            center, R = compiler.pose(markers[c])
            P, S = (R.T @ (compiler.position(markers[m]) - center) for m in (k, end))
            contact = contact_angle(part.radii[c], P, S, _described_angle(part, compiler, markers, c))
            if contact > 0.0:
                total += around_cylinder(part.radii[c], P, S, contact, np.empty((2, 3)), np.empty((6, 6)))
                k = end
                continue
        total += float(np.linalg.norm(compiler.position(markers[end]) - compiler.position(markers[k])))
        k = end
    return total
