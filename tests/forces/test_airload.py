"""Strips of wings against Wagner's step response, Theodorsen's lift, Garrick's thrust and the steady lift."""

import numpy as np
import pytest
from contracts.random_models import body
from contracts.test_tangents import assert_tangent

import flexmb as fmb
from flexmb.errors import ModelError
from flexmb.system import compile

RHO, CHORD, SPAN, SPEED = 1.2, 0.8, 2.0, 30.0
WAKE = ((0.165, 0.0455), (0.335, 0.3))


def jones(k):
    """Return the transfer function of Jones's approximation at the reduced frequency k."""
    return 1.0 - sum(part * 1j * k / (1j * k + rate) for part, rate in WAKE)


def strip(angle=0.0, heave=0.0, pitch=0.0, **more) -> fmb.Model:
    """Return a strip in a stream along x of W, nose up by an angle, that heaves (m) and pitches (rad)."""
    up = fmb.Pose.axes((0, 0, 0), z=(0, 0, 1), x=(1, 0, 0))
    along = fmb.Pose.axes((0, 0, 0), z=(0, 1, 0), x=(1, 0, 0))
    fields = {"chord": CHORD, "span": SPAN, "density": RHO, "wind": (SPEED, 0, 0), "place": 0.4} | more
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"up": up}),
            fmb.RigidBody("rod", mass=1.0, inertia=(1, 1, 1), markers={"up": up, "along": along}),
            fmb.RigidBody(
                "wing",
                mass=1.0,
                inertia=(1, 1, 1),
                rotation=(0, angle, 0),
                markers={"along": along, "strip": (0, 0, 0)},
            ),
        ],
        joints=[
            fmb.Prismatic("heave", markers=("ground.up", "rod.up")),
            fmb.Revolute("pitch", markers=("rod.along", "wing.along")),
            fmb.Drive("lift", joint="heave", displacement=heave),
            fmb.Drive("turn", joint="pitch", angle=pitch + angle if isinstance(pitch, float) else pitch),
        ],
        forces=[fmb.Airload("air", marker="wing.strip", **fields)],
        sensors=[fmb.ForceOf("force", force="air"), fmb.State("wake", of="air", state="wake 2"), fmb.Energy("energy")],
    )


def test_a_stream_that_begins_makes_wagners_lift():
    """Lift rho V 2 pi b w phi(s), phi = 1 - 0.165 exp(-0.0455 s) - 0.335 exp(-0.3 s), s = V t / b: half at once."""
    angle = 0.05
    run = fmb.simulate(strip(angle), t_end=0.4, integrator=fmb.Implicit(rtol=1e-9), samples=21)
    V, w = SPEED * np.cos(angle), SPEED * np.sin(angle)
    s = V * run.t / (0.5 * CHORD)
    wagner = 1.0 - sum(part * np.exp(-rate * s) for part, rate in WAKE)
    normal = run["force"][:, 0] * np.sin(angle) + run["force"][:, 2] * np.cos(angle)
    steady = 2 * np.pi * RHO * 0.5 * CHORD * SPAN * V * w
    np.testing.assert_allclose(normal, steady * wagner, rtol=1e-7)
    assert normal[0] == pytest.approx(0.5 * steady, rel=1e-12)
    about = (0.4 - 0.25) * CHORD * normal  # about the marker, from the quarter point
    np.testing.assert_allclose(run["force"][:, 4], about, rtol=1e-9)


@pytest.mark.parametrize("angle", [0.02, 0.4, -0.2])
def test_steady_lift_is_across_the_stream(angle):
    """Kutta and Joukowski: pi rho c V^2 sin(angle), no drag, at any angle."""
    final = fmb.statics(strip(angle))
    force = final["force"][-1]
    expected = np.pi * RHO * CHORD * SPAN * SPEED**2 * np.sin(angle)
    assert force[2] == pytest.approx(expected, rel=1e-8)
    assert abs(force[0]) < 1e-8 * abs(expected)


