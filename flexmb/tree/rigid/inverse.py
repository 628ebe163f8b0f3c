"""Inverse dynamics of rigid links in their own axes: rates outwards, the forces that they need inwards.

Source: Featherstone 2008, table 5.1 (Luh, Walker & Paul 1980).
"""

from __future__ import annotations

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.tables import pointer_kernel
from flexmb.tree.rigid.closing import pass_on
from flexmb.tree.rigid.link_tree import PASS
from flexmb.tree.rigid.passes import let_fall
from flexmb.tree.rigid.places import BALL, FRAME, SINGLE, carry, reach_axes, read_axes

__all__ = ["hold_links", "inverting", "move_links"]


@inner_kernel
def _resist(link, row):
    """Add what the link's own inertia needs for its rate to the force."""
    a, b, c = row.rate[0], row.rate[1], row.rate[2]
    u, v, w = row.rate[3], row.rate[4], row.rate[5]
    m, x, y, z = link.mass, link.h[0], link.h[1], link.h[2]
    J, force = link.J, row.force
    force[0] += J[0] * a + J[1] * b + J[2] * c + y * w - z * v
    force[1] += J[1] * a + J[3] * b + J[4] * c + z * u - x * w
    force[2] += J[2] * a + J[4] * b + J[5] * c + x * v - y * u
    force[3] += m * u + b * z - c * y
    force[4] += m * v + c * x - a * z
    force[5] += m * w + a * y - b * x


@kernel
def move_links(links, rows, a, first, last):
    """Write the rates of the links from `first` to before `last` at second rates a (nv,), and add what these need.

    The second rate of a driven link is in its velocity terms: see `place_links`.
    """
    for k in range(first, last):
        link, row = links[k], rows[k]
        rate, at = row.rate, link.rate
        carry(row, rows[link.parent].rate, rate)
        for i in range(6):
            rate[i] += row.bias[i]
        if link.kind == SINGLE:
            if link.driven == 0:
                rate[2] += link.sign * link.turn * a[at]
                rate[5] += link.sign * link.slide * a[at]
        elif link.kind == BALL:
            x, y, z = reach_axes(link, row, a[at], a[at + 1], a[at + 2])
            rate[0] += x
            rate[1] += y
            rate[2] += z
        elif link.kind == FRAME:
            for i in range(3):
                rate[i] += a[at + 3 + i]
                rate[3 + i] += a[at + i]
        _resist(link, row)


@kernel
def hold_links(links, rows, tau, first, last):
    """Write the forces on the rates of the links from `first` to before `last`, leaves first; pass theirs on."""
    for k in range(last - 1, first - 1, -1):
        link, row = links[k], rows[k]
        force, at = row.force, link.rate
        if link.kind == SINGLE:
            tau[at] = link.sign * (link.turn * force[2] + link.slide * force[5])
        elif link.kind == BALL:
            tau[at], tau[at + 1], tau[at + 2] = read_axes(link, row, force[0], force[1], force[2])
        elif link.kind == FRAME:
            for i in range(3):
                tau[at + i], tau[at + 3 + i] = force[3 + i], force[i]
        if link.parent >= 0:
            pass_on(row, force, rows[link.parent].force)


@pointer_kernel(PASS)
def inverting(tree, work):
    """Write the forces tree.tau on the rates that the second rates tree.a need; links and forces are in place."""
    n = len(tree.links)
    let_fall(tree.rows[n], tree.gravity, 1.0 - tree.run[0].still)
    move_links(tree.links, tree.rows, tree.a, 0, n)
    hold_links(tree.links, tree.rows, tree.tau, 0, n)
