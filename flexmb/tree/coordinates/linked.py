"""The links of a tree of joints, drawn from its assembled start, with or without inertia in all their motions."""

from __future__ import annotations

import numpy as np

from flexmb.errors import CompileError
from flexmb.math.weights import weigh
from flexmb.system.branches import Followed
from flexmb.system.program import evaluate
from flexmb.tree.coordinates.no_inertia import without_inertia
from flexmb.tree.coordinates.settle import Chart, new_chart
from flexmb.tree.rigid.link_tree import LinkTree, link_tree
from flexmb.tree.rigid.motion import evaluate_links, ready
from flexmb.tree.rigid.products import invertible

__all__ = ["drawn_links", "invertible_links", "moving_links", "refuse_drives", "timeless_chart"]


def timeless_chart(tree, start) -> Chart:
    """Return the coordinates of a `JointTree` for states of any time: turns that none of them counts are those near
    the start, whatever the time.
    """
    followed = Followed(tree.system, start, tree.work)
    followed.pace[:] = 0.0
    return new_chart(tree, start.q, followed)


def refuse_drives(tree) -> None:
    """Raise CompileError if motions are prescribed: forward dynamics is for joints that forces move."""
    if tree.drives:
        raise CompileError(
            f"Model '{tree.model.name}'",
            found=f"prescribed motions: {', '.join(tree.drives)}",
            expected="joints that forces move",
            remedy="Leave the drives out, or use fmb.simulate",
        )


def drawn_links(tree, chart: Chart, start) -> LinkTree:
    """Return the links of a `JointTree` at its start, with its forces and cut joints; see `JointTree.linked`."""
    weigh(tree.work.weights, 1.0, constrained=0)
    program = tree.system.program._replace(floor=np.zeros(len(tree.system.program.floor)))
    evaluate(program, start, tree.work)
    return ready(link_tree(tree, chart, start, tree.work))


def invertible_links(tree, start) -> LinkTree | None:
    """Return the same links, whether their motions have inertia or not, for inverse dynamics; None if the model has
    more than they know.
    """
    try:
        return invertible(drawn_links(tree, timeless_chart(tree, start), start))
    except CompileError:
        return None


def moving_links(tree, chart: Chart, start) -> LinkTree:
    """Return the same links; CompileError if a motion of them has no inertia."""
    links, here = drawn_links(tree, chart, start), tree.start
    links.x[:], links.v[:] = here.q, here.v
    evaluate_links(links, tree.work, here.t)
    if links.run[0].failed >= 0:
        raise without_inertia(tree.tree, links, tree.model)
    return links
