"""How ways over cylinders are drawn: short straight pieces between places that are a share of the way apart."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from flexmb.forces.cylinders_in_a_row import places_between, turn_about
from flexmb.forces.path_fields import first_places
from flexmb.io.solids import Surface, tube

__all__ = ["PIECES", "ends_between", "place_on_way", "way_pieces"]

PIECES = 24
"""Straight pieces that a way around a cylinder is drawn with."""


def way_pieces(force, e: float) -> list[tuple[tuple, Surface]]:
    """Return what is drawn of the way of a force, of thickness `e` (m): (carrier, surface).

    Carriers are ("link", marker, marker, force), and ("way", markers, radii, number, share, share, force) around one of
    the cylinders between two markers.
    """
    rod = tube((0, 0, 0), (0, 0, 1), 0.5 * e)
    pieces: list[tuple[tuple, Surface]] = []
    k = 0
    while k < len(force.through) - 1:
        end = k + 1
        while force.radii[end]:
            end += 1
        if end == k + 1:
            pieces.append((("link", force.through[k], force.through[end], force.name), rod))
        shares = np.linspace(0.0, 1.0, PIECES + 1).tolist()
        markers, radii = force.through[k : end + 1], force.radii[k + 1 : end]
        for j, radius in enumerate(radii):
            pieces += [(("way", markers, radii, j, a, b, force.name), rod) for a, b in pairwise(shares)]
            height = 2.0 * abs(radius)
            drum = tube((0, 0, -height), (0, 0, height), abs(radius) * (1.0 - 1e-3) - 0.5 * e)
            if abs(radius) > e:
                pieces.append((("marker", markers[1 + j], force.name), drum))
        k = end
    return pieces


def ends_between(motions, radii) -> np.ndarray:
    """Return the ends of the pieces of a way over each cylinder, (nt, m + 1, 3), m, in W.

    Parameters
    ----------
    motions : of the marker before, of the cylinders and of the marker behind, with r (nt, 3) and R (nt, 3, 3)
    radii : (m,), m
    """
    radii = np.array(radii, float)
    r = np.stack([motion.r for motion in motions], axis=1)
    R = np.ascontiguousarray(np.stack([motion.R for motion in motions[1:-1]], axis=1))
    ends = np.delete(r, -2, axis=1) if len(radii) == 1 else r[:, 1:].copy()
    ends[:, 0], ends[:, -1] = r[:, 0], r[:, -1]
    if len(radii) == 1:
        return ends
    near = np.full(len(radii), 0.5 * np.pi)
    X = first_places(radii, r[0, 1:-1], R[0], r[0, 0], r[0, -1])
    for k in range(len(r)):
        found = X.copy()
        if places_between(radii, np.ascontiguousarray(r[k, 1:-1]), R[k], near, r[k, 0].copy(), r[k, -1].copy(), found):
            X = found
        ends[k, 1:-1] = X
        for j in range(len(radii)):
            one, two = (R[k, j].T @ (x - r[k, 1 + j]) for x in ends[k, j : j + 2])
            near[j] = turn_about(radii[j], one, two, near[j])
    return ends


def place_on_way(before, cylinder, behind, radius: float, share: float) -> np.ndarray:
    """Return the places (nt, 3), m, in W, at a share of the way between two places around a cylinder.

    Parameters
    ----------
    before, behind : (nt, 3), m, in W
    cylinder : marker motion with r (nt, 3) and R (nt, 3, 3)
    radius : float, m
        Negative: clockwise about the z-axis of the cylinder.
    share : float
        0 at the place before, 1 at the one behind.
    """
    r, sense = abs(radius), float(np.sign(radius))
    P, S = (np.einsum("tji,tj->ti", cylinder.R, end - cylinder.r) for end in (before, behind))
    turn = sense * np.arctan2(P[:, 0] * S[:, 1] - P[:, 1] * S[:, 0], np.sum(P[:, :2] * S[:, :2], axis=1))
    turn = np.unwrap(turn) + (2.0 * np.pi if turn[0] < -0.5 * np.pi else 0.0)  # as described, then followed
    far = [np.hypot(x[:, 0], x[:, 1]) for x in (P, S)]
    open_angles = [np.arccos(np.clip(r / rho, 0.0, 1.0)) for rho in far]
    contact = turn - open_angles[0] - open_angles[1]
    tangents = [np.sqrt(np.maximum(rho * rho - r * r, 0.0)) for rho in far]
    whole = tangents[0] + r * contact + tangents[1]
    s = share * whole
    first = np.arctan2(P[:, 1], P[:, 0]) + sense * open_angles[0]
    angle = first + sense * np.clip((s - tangents[0]) / r, 0.0, np.maximum(contact, 0.0))
    on = r * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    along = sense * np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    beyond = np.minimum(s - tangents[0], 0.0) + np.maximum(s - tangents[0] - r * contact, 0.0)
    plane = on + beyond[:, None] * along
    around = np.column_stack([plane, P[:, 2] + share * (S[:, 2] - P[:, 2])])
    inside = np.where(contact[:, None] > 0.0, around, P + share * (S - P))
    return cylinder.r + np.einsum("tij,tj->ti", cylinder.R, inside)
