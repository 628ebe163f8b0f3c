"""Rigid bodies that would pass through each other within a step: the step is shortened."""

import numpy as np
import pytest

import flexmb as fmb

TRIANGLES = [(0, 1, 2), (0, 2, 3), (4, 6, 5), (4, 7, 6), (0, 4, 5), (0, 5, 1), (1, 5, 6), (1, 6, 2)]
TRIANGLES += [(2, 6, 7), (2, 7, 3), (3, 7, 4), (3, 4, 0)]


def sheet(x, y, z):
    """Return a box of triangles with the edges x, y, z, m."""
    corners = [(-1, -1, -1), (-1, 1, -1), (1, 1, -1), (1, -1, -1), (-1, -1, 1), (-1, 1, 1), (1, 1, 1), (1, -1, 1)]
    return fmb.TriangleMesh(vertices=0.5 * np.array(corners) * (x, y, z), triangles=np.array(TRIANGLES))


def shot(plate, steps=1e-4, ball=None):
    """Return the run of a ball of 1 mm at a plate in the y-z plane, 0.5 m away."""
    model = fmb.Model(
        bodies=[
            fmb.Ground(),
            fmb.RigidBody(
                "ball",
                mass=1e-3,
                inertia=(1e-9,) * 3,
                at=(-0.5003, 0, 0),
                velocity=(1000.0, 0.0, 0.0),
            ),
        ],
        surfaces=[
            fmb.Surface("plate", marker="ground.origin", shape=plate),
            fmb.Surface("ball", marker="ball.center", shape=ball or fmb.Sphere(radius=5e-4)),
        ],
        forces=[fmb.SurfaceContact("hit", surfaces=("plate", "ball"), law=fmb.Rigid(restitution=0.5))],
        sensors=[fmb.Position("x", marker="ball.center"), fmb.Velocity("v", marker="ball.center")],
    )
    return fmb.simulate(model, 1e-3, samples=11, integrator=fmb.MoreauJean(step=steps))


@pytest.mark.parametrize("plate", [fmb.Cuboid(size=(1e-3, 0.2, 0.2)), sheet(1e-3, 0.2, 0.2)])
@pytest.mark.parametrize("steps", [1e-3, 1e-4, 3.1e-5])
def test_a_bullet_meets_a_plate(plate, steps):
    """At 1000 m/s, whatever the step: back at 500 m/s from the near face, after (0.5003 - 0.001) m / (1000 m/s)."""
    found = shot(plate, steps=steps)
    np.testing.assert_allclose(found["v"][-1], (-500.0, 0, 0), atol=1e-6)
    np.testing.assert_allclose(found["x"][-1, 0], -1e-3 - 500.0 * (1e-3 - 0.4993e-3), atol=2e-3)


def test_a_cube_meets_a_plate():
    """Four corners at once."""
    found = shot(fmb.Cuboid(size=(1e-3, 0.2, 0.2)), ball=fmb.Cuboid(size=(1e-3,) * 3))
    np.testing.assert_allclose(found["v"][-1], (-500.0, 0, 0), atol=1e-5)


def test_passing_by_costs_no_steps():
    """Along the plate, 0.1 mm above it, nothing is nearing."""
    plate = fmb.Surface("plate", marker="ground.origin", shape=fmb.Cuboid(size=(2.0, 2.0, 1e-3)))
    ball = fmb.RigidBody("ball", mass=1e-3, inertia=(1e-9,) * 3, at=(-0.5, 0, 1.1e-3), velocity=(1000.0, 0, 0))
    model = fmb.Model(
        bodies=[fmb.Ground(), ball],
        surfaces=[plate, fmb.Surface("ball", marker="ball.center", shape=fmb.Sphere(radius=5e-4))],
        forces=[fmb.SurfaceContact("hit", surfaces=("plate", "ball"), law=fmb.Rigid())],
        sensors=[fmb.Position("x", marker="ball.center")],
    )
    found = fmb.simulate(model, 1e-3, samples=11, integrator=fmb.MoreauJean(step=1e-4))
    assert found.statistics["steps"] == 10
    np.testing.assert_allclose(found["x"][-1], (0.5, 0, 1.1e-3), atol=1e-12)


@pytest.mark.parametrize(
    ("shape", "thickness"),
    [
        (fmb.Cuboid(size=(1e-3, 1.0, 1.0)), 1e-3),
        (fmb.Cuboid(size=(0.3, 0.3, 0.3)), 0.1),
        (sheet(0.3, 0.3, 0.3), 0.1),
        (fmb.Sphere(radius=0.3), 0.2),
        (fmb.Plane(), np.inf),
    ],
)
def test_thickness(shape, thickness):
    assert shape.thickness == pytest.approx(thickness, rel=1e-2)
