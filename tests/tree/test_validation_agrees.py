"""The mechanisms of the validation set: four ways to the same accelerations, at random states.

Trees and loops, rigid and flexible, driven, redundant, with rods, springs and gears; 1e-9 relative as in
test_agreement. Chains of flexible bodies in spin, with and without the stiffness that their interface loads give.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from tree.models import chain, flexible_chain, random_consistent
from tree.test_agreement import AGREED, assert_agreement
from verification.mechanisms import andrews, bricard, car_axis, door, four_bars, towing_chain
from verification.rotating_beams import on_hub
from verification.test_gs01_three_rods import rods
from verification.test_interbody_load import chain as halves_of_blade

import flexmb as fmb
from flexmb.system import assemble

ROOT = Path(__file__).parents[2]


def case(name):
    return json.loads((ROOT / "tests" / "data" / "validation" / f"{name}.json").read_text())


def blade(stiffening):
    """Return the two halves of GS04 on a hub that is driven."""
    inner, rest = halves_of_blade(stiffening)
    return on_hub(inner, fmb.expression("3*t"), **rest)


MODELS = {
    "RB02 four-bars": lambda: four_bars(3),
    "RB03 seven bodies": lambda: andrews(case("RB03")),
    "RB04 Bricard": lambda: bricard(case("RB04")),
    "RB13 towing chain": lambda: towing_chain(case("RB13")),
    "RC01 door on three hinges": lambda: door(case("RC01"), (0.2, 1.0, 1.8)),
    "DAE1 car axis": lambda: car_axis(case("DAE1")),
    "GS01 three rods": lambda: rods(case("GS01")["model"], 3.0),
    "GS04 blade of two halves": lambda: blade(True),
    "without interface stiffness": lambda: blade(("inertia",)),
}


SPREAD = {"RB13 towing chain": 3e-4}
"""Of the random states: two straight halves of a chain go far only by way of a stretched one, which has no motion."""
REGULARISED = {"RC01 door on three hinges": {"regularised": 1e-6}}


@pytest.mark.parametrize("name", MODELS)
def test_four_formulations_agree(name, rng):
    for _ in range(2):
        assert_agreement(MODELS[name](), rng, spread=SPREAD.get(name, 0.02), **REGULARISED.get(name, {}))


def spinning(n, speed, **fields):
    """Return the system of a chain of flexible bodies and its state in a turn about z as one body, a little bent."""
    model = flexible_chain(n, **fields)
    system, state = random_consistent(model, np.random.default_rng(5), spread=0.0)
    for iq, iu in system.body_slices.values():
        if iq.stop > iq.start:
            state.u[iu] = 0.0
            state.u[iu][:6] = 0.0, speed * state.q[iq][0], 0.0, 0.0, 0.0, speed
    placed = {name: (state.q[iq], state.u[iu]) for name, (iq, iu) in system.body_slices.items()}
    return assemble(model, state=placed)


@pytest.mark.parametrize("stiffness", [True, ("inertia",), False], ids=["interbody", "inertia only", "bare"])
def test_a_flexible_chain_in_spin(stiffness):
    system, state = spinning(3, 30.0, geometric_stiffness=stiffness)
    work = system.workspace()
    ours = fmb.Recursive().accelerate(system, state, work)
    for other in (fmb.Augmented(), fmb.NullSpace(), fmb.UdwadiaPhohomsiri()):
        for one, two in zip(ours, other.accelerate(system, state, work), strict=True):
            np.testing.assert_allclose(one, two, atol=AGREED * max(1.0, np.abs(two).max()), rtol=0)


@pytest.mark.parametrize("omega", ["0.0", "1.0", "3.0", "10.0"])
def test_gs01_stiffness_of_spinning_rods_by_recursion(reference, omega):
    """GS01 (Banerjee 1993, eqs. 1 to 7): the torques of the recursive inverse dynamics,
    differentiated by the angles.
    """
    gs01 = reference("GS01")
    tree = fmb.JointTree(rods(gs01["model"], float(omega)))
    first, second = (tree.index(f"{name}.turn") for name in ("first", "second"))
    spin = np.zeros(len(tree.rate_names))
    spin[tree.index("axis.turn")] = float(omega)
    K = np.zeros((2, 2))
    for column, place in enumerate((first, second)):
        for n, weight in zip((-2, -1, 1, 2), (1, -8, 8, -1), strict=True):
            q = np.zeros(len(tree.names))
            q[place] = 1e-2 * n
            K[:, column] += weight / (12 * 1e-2) * tree.torques(q, spin)[[first, second]]
    expected = gs01["reference"][omega]["K"]
    np.testing.assert_allclose(K, expected, rtol=1e-7, atol=1e-7 * np.abs(expected).max())


@pytest.mark.parametrize("n", [3, 10])
def test_rb21_torques_of_a_chain_at_its_accelerations(n, reference):
    """RB21: at the exact first accelerations no joint needs a torque."""
    rods = [fmb.RigidBody.rod(f"b{k}", length=1.0, mass=1.0, at=(k, 0, 0)) for k in range(n)]
    model = fmb.Model(gravity=(0, -1, 0), bodies=[fmb.Ground(), *rods], joints=chain(n).joints)
    angular = np.array(reference("RB21")["reference"][f"n={n}"])
    relative = np.diff(angular, prepend=0.0)
    tau = fmb.JointTree(model).torques(np.zeros(n), np.zeros(n), relative)
    np.testing.assert_allclose(tau, 0.0, atol=1e-11 * np.abs(angular).max())
