"""The shadow of a planet on a plate in the light of the Sun.

References: the wall of a cylinder; the common area of two discs by quadrature over strips; motions by scipy.
"""

import numpy as np
import pytest
from contracts.random_models import random_state
from contracts.test_tangents import assert_tangent
from scipy.integrate import quad, solve_ivp

import flexmb as fmb
from flexmb.errors import ModelError
from flexmb.forces.shadow import lit

SUN = np.array((0.6, 0.0, 0.8))


def share(a, b, c):
    """What is left of a disc of radius a when one of radius b covers it, at the distance c, by strips across c."""

    def strip(x):
        own = np.sqrt(max(0.0, a * a - x * x))
        return 2.0 * max(0.0, own - np.sqrt(max(0.0, b * b - (x - c) ** 2)))

    x = (c * c + a * a - b * b) / (2.0 * c)
    kinks = sorted({float(np.clip(k, -a, a)) for k in (x, c - b, c + b)})
    area = sum(quad(strip, p, q, limit=200)[0] for p, q in zip((-a, *kinks), (*kinks, a), strict=True) if q > p)
    return area / (np.pi * a * a)


@pytest.mark.parametrize(("a", "far"), [(0.1, 1.2), (0.1, 3.0), (0.3, 5.0), (4.652e-3, 1.1)])
def test_share_is_that_of_two_discs(a, far):
    """From above the penumbra to its middle, and a ring where the Sun is larger; a planet of radius 1."""
    b = np.arcsin(1.0 / far)
    slope = np.empty(3)
    for c in np.linspace(0.02 * b if a > b else b - 1.1 * a, a + 1.1 * b, 9):
        across = np.cross(SUN, (0, 1, 0))
        r = far * (-np.cos(c) * SUN + np.sin(c) * across)
        assert lit(r, SUN, 1.0, a, slope) == pytest.approx(share(a, b, c), abs=1e-6)  # of the quadrature
        for k, e in enumerate(np.eye(3)):
            h = 1e-6
            ends = [lit(r + s * h * e, SUN, 1.0, a, np.empty(3)) for s in (1.0, -1.0)]
            assert slope[k] == pytest.approx((ends[0] - ends[1]) / (2 * h), abs=2e-3 * max(1.0, abs(slope).max()))


def crossing(sun_angle: float, pressure: float = 1e-6) -> fmb.Model:
    """A plate of 2 m2 and 3 kg faces the Sun, at rest along its light, and passes a planet of 100 m behind it."""
    body = fmb.RigidBody(
        "b",
        mass=3.0,
        inertia=(1, 1, 1),
        at=(-300.0, -250.0, 0.0),
        velocity=(0.0, 10.0, 0.0),
        markers={"p": fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))},
    )
    light = fmb.SolarPressure(
        "light", marker="b.p", area=2.0, sun=(5.0, 0, 0), pressure=pressure, shadow=100.0, sun_angle=sun_angle
    )
    return fmb.Model(
        bodies=[fmb.Ground(), body],
        forces=[light],
        sensors=[
            fmb.Position("r", marker="b.center"),
            fmb.Velocity("v", marker="b.center"),
            fmb.ForceOf("f", force="light"),
            fmb.Energy("E"),
        ],
    )


INTEGRATORS = [fmb.Explicit(), fmb.GeneralizedAlpha(), fmb.IDA(), fmb.Implicit()]


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda i: type(i).__name__)
def test_time_in_a_cylinder(integrator):
    """Of 50 s, 20 s are dark: what the light gives is its force times the other 30 s, however long the steps are."""
    run = fmb.simulate(crossing(0.0), 50.0, samples=2, integrator=integrator)
    np.testing.assert_allclose(run["v"][-1, 0], -1e-6 * 2.0 / 3.0 * 30.0, rtol=1e-6)


@pytest.fixture(scope="module")
def through_the_cone():
    """Places, speeds along the light and forces by scipy, shares by quadrature; it gains 0.2 m/s and 5 m."""

    def force(r):
        far = np.linalg.norm(r)
        a, b, c = 0.1, np.arcsin(100.0 / far), np.arccos(-r[0] / far)
        return -2e-2 * (1.0 if c > a + b else 0.0 if c < b - a else share(a, b, c))

    t = np.linspace(0.0, 50.0, 11)
    own = solve_ivp(
        lambda t, y: (y[1], force((y[0], -250.0 + 10.0 * t, 0.0)) / 3.0),
        (0, 50),
        (-300.0, 0.0),
        t_eval=t,
        rtol=1e-8,
        atol=1e-9,
        max_step=1.0,
    )
    places = np.column_stack([own.y[0], -250.0 + 10.0 * t, 0.0 * t])
    return places, own.y[1], [force(r) for r in places]


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda i: type(i).__name__)
def test_impulse_through_a_cone(integrator, through_the_cone):
    run = fmb.simulate(crossing(0.1, pressure=1e-2), 50.0, samples=11, integrator=integrator)
    places, speeds, forces = through_the_cone
    np.testing.assert_allclose(run["v"][:, 0], speeds, atol=2e-5)
    np.testing.assert_allclose(run["r"], places, atol=1e-3)
    np.testing.assert_allclose(run["f"][:, 0], forces, atol=2e-6)


