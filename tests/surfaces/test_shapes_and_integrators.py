"""Every shape with every integrator: it comes back as fast as it came, and slides to a stop where Coulomb says.

Reference: without losses the speed of a rebound is that of the impact; with a restitution e it is e times that; a body
that slides with friction mu at v stops after v^2 / (2 mu g).
"""

import numpy as np
import pytest
from by_turns import every_second

import flexmb as fmb

INTEGRATORS = {
    "alpha": fmb.GeneralizedAlpha(follow_errors=False),
    "implicit": fmb.Implicit(follow_errors=False),
    "explicit": fmb.Explicit(),
    "IDA": fmb.IDA(),
    "Moreau-Jean": fmb.MoreauJean(step=1e-3),
}
R, SPEED, MU, G = 0.1, 1.0, 0.3, 9.81
CORNERS = np.array([[x, y, z] for x in (-R, R) for y in (-R, R) for z in (-R, R)])
FACES = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6]])
FACES = np.vstack([FACES, [[0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]])
LYING = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))
SHAPES = {
    "sphere": (fmb.Sphere(radius=R), (0, 0, 0)),
    "capsule": (fmb.Capsule(radius=R, length=2 * R), LYING),
    "box": (fmb.Cuboid(size=(2 * R,) * 3), (0, 0, 0)),
    "hull": (fmb.Hull(CORNERS), (0, 0, 0)),
    "mesh": (fmb.TriangleMesh(CORNERS, FACES), (0, 0, 0)),
}
FLOORS = {
    "plane": fmb.Plane(),
    "field": fmb.HeightField(np.zeros((5, 5)), size=(4.0, 4.0), depth=0.5),
}


def thrown(shape, floor, law, velocity, gravity, height=0.01):
    """Return a body of 1 kg above a floor, with a large inertia: it does not turn."""
    solid, place = SHAPES[shape]
    body = fmb.RigidBody(
        "body", mass=1.0, inertia=(1e3,) * 3, at=(0, 0, R + height), velocity=velocity, markers={"skin": place}
    )
    return fmb.Model(
        bodies=[fmb.Ground(), body],
        surfaces=[
            fmb.Surface("floor", marker="ground.origin", shape=FLOORS[floor]),
            fmb.Surface("skin", marker="body.skin", shape=solid, spacing=0.5 * R),
        ],
        forces=[fmb.SurfaceContact("touch", surfaces=("floor", "skin"), law=law)],
        sensors=[fmb.Velocity("v", marker="body.center"), fmb.Position("r", marker="body.center")],
        gravity=(0, 0, -gravity),
    )


@pytest.mark.parametrize(("shape", "floor", "integrator"), every_second(SHAPES, FLOORS, INTEGRATORS))
def test_without_losses_it_comes_back_as_fast(shape, floor, integrator):
    law = fmb.ElasticFoundation(modulus=1e7, thickness=0.02)
    model = thrown(shape, floor, law, (0, 0, -SPEED), 0.0)
    solution = fmb.simulate(model, 0.1, samples=2, integrator=INTEGRATORS[integrator])
    assert solution["v"][-1, 2] == pytest.approx(SPEED, rel=0.01)
    np.testing.assert_allclose(solution["v"][-1, :2], 0.0, atol=2e-3)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("shape", SHAPES)
def test_rigid_laws_belong_to_one_integrator(shape, integrator):
    """Half of the speed comes back; the integrators whose velocities cannot jump refuse the law by name."""
    model = thrown(shape, "plane", fmb.Rigid(restitution=0.5), (0, 0, -SPEED), 0.0)
    if integrator != "Moreau-Jean":
        with pytest.raises(fmb.ModelError, match=r"'touch'.*MoreauJean"):
            fmb.simulate(model, 0.1, samples=2, integrator=INTEGRATORS[integrator])
        return
    solution = fmb.simulate(model, 0.1, samples=2, integrator=INTEGRATORS[integrator])
    assert solution["v"][-1, 2] == pytest.approx(0.5 * SPEED, rel=1e-6)


@pytest.mark.parametrize("shape", SHAPES)
def test_what_slides_stops_where_coulomb_says(shape):
    """With the rigid law, from 1 m/s: 0.170 m."""
    model = thrown(shape, "plane", fmb.Rigid(friction=MU), (SPEED, 0, 0), G, height=0.0)
    solution = fmb.simulate(model, 0.5, samples=2, integrator=fmb.MoreauJean(step=1e-3))
    assert abs(solution["v"][-1, 0]) < 1e-3  # what is round does not roll, as its inertia is large
    assert solution["r"][-1, 0] == pytest.approx(SPEED**2 / (2 * MU * G), rel=0.01)
