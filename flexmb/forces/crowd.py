"""Crowds: so many surfaces that those near each other are looked for anew in every evaluation.

Every surface has a row of `CROWD_STRIDE` numbers in the bulk data: its marker, its own place there, the groups it
belongs to (1: the first, 2: the second, 3: both), its body, and the pair of its marker with itself. Two surfaces have
no place of their own in the iteration matrix. Each adds its derivatives by its own motion there, and those by the
motion of the other are left out: implicit methods iterate with such a matrix until the equations, which are complete,
hold.
"""

from __future__ import annotations

import numpy as np

from flexmb.forces.relative import add_relative_tangent
from flexmb.forces.surface_pair import press_surfaces
from flexmb.math.impact_steps import LONGEST, SHORTEST, slow_speed, strikes, struck
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.switches import COLUMNS, IDLE
from flexmb.math.tables import PAIR
from flexmb.math.vectors import cross
from flexmb.surfaces.advancement import POSE, first_touch, part_within
from flexmb.surfaces.detection import find_closest, nearest_sample
from flexmb.surfaces.neighbours import near_among
from flexmb.surfaces.records import CONTACT, FAR, REACH

__all__ = ["CROWD_STRIDE", "gaps_in_crowd", "keep_poses", "press_crowd", "sweep_crowd"]

CROWD_STRIDE = 5
FELT = 2e-3
"""Share of the speed of an impact by which the step in which it begins may change it."""


@inner_kernel
def _numbers(row, data):
    """Return the groups and the bodies of all surfaces."""
    side, body = np.empty(row.count, np.int64), np.empty(row.count, np.int64)
    for k in range(row.count):
        at = row.pairs + CROWD_STRIDE * k
        side[k], body[k] = int(data[at + 2]), int(data[at + 3])
    return side, body


@inner_kernel
def _reach(row, data, k):
    return data[int(data[row.pairs + CROWD_STRIDE * k + 1]) + REACH]


@inner_kernel
def _near(row, data, markers):
    """Return the pairs (n, 2) of surfaces whose balls meet at the placed markers."""
    places, reach = np.empty((row.count, 3)), np.empty(row.count)
    for k in range(row.count):
        marker = markers[int(data[row.pairs + CROWD_STRIDE * k])]
        reach[k] = _reach(row, data, k)
        for i in range(3):
            places[k, i] = marker.r[i]
    side, body = _numbers(row, data)
    return near_among(places, reach, side, body)


@kernel
def press_crowd(row, data, work, wanted, contacts, motion, Q, f, K, C):
    """Let all surfaces that touch press on each other, and add their derivatives by their own motions."""
    pairs = _near(row, data, work.markers)
    blocks = np.zeros(1, PAIR)
    for n in range(len(pairs)):
        first, second = row.pairs + CROWD_STRIDE * pairs[n, 0], row.pairs + CROWD_STRIDE * pairs[n, 1]
        a, b = work.markers[int(data[first])], work.markers[int(data[second])]
        at_a, at_b = int(data[first + 1]), int(data[second + 1])
        if not press_surfaces(row, data, a, b, at_a, at_b, wanted, contacts, motion, Q, f, K, C, work.energy):
            continue
        if wanted:
            block = blocks[0]  # within the loop: a row does not keep its table, which would be freed before
            block.K[:] = 0.0
            block.D[:] = 0.0
            add_relative_tangent(block, a, b, f, K, C)
            one, other = work.pairs[int(data[first + 4])], work.pairs[int(data[second + 4])]
            for i in range(6):
                for j in range(6):
                    one.K[i, j] += block.K[i, j]
                    one.D[i, j] += block.D[i, j]
                    other.K[i, j] += block.K[6 + i, 6 + j]
                    other.D[i, j] += block.D[6 + i, 6 + j]


@kernel
def keep_poses(row, data, markers, out):
    """Write where the surfaces are, and how they move, in the axes of W, for `sweep_crowd`: one place of each."""
    for k in range(row.count):
        marker, place = markers[int(data[row.pairs + CROWD_STRIDE * k])], out[k]
        place[:] = 0.0
        place[0] = IDLE
        for i in range(3):
            place[POSE + i], place[POSE + 3 + i], place[POSE + 6 + i] = marker.r[i], marker.v[i], marker.w[i]
            for j in range(3):
                place[POSE + 9 + 3 * i + j] = marker.R[i, j]


@inner_kernel
def _relative(a, b, out):
    """Write d, d', w and Q of b in the axes of a, from two kept poses."""
    r, v, t = np.empty(3), np.empty(3), np.empty(3)
    for i in range(3):
        r[i] = b[POSE + i] - a[POSE + i]
    cross(a[POSE + 6 : POSE + 9], r, t)
    for i in range(3):
        v[i] = b[POSE + 3 + i] - a[POSE + 3 + i] - t[i]
    for i in range(3):
        for k in range(3):
            out[POSE + 3 * k + i] = 0.0
            out[POSE + 9 + 3 * i + k] = 0.0
        for j in range(3):
            x = a[POSE + 9 + 3 * j + i]
            out[POSE + i] += x * r[j]
            out[POSE + 3 + i] += x * v[j]
            out[POSE + 6 + i] += x * (b[POSE + 6 + j] - a[POSE + 6 + j])
            for k in range(3):
                out[POSE + 9 + 3 * i + k] += x * b[POSE + 9 + 3 * j + k]


