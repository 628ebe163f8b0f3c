"""Points on curves: a cycloid is isochronous, a circle is a pendulum; swept tracks, ends, messages."""

import numpy as np
import pytest
from scipy.special import ellipk

import flexmb as fmb


def bead(curve, at, *, joint=None, sensors=(), mass=2.0, **fields):
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), fmb.PointMass("bead", mass=mass, at=at)],
        joints=[fmb.PointOnCurve("track", markers=("ground.origin", "bead.center"), curve=curve, **fields)],
        sensors=[
            fmb.Position("r", marker="bead.center"),
            fmb.Velocity("v", marker="bead.center"),
            fmb.Energy("energy"),
            fmb.Reaction("force", joint="track"),
            *sensors,
        ],
    )


def cycloid(a, n=81):
    phi = np.linspace(-np.pi, np.pi, n)
    return np.column_stack([a * (phi + np.sin(phi)), 0 * phi, a * (1 - np.cos(phi))])


@pytest.mark.parametrize("start", [0.4, 1.5, 2.4])
def test_tautochrone(start):
    """On a cycloid the period is 4 pi sqrt(a/g), whatever the amplitude."""
    a = 0.5
    at = (a * (start + np.sin(start)), 0, a * (1 - np.cos(start)))
    period = 4 * np.pi * np.sqrt(a / 9.81)
    solution = fmb.simulate(
        bead(cycloid(a), at),
        2 * period,
        samples=3,
        integrator=fmb.GeneralizedAlpha(rho_inf=0.95, step=period / 2000),
    )
    np.testing.assert_allclose(solution["r"][1:], [at, at], atol=2e-5)
    assert np.ptp(solution["energy"]) < 1e-4


@pytest.mark.parametrize(
    "integrator",
    [fmb.GeneralizedAlpha(rho_inf=0.9, step=2e-4), fmb.IDA(rtol=1e-8, atol=1e-10)],
    ids=["alpha", "IDA"],
)
def test_closed_circle_is_a_pendulum(integrator):
    """Large swings: T = 4 sqrt(r/g) K(sin^2(amplitude/2)); normal force m (v^2/r - g z/r) towards the centre."""
    r, start = 0.8, 2.0
    angle = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    curve = np.column_stack([r * np.sin(angle), 0 * angle, -r * np.cos(angle)])
    at = (r * np.sin(start), 0, -r * np.cos(start))
    period = 4 * np.sqrt(r / 9.81) * ellipk(np.sin(start / 2) ** 2)
    solution = fmb.simulate(bead(curve, at, closed=True), period, samples=41, integrator=integrator)
    np.testing.assert_allclose(solution["r"][-1], at, atol=1e-4)
    position, v = solution["r"], solution["v"]
    inward = -position / r
    normal = np.einsum("ti,ti->t", solution["force"][:, :3], inward)
    expected = 2.0 * (np.einsum("ti,ti->t", v, v) / r - 9.81 * position[:, 2] / r)
    np.testing.assert_allclose(normal, expected, atol=2e-3 * np.abs(expected).max())


def test_a_bead_goes_round():
    """A closed curve is followed through its end again and again."""
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    curve = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    model = bead(curve, (1, 0, 0), closed=True).changed("bead", velocity=(0, 7.0, 0))
    model = type(model)(bodies=model.bodies, joints=model.joints, sensors=model.sensors)
    solution = fmb.simulate(model, 4.0, samples=81, integrator=fmb.GeneralizedAlpha(step=1e-3))
    turned = np.unwrap(np.arctan2(solution["r"][:, 1], solution["r"][:, 0]))
    assert turned[-1] == pytest.approx(28.0, rel=1e-4)


def test_swept_track_leaves_its_axis_free():
    """A cycloid swept along y: the motion in the plane is that of the curve, along y it is uniform."""
    a, start = 0.5, 1.5
    at = (a * (start + np.sin(start)), 0.2, a * (1 - np.cos(start)))
    period = 4 * np.pi * np.sqrt(a / 9.81)
    model = bead(cycloid(a), at, along="y").changed("bead", velocity=(0, 0.3, 0))
    assert fmb.check(model).equations == 1
    solution = fmb.simulate(
        model, period, samples=11, integrator=fmb.GeneralizedAlpha(rho_inf=0.95, step=period / 2000)
    )
    np.testing.assert_allclose(solution["r"][-1, [0, 2]], [at[0], at[2]], atol=2e-5)
    np.testing.assert_allclose(solution["r"][:, 1], 0.2 + 0.3 * solution.t, atol=1e-9)
    np.testing.assert_allclose(solution["force"][:, 1], 0.0, atol=1e-9)


