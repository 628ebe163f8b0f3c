"""Gravity in orbit: `CentralGravity` with its gradient, `OblateGravity` (J2), `ThirdBody`.

References: sums over point masses, formulas by components (Vallado 2013), an own integration with quaternions by scipy.
"""

import numpy as np
import pytest
from contracts.random_models import random_state
from contracts.test_tangents import assert_tangent
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb.errors import ModelError

MU, RADIUS, J2 = 3.986004418e14, 6378137.0, 1.0826267e-3


def rigid(**fields) -> fmb.RigidBody:
    values = {"mass": 1.7, "inertia": (0.5, 0.8, 0.9), "center_of_mass": (0.1, -0.2, 0.3), "at": (1.5, 2.0, -1.0)}
    return fmb.RigidBody("b", **{**values, **fields})


FORCES = {
    "central": fmb.CentralGravity("g", body="b", mu=40.0, source="ground.o"),
    "oblate": fmb.OblateGravity("g", body="b", mu=40.0, radius=0.9, j2=0.3, source="ground.o"),
    "third": fmb.ThirdBody("g", body="b", mu=40.0, at=(4.0, fmb.expression("3 + t"), -2.0)),
}


@pytest.mark.parametrize("name", FORCES)
def test_tangent_is_the_derivative(name, rng):
    ground = fmb.Ground(markers={"o": fmb.Pose((0.2, 0.1, 0.4), (0.3, -0.2, 0.5))})
    system, state = random_state(fmb.Model(bodies=[ground, rigid()], forces=[FORCES[name]]), rng)
    assert_tangent(system, state._replace(u=np.zeros(system.nu)), blocks=("M", "K"))


def test_field_over_the_body_is_the_sum_over_its_points():
    """Six points, 60 of their distances away: left are terms of fourth order, 1e-6 of the force, 1e-3 of the torque."""
    arms = np.array([(0.9, 0, 0), (-0.9, 0, 0), (0, 0.5, 0), (0, -0.5, 0), (0, 0, 0.3), (0, 0, -0.3)])
    m = 0.4
    J = m * np.sum([a @ a * np.eye(3) - np.outer(a, a) for a in arms], axis=0)
    R, at, mu = Rotation.from_rotvec((0.4, -0.7, 0.9)), np.array((30.0, 40.0, -20.0)), 5e4
    body = fmb.RigidBody("b", mass=6 * m, inertia=J, at=at, rotation=R)
    sensor = fmb.ForceOf("f", force="g")
    model = fmb.Model(bodies=[fmb.Ground(), body], forces=[fmb.CentralGravity("g", body="b", mu=mu)], sensors=[sensor])
    found = fmb.simulate(model, 1e-6, samples=2)["f"][0]
    points = at + R.apply(arms)
    pulls = -mu * m * points / np.linalg.norm(points, axis=1)[:, None] ** 3
    far = np.linalg.norm(at)
    monopole = -mu * 6 * m * at / far**3
    force, torque = pulls.sum(axis=0), np.cross(points - at, pulls).sum(axis=0)
    np.testing.assert_allclose(found[:3], force, atol=1e-6 * np.linalg.norm(monopole))
    assert np.linalg.norm(force - monopole) > 5e-5 * np.linalg.norm(monopole)
    np.testing.assert_allclose(found[3:], torque, atol=2e-3 * np.linalg.norm(torque))


def test_third_body_turns_what_has_a_size():
    """In axes that fall with the orbit force and torque are those of the centre, less the pull on the origin."""
    arms = np.array([(0.9, 0, 0), (-0.9, 0, 0), (0, 0.5, 0), (0, -0.5, 0), (0, 0, 0.3), (0, 0, -0.3)])
    m, mu = 0.4, 5e4
    J = m * np.sum([a @ a * np.eye(3) - np.outer(a, a) for a in arms], axis=0)
    R, at, centre = Rotation.from_rotvec((0.4, -0.7, 0.9)), np.array((0.3, -0.2, 0.5)), np.array((-30.0, -40.0, 20.0))
    body = fmb.RigidBody("b", mass=6 * m, inertia=J, at=at, rotation=R)
    force = fmb.ThirdBody("g", body="b", mu=mu, at=tuple(centre))
    model = fmb.Model(bodies=[fmb.Ground(), body], forces=[force], sensors=[fmb.ForceOf("f", force="g")])
    found = fmb.simulate(model, 1e-6, samples=2)["f"][0]
    points = at + R.apply(arms) - centre
    pulls = -mu * m * points / np.linalg.norm(points, axis=1)[:, None] ** 3
    pulls -= mu * m * centre / np.linalg.norm(centre) ** 3
    np.testing.assert_allclose(found[:3], pulls.sum(axis=0), atol=1e-6 * mu * 6 * m / np.linalg.norm(centre) ** 2)
    torque = np.cross(points - points.mean(axis=0), pulls).sum(axis=0)
    np.testing.assert_allclose(found[3:], torque, atol=2e-3 * np.linalg.norm(torque))


