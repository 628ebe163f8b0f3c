"""Axes of markers on a plate, and what holds the nodes of an edge on the ground."""

from __future__ import annotations

import numpy as np

from flexmb.bodies.plate.places import Place, functional
from flexmb.errors import ModelError
from flexmb.model.pose import Pose

__all__ = ["director_rows", "held_edge", "marker_axes"]


def held_edge(plate, name: str, edge: str, joint, rotation):
    """Return an `AncfPlate` with markers on an edge, the ground's markers and the joints, see `AncfPlate.held`."""
    if edge not in ("s0", "s1", "t0", "t1"):
        raise ModelError(
            plate.title,
            found=f"edge {edge!r}",
            expected="One of: s0, s1, t0, t1",
            remedy="s0 is the edge where the fraction s is 0",
        )
    along_t, end = edge[0] == "s", float(edge[1])
    n, axes = plate.elements[1 if along_t else 0], Pose((0.0, 0.0, 0.0), rotation).matrix
    markers, supports, joints = dict(plate.markers), {}, []
    for k in range(n + 1):
        where, own = (end, k / n) if along_t else (k / n, end), f"{name}_{k}"
        r, a, b = plate.drawn_at(*functional(plate, Place(where[0], where[1], None)))
        markers[own] = (where, marker_axes(a, b, plate.shear).T @ axes)
        supports[own] = Pose(tuple(r), axes)
        joints.append(joint(own, markers=(f"ground.{own}", f"{plate.name}.{own}")))
    return plate.replaced(markers=markers), supports, tuple(joints)


def director_rows(a, b) -> np.ndarray:
    """Return the frame of two directions as the kernels make it, by rows: along b x a, across, along a."""
    e3, e1 = a / np.linalg.norm(a), np.cross(b, a)
    e1 = e1 / np.linalg.norm(e1)
    return np.array([e1, np.cross(e3, e1), e3])


def marker_axes(a, b, shear: bool) -> np.ndarray:
    """Return marker axes (3, 3): x along s, z normal; a, b are r_s, r_t of thin plates, d, r_s of others."""
    e1, e2, e3 = director_rows(a, b)
    return np.stack([e2, -e1, e3] if shear else [e3, e2, -e1], axis=1)
