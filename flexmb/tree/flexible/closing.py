"""Closed loops of trees with flexible links: as for rigid links, with a mobility that need not be symmetric.

What the wrench of a unit multiplier leaves at joints and modes is found twice: of the wrench as a load, ``b``, and of
the equation's own row against the transposed inertias, ``c``. The mobility is ``A_mn = sum c_m D b_n``; without
stiffening by accelerations and interfaces c = b. Theory, eq. (bend-closure).
"""

from __future__ import annotations

from flexmb.math.kernel import inner_kernel
from flexmb.math.tables import pointer_kernel
from flexmb.tree.rigid.closing import RANK, ROUNDING, leave, pass_on, wrench_at
from flexmb.tree.rigid.link_tree import PASS, SPREAD, call_spread
from flexmb.tree.rigid.places import BALL, BEND, FRAME, MOUNT, SINGLE

__all__ = ["factorising", "solving"]


@inner_kernel
def _collect(tree, body, W, wrench, e, loads):
    """Add the wrenches on the places of a body to its own W, and write what they leave at its modes to e (m,).

    loads : 1 for wrenches as loads, 0 for rows of equations
    """
    flexible, m = tree.flexible, body.m
    e[:] = 0.0
    for n in range(body.first, body.last):
        place = flexible.places[n]
        own = wrench[place.link]
        used = False
        for i in range(6):
            used = used or own[i] != 0.0
        if not used:
            continue
        stiffened = loads == 1 and place.interface >= 0
        columns = flexible.loaded[place.kept] if stiffened else flexible.E[place.kept]
        before = (W[0], W[1], W[2], W[3], W[4], W[5])
        pass_on(tree.rows[place.link], own, W)
        for i in range(6):
            x = W[i] - before[i]
            for j in range(m):
                e[j] += x * columns[i, j]
        own[:] = 0.0
    if body.clamp >= 0:
        place = flexible.places[body.clamp]
        stiffened = loads == 1 and place.interface >= 0
        columns = flexible.loaded[place.kept] if stiffened else flexible.E[place.kept]
        for i in range(6):
            for j in range(m):
                e[j] -= W[i] * columns[i, j]


@inner_kernel
def _solve_modes(K, m, pivots, x):
    """Solve with the factors of the modal block, as `eliminate` leaves them; the solution replaces x (m,)."""
    if pivots[0] >= 0:
        for i in range(m):
            p = pivots[i]
            x[i], x[p] = x[p], x[i]
    for i in range(m):
        for j in range(i):
            x[i] -= K[i, j] * x[j]
        x[i] *= K[i, i]
    for i in range(m - 1, -1, -1):
        for j in range(i + 1, m):
            x[i] -= K[i, j] * x[j]


@inner_kernel
def _leave_body(tree, link, W, own, push, give, rows, wrench):
    """Write what loads W and rows `own` leave at the modes of a body, and subtract what these take."""
    body = tree.flexible.bodies[link.block]
    m = body.m
    flexible = tree.flexible
    L, K, B = flexible.L[link.block], flexible.K[body.kept], flexible.B[body.kept]
    _collect(tree, body, W, tree.closing.wrench, push, 1)
    _collect(tree, body, own, wrench, rows, 0)
    for j in range(m):
        give[j] = push[j]
    _solve_modes(K, m, flexible.pivots[body.kept], give)
    for i in range(6):
        for j in range(m):
            W[i] -= B[i, j] * give[j]
            own[i] -= L[j, i] * rows[j]


@inner_kernel
def _leave_wide(link, row, wide, factor, W, own, push, give, rows):
    """Write what loads W and rows `own` leave at a joint, and subtract what its motion takes."""
    if link.kind == SINGLE:
        push[0] = link.turn * W[2] + link.slide * W[5]
        rows[0] = link.turn * own[2] + link.slide * own[5]
        give[0] = 0.0
        if link.driven == 0:
            give[0] = push[0] * row.mobility
            for i in range(6):
                W[i] -= wide.gain[i] * push[0]
                own[i] -= row.gain[i] * rows[0]
    elif link.kind == BALL or link.kind == FRAME:
        n = link.kind
        for i in range(n):
            push[i], rows[i], give[i] = W[i], own[i], 0.0
            for j in range(n):
                give[i] += factor.D[i, j] * W[j]
        if n == 3:
            for i in range(3):
                for j in range(3):
                    W[3 + i] -= factor.column[i, j] * push[j]
                    own[3 + i] -= factor.row[j, i] * rows[j]
            W[:3] = 0.0
            own[:3] = 0.0


