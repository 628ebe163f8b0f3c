"""All formulations give the same accelerations and reactions, on trees and loops of every kind, at random states.

They share the equations, and nothing of how they solve them: recursion over the joints, sparse factorisation,
orthogonal complements, pseudo-inverses.
"""

import numpy as np
import pytest
from by_turns import every_second
from contracts.random_models import FORCES, PAIRS, connected
from tree.models import branched, chain, flexible_chain, loops, random_consistent
from verification.mechanisms import four_bars

import flexmb as fmb
from flexmb import joints

AGREED = 1e-9
KINDS = [name for name in joints.KINDS if name != "Drive"] + ["slide"]
MODELS = {
    "chain": lambda: chain(6),
    "spherical chain": lambda: chain(4, fmb.Spherical),
    "flexible chain": lambda: flexible_chain(3),
    "without geometric stiffness": lambda: flexible_chain(3, geometric_stiffness=False),
    "branched": branched,
    "loops": loops,
    "four-bars": lambda: four_bars(3),
}


def assert_agreement(model, rng, regularised=AGREED, **options):
    """Compare accelerations (relative to the largest of their kind) and multipliers of all formulations.

    `regularised` is the tolerance of Augmented's multipliers: its regularisation of 1e-9 leaves 1e-7 of rounding in
    those of dependent equations, where there is hardly anything else.
    """
    system, state = random_consistent(model, rng, **options)
    work = system.workspace()
    ours = fmb.Recursive().accelerate(system, state, work)
    for other in (fmb.Augmented(), fmb.NullSpace(), fmb.UdwadiaPhohomsiri()):
        theirs = other.accelerate(system, state, work)
        for name, one, two in zip(("accelerations", "multipliers"), ours, theirs, strict=True):
            scale = max(np.abs(two).max(initial=0.0), 1.0)
            allowed = regularised if (name, other) == ("multipliers", fmb.Augmented()) else AGREED
            np.testing.assert_allclose(one / scale, two / scale, atol=allowed, rtol=0, err_msg=f"{name}, {other}")


@pytest.mark.parametrize("name", MODELS)
def test_on_trees_and_loops(name, rng):
    for _ in range(3):
        assert_agreement(MODELS[name](), rng)


WITH_FRAMES = [pair for pair in PAIRS if not any(name in pair for name in ("cable", "beam", "plate"))]


@pytest.mark.parametrize(("kind", "pair"), every_second(KINDS, WITH_FRAMES))
def test_on_every_joint(kind, pair, rng):
    assert_agreement(connected(kind, pair, rng), rng)


@pytest.mark.parametrize(("kind", "pair"), every_second(FORCES, ["ground-rigid", "rigid-floating", "rigid-point"]))
def test_on_every_force(kind, pair, rng):
    assert_agreement(connected(kind, pair, rng), rng)


def test_cut_by_hand(rng):
    """Another choice of cut joints changes nothing."""
    system, state = random_consistent(loops(), rng)
    work = system.workspace()
    a, lam = fmb.Recursive().accelerate(system, state, work)
    for cut in (("B",), ("A", "C"), ("D",)):
        other = fmb.Recursive(cut=cut)
        assert set(cut) <= set(other.tree(system).cut)
        b, mu = other.accelerate(system, state, work)
        np.testing.assert_allclose(b, a, atol=AGREED * np.abs(a).max())
        np.testing.assert_allclose(mu, lam, atol=AGREED * np.abs(lam).max())


def test_geometric_stiffness_by_interface_loads_is_seen(rng):
    """A pull along a bent beam straightens it: the accelerations differ from those without it, and all agree."""
    system, state = random_consistent(flexible_chain(2), rng, strain=3e-3)
    with_it = fmb.Recursive().accelerate(system, state, system.workspace())[0]
    system, _ = random_consistent(flexible_chain(2, geometric_stiffness=False), rng)
    without = fmb.Recursive().accelerate(system, state, system.workspace())[0]
    assert np.abs(with_it - without).max() > 1e-6 * np.abs(with_it).max()


def test_friction_of_a_rod_without_inertia_about_itself(rng):
    """The inertia that its block is lent is given back in the iteration of the reactions as well."""
    rods = [
        fmb.RigidBody(f"r{k}", mass=1.0, inertia=(0, 0.1, 0.1), at=(k + 0.5, 0, 0), markers={"A": (-0.5, 0, 0)})
        for k in range(2)
    ]
    rods[0] = rods[0].replaced(markers={"A": (-0.5, 0, 0), "B": (0.5, 0, 0)})
    joints = [fmb.Revolute("A", markers=("ground.origin", "r0.A")), fmb.Revolute("B", markers=("r0.B", "r1.A"))]
    rub = fmb.JointFriction("rub", joint="B", moving=0.2, radius=0.02)
    model = fmb.Model(bodies=[fmb.Ground(), *rods], joints=joints, forces=[rub], gravity=(1, -9.81, 2))
    system, _ = random_consistent(model, rng)
    assert len(system.program.floor)
    assert_agreement(model, rng)
