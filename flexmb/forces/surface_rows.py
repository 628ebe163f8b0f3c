"""The rows of `SurfaceContact`, and its kernels.

Few surfaces are looked at two by two, and every two have their places in the iteration matrix. Of a crowd those near
each other are found by a grid in every evaluation.
"""

from __future__ import annotations

import numpy as np

from flexmb.forces.crowd import keep_poses, press_crowd, sweep_crowd
from flexmb.forces.relative import add_relative_tangent, relative_motion
from flexmb.forces.surface_pair import press_surfaces
from flexmb.math.kernel import inner_kernel
from flexmb.math.switches import GAP, IDLE, SLIP, sweep_kernel, switch_kernel
from flexmb.math.tables import DAMPED, row_kernel
from flexmb.math.vectors import cross, dot
from flexmb.surfaces.advancement import first_touch, part_within
from flexmb.surfaces.detection import find_closest, nearest_sample
from flexmb.surfaces.records import CONTACT, REACH

__all__ = ["PAIR_STRIDE", "ROW", "apply", "sweep", "switch"]

ROW = np.dtype(
    [
        ("pairs", np.int64),  # where the pairs of surfaces begin in the bulk data, `PAIR_STRIDE` numbers each
        ("count", np.int64),  # how many they are
        ("crowd", np.int64),  # 1: instead of pairs there are surfaces, see `flexmb.forces.crowd`
        ("switches", np.int64),  # two of each pair, or one of each surface of a crowd
        ("capacity", np.int64),  # most contacts of a pair, and one more
        ("law", np.int64),
        ("stiffness", float),  # N/m^e, or per area
        ("exponent", float),
        ("damping", float),  # s/m
        ("friction", float),
        ("transition", float),  # m/s
        ("restitution", float),
    ],
    align=True,
)
PAIR_STRIDE = 5
"""Marker of a and of b, number of the pair in the matrix, place of surface a and of b in the bulk data. Of a rigid law:
a marker and the branch of its wrench, 0, 0, 0."""


@inner_kernel
def _far(a, b, reach):
    """Are two markers farther apart than the balls around their surfaces reach?"""
    square = 0.0
    for i in range(3):
        square += (b.r[i] - a.r[i]) ** 2
    return square >= reach * reach


@inner_kernel
def _act_as_kept(row, data, state, work):
    """Let the wrenches act on markers that a method found for its rigid contacts; they stand in the last coordinates.

    A method of impulses has none there while it looks for them.
    """
    first = len(state.q) - len(work.branches)
    for k in range(row.count):
        at = row.pairs + PAIR_STRIDE * k
        marker, branch = work.markers[int(data[at])], int(data[at + 1])
        for i in range(6):
            wrench = state.q[first + branch + i]
            marker.wrench[i] += wrench
            work.branches[branch + i] = wrench


@row_kernel
def apply(raw, data, state, work):
    """Force and friction at every contact, eq. (surface-contact), as a wrench on the markers of the surfaces."""
    rows = raw.view(ROW)
    motion = np.empty(9)
    Q = np.empty((3, 3))
    f = np.empty(6)
    K = np.empty((6, 6))
    C = np.empty((6, 6))
    for m in range(rows.shape[0]):
        row = rows[m]
        if row.law > 1:
            _act_as_kept(row, data, state, work)
            continue
        contacts = np.empty(row.capacity, CONTACT)
        wanted = work.weights[0].wanted == 1
        if row.crowd == 1:
            press_crowd(row, data, work, wanted, contacts, motion, Q, f, K, C)
            continue
        for k in range(row.count):
            at = row.pairs + PAIR_STRIDE * k
            a, b = work.markers[int(data[at])], work.markers[int(data[at + 1])]
            at_a, at_b = int(data[at + 3]), int(data[at + 4])
            if wanted:
                # most pairs touch nothing: their blocks need neither clearing nor adding
                work.pairs[int(data[at + 2])].active = 0
            if _far(a, b, data[at_a + REACH] + data[at_b + REACH]):
                continue
            if not press_surfaces(row, data, a, b, at_a, at_b, wanted, contacts, motion, Q, f, K, C, work.energy):
                continue
            if wanted:
                pair = work.pairs[int(data[at + 2])]
                pair.active = DAMPED
                pair.K[:] = 0.0
                pair.D[:] = 0.0
                add_relative_tangent(pair, a, b, f, K, C)


@switch_kernel
def switch(raw, data, state, work, out):
    """The least gap of every pair, and the slip where it touches."""
    rows = raw.view(ROW)
    motion = np.empty(9)
    Q = np.empty((3, 3))
    u = np.empty(3)
    lever = np.empty(3)
    contacts = np.empty(2, CONTACT)
    first = 0
    for m in range(rows.shape[0]):
        row = rows[m]
        if row.law > 1:
            continue
        if row.crowd == 1:
            keep_poses(row, data, work.markers, out[first : first + row.switches])
            first += row.switches
            continue
        for k in range(row.count):
            gap, slip = out[first + 2 * k], out[first + 2 * k + 1]
            gap[:] = 0.0
            slip[:] = 0.0
            gap[0], slip[0] = IDLE, IDLE
            at = row.pairs + PAIR_STRIDE * k
            relative_motion(work.markers[int(data[at])], work.markers[int(data[at + 1])], motion, Q)
            at_a, at_b = int(data[at + 3]), int(data[at + 4])
            if row.law == 0:
                nearest_sample(data, at_a, at_b, np.inf, motion[0:3], Q, contacts)
            else:
                find_closest(data, at_a, at_b, np.inf, motion[0:3], Q, contacts)
            nearest = contacts[0]
            for i in range(3):
                lever[i] = nearest.x[i] - motion[i]
            cross(motion[6:9], lever, u)
            for i in range(3):
                u[i] += motion[3 + i]
            rate = dot(nearest.n, u)
            gap[0], gap[1], gap[4], gap[9] = GAP, nearest.gap, rate, 1.0
            gap[10:19] = motion
            for i in range(9):
                gap[19 + i] = Q[i // 3, i % 3]
            if nearest.gap < 0.0 and row.friction > 0.0:
                slip[0], slip[8] = SLIP, row.transition
                for i in range(3):
                    slip[4 + i] = u[i] - rate * nearest.n[i]
        first += row.switches


@sweep_kernel
def sweep(raw, data, now, then, h, adaptive, limits, part):
    """Contacts that begin and end within a step, or lead far through the thinner surface."""
    rows = raw.view(ROW)
    contacts = np.empty(2, CONTACT)
    floor = limits[0].floor
    first = 0
    for m in range(rows.shape[0]):
        row = rows[m]
        if row.law > 1:
            continue
        if row.crowd == 1:
            last = first + row.switches
            sweep_crowd(row, data, now[first:last], then[first:last], h, adaptive, limits, part)
            first = last
            continue
        for k in range(row.count):
            a, b = now[first + 2 * k], then[first + 2 * k]
            if a[0] != GAP or b[0] != GAP:
                continue
            at = row.pairs + PAIR_STRIDE * k
            at_a, at_b = int(data[at + 3]), int(data[at + 4])
            if a[1] > 0.0 and b[1] > 0.0:
                free = first_touch(data, row.law == 0, at_a, at_b, a, b, h, floor, contacts)
            else:
                free = part_within(data, row.law == 0, at_a, at_b, a, b, a[4], h, floor, contacts)
            if free < 1.0:
                part[0] = min(part[0], free)
        first += row.switches