@inner_kernel
def _responses(tree, work):
    """Write what unit multipliers and rows leave at the joints and modes on their ways."""
    c, flexible, links, rows = tree.closing, tree.flexible, tree.links, tree.rows
    for n in range(len(c.equations)):
        equation = work.equations[c.equations[n]]
        for m in range(equation.leg, equation.leg + equation.legs):
            leg = work.legs[m]
            place = tree.mark_of[leg.marker]
            if place >= 0:
                mark = tree.marks[place]
                wrench_at(tree.poses[mark.link], mark.s, leg.gradient, c.wrench[mark.link])
                wrench_at(tree.poses[mark.link], mark.s, leg.gradient, flexible.wrench[mark.link])
        for e in range(c.start[n], c.start[n + 1]):
            k = c.link[e]
            link, W, own = links[k], c.wrench[k], flexible.wrench[k]
            if link.kind == MOUNT:  # its body collects
                continue
            size = link.modes if link.kind == BEND else max(link.kind, 0)
            span = slice(c.at[e], c.at[e] + size)
            push, give, left = c.push[span], c.give[span], flexible.rows[span]
            if link.kind == BEND:
                _leave_body(tree, link, W, own, push, give, left, flexible.wrench)
            elif flexible.wide_of[k] >= 0:
                wide = flexible.wide[flexible.wide_of[k]]
                _leave_wide(link, rows[k], wide, flexible.factors[link.block], W, own, push, give, left)
            elif size > 0:
                leave(link, rows[k], tree.blocks[link.block], W, push, give)
                leave(link, rows[k], tree.blocks[link.block], own, left, give)
            if link.parent >= 0 and link.kind != FRAME:
                pass_on(rows[k], W, c.wrench[link.parent])
                pass_on(rows[k], own, flexible.wrench[link.parent])
            W[:] = 0.0
            own[:] = 0.0


@inner_kernel
def _mobilities(tree):
    """Write the mobility matrix: its lower half and diagonal to A, the upper half to `upper`, by columns."""
    c, flexible = tree.closing, tree.flexible
    c.A[:] = 0.0
    flexible.upper[:] = 0.0
    for k in range(len(tree.links)):
        link = tree.links[k]
        size = link.modes if link.kind == BEND else max(link.kind, 0)
        for i in range(c.start_meet[k], c.start_meet[k + 1]):
            n, p = c.equation[i], c.meet[i]
            at = c.row[n] - c.first[n]
            for j in range(c.start_meet[k], i + 1):
                q = c.meet[j]
                x, y = 0.0, 0.0
                for m in range(size):
                    x += flexible.rows[p + m] * c.give[q + m]
                    y += flexible.rows[q + m] * c.give[p + m]
                c.A[at + c.equation[j]] += x
                flexible.upper[at + c.equation[j]] += y


@pointer_kernel(PASS)
def factorising(tree, work):
    """Write the mobility matrix of the cut equations and factorise it, L d U, in its profile; both have unit diagonals.

    Equations that depend on others get the pivot zero, and no multiplier.
    """
    c, U = tree.closing, tree.flexible.upper
    _responses(tree, work)
    _mobilities(tree)
    most = 0.0
    for i in range(len(c.equations)):
        most = max(most, abs(c.A[c.row[i] + i - c.first[i]]) / c.mobility[i])
    least = max(RANK * min(most, 1.0), ROUNDING)
    for i in range(len(c.equations)):
        at, low = c.row[i] - c.first[i], c.first[i]
        for j in range(low, i):
            x, y = c.A[at + j], U[at + j]
            back = c.row[j] - c.first[j]
            for k in range(max(low, c.first[j]), j):
                x -= c.L[at + k] * U[back + k]
                y -= c.L[back + k] * U[at + k]
            c.L[at + j], U[at + j] = x, y
        pivot = c.A[at + i]
        for j in range(low, i):  # from products with the pivots to the factors
            x, y = c.L[at + j], U[at + j]
            if c.d[j] != 0.0:
                pivot -= x * y / c.d[j]
                c.L[at + j], U[at + j] = x / c.d[j], y / c.d[j]
            else:
                c.L[at + j], U[at + j] = 0.0, 0.0
        own = abs(c.A[at + i])
        c.d[i] = pivot if abs(pivot) > max(least * c.mobility[i], ROUNDING * own) else 0.0


@inner_kernel
def _multipliers(tree):
    """Solve A x = b with the factors; x replaces b, which stands in closing.x."""
    c, U = tree.closing, tree.flexible.upper
    x = c.x
    for i in range(len(x)):
        at = c.row[i] - c.first[i]
        for j in range(c.first[i], i):
            x[i] -= c.L[at + j] * x[j]
    for i in range(len(x)):
        x[i] = x[i] / c.d[i] if c.d[i] != 0.0 else 0.0
    for i in range(len(x) - 1, -1, -1):
        at = c.row[i] - c.first[i]
        for j in range(c.first[i], i):
            x[j] -= U[at + j] * x[i]


@inner_kernel
def _clear_loads(tree):
    """Take away what is left for joints and modes."""
    for k in range(len(tree.links)):
        link = tree.links[k]
        if link.kind == SINGLE:
            tree.rows[k].load = 0.0
        elif link.kind > 0:
            tree.blocks[link.block].load[: link.kind] = 0.0
        elif link.kind == BEND:
            tree.flexible.eta[link.block, :] = 0.0


@pointer_kernel(SPREAD)
def solving(tree, weight):
    """Close the loops with the right side in closing.x: second rates, or changes of weight 0.0, in tree.a."""
    c = tree.closing
    if weight == 0.0:
        _clear_loads(tree)
    _multipliers(tree)
    for k in range(len(tree.links)):
        link, row = tree.links[k], tree.rows[k]
        for i in range(c.start_meet[k], c.start_meet[k + 1]):
            lam, p = c.x[c.equation[i]], c.meet[i]
            if link.kind == SINGLE:
                row.load += lam * c.push[p]
            elif link.kind == BEND:
                eta = tree.flexible.eta[link.block]
                for m in range(link.modes):
                    eta[m] += lam * c.give[p + m]
            else:
                for m in range(link.kind):
                    tree.blocks[link.block].load[m] += lam * c.push[p + m]
    call_spread(tree.run[0].spread, tree, weight)
