"""`SolarPressure` and `ThinDrag`: formulas by components, the decay of a circular orbit, energy.

References: Wertz 1978 eq. 17-49 and Montenbruck & Gill 2000 section 3.4; momentum of the particles; King-Hele 1987.
"""

import numpy as np
import pytest
from contracts.random_models import random_state
from contracts.test_tangents import assert_tangent
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb.errors import ModelError

MU, EARTH = 3.986004418e14, 6378137.0


def loads(force, **fields):
    """Force on a body at (7, 1, 2) m, turned, moving: (3,), its normal, its velocity."""
    R = Rotation.from_rotvec((0.4, -0.7, 0.9))
    values = {"at": (7.0, 1.0, 2.0), "velocity": (3.0, -2.0, 1.0), "rotation": R}
    body = fmb.RigidBody("b", mass=1.0, inertia=(1, 1, 1), **{**values, **fields})
    model = fmb.Model(bodies=[fmb.Ground(), body], forces=[force], sensors=[fmb.ForceOf("f", force=force.name)])
    return fmb.simulate(model, 1e-9, samples=2)["f"][0, :3], R.as_matrix()[:, 2], np.array(values["velocity"])


@pytest.mark.parametrize(("mirrored", "diffuse"), [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.3, 0.5)])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_light_on_a_plate(mirrored, diffuse, side):
    """F = -p A cos ((1 - s) to_sun + 2 (s cos + d / 3) n), Montenbruck & Gill eq. 3.73 with the diffuse share."""
    given = np.array((2.0, 1.0, -4.0))
    to_sun = given / np.linalg.norm(given)
    shares = {"mirrored": mirrored, "diffuse": diffuse}
    for both in (True, False):
        law = fmb.SolarPressure(
            "f", marker="b.center", area=3.0, sun=tuple(side * given), pressure=2.0, both_faces=both, **shares
        )
        found, n, _ = loads(law)
        cos = side * to_sun @ n
        if cos < 0.0 and not both:
            np.testing.assert_array_equal(found, 0.0)
            continue
        n, cos = (n, cos) if cos > 0.0 else (-n, -cos)
        expected = -2.0 * 3.0 * cos * ((1 - mirrored) * side * to_sun + 2 * (mirrored * cos + diffuse / 3) * n)
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize(("mirrored", "diffuse"), [(0.0, 0.0), (1.0, 0.0), (0.2, 0.5)])
def test_gas_on_a_plate(mirrored, diffuse):
    """Momentum that arrives, less what leaves: mirrored, at the mean normal speed, or none."""
    law = fmb.ThinDrag(
        "f",
        marker="b.center",
        area=3.0,
        density=0.7,
        altitude=2.0,
        scale_height=4.0,
        surface=5.0,
        rotation=0.2,
        mirrored=mirrored,
        diffuse=diffuse,
        leaving=0.6,
    )
    found, n, v = loads(law)
    r = np.array((7.0, 1.0, 2.0))
    w = np.cross((0, 0, 0.2), r) - v
    n = n if n @ w < 0.0 else -n
    flow = 0.7 * np.exp((7.0 - np.linalg.norm(r)) / 4.0) * 3.0 * -(n @ w)  # kg/s
    leaves = mirrored * (w - 2 * (w @ n) * n) + diffuse * 0.6 * n + (1 - mirrored - diffuse) * 0.0
    np.testing.assert_allclose(found, flow * (w - leaves), rtol=1e-12)


