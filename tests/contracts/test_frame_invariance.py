"""Mechanics does not depend on where the world frame is: every kind, moved and turned as a whole with its gravity."""

from dataclasses import replace

import numpy as np
import pytest
from contracts.random_models import FORCES, connected, put_together
from tolerances import SOLVER

import flexmb as fmb
from flexmb import joints
from flexmb.math.rotations import rotation_matrix

KINDS = (*joints.KINDS, "slide", *FORCES)
AT, ROTATION = (3.0, -2.0, 5.0), (0.4, -1.1, 0.7)


def turned(model):
    """Return the model, its prescribed forces and its gravity, moved and turned."""
    R = rotation_matrix(ROTATION)
    return replace(model.placed("p", at=AT, rotation=ROTATION), gravity=tuple(R @ model.gravity))


@pytest.mark.parametrize("pair", ["ground-rigid", "rigid-floating"])
@pytest.mark.parametrize("kind", KINDS)
def test_accelerations_and_reactions_turn_along(kind, pair, rng):
    model = put_together(connected(kind, pair, rng))
    one, other = fmb.accelerations(model), fmb.accelerations(turned(model))
    R = rotation_matrix(ROTATION)
    for body in model.bodies:
        if body.name != "ground":
            expected = np.concatenate([R @ one[body.name][:3], R @ one[body.name][3:]])
            np.testing.assert_allclose(other[f"p_{body.name}"], expected, rtol=1e-7, atol=1e-6)
    for joint in model.joints:
        expected = np.concatenate([R @ one.reactions[joint.name][:3], R @ one.reactions[joint.name][3:]])
        scale = max(1.0, np.abs(expected).max())
        np.testing.assert_allclose(other.reactions[f"p_{joint.name}"] / scale, expected / scale, atol=1e-7)


@pytest.mark.parametrize(
    "integrator", [fmb.GeneralizedAlpha(step=2e-3), fmb.IDA(rtol=1e-9, atol=1e-11)], ids=["alpha", "IDA"]
)
def test_motion_turns_along(integrator):
    """A rod hangs from a rod by a cardan joint; a spring pulls at it."""
    model = fmb.Model(
        gravity=(0.0, 0.0, -9.81),
        bodies=[
            fmb.Ground(markers={"O": (0, 0, 0), "S": (1, 1, 0)}),
            fmb.RigidBody.rod("one", length=0.6, mass=1.0, radius=0.05, angular_velocity=(1, 2, 3)),
            fmb.RigidBody.rod("two", length=0.4, mass=2.0, radius=0.05, at=(0.6, 0, 0), rotation=(0, -1.0, 0)),
        ],
        joints=[
            fmb.Spherical("ball", markers=("ground.O", "one.start")),
            fmb.Spherical("hinge", markers=("one.end", "two.start")),
        ],
        forces=[fmb.SpringDamper("spring", markers=("ground.S", "two.end"), stiffness=50.0, damping=1.0)],
        sensors=[fmb.Position("tip", marker="two.end"), fmb.Reaction("force", joint="ball")],
    )
    one = fmb.simulate(model, 1.0, integrator=integrator, samples=11)
    other = fmb.simulate(turned(model), 1.0, integrator=integrator, samples=11)
    R = rotation_matrix(ROTATION)
    np.testing.assert_allclose(other["p_tip"], one["tip"] @ R.T + AT, atol=SOLVER)
    np.testing.assert_allclose(other["p_force"][:, :3], one["force"][:, :3] @ R.T, atol=20 * SOLVER)