def test_flattening_and_third_body_by_components():
    r, s = np.array((6.9e6, 1.2e6, 3.1e6)), np.array((3.0e8, -2.0e8, 1.0e8))
    point = fmb.PointMass("b", mass=3.0, at=r)
    far, z = np.linalg.norm(r), r[2]
    k = -1.5 * J2 * MU * RADIUS**2 / far**5
    oblate = k * r * (np.array((1.0, 1.0, 3.0)) - 5.0 * z * z / far**2)
    moon = 4.9048695e12
    tide = moon * ((s - r) / np.linalg.norm(s - r) ** 3 - s / np.linalg.norm(s) ** 3)
    for force, expected, within in (
        (fmb.OblateGravity("g", body="b"), oblate, 1e-12),
        (fmb.ThirdBody("g", body="b", mu=moon, at=tuple(s)), tide, 1e-9),
    ):
        found = fmb.accelerations(fmb.Model(bodies=[fmb.Ground(), point], forces=[force]))["b"][:3]
        np.testing.assert_allclose(found, expected, atol=within * np.linalg.norm(expected))


def test_rigid_spacecraft_against_quaternions():
    """A body in orbit for 600 s: place, and attitude under the gradient torque, by scipy in the quaternion's rates."""
    m, J, start = 120.0, np.array((8.0, 25.0, 30.0)), np.array((6.9e6, 0.0, 0.0))
    v0, w0 = np.array((0.0, 7.0e3, 2.5e3)), np.array((0.02, -0.01, 0.03))
    body = fmb.RigidBody("b", mass=m, inertia=tuple(J), at=start, velocity=v0, angular_velocity=w0)
    forces = [fmb.CentralGravity("g", body="b"), fmb.OblateGravity("j2", body="b")]
    sensors = [fmb.Position("r", marker="b.center"), fmb.Orientation("p", marker="b.center")]
    model = fmb.Model(bodies=[fmb.Ground(), body], forces=forces, sensors=sensors)
    run = fmb.simulate(model, 600.0, samples=4, integrator=fmb.Explicit(rtol=1e-11))

    def rate(t, y):
        r, v, p, w = y[:3], y[3:6], y[6:10], y[10:]
        far = np.linalg.norm(r)
        own = Rotation.from_quat(np.roll(p, -1)).inv().apply(r / far)
        Je = J * own
        bracket = J.sum() * own + 2 * Je - 5 * (own @ Je) * own
        pull = -MU * r / far**3 - 1.5 * MU / far**4 / m * Rotation.from_quat(np.roll(p, -1)).apply(bracket)
        flat = -1.5 * J2 * MU * RADIUS**2 / far**5 * r * (np.array((1.0, 1.0, 3.0)) - 5.0 * r[2] ** 2 / far**2)
        # the gradient of the flattening turns it too: -sum m rho x H rho = eps (J H), H the second derivatives
        k = Rotation.from_quat(np.roll(p, -1)).inv().apply((0.0, 0.0, 1.0))
        z, mixed = own @ k, np.outer(own, k) + np.outer(k, own)
        H = 6 * np.outer(k, k) - 30 * z * mixed + (105 * z * z - 15) * np.outer(own, own) + (3 - 15 * z * z) * np.eye(3)
        S = 0.5 * J2 * MU * RADIUS**2 / far**5 * J[:, None] * H
        flat_torque = np.array((S[1, 2] - S[2, 1], S[2, 0] - S[0, 2], S[0, 1] - S[1, 0]))
        turn = (3 * MU / far**3 * np.cross(own, Je) + flat_torque - np.cross(w, J * w)) / J
        a, b = p[0], p[1:]
        return np.concatenate([v, pull + flat, [-0.5 * b @ w], 0.5 * (a * w + np.cross(b, w)), turn])

    y0 = np.concatenate([start, v0, [1.0, 0, 0, 0], w0])
    own = solve_ivp(rate, (0, 600), y0, method="DOP853", t_eval=run.t, rtol=1e-13, atol=1e-12)
    np.testing.assert_allclose(run["r"], own.y[:3].T, atol=1e-2)  # 1e-9 of the orbit
    signs = np.sign(np.sum(run["p"] * own.y[6:10].T, axis=1))
    np.testing.assert_allclose(run["p"] * signs[:, None], own.y[6:10].T, atol=1e-6)


