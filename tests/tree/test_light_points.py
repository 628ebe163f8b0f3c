"""Points of little or no mass between joints, in joint coordinates: closed forms and the other formulations."""

import numpy as np
import pytest

import flexmb as fmb

MASSES = [0.0, 1e-12, 1e-7, 1e-4, 1.0]


def hung(mass: float) -> fmb.Model:
    """A rod that hangs by a ball joint on a point, which hangs by a ball joint on the ground; drawn horizontal."""
    return fmb.Model(
        name="rod on a point",
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(),
            fmb.PointMass("point", mass=mass),
            fmb.RigidBody.rod("rod", mass=1.0, length=1.0, radius=1e-3),
        ],
        joints=[
            fmb.Spherical("top", markers=("ground.origin", "point.center")),
            fmb.Spherical("low", markers=("point.center", "rod.start")),
        ],
    )


@pytest.mark.parametrize("mass", MASSES)
def test_a_rod_on_a_point_turns(mass):
    """3 g / 2 l = 14.715 rad/s2 for a thin rod; a quarter of its weight, and the point's, in the joints."""
    model = hung(mass)
    found = fmb.accelerations(model, formulation=fmb.Recursive())
    assert found["rod"][4] == pytest.approx(1.5 * 9.81, rel=1e-5)  # as thin as 1 mm
    assert found.reactions["top"][2] == pytest.approx(9.81 * (0.25 + mass), rel=1e-5)
    exact = fmb.accelerations(model, formulation=fmb.NullSpace())
    np.testing.assert_allclose(found["rod"], exact["rod"], rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("mass", MASSES)
def test_a_point_between_two_rods(mass):
    """The path of a double pendulum whose middle joint is a point, against Udwadia & Phohomsiri's closed form."""
    rod = fmb.RigidBody.rod
    model = fmb.Model(
        name="two rods",
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(),
            rod("first", mass=1.0, length=1.0, radius=0.01),
            fmb.PointMass("point", mass=mass, at=(1, 0, 0)),
            rod("second", mass=2.0, length=1.0, radius=0.01, at=(1, 0, 0)),
        ],
        joints=[
            fmb.Spherical("ground", markers=("ground.origin", "first.start")),
            fmb.Spherical("left", markers=("first.end", "point.center")),
            fmb.Spherical("right", markers=("point.center", "second.start")),
        ],
        sensors=[fmb.Position("tip", marker="second.end")],
    )
    paths = [
        fmb.simulate(model, t_end=0.2, samples=3, integrator=fmb.Explicit(formulation=formulation))["tip"]
        for formulation in (fmb.UdwadiaPhohomsiri(), fmb.Recursive())
    ]
    np.testing.assert_allclose(paths[1], paths[0], rtol=0.0, atol=1e-8)