@pytest.mark.slow
@pytest.mark.parametrize("k", [0.1, 0.7])
def test_oscillations_have_theodorsens_lift_and_garricks_thrust(k):
    """Lift without the mass of the air is 2 pi rho b V C w + pi rho b^2 V a' at the places of the chord; the mean
    thrust of plunging is pi rho b |C|^2 w0^2 of a wash of the amplitude w0.
    """
    b = 0.5 * CHORD
    omega = k * SPEED / b
    period = 2 * np.pi / omega
    times = np.linspace(0.0, 25 * period, 25 * 64 + 1)
    size = 0.01
    wave = fmb.harmonic(amplitude=size, frequency=omega / (2 * np.pi))
    C = jones(k)
    run = fmb.simulate(strip(heave=wave), t_end=times[-1], samples=times, integrator=fmb.Implicit(rtol=1e-8))
    last = slice(-641, -1)  # ten periods
    speed = np.mean(run["force"][last, 2] * np.exp(-1j * omega * run.t[last])) * 2
    wash = -size * omega  # of h = size sin(w t): w = -h' = -size omega cos(w t)
    assert speed == pytest.approx(2 * np.pi * RHO * b * SPAN * SPEED * C * wash, rel=2e-4)
    thrust = -np.mean(run["force"][last, 0])
    assert thrust == pytest.approx(np.pi * RHO * b * SPAN * abs(C) ** 2 * wash**2, rel=1e-3)
    wave = fmb.harmonic(amplitude=1e-4, frequency=omega / (2 * np.pi))
    run = fmb.simulate(strip(pitch=wave), t_end=times[-1], samples=times, integrator=fmb.Implicit(rtol=1e-8))
    found = np.mean(run["force"][last, (2, 4)] * np.exp(-1j * omega * run.t[last])[:, None], axis=0) * 2j
    rate = 1j * omega * 1e-4
    wash = SPEED * 1e-4 + (0.75 - 0.4) * CHORD * rate
    lift, moved = 2 * np.pi * RHO * b * SPAN * SPEED * C * wash, np.pi * RHO * b * b * SPAN * SPEED * rate
    moment = (0.4 - 0.25) * CHORD * lift - (0.75 - 0.4) * CHORD * moved
    np.testing.assert_allclose(found, [lift + moved, moment], rtol=1e-3)


@pytest.mark.parametrize("kind", ["rigid", "floating", "beam"])
def test_tangent(kind, rng):
    """The iteration matrix is the derivative of the residual, at rest with lags and in motion."""
    carrier, marker = body(kind, "b", rng)
    model = fmb.Model(bodies=[fmb.Ground(), carrier])
    R = compile(model).tables["markers"][compile(model).marker_index[marker]]["R"]
    wind = R @ (5.0, 1.0, 0.8)
    air = fmb.Airload("air", marker=marker, chord=1.0, span=0.7, place=0.4, density=0.9, wind=tuple(wind))
    system = compile(model.with_parts(forces=[air]))
    state = system.state()
    u = np.zeros(system.nu)
    u[-2:] = 0.4, -0.3
    assert_tangent(system, state._replace(u=u))
    u[: min(6, len(u) - 2)] = 0.2 * rng.normal(size=min(6, len(u) - 2))
    assert_tangent(system, state._replace(u=u), blocks=("D",))


def test_power_of_the_air_is_what_the_wing_gains():
    wave = fmb.harmonic(amplitude=0.05, frequency=3.0)
    model = strip(0.03, heave=wave)
    free = fmb.Model(
        bodies=[
            fmb.Ground(),
            fmb.RigidBody("wing", mass=2.0, inertia=(1, 1, 1), rotation=(0, 0.03, 0), markers={"strip": (0.1, 0, 0)}),
        ],
        forces=[model.forces[0].replaced(marker="wing.strip", span=0.1)],
        sensors=[fmb.Energy("energy")],
    )
    run = fmb.simulate(free, t_end=0.3, integrator=fmb.Implicit(rtol=1e-9), samples=31)
    balance = run["energy"] - run.phases[0].works @ (1.0, 1.0, -1.0)
    assert np.ptp(run["energy"]) > 0.1
    np.testing.assert_allclose(balance, balance[0], atol=1e-7 * np.ptp(run["energy"]))


def test_a_stream_from_behind_ends_the_run():
    with pytest.raises(fmb.IntegrationError, match="air"):
        fmb.simulate(strip(0.05, wind=(fmb.expression("10 - 40*t"), 0, 0)), t_end=1.0)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"chord": 0.0}, "chord"),
        ({"place": 1.5}, "leading edge"),
        ({"wakes": (1.0,)}, "two finite numbers"),
        ({"wind": 3.0}, "three numbers"),
    ],
)
def test_bad_input_is_told(changes, told):
    with pytest.raises(ModelError, match=told):
        strip(**changes)
