"""Rigid laws act at points: surfaces that would meet between them are refused, or what is not seen is said."""

import pytest

import flexmb as fmb
from flexmb.errors import ModelError
from flexmb.integrate.oversights import oversights

CUBE, BALL = fmb.Cuboid(size=(0.1, 0.1, 0.1)), fmb.Sphere(radius=0.1)
ROLLER, BAR = fmb.Cylinder(radius=0.1, length=0.2), fmb.Capsule(radius=0.1, length=0.2)
RING = fmb.Torus(radius=0.1, tube=0.02)
WEDGE = fmb.Hull(points=[(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)])
CAM = fmb.ExtrudedProfile(fmb.Disc(radius=0.1), length=0.1)
LINES = "edges of 'a' and 'b' that cross are not seen"


def scene(first, second, swapped=False):
    names = ("b", "a") if swapped else ("a", "b")
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("body", mass=1.0, inertia=(1, 1, 1), at=(0, 0, 1))],
        surfaces=[
            fmb.Surface("a", marker="ground.origin", shape=first),
            fmb.Surface("b", marker="body.center", shape=second),
        ],
        forces=[fmb.SurfaceContact("touch", surfaces=names, law=fmb.Rigid())],
        gravity=(0, 0, -9.81),
    )


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize(
    ("first", "second", "words"),
    [
        (fmb.Plane(), RING, "'b' is a Torus, which has no corners"),
        (CUBE, ROLLER, "'b' is a Cylinder, which has no corners"),
        (ROLLER, CUBE, "'a' is a Cylinder, which has no corners"),
    ],
)
def test_surfaces_without_points_are_refused(first, second, words, swapped):
    with pytest.raises(ModelError, match=words):
        fmb.simulate(scene(first, second, swapped), 0.1, integrator=fmb.MoreauJean(step=1e-2))


@pytest.mark.parametrize(
    ("first", "second", "told"),
    [
        (fmb.Plane(), CUBE, False),
        (BALL, ROLLER, False),
        (CUBE, BALL, False),
        (CUBE, CUBE, False),
        (BAR, BAR, False),
        (CUBE, BAR, False),
        (CUBE, WEDGE, False),
        (WEDGE, CAM, True),
        (CAM, BAR, True),
        (fmb.Plane(), CAM, False),
    ],
)
def test_edges_are_spoken_of(first, second, told):
    model = scene(first, second)
    fmb.simulate(model, 0.02, integrator=fmb.MoreauJean(step=1e-2))
    assert any(LINES in line for line in oversights(model)) == told
