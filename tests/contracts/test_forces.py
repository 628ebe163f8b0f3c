"""Every registered force between two markers: action is reaction, and what it says it does is what the markers feel."""

import numpy as np
import pytest
from contracts.random_models import FORCES, PAIRS, connected, random_state
from tolerances import MACHINE

from flexmb import forces
from flexmb.system.program import evaluate

EXTERNAL = {
    "Airload",
    "PointLoad",
    "Pressure",
    "LineLoad",
    "CentralGravity",
    "OblateGravity",
    "SolarPressure",
    "ThinDrag",
    "ThirdBody",
}
"""Loads of the surroundings: they have no partner."""
ON_LINES = {"LineContact"}
"""Examined in forces/test_line_contact.py."""
OF_GEARS = {"Gears"}
"""Examined in forces/test_gears.py: teeth do not mesh at random places."""
OF_WAYS = {"Muscle"}
"""Examined in forces/test_muscle.py: ways over cylinders do not exist at random places."""
OF_SKINS = {"SkinContact"}
"""Examined in surfaces/test_skin_contact.py: skins do not meet at random places."""


def wrenches(kind, pair, rng):
    """Return force, moment and position of all markers at a random state, joints without multipliers."""
    system, state = random_state(connected(kind, pair, rng), rng, strain=0.0)
    work = system.workspace()
    evaluate(system.program, state._replace(lam=np.zeros(system.ng)), work)
    of_bodies = work.markers[: len(system.marker_index)]  # those of states follow
    return of_bodies["wrench"][:, :3], of_bodies["wrench"][:, 3:], of_bodies["r"].copy()


def test_every_force_is_examined():
    assert set(FORCES) | EXTERNAL | ON_LINES | OF_GEARS | OF_WAYS | OF_SKINS == set(forces.KINDS)


@pytest.mark.parametrize("kind", [name for name in FORCES if name not in EXTERNAL])
@pytest.mark.parametrize("pair", PAIRS)
def test_action_is_reaction(kind, pair, rng):
    """Forces cancel, and so do their moments about the origin of W."""
    force, moment, r = wrenches(kind, pair, rng)
    scale = max(1.0, np.abs(force).max(), np.abs(moment).max()) * max(1.0, np.abs(r).max())
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e2 * MACHINE * scale)
    np.testing.assert_allclose((moment + np.cross(r, force)).sum(axis=0), 0.0, atol=1e2 * MACHINE * scale)


@pytest.mark.parametrize("kind", [name for name in FORCES if name not in EXTERNAL])
def test_the_sampled_states_feel_something(kind, rng):
    """So that the test above cannot hold for nothing: in one of the pairs at least the force is not zero."""
    largest = max(
        np.abs(wrenches(kind, pair, rng)[0]).max() + np.abs(wrenches(kind, pair, rng)[1]).max() for pair in PAIRS
    )
    if kind != "JointFriction":  # lives on the reactions, which are zero here
        assert largest > 1e-3, f"{kind} is zero as described: give it a length or a preload in FORCE_FIELDS"
