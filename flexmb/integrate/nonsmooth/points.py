"""The points at which surfaces with rigid laws touch, or may touch within a step."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.nonsmooth.problem import POINT
from flexmb.integrate.nonsmooth.solids import found_between_solids, gap_of_solids
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.vectors import cross, dot, matvec, matvec_t
from flexmb.surfaces.detection import bound_gap, find_closest, find_points
from flexmb.surfaces.edge_pairs import have_edges
from flexmb.surfaces.neighbours import FEW, LARGE, candidates, near_pairs
from flexmb.surfaces.records import CODE, CONTACT, CORNERS, FAR, PATCH, THICKNESS
from flexmb.surfaces.rod_on_plane import find_rod_on_plane, is_rod_on_plane
from flexmb.surfaces.skin_surface import pieces_of

__all__ = ["Touching"]

BALL = 1
"""Code of a sphere."""
SOME = 16
"""Contacts of a pair for which there is room at first."""


@inner_kernel
def _write_point(point, contact, a):
    """Write place and axes in W of a contact that is known in the axes of marker a."""
    at, n = np.empty(3), np.empty(3)
    for i in range(3):
        at[i] = contact.x[i] - 0.5 * contact.gap * contact.n[i]
        point.local[i] = at[i]
    matvec(a.R, at, n)
    for i in range(3):
        point.r[i] = a.r[i] + n[i]
    matvec(a.R, contact.n, n)
    least = 0
    for i in range(3):
        if abs(n[i]) < abs(n[least]):
            least = i
    j, k = (least + 1) % 3, (least + 2) % 3
    size = (n[j] * n[j] + n[k] * n[k]) ** 0.5
    for i in range(3):
        point.axes[0, i] = n[i]
    # t1 = e x n / |e x n| with the axis e that is nearest to a right angle, t2 = n x t1
    point.axes[1, least], point.axes[1, j], point.axes[1, k] = 0.0, -n[k] / size, n[j] / size
    t = point.axes[1]
    for i in range(3):
        p, q = (i + 1) % 3, (i + 2) % 3
        point.axes[2, i] = n[p] * t[q] - n[q] * t[p]
    point.gap = contact.gap


@inner_kernel
def _by_centre(data, at_a, at_b):
    """Is one surface a ball, and the other one with a distance from its centre?"""
    a, b = int(data[at_a + CODE]), int(data[at_b + CODE])
    return (a == BALL or b == BALL) and a != PATCH and b != PATCH


@inner_kernel
def _relative_place(a, b, d, Q):
    """Write the place of marker b from a, and its axes, in the axes of a; return the speeds of b as seen from a."""
    r, v, t = np.empty(3), np.empty(3), np.empty(3)
    spin = 0.0
    for i in range(3):
        r[i] = b.r[i] - a.r[i]
        spin += (b.w[i] - a.w[i]) ** 2
        for j in range(3):
            Q[i, j] = a.R[0, i] * b.R[0, j] + a.R[1, i] * b.R[1, j] + a.R[2, i] * b.R[2, j]
    matvec_t(a.R, r, d)
    cross(a.w, r, t)
    for i in range(3):
        v[i] = b.v[i] - a.v[i] - t[i]
    return dot(v, v) ** 0.5, spin**0.5


@inner_kernel
def _found_between(data, at_a, at_b, edges, own, other, margin, d, Q, contacts):
    """Write the contacts of two surfaces; return how many, those for which there is no room included."""
    if _by_centre(data, at_a, at_b):
        return find_closest(data, at_a, at_b, margin, d, Q, contacts)
    if is_rod_on_plane(data, at_a, at_b):
        return find_rod_on_plane(data, at_a, at_b, margin, d, Q, contacts)
    if have_edges(edges, own, other):
        return found_between_solids(data, at_a, at_b, edges, own, other, margin, d, Q, contacts)
    return find_points(data, at_a, at_b, margin, d, Q, contacts)


@kernel
def find_in_pairs(
    markers, data, edges, surface_marker, place, edges_at, pairs, owner, law, span, slack, contacts, points, found
):
    """Write the points of pairs of surfaces that may close in a step of length `span`; return how many there are then,
    and the most contacts of a pair.

    `slack` (m) is what accelerations may close. Points beyond the size of `points` are counted, not written, and so are
    contacts of a pair beyond that of `contacts`.
    """
    d, Q = np.empty(3), np.empty((3, 3))
    most = 0
    for n in range(len(pairs)):
        i, j = pairs[n, 0], pairs[n, 1]
        a, b = markers[surface_marker[i]], markers[surface_marker[j]]
        speed, spin = _relative_place(a, b, d, Q)
        at_a, at_b = place[i], place[j]
        reach = min(data[at_b + 1], data[at_a + 1] + dot(d, d) ** 0.5)
        margin = slack + 2.0 * span * (speed + reach * spin)
        if bound_gap(data, at_a, at_b, d, Q) >= margin:
            continue
        count = _found_between(data, at_a, at_b, edges, edges_at[i], edges_at[j], margin, d, Q, contacts)
        most = max(most, count)
        for c in range(min(count, len(contacts))):
            if found < len(points):
                point = points[found]
                _write_point(point, contacts[c], a)
                point.a, point.b = surface_marker[i], surface_marker[j]
                point.owner, point.key = owner, (owner * len(place) + i) * len(place) + j
                point.restitution, point.poisson, point.friction = law[0], law[1], law[2]
                point.drilling, point.rolling = law[3], law[4]
            found += 1
    return found, most


@inner_kernel
def _least_gap(data, at_a, at_b, edges, own, other, enough, d, Q, contacts, n):
    """Return the gap of two surfaces that may meet, m, but none below zero, and write its normal; -1 if nothing of one
    may meet the other. Of solids with edges none above `enough`, m, is looked for.
    """
    if have_edges(edges, own, other):
        return gap_of_solids(data, at_a, at_b, edges, own, other, enough, d, Q, contacts, n)
    if _by_centre(data, at_a, at_b):
        count = find_closest(data, at_a, at_b, np.inf, d, Q, contacts)
    else:
        count = find_points(data, at_a, at_b, np.inf, d, Q, contacts)
    least = np.inf
    for c in range(count):
        if contacts[c].gap < least:
            least = contacts[c].gap
            n[:] = contacts[c].n
    return max(least, 0.0) if count else -1.0


@kernel
def longest_step(markers, data, edges, surface_marker, place, edges_at, thickness, convex, pairs, span, contacts):
    """Return the longest step, s, up to `span`, in which no pair of surfaces passes through each other.

    Contacts are looked for in the middle of a step, and a point inside a body is pushed out of the nearest face. So a
    step may end a quarter of the thinner body deep; the middle of the next one is then above half. Between convex
    surfaces a plane stands, so only the way along the normal counts, and what turning adds to it.
    """
    d, Q = np.empty(3), np.empty((3, 3))
    r, v, t, n = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for m in range(len(pairs)):
        i, j = pairs[m, 0], pairs[m, 1]
        room = 0.25 * min(thickness[i], thickness[j])
        if max(thickness[i], thickness[j]) >= FAR:
            continue
        a, b = markers[surface_marker[i]], markers[surface_marker[j]]
        speed, spin = _relative_place(a, b, d, Q)
        at_a, at_b = place[i], place[j]
        turning = spin * min(data[at_b + 1], data[at_a + 1] + dot(d, d) ** 0.5)
        if span * (speed + turning) <= room + max(0.0, bound_gap(data, at_a, at_b, d, Q)):
            continue
        nearing = speed + turning
        enough = span * nearing
        gap = _least_gap(data, at_a, at_b, edges, edges_at[i], edges_at[j], enough, d, Q, contacts, n)
        if gap >= enough:
            continue
        if gap >= 0.0 and convex[i] and convex[j]:
            for k in range(3):
                r[k] = b.r[k] - a.r[k]
            cross(a.w, r, t)
            for k in range(3):
                t[k] = b.v[k] - a.v[k] - t[k]
            matvec_t(a.R, t, v)
            nearing = max(0.0, -dot(n, v)) + turning
        gap = max(gap, 0.0)
        if nearing * span > room + gap:
            span = (room + gap) / nearing
    return span


class Touching:
    """The surfaces of a system that touch by rigid laws.

    Parameters
    ----------
    system : System
    """

    def __init__(self, system):
        model = system.model
        self.forces = [(k, f) for k, f in enumerate(model.forces) if f.impulsive]
        names = dict.fromkeys(name for _, f in self.forces for group in f.groups for name in group)
        self.surfaces = pieces_of(model, names, "rigid contact")
        number = {surface.name: k for k, surface in enumerate(self.surfaces)}
        packed = [surface.packed for surface in self.surfaces]
        starts = np.concatenate([[0], np.cumsum([len(x) for x in packed])]).astype(np.int64)
        self.place = starts[:-1].copy()
        self.data = np.concatenate([*packed, np.zeros(1)])
        edges = [surface.packed_edges for surface in self.surfaces]
        self.edges_at = np.concatenate([[0], np.cumsum([len(x) for x in edges])]).astype(np.int64)[:-1]
        self.edges = np.concatenate([*edges, np.zeros(1)])
        self.marker = np.array([system.marker_index[s.marker] for s in self.surfaces], np.int64)
        bodies = {name: k for k, name in enumerate(dict.fromkeys(s.marker.split(".")[0] for s in self.surfaces))}
        self.body = np.array([bodies[s.marker.split(".")[0]] for s in self.surfaces], np.int64)
        self.reach = np.array([self.data[at + 1] for at in self.place])
        ends = self.reach[self.reach < FAR]
        self.small = float(np.min(ends)) if len(ends) else system.lengths.whole
        self.large = float(np.max(ends, initial=0.0))
        self.thickness = self.data[self.place + THICKNESS]  # m; FAR of a half-space
        self.convex = np.array([surface.shape.convex for surface in self.surfaces])
        corners = max((int(self.data[at + CORNERS]) for at in self.place), default=0)
        self.contacts = np.zeros(2 * corners + SOME, CONTACT)
        self.groups = [self._group(model, f, number) for _, f in self.forces]
        self.points = np.zeros(64, POINT)

    def __deepcopy__(self, memo: dict) -> Touching:
        """Return itself: surfaces, which may be large, and scratch; nothing in it goes on from step to step."""
        return self

    def _group(self, model, force, number):
        groups = (pieces_of(model, group, force.title) for group in force.groups)
        first, second = (np.array([number[s.name] for s in group], np.int64) for group in groups)
        law = force.law
        newton, poisson = (law.restitution, 0.0) if law.rule == "Newton" else (0.0, law.restitution)
        given = (newton, poisson, law.friction, law.drilling, law.rolling)
        numbers = np.array(given, float)
        if len(first) * len(second) <= FEW:
            return numbers, candidates(first, second, self.body), None
        side = np.zeros(len(self.surfaces), np.int64)
        side[first] |= 1
        side[second] |= 2
        members = np.flatnonzero(side)
        typical = np.median(self.reach[members])
        large = (self.reach[members] > LARGE * typical) | (self.reach[members] >= FAR)
        return numbers, np.zeros((64, 2), np.int64), (side, members[~large], members[large])

    def longest(self, work, span: float, slack: float) -> float:
        """Return the step, s, up to `span`, in which no surfaces at the placed markers of `work` miss each other."""
        for k in range(len(self.forces)):
            pairs = self._pairs(k, work, span, slack)
            span = longest_step(
                work.markers,
                self.data,
                self.edges,
                self.marker,
                self.place,
                self.edges_at,
                self.thickness,
                self.convex,
                pairs,
                span,
                self.contacts,
            )
        return span

    def found(self, work, span: float, slack: float) -> np.ndarray:
        """Return the points (n,) at the placed markers of `work` that may close within `span` (s) or `slack` (m)."""
        while True:
            total, most = 0, 0
            for k, (owner, _) in enumerate(self.forces):
                law, _, _ = self.groups[k]
                pairs = self._pairs(k, work, span, slack)
                total, own = find_in_pairs(
                    work.markers,
                    self.data,
                    self.edges,
                    self.marker,
                    self.place,
                    self.edges_at,
                    pairs,
                    owner,
                    law,
                    span,
                    slack,
                    self.contacts,
                    self.points,
                    total,
                )
                most = max(most, own)
            if total <= len(self.points) and most <= len(self.contacts):
                break
            if most > len(self.contacts):
                self.contacts = np.zeros(2 * most, CONTACT)
            if total > len(self.points):
                self.points = np.zeros(2 * total, POINT)
        points = self.points[:total]
        return points[np.argsort(points["key"], kind="stable")]

    def _pairs(self, k: int, work, span: float, slack: float) -> np.ndarray:
        law, pairs, grid = self.groups[k]
        if grid is None:
            return pairs
        side, members, large = grid
        markers = work.markers[self.marker]
        speed = np.linalg.norm(markers["v"], axis=1) + self.reach * np.linalg.norm(markers["w"], axis=1)
        reach = self.reach + slack + 2.0 * span * np.where(self.reach < FAR, speed, 0.0)
        size = 2.0 * float(np.max(reach[members], initial=0.0)) * (1.0 + 1e-9)
        places = np.ascontiguousarray(markers["r"])
        while True:
            count = near_pairs(places, reach, side, self.body, members, large, max(size, 1e-300), pairs)
            if count <= len(pairs):
                return pairs[:count]
            pairs = np.zeros((2 * count, 2), np.int64)
            self.groups[k] = law, pairs, grid
