"""Bullets of 1 mm at 1 to 1000 m/s against plates of 1 mm: every pair of kinds, every integrator, straight and oblique.

Reference: without friction the normal speed comes back whole, with a restitution e by that share; along the plate it
stays. The inertia is large, so nothing turns. Layers are so stiff that the bullet goes about 0.03 mm deep.
"""

import itertools
import warnings

import numpy as np
import pytest
from by_turns import every_second
from surfaces.bodies_of_triangles import box

import flexmb as fmb
from flexmb.profiles import Disc, Line, Outline

THICK, WIDE, R, MASS = 1e-3, 0.2, 5e-4, 4e-6


def rectangle(width, height):
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    start, *others = [(0.5 * width * x, 0.5 * height * y) for x, y in corners]
    return Outline(start=start, pieces=[Line(to=to) for to in others])


SLAB, CUBE = box((WIDE, WIDE, THICK)), box((2 * R,) * 3)
PLATES = {
    "cuboid": (fmb.Cuboid(size=(WIDE, WIDE, THICK)), (0, 0, 0)),
    "hull": (fmb.Hull(SLAB[0]), (0, 0, 0)),
    "mesh": (fmb.TriangleMesh(*SLAB), (0, 0, 0)),
    "field": (fmb.HeightField(np.zeros((5, 5)), size=(WIDE, WIDE), depth=THICK), (0, 0, 0.5 * THICK)),
    "extruded": (
        fmb.ExtrudedProfile(rectangle(WIDE, THICK), length=WIDE),
        fmb.Pose.axes((0, 0, 0), x=(1, 0, 0), y=(0, 0, 1)),
    ),
    "disc": (fmb.ExtrudedProfile(Disc(radius=0.5 * WIDE), length=THICK), (0, 0, 0)),
    "revolved": (fmb.RevolvedProfile(rectangle(WIDE, THICK)), (0, 0, 0)),
    "cylinder": (fmb.Cylinder(radius=0.5 * WIDE, length=THICK), (0, 0, 0)),
}
BULLETS = {
    "sphere": fmb.Sphere(R),
    "capsule": fmb.Capsule(radius=R, length=2 * R),
    "cuboid": fmb.Cuboid(size=(2 * R,) * 3),
    "hull": fmb.Hull(CUBE[0]),
    "mesh": fmb.TriangleMesh(*CUBE),
    "extruded": fmb.ExtrudedProfile(rectangle(2 * R, 2 * R), length=2 * R),
    "cylinder": fmb.Cylinder(radius=R, length=2 * R),
    "cone": fmb.Cone(radius=R, length=2 * R, top=0.5 * R),
    "torus": fmb.Torus(radius=R, tube=R / 3),
}
INTEGRATORS = {
    "alpha": lambda _: fmb.GeneralizedAlpha(follow_errors=False),
    "IDA": lambda _: fmb.IDA(),
    "explicit": lambda _: fmb.Explicit(),
    "implicit": lambda _: fmb.Implicit(follow_errors=False),
    "Moreau-Jean": lambda speed: fmb.MoreauJean(step=0.03 / speed),
}
SPEEDS = (1.0, 30.0, 1000.0)
WAYS = {"straight": (0.0, 0.0, -1.0), "oblique": (0.6, 0.2, -1.0)}
E = 0.5
CASES = list(itertools.product(INTEGRATORS, SPEEDS, WAYS))


def shot(plate, bullet, law, speed, way, softer=1.0):
    """Return a bullet before a plate, 53 mm of its way along the normal; `speed` is that along the normal."""
    shape, place = PLATES[plate]
    way = np.array(WAYS[way])
    body = fmb.RigidBody(
        "bullet",
        mass=MASS,
        inertia=(1e3 * MASS,) * 3,
        at=tuple(-0.0531 * way + (0.0013, 0.0017, 0.0)),
        velocity=tuple(speed * way),
    )
    laws = {
        "layer": lambda: fmb.ElasticFoundation(modulus=4e6 * speed**2 / softer, thickness=1e-3),
        "Hertz": lambda: fmb.Hertz(stiffness=1.25 * MASS * speed**2 / 3e-5**2.5 / softer),
        "rigid": lambda: fmb.Rigid(restitution=E),
    }
    return fmb.Model(
        bodies=[fmb.Ground(markers={"plate": place}), body],
        surfaces=[
            fmb.Surface("plate", marker="ground.plate", shape=shape),
            fmb.Surface("skin", marker="bullet.center", shape=BULLETS[bullet], spacing=R / 2.5),
        ],
        forces=[fmb.SurfaceContact("hit", surfaces=("plate", "skin"), law=laws[law]())],
        sensors=[fmb.Position("r", marker="bullet.center"), fmb.Velocity("v", marker="bullet.center")],
    )


def assert_comes_back(plate, bullet, law, integrator, speed, way):
    model = shot(plate, bullet, law, speed, way)
    with warnings.catch_warnings():
        warnings.simplefilter("error", fmb.ValidityWarning)
        found = fmb.simulate(model, 0.1 / speed, samples=2, integrator=INTEGRATORS[integrator](speed))
    expected = speed * np.array(WAYS[way]) * (1.0, 1.0, -E if law == "rigid" else -1.0)
    np.testing.assert_allclose(found["v"][-1], expected, rtol=0.02, atol=1e-3 * speed)


@pytest.mark.parametrize("bullet", BULLETS)
@pytest.mark.parametrize("plate", PLATES)
def test_every_pair_of_kinds(plate, bullet):
    """One of the 30 cases for each, another for the next pair: each of them twice at least."""
    number = 7 * list(PLATES).index(plate) + list(BULLETS).index(bullet)
    assert_comes_back(plate, bullet, "layer", *CASES[number % len(CASES)])


@pytest.mark.slow
@pytest.mark.parametrize("bullet", BULLETS)
@pytest.mark.parametrize("plate", PLATES)
def test_every_case_of_every_pair(plate, bullet):
    for case in CASES:
        assert_comes_back(plate, bullet, "layer", *case)


@pytest.mark.parametrize("case", CASES, ids=lambda case: "-".join(map(str, case)))
def test_a_ball_by_hertz(case):
    assert_comes_back("cuboid", "sphere", "Hertz", *case)


@pytest.mark.parametrize(
    ("plate", "bullet"),
    every_second(
        [name for name in PLATES if name not in ("revolved", "cylinder")],
        ["sphere", "capsule", "cuboid", "hull", "mesh", "extruded"],
    ),
)
def test_rigid_laws(plate, bullet):
    """At every speed, straight and oblique by turns."""
    number = list(PLATES).index(plate) + list(BULLETS).index(bullet)
    for k, speed in enumerate(SPEEDS):
        assert_comes_back(plate, bullet, "rigid", "Moreau-Jean", speed, list(WAYS)[(number + k) % 2])


@pytest.mark.filterwarnings("ignore:.*closed and opened again")
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize(("bullet", "law"), [("sphere", "Hertz"), ("cuboid", "layer")])
def test_what_passes_between_the_faces_is_named(bullet, law, integrator):
    """A law 1e5 times too soft: the bullet flies on behind the plate, and the run says so, whatever else it says."""
    model = shot("cuboid", bullet, law, 30.0, "straight", softer=1e5)
    with pytest.warns(fmb.ValidityWarning, match="have sunk into each other .* (middle of|reach)"):
        found = fmb.simulate(model, 0.1 / 30.0, samples=2, integrator=INTEGRATORS[integrator](30.0))
    assert found["r"][-1, 2] < -0.04
