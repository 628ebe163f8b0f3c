"""The passes over rigid links as the motion of links calls them, by their addresses."""

from __future__ import annotations

from flexmb.math.kernel import inner_kernel
from flexmb.math.tables import pointer_kernel
from flexmb.tree.rigid.closing import add_multipliers, factorise, solve_multipliers
from flexmb.tree.rigid.link_tree import PASS, SPREAD
from flexmb.tree.rigid.passes import gather, let_fall, spread
from flexmb.tree.rigid.places import SINGLE, place_links

__all__ = ["factorising", "gathering", "placing", "solving", "spreading"]


@pointer_kernel(PASS)
def placing(tree, work):
    """Place all links: see `place_links`."""
    place_links(tree.links, tree.rows, tree.x, tree.v, tree.a, 0, len(tree.links))


@pointer_kernel(PASS)
def gathering(tree, work):
    """Pass inertias and forces on to the parents; run.failed gets -1, or a link whose motion has no inertia."""
    tree.run[0].failed = gather(tree.links, tree.rows, tree.blocks, tree.tau, 0, len(tree.links))


@inner_kernel
def _spread(tree, weight):
    """Write the second rates of all links."""
    n = len(tree.links)
    let_fall(tree.rows[n], tree.gravity, weight)
    spread(tree.links, tree.rows, tree.blocks, weight, tree.tau, tree.a, 0, n)


@pointer_kernel(SPREAD)
def spreading(tree, weight):
    """Write the second rates tree.a, and the forces on driven rates: see `spread`."""
    _spread(tree, weight)


@pointer_kernel(PASS)
def factorising(tree, work):
    """Write the mobility matrix of the cut equations and factorise it."""
    factorise(tree, tree.closing, work)


@inner_kernel
def _clear_loads(tree):
    """Take away what is left for the joints."""
    for k in range(len(tree.links)):
        link = tree.links[k]
        if link.kind == SINGLE:
            tree.rows[k].load = 0.0
        elif link.kind > 0:
            tree.blocks[link.block].load[: link.kind] = 0.0


@pointer_kernel(SPREAD)
def solving(tree, weight):
    """Close the loops with the right side in closing.x: second rates, or changes of weight 0.0, in tree.a."""
    if weight == 0.0:
        _clear_loads(tree)
    solve_multipliers(tree.closing)
    add_multipliers(tree, tree.closing)
    _spread(tree, weight)
