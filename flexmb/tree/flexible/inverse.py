"""Inverse dynamics of trees with flexible links: the forces on joints and modes that second rates need.

A body's mass matrix times its second rates is held by what its joint, its markers and its modes get: eq. (bend-out)
before the modes are eliminated.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.eights import WIDTH, keep, more, read, same
from flexmb.math.kernel import inner_kernel
from flexmb.math.tables import pointer_kernel
from flexmb.tree.flexible.inertia import own_terms
from flexmb.tree.flexible.passes import forget_forces, leave_clamp, ride, write_place_columns
from flexmb.tree.rigid.closing import pass_on
from flexmb.tree.rigid.inverse import hold_links, move_links
from flexmb.tree.rigid.link_tree import PASS
from flexmb.tree.rigid.passes import let_fall
from flexmb.tree.rigid.places import BEND, MOUNT, carry

__all__ = ["inverting"]


@inner_kernel
def _ride_frame(flexible, link, row, of_parent, a):
    """Write the rate of the frame of a flexible body, which moves against its own marker with the modes."""
    body = flexible.bodies[link.block]
    V = row.rate
    carry(row, of_parent.rate, V)
    for i in range(6):
        V[i] += row.bias[i]
    leave_clamp(flexible, body, a, V)


@inner_kernel
def _move(tree):
    """Write the rates of all links at the second rates tree.a, roots first, and add what rigid ones need."""
    flexible, links, rows = tree.flexible, tree.links, tree.rows
    for n in range(len(flexible.runs)):
        run = flexible.runs[n]
        k = run.first
        link, row = links[k], rows[k]
        if run.kind == MOUNT:
            ride(flexible, link, row, rows[link.parent], 1.0, tree.a)
        elif run.kind == BEND:
            _ride_frame(flexible, link, row, rows[link.parent], tree.a)
        else:
            move_links(links, rows, tree.a, k, run.last)


@inner_kernel
def _on_modes(loaded, m, W, sign, h):
    """Add what a wrench (6,) of a place, moved to the frame, does to the modes, times a sign, to h (filled m,)."""
    for at in range(0, m, WIDTH):
        x = read(h, at)
        for i in range(6):
            x = more(x, same(sign * W[i]), read(loaded, (i, at)))
        keep(h, at, x)


@inner_kernel
def _resist(body, row, a, P, K, L, B, f, h):
    """Write the force f (6,) and h (filled m,) of a body alone: its blocks times the rates of its frame and modes."""
    m, V, first = body.m, row.rate, body.rate
    for i in range(6):
        x = row.force[i] + P[i, 6]
        for j in range(6):
            x += P[i, j] * V[j]
        for j in range(m):
            x += B[i, j] * a[first + j]
        f[i] = x
    for j in range(m):
        x = L[j, 6]
        for i in range(6):
            x += L[j, i] * V[i]
        for i in range(m):
            x += K[j, i] * a[first + i]
        h[j] = x


@inner_kernel
def _hold_body(tree, work, link, row):
    """Write the forces on the modes of a flexible body, and that of its frame: its own and of all that it carries."""
    flexible, f, W = tree.flexible, np.empty(6), np.empty(6)
    body = flexible.bodies[link.block]
    m, P = body.m, flexible.P
    L, K, B, h = flexible.L[link.block], flexible.K[body.kept], flexible.B[body.kept], flexible.eta[link.block]
    at = own_terms(tree, link.block, work)
    if tree.run[0].still == 1:
        forget_forces(m, P, L)
    _resist(body, row, tree.a, P, K, L, B, f, h)
    for n in range(body.first, body.last):
        place = flexible.places[n]
        mount = tree.rows[place.link]
        write_place_columns(tree, body, n, flexible.scratch[0], at)
        loaded = flexible.loaded[place.kept] if place.interface >= 0 else flexible.E[place.kept]
        W[:] = 0.0
        pass_on(mount, mount.force, W)
        for i in range(6):
            f[i] += W[i]
        _on_modes(loaded, m, W, 1.0, h)
    if body.clamp >= 0:
        place = flexible.places[body.clamp]
        write_place_columns(tree, body, body.clamp, flexible.scratch[0], at)
        loaded = flexible.loaded[place.kept] if place.interface >= 0 else flexible.E[place.kept]
        _on_modes(loaded, m, f, -1.0, h)
    for j in range(m):
        tree.tau[body.rate + j] = h[j]
    for i in range(6):
        row.force[i] = f[i]


@pointer_kernel(PASS)
def inverting(tree, work):
    """Write the forces tree.tau on the rates that the second rates tree.a need; links and forces are in place."""
    flexible, links, rows = tree.flexible, tree.links, tree.rows
    let_fall(rows[len(links)], tree.gravity, 1.0 - tree.run[0].still)
    _move(tree)
    for n in range(len(flexible.runs) - 1, -1, -1):
        run = flexible.runs[n]
        k = run.first
        link, row = links[k], rows[k]
        if run.kind == MOUNT:  # its body collects
            continue
        if run.kind != BEND:
            hold_links(links, rows, tree.tau, k, run.last)
            continue
        _hold_body(tree, work, link, row)
        if link.parent >= 0:
            pass_on(row, row.force, rows[link.parent].force)
