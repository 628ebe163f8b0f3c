"""The articulated-body algorithm for trees with flexible links.

Rigid links on which nothing flexible hangs take the passes of rigid trees.

Banerjee 1993 eliminates the modes of a body before its joint, as here: theory, eq. (bend-out).
"""

from __future__ import annotations

import numpy as np

from flexmb.math.eights import WIDTH, keep, put, read
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.rotations import matrix_to_euler
from flexmb.math.tables import pointer_kernel
from flexmb.tree.flexible.carried import add_links, eliminate, hang, stiffened_columns
from flexmb.tree.flexible.inertia import filled, own_terms
from flexmb.tree.flexible.shapes import clear_inertia, place_bend, place_mount, shape
from flexmb.tree.flexible.tables import RIGID
from flexmb.tree.flexible.wide import add_own, clear_wide, force_with_bias, give_wide, move_wide, moved, open_wide
from flexmb.tree.rigid.link_tree import PASS, SPREAD
from flexmb.tree.rigid.passes import gather, let_fall, spread
from flexmb.tree.rigid.places import BEND, FRAME, MOUNT, carry, place_links

__all__ = ["gathering", "placing", "spreading", "write_bodies"]


@inner_kernel
def _write_shape(tree, n, body, A, motion, x):
    """Write columns, axes and motion of place n of a body."""
    flexible = tree.flexible
    place, E, s = flexible.places[n], flexible.E[n], flexible.lever[n]
    eta, rate = tree.x[body.coordinate :], tree.v[body.rate :]
    shapes, rises = flexible.shapes[place.shapes], flexible.rises[place.shapes]
    shape(place, shapes, rises, body.m, eta, rate, E, A, motion, x)
    for i in range(3):
        s[i] = motion[i]


@pointer_kernel(PASS)
def placing(tree, work):
    """Place all links in their parents, write their twists, and own inertias and forces of the rigid ones."""
    flexible, links, rows = tree.flexible, tree.links, tree.rows
    A, motion, x = np.empty((3, 3)), np.empty(12), np.empty(2 * WIDTH)
    for n in range(len(flexible.runs)):
        first, last, kind = flexible.runs[n, 0], flexible.runs[n, 1], flexible.runs[n, 2]
        if kind != BEND and kind != MOUNT:
            place_links(links, rows, tree.x, tree.v, tree.a, first, last)
            continue
        link, row = links[first], rows[first]
        if kind == MOUNT:
            place = flexible.places[link.block]
            _write_shape(tree, link.block, flexible.bodies[place.body], A, motion, x)
            place_mount(row, rows[link.parent], A, motion)
            if place.rigid == 1:
                clear_inertia(row)
            continue
        body = flexible.bodies[link.block]
        if body.clamp >= 0:
            _write_shape(tree, body.clamp, body, A, motion, x)
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
def _columns(tree, body, n, products, at):
    """Return the columns for motions of a place and those for loads, which stiffness changes at interfaces."""
    flexible = tree.flexible
    place, E = flexible.places[n], flexible.E[n]
    if place.interface < 0:
        return E, E
    loaded, own = flexible.loaded[place.kept], products[at + 6 * place.interface * filled(body.m) :]
    stiffened_columns(flexible.lever[n], body.m, own, E, loaded)
    return E, loaded


@inner_kernel
def _take_loads(row, loaded, m, zeros, P, L, out):
    """Add the force of a place without links to the force of the body."""
    moved(row, zeros, row.force, out)
    for i in range(6):
        P[i, 6] += out[i, 6]
        for j in range(m):
            L[j, 6] += loaded[i, j] * out[i, 6]


@inner_kernel
def _gather_body(tree, work, link, row, P, out):
    """Collect what a flexible body carries and eliminate its modes; False if one has no inertia."""
    flexible = tree.flexible
    body = flexible.bodies[link.block]
    m, scratch = body.m, flexible.scratch
    L, K, B, eta = flexible.L[link.block], flexible.K[body.kept], flexible.B[body.kept], flexible.eta[link.block]
    at = own_terms(tree, body, work, scratch, P, K, L, B)
    for n in range(body.first, body.last):
        place = flexible.places[n]
        mount = tree.rows[place.link]
        E, loaded = _columns(tree, body, n, scratch[0], at)
        if place.loaded == 0:
            _take_loads(mount, loaded, m, flexible.zeros, P, L, out)
            continue
        carried = flexible.wide[flexible.wide_of[place.link]].P
        if place.wide == 0:  # nothing has written to it
            clear_wide(carried)
        if place.rigid == 1:
            add_own(mount, carried)
        force_with_bias(mount, carried, flexible.sums)
        moved(mount, carried, mount.force, out)
        add_links(E, loaded, out, m, P, K, L, B)
    if body.clamp >= 0:
        E, loaded = _columns(tree, body, body.clamp, scratch[0], at)
        hang(E, loaded, m, P, K, L, B)
    for j in range(m):
        L[j, 6] -= tree.tau[body.rate + j]
    if not eliminate(m, P, K, L, B):
        return False
    for j in range(m):
        eta[j] = -L[j, 6]
    own = flexible.wide[flexible.wide_of[body.link]].P
    for i in range(6):
        row.force[i] += P[i, 6]
        keep(own, (i, 0), put(read(P, (i, 0)), 6, 0.0))
    force_with_bias(row, own, flexible.sums)
    return True