LAWS = {
    "light": fmb.SolarPressure(
        "f", marker="b.p", area=3.0, sun=(2.0, 1.0, -4.0), mirrored=0.3, diffuse=0.4, pressure=20.0, both_faces=True
    ),
    "gas": fmb.ThinDrag(
        "f",
        marker="b.p",
        area=3.0,
        density=0.7,
        altitude=2.0,
        scale_height=4.0,
        surface=1.0,
        rotation=0.2,
        mirrored=0.3,
        diffuse=0.4,
        leaving=0.6,
    ),
}


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("follows", [False, True])
def test_tangent_is_the_derivative(name, follows, rng):
    markers = {"p": fmb.Pose((0.3, 0.2, -0.4), (0.2, 0.5, -0.3))}
    body = fmb.RigidBody("b", mass=1.7, inertia=(0.5, 0.8, 0.9), at=(1.5, 2.0, -1.0), markers=markers)
    forces, origin = [LAWS[name]], None
    if follows:
        origin = fmb.Orbit((3.0, 1.0, 2.0), (0.1, 1.0, 2.0), 20.0)
        forces.append(fmb.CentralGravity("g", body="b", mu=20.0))
    system, state = random_state(fmb.Model(bodies=[fmb.Ground(), body], forces=forces, origin=origin), rng)
    assert_tangent(system, state)


def test_drag_shrinks_a_circular_orbit():
    """da / dt = -2 rho A sqrt(mu a) / m of a plate across the way that absorbs (drag coefficient 2, King-Hele 1987).

    In axes along the orbit the origin would fall in vacuum: the body lags and sinks from it by the same amount.
    """
    a, rho, A, m = EARTH + 4e5, 3e-12, 20.0, 100.0
    n = np.sqrt(MU / a**3)
    # the plate turns once per orbit about z: its normal, the body's y-axis, stays along the way
    pose = fmb.Pose.axes((0, 0, 0), x=(1, 0, 0), z=(0, 1, 0))
    drag = fmb.ThinDrag("d", marker="b.p", area=A, density=rho, altitude=4e5, scale_height=1e12, rotation=0.0)
    found = {}
    for name, origin in (("Earth", None), ("orbit", fmb.Orbit.circular(a))):
        body = fmb.RigidBody(
            "b",
            mass=m,
            inertia=(1.0, 1.0, 1.0),
            at=(a, 0, 0) if origin is None else (0, 0, 0),
            velocity=(0, n * a, 0) if origin is None else (0, 0, 0),
            angular_velocity=(0, 0, n),
            markers={"p": pose},
        )
        sensors = [fmb.Position("r", marker="b.center"), fmb.Velocity("v", marker="b.center")]
        pull = fmb.CentralGravity("g", body="b")
        model = fmb.Model(bodies=[fmb.Ground(), body], forces=[pull, drag], sensors=sensors, origin=origin)
        run = fmb.simulate(model, 2 * np.pi / n, samples=5, integrator=fmb.Explicit(rtol=1e-11, atol=1e-9))
        r, v = run["r"], run["v"]
        if origin is not None:
            place, speed = origin.at(run.t)
            r, v = r + place, v + speed
        found[name] = 1.0 / (2.0 / np.linalg.norm(r, axis=1) - np.sum(v**2, axis=1) / MU) - a
    expected = -2.0 * rho * A * np.sqrt(MU * a) / m * run.t
    np.testing.assert_allclose(found["orbit"], expected, atol=2e-4 * abs(expected[-1]))
    np.testing.assert_allclose(found["orbit"], found["Earth"], atol=1e-5 * abs(expected[-1]))


def test_shares_are_shares():
    with pytest.raises(ModelError, match=r"mirrored = 0\.7, diffuse = 0\.5.*sum of at most 1"):
        fmb.SolarPressure("f", marker="b.center", area=1.0, sun=(1, 0, 0), mirrored=0.7, diffuse=0.5)
    with pytest.raises(ModelError, match=r"sun = \(0, 0, 0\), which has no direction"):
        fmb.SolarPressure("f", marker="b.center", area=1.0, sun=(0, 0, 0))
    with pytest.raises(ModelError, match="area = 0"):
        fmb.ThinDrag("f", marker="b.center", area=0.0, density=1e-12)
    with pytest.raises(ModelError, match="leaving = -1"):
        fmb.ThinDrag("f", marker="b.center", area=1.0, density=1e-12, leaving=-1.0)
    body = fmb.RigidBody("b", mass=1.0, inertia=(1, 1, 1))
    with pytest.raises(ModelError, match="on a body that moves"):
        fmb.Model(
            bodies=[body], forces=[fmb.ThinDrag("f", marker="b.center", area=1.0, density=1.0, source="b.center")]
        )
