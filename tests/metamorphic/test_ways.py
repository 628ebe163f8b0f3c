"""A mechanism in other units, at another place, mirrored, with other axes, names, orders and times: the same results.

The mechanisms follow the option --seed (the header of the test run prints it). The campaign repeats a failure:
``cd tests; python -m metamorphic.campaign --seeds 7 --analyses IDA --ways units``.
"""

import numpy as np
import pytest
from metamorphic.analyses import WITHOUT_TIME, analysed, worst_difference
from metamorphic.campaign import drawn, kinds_for, outcome, way_holds
from metamorphic.extras import KINDS_AND_PLATES
from metamorphic.flexible_trees import flexible_tree
from metamorphic.mechanisms import mechanism
from metamorphic.relations import apart
from metamorphic.seen import CHANGES, PLAIN, Seen

import flexmb as fmb

WAYS = 3
"""Ways of each mechanism and analysis that are tried in the quick suite."""
CASES = [
    *((k, how) for k, how in enumerate(("Augmented", "NullSpace", "UdwadiaPhohomsiri", "tree"))),
    *((k, "linearize") for k in range(2)),
    *((k, "steps") for k in range(3)),
    *((k, how) for k, how in enumerate(("IDA", "Explicit", "Recursive", "Implicit", "adaptive"))),
    (0, "statics"),
]


@pytest.mark.parametrize(("number", "how"), CASES)
def test_ways_to_write_it_down(seed, number, how):
    seed += number
    rng = np.random.default_rng(seed)
    possible = [name for name in CHANGES if not (name == "start" and how in WITHOUT_TIME)]
    plain = outcome(mechanism(seed, **kinds_for(how)), how)
    for change in rng.choice(possible, size=WAYS, replace=False):
        holds, found = way_holds(seed, how, str(change), plain)
        assert holds, f"seed {seed}, {how}, {change}: {found}"


@pytest.mark.parametrize(("number", "how"), [(0, "Augmented"), (1, "steps"), (2, "steps")])
def test_ways_to_write_down_contacts_and_the_like(seed, number, how):
    """With plates, contacts, friction, stops, equations of the user and attraction."""
    seed += 50 + number
    rng = np.random.default_rng(seed)
    plain = outcome(mechanism(seed, **kinds_for(how, True)), how)
    for change in ("mirror", str(rng.choice(["units", "time", "length"]))):
        holds, found = way_holds(seed, how, change, plain, extras=True)
        assert holds, f"seed {seed}, {how}, {change}: {found}"


OF_TREES = [*enumerate(("Recursive", "Recursive", "tree", "linearize", "statics", "kinematics"))]


@pytest.mark.parametrize(("number", "how"), OF_TREES)
def test_ways_to_write_down_flexible_trees(seed, number, how):
    """Reduced bodies, whole and split, with loads that follow them, preloads and loops; held, or rigid and driven."""
    seed += 80 + number
    rng = np.random.default_rng(seed)
    plain = outcome(drawn(seed, how, trees=True), how)
    for change in ("units", "axes", str(rng.choice(["mirror", "time", "order", "place"]))):
        holds, found = way_holds(seed, how, change, plain, trees=True)
        assert holds, f"seed {seed}, {how}, {change}: {found}"


def test_flexible_trees_have_everything():
    """Among some of them, and the recursion over links takes most."""
    trees = [flexible_tree(seed) for seed in range(40)]
    parts = [type(part).__name__ for m in trees for part in (*m.bodies, *m.joints, *m.forces)]
    wanted = ("FloatingBody", "RigidBody", "Drive", "Screw", "Planar", "Universal", "Pressure", "SpringDamper")
    assert all(parts.count(name) > 4 for name in wanted), {name: parts.count(name) for name in wanted}
    assert sum(any(joint.name == "closing" for joint in m.joints) for m in trees) > 5
    assert sum(any("_cut_" in joint.name for joint in m.joints) for m in trees) > 10


def test_equilibrium_of_a_loop_in_microseconds():
    """Stiffnesses of 1e12 beside coefficients of 1: the search needs all digits of its multipliers."""
    seen = Seen(time=5.6e-6)
    plain, other = (analysed(flexible_tree(3003, s, held=True), "statics", s) for s in (PLAIN, seen))
    share, where = worst_difference(plain, other)
    assert share < 1e-8, where


def test_held_and_driven_trees():
    """Held ones have an equilibrium; nothing but drives moves driven ones, which begin where they are drawn."""
    for seed in range(3, 9):
        assert fmb.statics(flexible_tree(seed, held=True)).status.ok
        found = fmb.check(flexible_tree(seed, driven=True))
        assert found.mobility == 0
        assert found.assembly_error < 1e-12


def test_what_is_added_acts():
    """Among some mechanisms there is everything."""
    mechanisms = [mechanism(seed, kinds=KINDS_AND_PLATES, extras=True) for seed in range(60)]
    parts = [type(part).__name__ for m in mechanisms for part in (*m.bodies, *m.joints, *m.forces)]
    wanted = ("AncfPlate", "Contact", "JointFriction", "BiStop", "Constraint", "CentralGravity")
    assert all(parts.count(name) > 4 for name in wanted), {name: parts.count(name) for name in wanted}


def test_comparison_sees_what_differs():
    one = {"a place": np.array([[1.0, 2.0, 3.0]]), "b place": np.array([[1e-9, 0.0, 0.0]])}
    other = {"a place": np.array([[1.0, 2.0, 3.003]]), "b place": np.array([[0.0, 0.0, 0.0]])}
    assert apart(one, one) == (0.0, "none")
    share, where = apart(one, other)
    assert where == "a place"
    np.testing.assert_allclose(share, 1e-3, rtol=1e-9)
