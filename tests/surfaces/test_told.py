"""What is told of contacts: sensor, overlaps, pictures, messages."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.io.scene import Scene

LAYER = fmb.ElasticFoundation(modulus=1e8, thickness=0.01, damping=0.1, friction=0.3)


def ball_on_floor(depth, law=LAYER, spacing=1e-3, **more):
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"o": (0, 0, 0)}),
            fmb.RigidBody("b", mass=2.0, inertia=(0.01,) * 3, at=(0, 0, 0.1 - depth), **more),
        ],
        surfaces=[
            fmb.Surface("floor", marker="ground.o", shape=fmb.Plane()),
            fmb.Surface("ball", marker="b.center", shape=fmb.Sphere(0.1), spacing=spacing),
        ],
        forces=[fmb.SurfaceContact("touch", surfaces=("floor", "ball"), law=law)],
        sensors=[
            fmb.ContactState("state", force="touch"),
            fmb.ForceOf("F", force="touch"),
            fmb.Energy("lost", kind="total"),
        ],
    )


def test_state_of_a_contact():
    """A ball in a layer: pi K/h R d^2, area 2 pi R d on the ball, pressure K/h d; friction is what `ForceOf` tells."""
    d = 5e-4
    solution = fmb.simulate(ball_on_floor(d, velocity=(0.2, 0, 0)), t_end=1e-5, samples=2)
    force, area, pressure, penetration, slip, power = solution["state"][0]
    assert force == pytest.approx(np.pi * 1e10 * 0.1 * d**2, rel=1e-2)
    assert area == pytest.approx(2 * np.pi * 0.1 * d, rel=1e-2)
    assert pressure == pytest.approx(1e10 * d, rel=1e-2)
    assert penetration == pytest.approx(d, rel=1e-2)
    assert slip == pytest.approx(0.2, rel=1e-9)
    assert force == pytest.approx(solution["F"][0, 2], rel=1e-9)
    assert power == pytest.approx(-solution["F"][0, 0] * 0.2, rel=1e-6)


def test_state_of_a_point():
    solution = fmb.simulate(ball_on_floor(1e-4, fmb.Hertz(stiffness=1e9), None), t_end=1e-5, samples=2)
    force, area, _, penetration, *_ = solution["state"][0]
    assert force == pytest.approx(1e9 * 1e-4**1.5, rel=1e-9)
    assert np.isnan(area)
    assert penetration == pytest.approx(1e-4, rel=1e-9)
    apart = fmb.simulate(ball_on_floor(-1e-2), t_end=1e-5, samples=2)
    assert np.all(apart["state"] == 0.0)


def test_overlap_at_the_start_is_told():
    deep = ball_on_floor(0.02, spacing=2e-3)
    with pytest.warns(fmb.ValidityWarning, match=r"'floor' and 'ball' by 0\.0[12]\d* m"):
        fmb.simulate(deep, t_end=1e-6, samples=2)
    assert any("'floor' and 'ball' by" in told for told in fmb.check(deep).warnings)
    assert not any("overlap" in told for told in fmb.check(ball_on_floor(5e-4, spacing=2e-3)).warnings)


BALL, RING = fmb.Sphere(0.1), fmb.Torus(radius=0.1, tube=0.03)
LONG = fmb.Capsule(radius=0.1, length=0.1)


def two_at(way, shape, law=LAYER):
    """Return two bodies of one shape, the second a little higher."""
    free = {"mass": 1.0, "inertia": (0.01,) * 3}
    return fmb.Model(
        bodies=[fmb.RigidBody("b", **free), fmb.RigidBody("c", **free, at=(0, 0, way))],
        surfaces=[
            fmb.Surface("one", marker="b.center", shape=shape, spacing=0.03),
            fmb.Surface("other", marker="c.center", shape=shape),
        ],
        forces=[fmb.SurfaceContact("touch", surfaces=("one", "other"), law=law)],
    )


@pytest.mark.parametrize("shape", [BALL, LONG, RING], ids=lambda s: type(s).__name__)
def test_bodies_that_coincide_are_refused(shape):
    """No sample lies inside the other body, and nothing says where to push it."""
    for way in (fmb.check, lambda model: fmb.simulate(model, t_end=1e-3, samples=2)):
        with pytest.raises(fmb.ModelError, match="'one' and 'other' around one place"):
            way(two_at(0.0, shape))


@pytest.mark.parametrize("shape", [BALL, LONG], ids=lambda s: type(s).__name__)
def test_bodies_that_nearly_coincide_are_told(shape):
    """Normals of both have one direction, so that no sample is counted."""
    assert any("'one' and 'other' by 0." in told for told in fmb.check(two_at(1e-4, shape)).warnings)
    assert not fmb.check(two_at(0.3, shape)).warnings


@pytest.mark.parametrize(("against", "at"), [("plane", 0.05), ("sphere", 0.15), ("socket", 0.15), ("bore", 0.15)])
def test_a_ball_that_begins_deep_is_told(against, at):
    place = (at, 0, 0) if against == "bore" else (0, 0, at)
    ball = fmb.RigidBody("b", mass=1.0, inertia=(1e-3,) * 3, at=place)
    touch = fmb.Contact(
        "touch",
        markers=("ground.origin", "b.center"),
        against=against,
        radius=0.1,
        other_radius=None if against == "plane" else 0.1 if against == "sphere" else 0.2,
        stiffness=1e6,
    )
    model = fmb.Model(bodies=[fmb.Ground(), ball], forces=[touch])
    assert any("ball lies 0.05 m deep" in told for told in fmb.check(model).warnings)
    if against == "sphere":
        with pytest.raises(fmb.ModelError, match="both markers at one place"):
            fmb.check(model.with_parts(bodies=[]).changed("b", at=(0, 0, 0)))


def test_work_of_friction_and_damping_is_in_the_balance():
    """What the energy loses is what the law dissipates, in every point of the surface: few of them do."""
    model = ball_on_floor(-1e-3, spacing=2e-3, velocity=(0.3, 0, -0.5), angular_velocity=(0, 3.0, 0))
    solution = fmb.simulate(model, t_end=0.01, samples=101, integrator=fmb.Explicit())
    energy, works = solution["lost"], solution.series(0).works
    assert works[-1, 2] > 0.01 * energy[0]
    assert energy[0] - energy[-1] == pytest.approx(works[-1, 2], rel=1e-5)


def test_surfaces_are_drawn():
    solution = fmb.simulate(ball_on_floor(-0.1, spacing=2e-3, velocity=(1.0, 0, 0)), t_end=0.1, samples=2)
    scene = Scene(solution)
    names = {part.name: part for part in scene.parts}
    assert {"ball", "floor"} <= set(names)
    points = scene.snapshot(names["ball"], 1).points
    np.testing.assert_allclose(np.linalg.norm(points - (0.1, 0, 0.2), axis=1), 0.1, atol=1e-9)


def test_messages():
    model = ball_on_floor(0.0)
    with pytest.raises(fmb.ModelError, match="a SurfaceContact by ElasticFoundation or Hertz"):
        model.with_parts(
            forces=[fmb.SpringDamper("s", markers=("ground.o", "b.center"), stiffness=1.0)],
            sensors=[fmb.ContactState("x", force="s")],
        )
    model = model.with_parts(
        bodies=[fmb.RigidBody("c", mass=1, inertia=(1, 1, 1), at=(1, 0, 1))],
        surfaces=[fmb.Surface("other", marker="c.center", shape=fmb.Sphere(0.1), spacing=0.01)],
    )
    with pytest.raises(fmb.ModelError, match="acts on several second surfaces"):
        model.changed("touch", surfaces=("floor", ("ball", "other")))
