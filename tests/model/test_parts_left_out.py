"""`Model.without`: what still names a part that is left out says so."""

import pytest

import flexmb as fmb
from flexmb.errors import ModelError


def test_a_sensor_of_what_is_left_out_is_named():
    mass = fmb.PointMass("mass", mass=1.0, at=(1, 0, 0))
    spring = fmb.SpringDamper("spring", markers=("ground.origin", "mass.center"), stiffness=10.0)
    model = fmb.Model(bodies=[fmb.Ground(), mass], forces=[spring], sensors=[fmb.ForceOf("pull", force="spring")])
    with pytest.raises(ModelError, match=r"Sensor 'pull': .*names what is left out \(spring\): leave it out"):
        model.without("spring")
    assert model.without("spring", "pull").sensors == ()
