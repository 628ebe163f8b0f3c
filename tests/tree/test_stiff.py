"""Stiff flexible bodies: the implicit counterpart of the recursion costs few steps,
and grows in proportion to the tree.
"""

import numpy as np
from tree.models import chain, flexible_chain

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.system import compile


def stiff_chain(n):
    """Return beams of 1 m on hinges that fall from rest; their fastest mode is far above the motion."""
    points = np.column_stack([np.linspace(0.0, 1.0, 6), np.zeros(6), np.zeros(6)])
    fe = fem.frame(points=points, section=fem.Section.rectangle(0.05, 0.05), material=fmb.MATERIALS["steel"])
    data = reduction.reduce(fe, interfaces={"root": [0], "tip": [5]}, modes=3, geometric_stiffness=True)
    bodies = [fmb.FloatingBody(f"f{k}", data=data, at=(k, 0, 0), damping=0.01) for k in range(n)]
    ends = ["ground.origin"] + [f"f{k}.tip" for k in range(n)]
    joints = [fmb.Revolute(f"j{k}", markers=(ends[k], f"f{k}.root")) for k in range(n)]
    return fmb.Model(gravity=(0, -9.81, 0), bodies=[fmb.Ground(), *bodies], joints=joints)


def test_implicit_steps_are_not_bound_to_the_fastest_mode():
    """Two beams: explicit steps follow the fastest mode, implicit ones the motion; both arrive at the same place."""
    model = stiff_chain(2)
    explicit = fmb.simulate(
        model, 0.05, samples=2, integrator=fmb.Explicit(formulation=fmb.Recursive(), rtol=1e-5, atol=1e-7)
    )
    implicit = fmb.simulate(model, 0.05, samples=2, integrator=fmb.GeneralizedAlpha(step=5e-3, rho_inf=0.5))
    assert implicit.statistics["steps"] * 15 < explicit.statistics["steps"]
    tree = fmb.JointTree(model)
    tips = [tree.pose("f1.tip", tree.relative(solution.final).q)[0] for solution in (explicit, implicit)]
    np.testing.assert_allclose(*tips, atol=1e-4)


def test_factors_grow_in_proportion_to_the_tree():
    """Numbers in the factors of the iteration matrix (eliminated from the leaves): no fill beyond bodies and joints."""
    for make in (chain, flexible_chain):
        one, two, four = (int(compile(make(n)).program.pattern.row_start[-1]) for n in (6, 12, 24))
        assert abs((four - two) - 2 * (two - one)) <= 0.01 * four
