"""LuGre friction against the equations and the data of Canudas de Wit, Olsson, Astrom & Lischinsky 1995.

Table I: sigma_0 = 1e5 N/m, sigma_1 = sqrt(1e5) N s/m, sigma_2 = 0.4 N s/m, F_C = 1 N, F_S = 1.5 N, v_s = 0.001 m/s; a
mass of 1 kg. The reference integrates their equations by scipy.
"""

import numpy as np
import pytest
from by_turns import slow
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import flexmb as fmb
from flexmb.errors import ModelError

S0, S1, S2, MOVING, STANDING, STRIBECK = 1e5, 1e5**0.5, 0.4, 1.0, 1.5, 1e-3
DATA = {
    "stiffness": S0,
    "damping": S1,
    "viscous": S2,
    "moving": MOVING,
    "standing": STANDING,
    "stribeck": STRIBECK,
}
SPRING, PULL = 2.0, 0.1  # N/m and m/s of section IV.B


def level(v):
    return MOVING + (STANDING - MOVING) * np.exp(-((v / STRIBECK) ** 2))


def paper(push, t_end, at):
    """Return position, speed and bristles of the unit mass under push(t, x), by Radau's method."""

    def rates(t, y):
        x, v, z = y
        dz = v - S0 * abs(v) / level(v) * z
        return v, push(t, x) - S0 * z - S1 * dz - S2 * v, dz

    found = solve_ivp(rates, (0.0, t_end), np.zeros(3), method="Radau", rtol=1e-9, atol=1e-13, t_eval=at, max_step=0.02)
    assert found.success
    return found.y


def sled(*forces, turning=False, **more) -> fmb.Model:
    """Return a unit mass (or moment of inertia) on a rubbing rail along z."""
    markers = ("ground.origin", "b.center")
    kind = fmb.Revolute if turning else fmb.Prismatic
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("b", mass=1.0, inertia=(1.0, 1.0, 1.0))],
        joints=[kind("rail", markers=markers)],
        forces=[fmb.LuGre("rub", joint="rail", **DATA), *forces],
        sensors=[fmb.JointCoordinate("x", joint="rail"), fmb.State("z", of="rub"), fmb.Energy("energy")],
        **more,
    )


@pytest.mark.parametrize("turning", [False, True])
def test_presliding_displacement(turning):
    """Section IV.A: the push swings up to 1.425 N, below the break-away; a loop opens and a displacement remains."""
    wave = fmb.expression("1.425*sin(2*t)")
    model = sled(fmb.Actuator("push", joint="rail", effort=wave), turning=turning)
    solution = fmb.simulate(model, t_end=np.pi, integrator=fmb.GeneralizedAlpha(rtol=1e-7), samples=61)
    exact = paper(lambda t, x: 1.425 * np.sin(2.0 * t), np.pi, at=solution.t)
    assert solution["x"] == pytest.approx(exact[0], abs=2e-4 * np.abs(exact[0]).max())
    assert solution["z"] == pytest.approx(exact[2], abs=2e-4 * np.abs(exact[2]).max())
    # no push in the middle
    assert abs(exact[0][30]) > 0.1 * np.abs(exact[0]).max()


def test_bristles_hold_without_creeping():
    """Under a constant push below the break-away the mass stays: z = F / sigma_0, and x with it."""
    model = sled(fmb.Actuator("push", joint="rail", effort=fmb.expression("0.9*tanh(t)**2")))
    solution = fmb.simulate(model, t_end=100.0, samples=101)
    assert solution["z"][20:] == pytest.approx(np.full(81, 0.9 / S0), rel=1e-6)
    assert np.ptp(solution["x"][20:]) < 1e-6 * solution["x"][-1]


def test_steady_sliding():
    """At a constant push above the break-away the speed is that of F = g(v) + sigma_2 v."""
    model = sled(fmb.Actuator("push", joint="rail", effort=2.0))
    solution = fmb.simulate(model, t_end=60.0, samples=3)
    speed = brentq(lambda v: level(v) + S2 * v - 2.0, 0.1, 10.0)
    assert solution.final.u[2] == pytest.approx(speed, rel=1e-6)


def test_break_away_falls_with_the_rate_of_the_push():
    """Section IV.C: the friction at break-away is lower for faster pushes, as the equations have it."""
    forces = []
    for rate in (1.0, 20.0):
        model = sled(fmb.Actuator("push", joint="rail", effort=fmb.ramp(rate=rate)))
        t_end = 1.6 / rate
        solution = fmb.simulate(model, t_end=t_end, integrator=fmb.GeneralizedAlpha(rtol=1e-7), samples=401)
        exact = paper(lambda t, x, rate=rate: rate * t, t_end, at=solution.t)
        largest = S0 * solution["z"].max()
        assert largest == pytest.approx(S0 * exact[2].max(), rel=2e-4)
        forces.append(largest)
    assert forces[1] < forces[0] - 0.05


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(rtol=1e-7), slow(fmb.Implicit(rtol=1e-7))])
def test_stick_slip(integrator):
    """Section IV.B: a spring of 2 N/m, its end pulled with 0.1 m/s, moves the mass in jumps. The energies balance."""
    model = sled(
        fmb.Actuator("spring", joint="rail", effort=fmb.table([-50, 50], [50 * SPRING, -50 * SPRING], of="rail")),
        fmb.Actuator("end", joint="rail", effort=fmb.ramp(rate=SPRING * PULL)),
    )
    solution = fmb.simulate(model, t_end=20.0, integrator=integrator, samples=201)
    exact = paper(lambda t, x: SPRING * (PULL * t - x), 20.0, at=solution.t)
    jumps = np.diff(exact[0])
    assert (jumps > 0.02).any()
    assert (np.abs(jumps) < 1e-6).any()
    assert solution["x"] == pytest.approx(exact[0], abs=5e-5)  # m, of 1.27 m in three jumps
    phase = solution.phases[0]
    balance = solution["energy"] - phase.works @ (1.0, 1.0, -1.0)
    assert balance == pytest.approx(np.zeros(201), abs=1e-4)


def test_poles_at_rest_are_those_of_a_spring():
    """Linearised at z = v = 0 the bristles are a spring: s^2 + (sigma_1 + sigma_2) s + sigma_0 (section III)."""
    values = fmb.linearize(sled()).eigenvalues
    exact = np.roots([1.0, S1 + S2, S0])
    assert values[np.abs(values) > 1.0] == pytest.approx(exact[exact.imag > 0], rel=1e-9)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"standing": 0.5}, "standing = 0.5 below moving = 1.0"),
        ({"stiffness": 0.0}, "stiffness = 0"),
        ({"stribeck": -1.0}, "stribeck = -1"),
        ({"damping": float("nan")}, "damping = nan"),
        ({"deflection": 2e-5}, "deflection = 2e-05"),
        ({"deflection": "much"}, "deflection = 'much'"),
    ],
)
def test_messages(change, words):
    with pytest.raises(ModelError, match=words):
        fmb.LuGre("rub", joint="rail", **{**DATA, **change})
