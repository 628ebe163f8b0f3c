"""What the equations ``M a + b = tau`` of links give at given coordinates, in one or two passes and without a matrix.

Products with M and its inverse take links in the still: without rates, weight and forces.
"""

from __future__ import annotations

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.tree.coordinates.settle import unit_length
from flexmb.tree.flexible import inverse as flexible_inverse
from flexmb.tree.rigid import inverse as rigid_inverse
from flexmb.tree.rigid.link_tree import LinkTree, call_pass, call_spread
from flexmb.tree.rigid.motion import act_on_links, closing_rates, evaluate_loops, place_marks, pose_links
from flexmb.tree.rigid.states import move_states, resist_states

__all__ = ["invertible", "link_product", "link_solution", "link_torques"]


def invertible(tree: LinkTree) -> LinkTree:
    """Return the links, from `ready`, with the address of the pass that finds forces, compiled."""
    passes = flexible_inverse if len(tree.flexible.bodies) else rigid_inverse
    tree.run[0].invert = passes.inverting.compiled.address
    return tree


@inner_kernel
def _place_at_rest(tree, work):
    """Place the links at tree.x without rates, weight and forces, until run.still is cleared."""
    unit_length(tree.chart.rows, tree.x)
    tree.v[:] = 0.0
    tree.run[0].still = 1
    call_pass(tree.run[0].place, tree, work)


@kernel
def link_torques(tree, work, t):
    """Write the forces tree.tau that tree.a need at tree.x, tree.v and time t, in addition to the model's forces."""
    chart, program = tree.chart, tree.program
    unit_length(chart.rows, tree.x)
    call_pass(tree.run[0].place, tree, work)
    if len(program.forces) > 0:
        pose_links(tree)
        place_marks(tree, work)
        act_on_links(tree, chart, program, work, t)
    call_pass(tree.run[0].invert, tree, work)
    resist_states(tree, work, 1.0)


@kernel
def link_product(tree, work):
    """Write the product of the mass matrix at tree.x with tree.a to tree.tau."""
    _place_at_rest(tree, work)
    call_pass(tree.run[0].invert, tree, work)
    resist_states(tree, work, 0.0)
    tree.run[0].still = 0


@kernel
def link_solution(tree, work, t):
    """Write the second rates tree.a that forces tree.tau on the rates give to links at rest at tree.x, loops closed.

    The run's `failed` is -1, or the link whose motion has no inertia.
    """
    c, chart, program = tree.closing, tree.chart, tree.program
    tree.a[:] = 0.0
    _place_at_rest(tree, work)
    if len(c.equations) > 0:
        pose_links(tree)
        place_marks(tree, work)
        evaluate_loops(tree, chart, program, work, t)
    call_pass(tree.run[0].gather, tree, work)
    if tree.run[0].failed < 0:
        call_spread(tree.run[0].spread, tree, 0.0)
        if len(c.equations) > 0:
            alone = tree.a.copy()
            call_pass(tree.run[0].factorise, tree, work)
            closing_rates(tree, c, work, True)
            tree.a[:] = 0.0
            call_spread(tree.run[0].solve, tree, 0.0)
            tree.a[:] += alone
        move_states(tree, work, 0.0)
    tree.run[0].still = 0
