"""How ways over cylinders are drawn: short straight pieces between places that are a share of the way apart."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from flexmb.io.solids import Surface, tube

__all__ = ["PIECES", "place_on_way", "way_pieces"]

PIECES = 24
"""Straight pieces that a way around a cylinder is drawn with."""


def way_pieces(force, e: float) -> list[tuple[tuple, Surface]]:
    """Return what is drawn of the way of a force, of thickness `e` (m): (carrier, surface).

    Carriers are ("link", marker, marker, force), and ("way", marker before, cylinder, marker behind, radius, share,
    share, force) around a cylinder.
    """
    rod = tube((0, 0, 0), (0, 0, 1), 0.5 * e)
    pieces: list[tuple[tuple, Surface]] = []
    k = 0
    while k < len(force.through) - 1:
        radius = force.radii[k + 1]
        if radius == 0.0:
            pieces.append((("link", force.through[k], force.through[k + 1], force.name), rod))
            k += 1
            continue
        shares = np.linspace(0.0, 1.0, PIECES + 1).tolist()
        markers = force.through[k : k + 3]
        pieces += [(("way", *markers, radius, a, b, force.name), rod) for a, b in pairwise(shares)]
        drum = tube((0, 0, -2.0 * abs(radius)), (0, 0, 2.0 * abs(radius)), abs(radius) * (1.0 - 1e-3) - 0.5 * e)
        if abs(radius) > e:
            pieces.append((("marker", markers[1], force.name), drum))
        k += 2
    return pieces


def place_on_way(before, cylinder, behind, radius: float, share: float) -> np.ndarray:
    """Return the places (nt, 3), m, in W, at a share of the way between two markers around a cylinder.

    Parameters
    ----------
    before, cylinder, behind : marker motions with r (nt, 3), and R (nt, 3, 3) of the cylinder
    radius : float, m
        Negative: clockwise about the z-axis of the cylinder.
    share : float
        0 at the marker before, 1 at the one behind.
    """
    r, sense = abs(radius), float(np.sign(radius))
    P, S = (np.einsum("tji,tj->ti", cylinder.R, end.r - cylinder.r) for end in (before, behind))
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