def test_beyond_the_end_the_track_goes_on_straight():
    """From the end of a slope of 45 degrees a bead without gravity goes on at its speed, along the last tangent."""
    curve = [(0, 0, 0), (1, 0, 0), (2, 0, 0.5), (2.5, 0, 1.0)]
    model = bead(curve, (2.5, 0, 1.0))
    last = fmb.joints.PointOnCurve("t", markers=("a.b", "c.d"), curve=curve).spline
    assert last[0] == 4
    model = type(model)(
        bodies=[b.replaced(velocity=(1, 0, 1)) if b.name == "bead" else b for b in model.bodies],
        joints=model.joints,
        sensors=model.sensors,
    )
    solution = fmb.simulate(model, 2.0, samples=5)
    steps = np.diff(solution["r"], axis=0)
    np.testing.assert_allclose(steps[1:], steps[:-1], atol=1e-6)


def test_leaving_a_track_with_hard_ends_is_an_error():
    model = bead([(0, 0, 0), (1, 0, 0), (2, 0, 0)], (1, 0, 0), ends="error").changed("bead", velocity=(2.0, 0, 0))
    with pytest.raises(fmb.IntegrationError, match="track: OnCurve") as error:
        fmb.simulate(model, 2.0, samples=201)
    assert error.value.solution.t[-1] == pytest.approx(0.5, abs=0.02)


def test_curve_on_a_moving_body():
    """A bead in a straight tube that turns at a constant rate flies out: r = r0 cosh(w t)."""
    w = 2.0
    model = fmb.Model(
        bodies=[
            fmb.Ground(),
            fmb.RigidBody("tube", mass=1.0, inertia=(1, 1, 1), angular_velocity=(0, 0, w)),
            fmb.PointMass("bead", mass=0.5, at=(0.1, 0, 0), velocity=(0, 0.1 * w, 0)),
        ],
        joints=[
            fmb.Revolute("axis", markers=("ground.origin", "tube.center")),
            fmb.Drive("motor", joint="axis", angle=fmb.ramp(rate=w)),
            fmb.PointOnCurve("bore", markers=("tube.center", "bead.center"), curve=[(0, 0, 0), (1, 0, 0), (2, 0, 0)]),
        ],
        sensors=[fmb.Position("r", marker="bead.center"), fmb.Reaction("force", joint="bore")],
    )
    solution = fmb.simulate(model, 1.2, samples=13, integrator=fmb.GeneralizedAlpha(step=5e-4))
    r = 0.1 * np.cosh(w * solution.t)
    np.testing.assert_allclose(np.linalg.norm(solution["r"], axis=1), r, rtol=1e-5)
    push = np.linalg.norm(solution["force"][:, :3], axis=1)
    np.testing.assert_allclose(push, 0.5 * 2 * w * 0.1 * w * np.sinh(w * solution.t), atol=2e-4)


@pytest.mark.parametrize(
    ("fields", "found"),
    [
        ({"curve": [(0, 0, 0), (1, 0, 0)]}, "a curve with the shape"),
        ({"curve": "circle"}, "a curve with the shape"),
        ({"curve": [(0, 0, 0), (1, 0, 0), (1, 0, 0)]}, "neighbouring points"),
        ({"curve": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 0, 0)], "closed": True}, "neighbouring points"),
        ({"curve": [(0, 0, 0), (1, 0, 0), (2, 1, 0)], "ends": "stop"}, "ends = 'stop'"),
        ({"curve": [(0, 0, 0), (1, 0, 0), (2, 1, 0)], "along": "u"}, "along = 'u'"),
        ({"curve": [(0, 0, 0), (1, 0, 0), (2, 1, 0)], "along": "y"}, "whose y varies"),
    ],
)
def test_messages(fields, found):
    with pytest.raises(fmb.ModelError, match=found):
        fmb.PointOnCurve("p", markers=("ground.origin", "b.center"), **fields)