@pointer_kernel(PASS)
def gathering(tree, work):
    """Pass inertias and forces on to the parents; run.failed gets -1, or a link whose motion has no inertia."""
    flexible, links, rows, blocks = tree.flexible, tree.links, tree.rows, tree.blocks
    A, out, P = np.empty((6, WIDTH)), np.empty((6, WIDTH)), np.empty((6, WIDTH))
    pivots, column = np.empty(6, np.int64), np.empty(6)
    tree.run[0].failed = -1
    for n in range(len(flexible.runs) - 1, -1, -1):
        k, last, kind = flexible.runs[n, 0], flexible.runs[n, 1], flexible.runs[n, 2]
        if kind == MOUNT:  # its body collects
            continue
        if kind == RIGID:
            tree.run[0].failed = gather(links, rows, blocks, tree.tau, k, last)
            if tree.run[0].failed >= 0:
                return
            continue
        link, row = links[k], rows[k]
        wide = flexible.wide[flexible.wide_of[k]]
        if kind == BEND:
            good = _gather_body(tree, work, link, row, P, out)
        else:
            block, factor = blocks[link.block], flexible.factors[link.block]
            good = open_wide(link, row, wide, block, factor, tree.tau, A, pivots, column, flexible.sums)
        if not good:
            tree.run[0].failed = k
            return
        if link.parent >= 0 and link.kind != FRAME:
            parent = flexible.wide[flexible.wide_of[link.parent]]
            give_wide(row, wide.P, rows[link.parent], parent, flexible.runs[n, 3] == 1, out)


@inner_kernel
def _bend(flexible, link, row, a):
    """Write the modal second rates of a flexible body, of whose frame `row` has the rate with the own marker."""
    body = flexible.bodies[link.block]
    m = body.m
    L, eta = flexible.L[link.block], flexible.eta[link.block]
    V = row.rate
    for j in range(m):
        x = eta[j]
        for i in range(6):
            x -= L[j, i] * V[i]
        a[body.rate + j] = x
    if body.clamp >= 0:
        E = flexible.E[body.clamp]
        for i in range(6):
            x = 0.0
            for j in range(m):
                x += E[i, j] * a[body.rate + j]
            V[i] -= x


@inner_kernel
def _ride(flexible, link, row, of_parent, weight, a, moving):
    """Write the rate of a marker of a flexible body."""
    place = flexible.places[link.block]
    body = flexible.bodies[place.body]
    E = flexible.E[link.block]
    for i in range(6):
        x = of_parent.rate[i]
        for j in range(body.m):
            x += E[i, j] * a[body.rate + j]
        moving[i] = x
    carry(row, moving, row.rate)
    for i in range(6):
        row.rate[i] += weight * row.bias[i]


@pointer_kernel(SPREAD)
def spreading(tree, weight):
    """Write the second rates tree.a from the roots to the leaves, and the forces on driven rates: see `spread`."""
    flexible, links, rows, blocks = tree.flexible, tree.links, tree.rows, tree.blocks
    column = np.empty(6)
    let_fall(rows[len(links)], tree.gravity, weight)
    for n in range(len(flexible.runs)):
        k, last, kind = flexible.runs[n, 0], flexible.runs[n, 1], flexible.runs[n, 2]
        if kind == RIGID:
            spread(links, rows, blocks, weight, tree.tau, tree.a, k, last)
            continue
        link, row = links[k], rows[k]
        of_parent = rows[link.parent]
        if kind == MOUNT:
            _ride(flexible, link, row, of_parent, weight, tree.a, column)
        elif kind == BEND:
            carry(row, of_parent.rate, row.rate)
            for i in range(6):
                row.rate[i] += weight * row.bias[i]
            _bend(flexible, link, row, tree.a)
        else:
            wide, block, factor = flexible.wide[flexible.wide_of[k]], blocks[link.block], flexible.factors[link.block]
            move_wide(link, row, wide, block, factor, of_parent, weight, tree.tau, column, tree.a)
