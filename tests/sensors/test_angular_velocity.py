"""`AngularVelocity`: of a shaft at constant speed, of a body that tumbles; what is asked for by the name of a part."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import FlexmbError


@pytest.fixture(scope="module")
def shaft():
    body = fmb.RigidBody(
        "shaft", mass=1.0, inertia=(0.1, 0.2, 0.2), rotation=(0, 0.3, 0), angular_velocity=(1.0, 2.0, -3.0)
    )
    sensors = [
        fmb.AngularVelocity("spin", marker="shaft.center"),
        fmb.Momentum("p"),
        fmb.Position("end of it", marker="shaft.center"),
    ]
    force = fmb.PointLoad("push", marker="shaft.center", force=(0, 0, 0))
    return fmb.simulate(
        fmb.Model(bodies=[body], forces=[force], sensors=sensors), 0.5, samples=26, integrator=fmb.Explicit()
    )


def test_angular_velocity_is_that_of_the_start_and_keeps_the_angular_momentum(shaft):
    """Free body: L = J w is constant in W; the axes at each time are those of the orientation sensor."""
    w = shaft["spin"]
    np.testing.assert_allclose(w[0], (1.0, 2.0, -3.0), rtol=1e-12)
    scalar, x, y, z = shaft[fmb.Orientation("turn", marker="shaft.center")].T
    first = np.stack(
        [1 - 2 * (y * y + z * z), 2 * (x * y + scalar * z), 2 * (x * z - scalar * y)], axis=1
    )  # x-axis in W
    L = 0.2 * w + (0.1 - 0.2) * np.sum(first * w, axis=1)[:, None] * first
    np.testing.assert_allclose(L, np.tile(L[0], (len(L), 1)), rtol=1e-5)
    assert np.ptp(w[:, 0]) > 0.01
    assert shaft.column_titles("spin") == ("wx [rad/s]", "wy [rad/s]", "wz [rad/s]")


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ("spinn", "Did you mean 'spin'?"),
        ("endofit", "Did you mean 'end of it'?"),
        ("push", "It is a force: solution[fmb.ForceOf('push force', force='push')]"),
        ("shaft", "marker='shaft.MARKER'"),
        ("shaft.center", "marker='shaft.center'"),
    ],
)
def test_what_to_ask_instead(shaft, asked, told):
    with pytest.raises(FlexmbError) as caught:
        shaft[asked]
    assert told in str(caught.value)
