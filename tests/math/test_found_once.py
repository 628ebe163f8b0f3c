"""What is found once for an object is forgotten with it."""

import gc
import weakref

import pytest
from tree.models import flexible_chain

import flexmb as fmb
from flexmb.bodies.floating.holders import Holders
from flexmb.math.found_once import found_once
from flexmb.system import assemble


class Thing:
    """Anything that can be referred to weakly."""


def test_each_result_is_found_once_and_forgotten_with_its_object():
    asked = []

    @found_once
    def find(of, *rest):
        asked.append(rest)
        return [rest]

    one, other = Thing(), Thing()
    first = find(one, "a")
    assert find(one, "a") is first
    assert find(one, "b") is not first
    assert find(other, "a") is not first
    assert asked == [("a",), ("b",), ("a",)]
    result = weakref.ref(one)
    del one
    gc.collect()
    assert result() is None


@pytest.mark.parametrize("used", ["holders", "accelerations", "joint coordinates", "run"])
def test_no_system_stays_alive_after_its_use(used):
    """Up to sixteen systems with all their tables stayed as long as the program."""
    system, state = assemble(flexible_chain(2))
    if used == "holders":
        Holders("f1", ["f1.root", "f1.tip"], system)
    elif used == "accelerations":
        fmb.Recursive().accelerate(system, state, system.workspace())
    elif used == "joint coordinates":
        tree = fmb.JointTree.of(system, state)
        tree.accelerations(tree.start)
        del tree
    else:
        run = fmb.Explicit(formulation=fmb.Recursive()).start(system, state, system.workspace(), 1.0)
        del run
    alive = weakref.ref(system)
    del system, state
    gc.collect()
    assert alive() is None
