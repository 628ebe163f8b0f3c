"""The articulated-body algorithm for trees with flexible links.

Rigid links on which nothing flexible hangs take the passes of rigid trees.

Banerjee 1993 eliminates the modes of a body before its joint, as here: theory, eq. (bend-out).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.eights import WIDTH, keep, less, part, put, read, times, totals
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.prefetch import ask, ask_to_write
from flexmb.math.rotations import matrix_to_euler
from flexmb.math.tables import pointer_kernel
from flexmb.tree.flexible.carried import add_links, eliminate, hang, stiffened_columns
from flexmb.tree.flexible.inertia import filled, own_terms
from flexmb.tree.flexible.shapes import clear_inertia, place_bend, place_mount, rate_of_place, shape, write_columns
from flexmb.tree.flexible.tables import BENT, JOINT, PLACE, RIGID
from flexmb.tree.flexible.wide import add_own, clear_wide, force_with_bias, give_wide, move_wide, moved, open_wide
from flexmb.tree.rigid.link_tree import PASS, SPREAD
from flexmb.tree.rigid.passes import gather, let_fall, spread
from flexmb.tree.rigid.places import BEND, FRAME, LINK, MOUNT, carry, place_light, place_links

__all__ = [
    "forget_forces",
    "gathering",
    "leave_clamp",
    "placing",
    "ride",
    "spreading",
    "write_bodies",
    "write_place_columns",
]

AHEAD = 6
"""So many runs before they are needed, links are asked for on the way to the root: two flexible bodies of a chain."""

NEAR = 600
"""Up to so many runs, all that the passes use stays in the second cache, and asking would only take time."""

LINK_BYTES, PLACE_BYTES, BENT_BYTES, PRESENT_BYTES = LINK.itemsize, PLACE.itemsize, BENT.itemsize, 96


@inner_kernel
def _write_shape(tree, n, body, A, motion):
    """Write axes and motion of place n of a body, and keep what its columns are made of."""
    flexible = tree.flexible
    shapes = flexible.places[n].shapes
    eta, rate = tree.x[body.coordinate :], tree.v[body.rate :]
    shape(flexible.rests[shapes], flexible.rises[shapes], body.m, eta, rate, flexible.present[n], A, motion)


@pointer_kernel(PASS)
def placing(tree, work):
    """Place all links in their parents, write their twists, and own inertias and forces of the rigid ones."""
    flexible, links, rows = tree.flexible, tree.links, tree.rows
    A, motion = np.empty((3, 3)), np.empty(12)
    rows[len(links)].twist[:] = 0.0
    for n in range(len(flexible.runs)):
        run = flexible.runs[n]
        first = run.first
        link, row = links[first], rows[first]
        if run.light == 1:
            place_light(link, row, rows[link.parent], tree.x, tree.v, tree.a, A)
            continue
        if run.kind != BEND and run.kind != MOUNT:
            place_links(links, rows, tree.x, tree.v, tree.a, first, run.last)
            continue
        if run.kind == MOUNT:
            place = flexible.places[run.block]
            _write_shape(tree, run.block, flexible.bodies[place.body], A, motion)
            place_mount(row, rows[link.parent], A, motion)
            if place.rigid == 1:
                clear_inertia(row)
            continue
        body = flexible.bodies[run.block]
        if body.clamp >= 0:
            _write_shape(tree, body.clamp, body, A, motion)
        else:
            motion[:] = 0.0
            for i in range(3):
                for j in range(3):
                    A[i, j] = 1.0 if i == j else 0.0
        place_bend(link, row, rows[link.parent], A, motion)


@kernel
def write_bodies(tree, work):
    """Write coordinates and velocities of flexible bodies, which some forces read, and clear what forces write."""
    p = np.empty(4)
    for n in range(len(tree.flexible.bodies)):
        body = tree.flexible.bodies[n]
        pose, row = tree.poses[body.link], tree.rows[body.link]
        matrix_to_euler(pose.R, p)
        for i in range(3):
            tree.q[body.q + i] = pose.r[i]
            tree.u[body.u + i], tree.u[body.u + 3 + i] = row.twist[3 + i], row.twist[i]
        tree.q[body.q + 3 : body.q + 7] = p
        for j in range(body.m):
            tree.q[body.q + 7 + j], tree.u[body.u + 6 + j] = tree.x[body.coordinate + j], tree.v[body.rate + j]
        work.residual[body.u : body.u + 6 + body.m] = 0.0
    work.loads[:] = 0.0


@inner_kernel
def write_place_columns(tree, body, n, products, at):
    """Write the columns for motions of a place, and those for loads where stiffness changes them, at interfaces."""
    flexible = tree.flexible
    place = flexible.places[n]
    E = flexible.E[place.kept]
    write_columns(flexible.shapes[place.shapes], body.m, flexible.present[n], E)
    if place.interface >= 0:
        own = products[at + 6 * place.interface * filled(body.m) :]
        stiffened_columns(flexible.present[n], body.m, own, E, flexible.loaded[place.kept])


@inner_kernel
def _take_loads(row, loaded, m, zeros, P, L, out):
    """Add the force of a place without links to the force of the body."""
    moved(row, zeros, row.force, out)
    for i in range(6):
        P[i, 6] += out[i, 6]
        for j in range(m):
            L[j, 6] += loaded[i, j] * out[i, 6]


@kernel
def forget_forces(m, P, L):
    """Take the force at rate zero, in its column, from a body with m modes."""
    for i in range(6):
        P[i, 6] = 0.0
    for j in range(m):
        L[j, 6] = 0.0


@inner_kernel
def _take_place(tree, block, n, at):
    """Add what hangs on place n of a flexible body, or its load, to the body; from `at` on stand products of stiffness.

    By itself, as the many constants of its products would be made ready before a loop over places, mostly of one turn.
    """
    flexible = tree.flexible
    body, place = flexible.bodies[block], flexible.places[n]
    m, out, mount = body.m, flexible.moved, tree.rows[place.link]
    write_place_columns(tree, body, n, flexible.scratch[0], at)
    E = flexible.E[place.kept]
    loaded = flexible.loaded[place.kept] if place.interface >= 0 else E
    if place.loaded == 0:
        _take_loads(mount, loaded, m, flexible.zeros, flexible.P, flexible.L[block], out)
        return
    carried = flexible.wide[flexible.wide_of[place.link]].P
    if place.wide == 0:  # nothing has written to it
        clear_wide(carried)
    if place.rigid == 1:
        add_own(mount, carried)
    force_with_bias(mount, carried)
    moved(mount, carried, mount.force, out)
    add_links(E, loaded, out, m, flexible.P, flexible.K[body.kept], flexible.L[block], flexible.B[body.kept])


@inner_kernel
def _gather_body(tree, work, link, row):
    """Collect what a flexible body carries and eliminate its modes; False if one has no inertia."""
    flexible = tree.flexible
    body = flexible.bodies[link.block]
    m, P, eta = body.m, flexible.P, flexible.eta[link.block]
    L, K, B = flexible.L[link.block], flexible.K[body.kept], flexible.B[body.kept]
    at = own_terms(tree, link.block, work)
    if tree.run[0].still == 1:
        forget_forces(m, P, L)
    for n in range(body.first, body.last):
        _take_place(tree, link.block, n, at)
    if body.clamp >= 0:
        place = flexible.places[body.clamp]
        write_place_columns(tree, body, body.clamp, flexible.scratch[0], at)
        E = flexible.E[place.kept]
        loaded = flexible.loaded[place.kept] if place.interface >= 0 else E
        hang(E, loaded, m, P, K, L, B)
    for j in range(m):
        L[j, 6] -= tree.tau[body.rate + j]
    if not eliminate(m, P, K, L, B, flexible.scratch[1], flexible.pivots[body.kept]):
        return False
    for j in range(m):
        eta[j] = -L[j, 6]
    own = flexible.wide[flexible.wide_of[body.link]].P
    for i in range(6):
        row.force[i] += P[i, 6]
        keep(own, (i, 0), put(read(P, (i, 0)), 6, 0.0))
    force_with_bias(row, own)
    return True


@inner_kernel
def _ask(tree, run):
    """Ask for what the run of links needs that comes soon."""
    flexible = tree.flexible
    if run.kind == RIGID:  # they come in order
        return
    ask(tree.links, run.first, LINK_BYTES)
    ask_to_write(tree.rows, run.first, run.kept)
    if run.kind == JOINT:
        return
    ask(flexible.places, run.place, PLACE_BYTES)
    ask(flexible.present, run.place, PRESENT_BYTES)
    if run.kind == BEND:
        ask(flexible.bodies, run.block, BENT_BYTES)
        L = flexible.L
        ask_to_write(L, run.block, 8 * L.shape[1] * L.shape[2])
        ask_to_write(flexible.eta, run.block, 8 * L.shape[1])


@pointer_kernel(PASS)
def gathering(tree, work):
    """Pass inertias and forces on to the parents; run.failed gets -1, or a link whose motion has no inertia."""
    flexible, links, rows, blocks = tree.flexible, tree.links, tree.rows, tree.blocks
    tree.run[0].failed = -1
    asking = len(flexible.runs) > NEAR
    for n in range(len(flexible.runs) - 1, -1, -1):
        run = flexible.runs[n]
        k, kind = run.first, run.kind
        if asking and n >= AHEAD:
            _ask(tree, flexible.runs[n - AHEAD])
        if kind == MOUNT:  # its body collects
            continue
        if kind == RIGID:
            tree.run[0].failed = gather(links, rows, blocks, tree.tau, k, run.last)
            if tree.run[0].failed >= 0:
                return
            continue
        link, row = links[k], rows[k]
        wide = flexible.wide[flexible.wide_of[k]]
        if kind == BEND:
            good = _gather_body(tree, work, link, row)
        else:
            block, factor = blocks[link.block], flexible.factors[link.block]
            good = open_wide(link, row, wide, run.light, block, factor, tree.tau)
        if not good:
            tree.run[0].failed = k
            return
        if link.parent >= 0 and link.kind != FRAME:
            parent = flexible.wide[flexible.wide_of[link.parent]]
            give_wide(row, wide.P, rows[link.parent], parent, run.gives_first == 1)


@kernel
def leave_clamp(flexible, body, a, V):
    """Make of the rate V (6,) of a flexible body's own marker that of its frame: without what its modes add there."""
    if body.clamp < 0:
        return
    rises = flexible.rises[flexible.places[body.clamp].shapes]
    p, q, r, u, v, w = rate_of_place(rises, body.m, flexible.present[body.clamp], a, body.rate)
    V[0] -= p
    V[1] -= q
    V[2] -= r
    V[3] -= u
    V[4] -= v
    V[5] -= w


