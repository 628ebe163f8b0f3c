"""How the matrix of a step is factorised, as a run tells it: the recursion over trees, a sparse order for loops."""

import re

import numpy as np
import pytest
from study.test_ensemble import four_bar

import flexmb as fmb
from flexmb.system.compile import compile as compiled
from flexmb.system.pattern import cheapest_order, elimination_order, multiplications


def chain(n):
    """Bars on hinges in a row."""
    bars = [
        fmb.RigidBody(f"bar {k}", mass=1.0, inertia=(0.1, 0.1, 0.1), at=(k, 0, 0), markers={"end": (1, 0, 0)})
        for k in range(n)
    ]
    joints = [
        fmb.Revolute(f"hinge {k}", markers=("ground.origin" if k == 0 else f"bar {k - 1}.end", f"bar {k}.center"))
        for k in range(n)
    ]
    return fmb.Model(bodies=[fmb.Ground(markers={"origin": (0, 0, 0)}), *bars], joints=joints)


def told(model):
    run = fmb.simulate(model, 0.01, samples=2, integrator=fmb.Implicit())
    return run.statistics["elimination"]


def told_number(text):
    return float(re.search(r"([\d.e+]+) multiplications", text).group(1))


def test_trees_are_solved_by_the_recursion_and_loops_are_named():
    short, long = told(chain(4)), told(chain(8))
    assert short.startswith("recursion from the leaves over 8 blocks")
    assert long.startswith("recursion from the leaves over 16 blocks")
    # of linear cost: every bar in the middle of a chain takes 6^3/3 + 6 * 11 * 17 and 5^3/3 + 5 * 6 * 11
    more = 4 * (72.0 + 6 * 11 * 17 + 125.0 / 3.0 + 5 * 6 * 11)
    assert told_number(long) - told_number(short) == pytest.approx(more, rel=1e-2)
    assert told(four_bar()).startswith("sparse order, at most")
    default = fmb.simulate(chain(4), 0.01, samples=2).statistics["elimination"]
    assert default == short
    assert "elimination" not in fmb.simulate(chain(4), 0.01, samples=2, integrator=fmb.Explicit()).statistics


def test_a_loop_that_opens_is_told_beside_what_was_before():
    """Without the joint C, all bars hang in two branches from the ground."""
    opened = four_bar().with_parts(events=[fmb.Event("opens", at=0.005, then=[fmb.Release("C")])])
    first, then = told(opened).split("; then ")
    assert first == told(four_bar())
    assert then.startswith("recursion from the leaves over 6 blocks")


def test_a_stepper_tells_it():
    stepper = fmb.stepper(chain(4))
    stepper.advance(to=0.01)
    assert stepper.solution.statistics["elimination"].startswith("recursion from the leaves over 8 blocks")


def test_the_order_of_a_tree_is_that_of_the_recursion_whatever_its_shape():
    """A body and its joint, child after child: no block leaves more than its joint and its parent behind."""
    model = chain(6)
    twigs = [
        fmb.RigidBody(f"twig {k}", mass=1.0, inertia=(0.1, 0.1, 0.1), at=(k, 0, 1), markers={"foot": (0, 0, -1)})
        for k in range(6)
    ]
    balls = [fmb.Spherical(f"ball {k}", markers=(f"bar {k}.center", f"twig {k}.foot")) for k in range(6)]
    pattern = compiled(model.with_parts(bodies=twigs, joints=balls)).program.pattern
    assert np.bincount(pattern.source).max() == 2


def test_large_bodies_do_not_lead_away_from_the_leaves():
    """A rigid hub between two bodies with modes: the hub goes before the body that the ground holds."""
    sizes = [16, 6, 16, 5, 5, 5]  # bar, hub, bar, and the joints ground-bar, bar-hub, hub-bar

    def neighbours():
        return [{1, 3, 4}, {0, 2, 4, 5}, {1, 5}, {0}, {0, 1}, {1, 2}]

    by_size = elimination_order(sizes, 3, neighbours(), set())
    chosen = cheapest_order(sizes, 3, neighbours(), set())
    assert max(len(later) for later in by_size[1]) == 3
    assert chosen[0] == [2, 5, 1, 4, 0, 3]
    assert multiplications(sizes, *chosen) < multiplications(sizes, *by_size)