@pytest.mark.parametrize("follows", [False, True])
def test_tangent_in_the_penumbra(follows, rng):
    light = fmb.SolarPressure(
        "f",
        marker="b.p",
        area=3.0,
        sun=(-3.0, -1.0, 0.5),
        mirrored=0.3,
        diffuse=0.4,
        pressure=20.0,
        both_faces=True,
        shadow=2.2,
        sun_angle=0.4,
    )
    markers = {"p": fmb.Pose((0.3, 0.2, -0.4), (0.2, 0.5, -0.3))}
    body = fmb.RigidBody("b", mass=1.7, inertia=(0.5, 0.8, 0.9), at=(4.0, 2.5, -1.0), markers=markers)
    forces, origin = [light], None
    if follows:
        origin = fmb.Orbit((3.0, 1.0, 2.0), (0.1, 1.0, 2.0), 20.0)
        body = body.replaced(at=(0.5, 1.0, -3.0))
        forces.append(fmb.CentralGravity("g", body="b", mu=20.0))
    model = fmb.Model(bodies=[fmb.Ground(), body], forces=forces, origin=origin)
    system, state = random_state(model, rng)
    slope = np.empty(3)
    sun = np.array((-3.0, -1.0, 0.5)) / np.linalg.norm((-3.0, -1.0, 0.5))
    at = state.q[:3] + (0.0 if origin is None else origin.at(state.t)[0])
    assert 0.01 < lit(at, sun, 2.2, 0.4, slope) < 0.99
    assert_tangent(system, state)


def test_tangent_of_a_plate_that_nothing_shades_beside_one_in_the_penumbra(rng):
    """The change of the light on one plate is no matter of the other."""
    shaded = fmb.SolarPressure(
        "shaded",
        marker="a.center",
        area=3.0,
        sun=(-3.0, -1.0, 0.5),
        pressure=20.0,
        both_faces=True,
        shadow=2.2,
        sun_angle=0.4,
    )
    free = shaded.replaced(name="free", marker="b.center", shadow=0.0)
    bodies = [
        fmb.RigidBody(name, mass=1.7, inertia=(0.5, 0.8, 0.9), at=at, rotation=(0.2, 0.5, -0.3))
        for name, at in (("a", (4.0, 2.5, -1.0)), ("b", (9.0, 2.0, 1.0)))
    ]
    model = fmb.Model(bodies=[fmb.Ground(), *bodies], forces=[shaded, free])
    system, state = random_state(model, rng)
    sun, slope = np.array((-3.0, -1.0, 0.5)) / np.linalg.norm((-3.0, -1.0, 0.5)), np.empty(3)
    assert 0.01 < lit(state.q[:3], sun, 2.2, 0.4, slope) < 0.99
    assert_tangent(system, state)


def test_dark_share_of_a_low_orbit():
    """A cylinder covers asin(R / r) / pi of a circular orbit whose plane holds the Sun; seen at 2000 samples."""
    orbit = fmb.Orbit.circular(7e6)
    markers = {"p": fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))}
    body = fmb.RigidBody("b", mass=100.0, inertia=(1, 1, 1), markers=markers)
    light = fmb.SolarPressure(
        "l", marker="b.p", area=5.0, sun=(1, 0, 0), shadow=6378137.0, sun_angle=0.0, both_faces=True
    )
    pull = fmb.CentralGravity("g", body="b")
    sensors = [fmb.ForceOf("f", force="l"), fmb.Energy("E"), fmb.Energy("W", kind="work_of_loads")]
    model = fmb.Model(bodies=[fmb.Ground(), body], forces=[pull, light], sensors=sensors, origin=orbit)
    run = fmb.simulate(model, orbit.period, samples=2001)
    dark = np.mean(run["f"][:-1, 0] == 0.0)
    assert dark == pytest.approx(np.arcsin(6378137.0 / 7e6) / np.pi, abs=1e-3)
    np.testing.assert_allclose(run["E"] - run["E"][0], run["W"], atol=1e-9)


def test_shadow_is_described_in_numbers():
    with pytest.raises(ModelError, match="shadow = -1"):
        fmb.SolarPressure("f", marker="b.center", area=1.0, sun=(1, 0, 0), shadow=-1.0)
    with pytest.raises(ModelError, match=r"sun_angle = 2\.0 rad.*half of an apparent diameter"):
        fmb.SolarPressure("f", marker="b.center", area=1.0, sun=(1, 0, 0), shadow=1.0, sun_angle=2.0)
    body = fmb.RigidBody("b", mass=1.0, inertia=(1, 1, 1))
    light = fmb.SolarPressure("f", marker="b.center", area=1.0, sun=(1, 0, 0), shadow=1.0, source="b.center")
    with pytest.raises(ModelError, match="on a body that moves"):
        fmb.Model(bodies=[body], forces=[light])