@inner_kernel
def _gap(sampled, data, at_a, at_b, pose, Q, contacts):
    """Write the gap at a relative pose to its row."""
    for i in range(9):
        Q[i // 3, i % 3] = pose[POSE + 9 + i]
    if sampled:
        nearest_sample(data, at_a, at_b, np.inf, pose[POSE : POSE + 3], Q, contacts)
    else:
        find_closest(data, at_a, at_b, np.inf, pose[POSE : POSE + 3], Q, contacts)
    pose[1] = contacts[0].gap
    return pose[1]


@inner_kernel
def _rate(pose, contact):
    """Return the rate of the gap at a contact, m/s."""
    lever, u = np.empty(3), np.empty(3)
    for i in range(3):
        lever[i] = contact.x[i] - pose[POSE + i]
    cross(pose[POSE + 6 : POSE + 9], lever, u)
    rate = 0.0
    for i in range(3):
        rate += contact.n[i] * (pose[POSE + 3 + i] + u[i])
    return rate


@inner_kernel
def _followed(g0, g1, before, after, h, limits):
    """Return how much longer or shorter a step may be for an impact, and if it is to end where the contact begins."""
    floor, share = limits[0].floor, limits[0].impact
    short = 2.0 * max(abs(before), abs(after)) * h <= floor
    if not strikes(before, after, short, floor, limits[0].duration):
        return LONGEST, False
    slow, depth = slow_speed(limits, floor, h), max(-g0, -g1)
    fits = struck(before, after, depth, h, share, slow)
    if not g0 > 0.0 > g1:
        return fits, False
    if limits[0].unfelt == 1.0:
        return fits, not short
    return fits, fits >= 1.0 and struck(before, after, depth, h, min(share, FELT), slow) < 1.0


@kernel
def sweep_crowd(row, data, now, then, h, adaptive, limits, part):
    """Lower part[0] to where in a step two surfaces first touch that are apart at both of its ends, see `part_within`
    for the others; where steps are `adaptive` those that strike are followed, as gaps of two surfaces are.

    Between the ends a marker goes on a cubic, within the hull of four points: the ball around it is that of the way.
    """
    n, floor = row.count, limits[0].floor
    follows = adaptive and np.isfinite(limits[0].impact)
    places, reach = np.empty((n, 3)), np.empty(n)
    for k in range(n):
        a, b = now[k], then[k]
        way = np.zeros(3)
        for i in range(3):
            places[k, i] = 0.5 * (a[POSE + i] + b[POSE + i])
        for i in range(3):
            c = places[k, i]
            way[0] += (a[POSE + i] - c) ** 2
            way[1] += (a[POSE + i] + h / 3.0 * a[POSE + 3 + i] - c) ** 2
            way[2] += (b[POSE + i] - h / 3.0 * b[POSE + 3 + i] - c) ** 2
        reach[k] = min(_reach(row, data, k) + max(way[0], way[1], way[2]) ** 0.5, FAR)
    side, body = _numbers(row, data)
    pairs = near_among(places, reach, side, body)
    sampled = 1 if row.law == 0 else 0
    begin, end, Q = np.zeros(COLUMNS), np.zeros(COLUMNS), np.empty((3, 3))
    contacts = np.empty(2, CONTACT)
    for m in range(len(pairs)):
        i, j = pairs[m, 0], pairs[m, 1]
        at_a = int(data[row.pairs + CROWD_STRIDE * i + 1])
        at_b = int(data[row.pairs + CROWD_STRIDE * j + 1])
        _relative(now[i], now[j], begin)
        _relative(then[i], then[j], end)
        g0, before = _gap(sampled, data, at_a, at_b, begin, Q, contacts), _rate(begin, contacts[0])
        g1, after = _gap(sampled, data, at_a, at_b, end, Q, contacts), _rate(end, contacts[0])
        if g0 > 0.0 and g1 > 0.0:
            free = first_touch(data, sampled == 1, at_a, at_b, begin, end, h, floor, contacts)
            # the way between does not know what turned the motion: one end leads through the other surface then
            if follows and free >= 1.0 and (g0 + h * before < 0.0 or g1 - h * after < 0.0):
                part[0] = min(part[0], _followed(g0, g1, before, after, h, limits)[0])
        else:
            free = part_within(data, sampled == 1, at_a, at_b, begin, end, before, h, floor, contacts)
            if follows and free >= 1.0:
                fits, begins = _followed(g0, g1, before, after, h, limits)
                part[0] = min(part[0], fits)
                if begins:
                    free = first_touch(data, sampled == 1, at_a, at_b, begin, end, h, floor, contacts)
                    free = max(SHORTEST, min(0.9, free))
        if free < 1.0:
            part[0] = min(part[0], free)


@kernel
def gaps_in_crowd(data, starts, sampled, poses, pairs, out):
    """Write the gaps, m, of pairs of surfaces, which begin in `data` at `starts`, at kept poses."""
    pose, Q = np.zeros(COLUMNS), np.empty((3, 3))
    contacts = np.empty(2, CONTACT)
    for m in range(len(pairs)):
        i, j = pairs[m, 0], pairs[m, 1]
        _relative(poses[i], poses[j], pose)
        out[m] = _gap(sampled, data, starts[i], starts[j], pose, Q, contacts)
