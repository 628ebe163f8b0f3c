"""A body without inertia about one axis that is turned in space: rounding makes its least moment -1e-17 or +1e-17.

Reference: the rod on a hinge, m g c / (J + m c^2); the same body with its axis along x.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tolerances import SOLVER

import flexmb as fmb
from flexmb.errors import CompileError, ModelError

MASS, ARM, INERTIA, G = 2.0, 0.5, 1.0, 9.81


def thin(R, digits=np.float64, least=0.0):
    """Return a body whose x-axis has no inertia, described in axes that are turned by R."""
    J = (R @ np.diag([least, INERTIA, INERTIA]) @ R.T).astype(digits).astype(float)
    pin = fmb.Pose.axes(at=(0, 0, 0), z=R @ (0, 1, 0), x=R @ (1, 0, 0))
    center = R @ (ARM, 0, 0)
    return fmb.RigidBody("b", mass=MASS, inertia=J, center_of_mass=center, rotation=R.T, markers={"pin": pin})


def hung(body, joint):
    pin = fmb.Pose.axes(at=(0, 0, 0), z=(0, 1, 0), x=(1, 0, 0))
    model = fmb.Model(
        gravity=(0, 0, -G),
        bodies=[fmb.Ground(markers={"pin": pin}), body],
        joints=[joint("pin", markers=("ground.pin", "b.pin"))],
    )
    return fmb.accelerations(model)["b"][3:]


@pytest.mark.parametrize(("digits", "tolerance"), [(np.float64, SOLVER), (np.float32, 1e-6)])
def test_any_axis_may_have_none(rng, digits, tolerance):
    for R in Rotation.random(100, random_state=rng).as_matrix():
        body = thin(R, digits)
        assert np.linalg.eigvalsh(body.inertia)[0] > -1e-15 * INERTIA
    expected = (0.0, MASS * G * ARM / (INERTIA + MASS * ARM**2), 0.0)
    np.testing.assert_allclose(hung(body, fmb.Revolute), expected, rtol=tolerance, atol=tolerance)


def test_less_than_none_is_refused(rng):
    R = Rotation.random(random_state=rng).as_matrix()
    thin(R, least=-0.9e-6)
    with pytest.raises(ModelError, match="principal moments of inertia"):
        thin(R, least=-1.1e-6)
    with pytest.raises(ModelError, match="principal moments of inertia"):
        fmb.RigidBody("b", mass=1.0, inertia=(-0.5, 1.0, 1.0))


def test_a_turn_that_nothing_holds_is_named_whichever_way_the_axis_points(rng):
    """On a ball the spin of the rod about itself is unknown; it was -2 rad/s2 of rounding for some axes."""
    for R in [np.eye(3), *Rotation.random(10, random_state=rng).as_matrix()]:
        with pytest.raises(CompileError, match="Body 'b': the equations of motion are singular: no inertia about its"):
            hung(thin(R), fmb.Spherical)
