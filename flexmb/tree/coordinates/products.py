"""``tau = M a + b`` of a tree: forces, and products with M and its inverse, without the matrix and in linear time.

Rigid and reduced bodies take the passes over links; trees with others the equations of all bodies, where forces are
affine in the second rates: there a product is a difference of two values, divided by a power of two that makes what is
looked for large against all that cancels.
"""

from __future__ import annotations

import math

import numpy as np

from flexmb.errors import CompileError
from flexmb.math.weights import weigh
from flexmb.system.program import evaluate
from flexmb.tree.coordinates.joint_torques import gather_torques
from flexmb.tree.coordinates.no_inertia import without_inertia
from flexmb.tree.rigid.links import require_known_forces
from flexmb.tree.rigid.products import link_product, link_solution, link_torques

__all__ = ["mass_product", "mass_solution", "torques"]

LARGE = 40
"""Binary digits by which second rates exceed 1 where they are asked for."""


def _require_tree(tree) -> None:
    """Raise CompileError if joints close loops: they share the forces in a way that the motion does not tell."""
    if len(tree.tree.tables.cut_equations):
        raise CompileError(
            f"Model '{tree.model.name}'",
            found=f"no tree: loops are closed by {', '.join(tree.tree.cut)}",
            expected="a tree of joints for forces by recursion",
            remedy="Use fmb.inverse_dynamics with drives for closed mechanisms",
        )


def _of_bodies(tree, q, v, a, t: float) -> np.ndarray:
    """Return the forces (nv,) by the equations of all bodies, eq. (tree-torques)."""
    work = tree.work
    state = tree.absolute(q, v, a, t)
    weigh(work.weights, 1.0, 0.0, 0.0, 0.0, 0, 0)  # what stiffens bodies belongs to the tangent
    evaluate(tree.system.program, state, work)
    tau = np.zeros(len(tree.rate_names))
    gather_torques(tree.rows, state, work, work.residual.copy(), tau, 1)
    return tau


def torques(tree, q, v, a, t: float) -> np.ndarray:
    """Return the forces (nv,) that a motion needs, see `JointTree.torques`."""
    _require_tree(tree)
    require_known_forces(
        tree.model, "Use fmb.inverse_dynamics with drives, which finds the reactions too, or leave it out"
    )
    links = tree.invertible_links
    if links is None:
        return _of_bodies(tree, q, v, a, t)
    links.x[:], links.v[:], links.a[:] = q, v, a
    link_torques(links, tree.work, t)
    return links.tau.copy()


def mass_product(tree, q, a) -> np.ndarray:
    """Return M(q) a, see `JointTree.mass_product`."""
    _require_tree(tree)
    links = tree.invertible_links
    if links is None:
        rest = np.zeros(len(tree.rate_names))
        return _linear_part(lambda x: _of_bodies(tree, q, rest, x, 0.0), a)
    links.x[:], links.a[:] = q, a
    link_product(links, tree.work)
    return links.tau.copy()


def mass_solution(tree, links, q, tau) -> np.ndarray:
    """Return M(q)^-1 tau by the links of the tree, see `JointTree.mass_solution`."""
    links.x[:], links.tau[:] = q, tau
    link_solution(links, tree.work, 0.0)
    if links.run[0].failed >= 0:
        raise without_inertia(tree.tree, links, tree.model)
    return links.a.copy()


def _linear_part(f, x: np.ndarray) -> np.ndarray:
    """Return f(x) - f(0) of an affine function, for any size of x."""
    largest = float(np.abs(x).max(initial=0.0))
    if largest == 0.0:
        return np.zeros(len(x))
    scale = math.frexp(largest)[1]
    return np.ldexp(f(np.ldexp(x, LARGE - scale)) - f(np.zeros(len(x))), scale - LARGE)