@inner_kernel
def _bend(flexible, link, row, a):
    """Write the modal second rates of a flexible body, of whose frame `row` has the rate with the own marker."""
    body = flexible.bodies[link.block]
    m = body.m
    L, eta, rates = flexible.L[link.block], flexible.eta[link.block], flexible.scratch[0]
    V = row.rate
    rate = part(V, 0, 6)
    for at in range(0, m, WIDTH):
        p, q = times(rate, read(L, (at, 0))), times(rate, read(L, (at + 1, 0)))
        r, u = times(rate, read(L, (at + 2, 0))), times(rate, read(L, (at + 3, 0)))
        v, w = times(rate, read(L, (at + 4, 0))), times(rate, read(L, (at + 5, 0)))
        x, y = times(rate, read(L, (at + 6, 0))), times(rate, read(L, (at + 7, 0)))
        keep(rates, at, less(read(eta, at), 1.0, totals(p, q, r, u, v, w, x, y)))
    for j in range(m):
        a[body.rate + j] = rates[j]
    leave_clamp(flexible, body, a, V)


@kernel
def ride(flexible, link, row, of_parent, weight, a):
    """Write the rate of a marker of a flexible body."""
    moving = np.empty(6)
    place = flexible.places[link.block]
    body = flexible.bodies[place.body]
    rises, present, V = flexible.rises[place.shapes], flexible.present[link.block], of_parent.rate
    p, q, r, u, v, w = rate_of_place(rises, body.m, present, a, body.rate)
    moving[0], moving[1], moving[2] = V[0] + p, V[1] + q, V[2] + r
    moving[3], moving[4], moving[5] = V[3] + u, V[4] + v, V[5] + w
    carry(row, moving, row.rate)
    for i in range(6):
        row.rate[i] += weight * row.bias[i]


@pointer_kernel(SPREAD)
def spreading(tree, weight):
    """Write the second rates tree.a from the roots to the leaves, and the forces on driven rates: see `spread`."""
    flexible, links, rows, blocks = tree.flexible, tree.links, tree.rows, tree.blocks
    let_fall(rows[len(links)], tree.gravity, weight)
    for n in range(len(flexible.runs)):
        run = flexible.runs[n]
        k, kind = run.first, run.kind
        if kind == RIGID:
            spread(links, rows, blocks, weight, tree.tau, tree.a, k, run.last)
            continue
        link, row = links[k], rows[k]
        of_parent = rows[link.parent]
        if kind == MOUNT:
            ride(flexible, link, row, of_parent, weight, tree.a)
        elif kind == BEND:
            carry(row, of_parent.rate, row.rate)
            for i in range(6):
                row.rate[i] += weight * row.bias[i]
            _bend(flexible, link, row, tree.a)
        else:
            wide, block, factor = flexible.wide[flexible.wide_of[k]], blocks[link.block], flexible.factors[link.block]
            move_wide(link, row, wide, block, factor, of_parent, weight, tree.tau, tree.a)