def test_what_has_no_centre_is_named():
    with pytest.raises(ModelError, match=r"'ground', Ground.*RigidBody or a PointMass"):
        fmb.Model(bodies=[fmb.Ground(), rigid()], forces=[fmb.CentralGravity("g", body="ground")])
    with pytest.raises(ModelError, match="on a body that moves"):
        fmb.Model(bodies=[rigid()], forces=[fmb.OblateGravity("g", body="b", source="b.center")])
    with pytest.raises(ModelError, match="mu = -1"):
        fmb.CentralGravity("g", body="b", mu=-1.0)


@pytest.mark.parametrize(
    ("integrator", "within"), [(fmb.Explicit(), 1e-6), (fmb.GeneralizedAlpha(), 1e-4), (fmb.IDA(), 1e-4)]
)
def test_origin_that_follows_an_orbit_keeps_all_digits(integrator, within):
    """Two points on a rod of 1.8 m, in axes that fall along a circular orbit: the centre is a `ThirdBody`.

    By scipy: d'' = g_b - g_a - T d, T from d . d'' = -d' . d', each g the difference of attractions to the origin.
    """
    radius, masses = 6.9e6, (120.0, 40.0)
    n = np.sqrt(MU / radius**3)
    places = np.array([(0.0, 0.0, 0.0), (1.2, 1.2, 0.6)])
    speeds = np.array([(0.0, 0.0, 0.0), (-0.002, 0.002, 0.0)])
    centre = tuple(fmb.expression(f"-R*{f}(n*t)", R=radius, n=float(n)) for f in ("cos", "sin")) + (0.0,)
    bodies = [
        fmb.PointMass(k, mass=m, at=r, velocity=v) for k, m, r, v in zip("ab", masses, places, speeds, strict=True)
    ]
    model = fmb.Model(
        bodies=bodies,
        joints=[fmb.Rod("rod", markers=("a.center", "b.center"))],
        forces=[fmb.ThirdBody(f"g{k}", body=k, mu=MU, at=centre) for k in "ab"],
        sensors=[fmb.Position(k, marker=f"{k}.center") for k in "ab"],
    )
    run = fmb.simulate(model, 600.0, samples=4, integrator=integrator)

    def rate(t, y):
        r, v = y[:6].reshape(2, 3), y[6:].reshape(2, 3)
        s = -radius * np.array((np.cos(n * t), np.sin(n * t), 0.0))
        g = MU * ((s - r) / np.linalg.norm(s - r, axis=1)[:, None] ** 3 - s / np.linalg.norm(s) ** 3)
        d, dv = r[1] - r[0], v[1] - v[0]
        tension = (d @ (g[1] - g[0]) + dv @ dv) / (d @ d * (1 / masses[0] + 1 / masses[1]))
        g += np.outer((1 / masses[0], -1 / masses[1]), d * tension)
        return np.concatenate([v.ravel(), g.ravel()])

    y0 = np.concatenate([places.ravel(), speeds.ravel()])
    own = solve_ivp(rate, (0, 600), y0, method="DOP853", t_eval=run.t, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(run["b"] - run["a"], (own.y[3:6] - own.y[:3]).T, atol=within)
    np.testing.assert_allclose(run["a"], own.y[:3].T, atol=10.0 * within)
