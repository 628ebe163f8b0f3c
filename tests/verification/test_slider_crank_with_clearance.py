"""Slider-crank whose slider has a clearance of 1 mm in its guide: free motion, first impact, and what follows.

Data: Flores, Leine & Glocker 2010, Multibody Syst. Dyn. 23 (table 1). References: their equations of motion in two
angles, integrated by SciPy until the slider strikes; balance of impulses of both corners by hand.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fmb

G, CRANK, ROD = 9.81, 0.153, 0.306
HALF, HIGH, PLAY = 0.05, 0.025, 1e-3
MASSES, TURNING = (0.038, 0.038, 0.076), (7.4e-5, 5.9e-4, 2.7e-6)
RESTITUTION, FRICTION = 0.4, 0.01
SPEEDS = 150.0, -75.0  # rad/s, of crank and rod, from x to z


def hinge(x):
    return fmb.Pose.axes((x, 0, 0), x=(1, 0, 0), z=(0, 1, 0))


def mechanism():
    m, J = MASSES, TURNING
    bodies = [
        fmb.Ground(
            markers={
                "bearing": hinge(0.0),
                "low": fmb.Pose.axes((0, 0, -HIGH - PLAY), x=(1, 0, 0), z=(0, 0, 1)),
                "high": fmb.Pose.axes((0, 0, HIGH + PLAY), x=(1, 0, 0), z=(0, 0, -1)),
            }
        )
    ]
    rises = 0.0, SPEEDS[0] * CRANK, SPEEDS[0] * CRANK + SPEEDS[1] * ROD
    for k, (name, length, start) in enumerate(
        (("crank", CRANK, 0.0), ("rod", ROD, CRANK), ("slider", 0.0, CRANK + ROD))
    ):
        bodies.append(
            fmb.RigidBody(
                name,
                mass=m[k],
                inertia=(J[k],) * 3,
                at=(start + 0.5 * length, 0, 0),
                velocity=(0, 0, 0.5 * (rises[k] + rises[min(k + 1, 2)])),
                angular_velocity=(0, -(*SPEEDS, 0.0)[k], 0),
                markers={"start": hinge(-0.5 * length), "end": hinge(0.5 * length)},
            )
        )
    pins = ("ground.bearing", "crank.start"), ("crank.end", "rod.start"), ("rod.end", "slider.start")
    box = fmb.Cuboid(size=(2 * HALF, 0.02, 2 * HIGH))
    sides = [fmb.Surface(name, marker=f"ground.{name}", shape=fmb.Plane()) for name in ("low", "high")]
    law = fmb.Rigid(restitution=RESTITUTION, friction=FRICTION)
    return fmb.Model(
        gravity=(0, 0, -G),
        bodies=bodies,
        joints=[fmb.Revolute(f"pin {k}", markers=pair) for k, pair in enumerate(pins)],
        surfaces=[*sides, fmb.Surface("slider", marker="slider.center", shape=box)],
        forces=[fmb.SurfaceContact("guide", surfaces=(("low", "high"), "slider"), law=law)],
        sensors=[
            *(fmb.AngularVelocity(f"w {name}", marker=f"{name}.center") for name in ("crank", "rod", "slider")),
            fmb.Position("crank", marker="crank.center"),
            fmb.Position("slider", marker="slider.center"),
        ],
    )


def mass_matrix(q):
    m, J = MASSES, TURNING
    between = (0.5 * m[1] + m[2]) * CRANK * ROD
    off = between * np.cos(q[1] - q[0])
    rod = J[1] + (0.25 * m[1] + m[2]) * ROD**2
    return np.array([[J[0] + (0.25 * m[0] + m[1] + m[2]) * CRANK**2, off], [off, rod]]), between


def free(_, x):
    """Return the rates of both angles and their speeds while the slider touches nothing, and does not turn."""
    q, v, m = x[:2], x[2:], MASSES
    M, between = mass_matrix(q)
    turn = between * np.sin(q[0] - q[1])
    weights = (0.5 * m[0] + m[1] + m[2]) * CRANK, (0.5 * m[1] + m[2]) * ROD
    loads = [-turn * v[1] ** 2 - G * weights[0] * np.cos(q[0]), turn * v[0] ** 2 - G * weights[1] * np.cos(q[1])]
    return np.concatenate([v, np.linalg.solve(M, loads)])


def strikes(_, x):
    return CRANK * np.sin(x[0]) + ROD * np.sin(x[1]) - PLAY


strikes.terminal = True


def test_free_motion_and_first_impact():
    """Both upper corners strike at once: the slider leaves with 0.4 of its speed, and friction acts along the guide."""
    exact = solve_ivp(free, (0, 0.005), [0, 0, *SPEEDS], rtol=1e-11, atol=1e-12, events=strikes, dense_output=True)
    hit, q, v = exact.t[-1], exact.y[:2, -1], exact.y[2:, -1]
    step = 1e-5
    found = fmb.simulate(mechanism(), 3e-3, integrator=fmb.MoreauJean(step=step), samples=301)
    w = -np.column_stack([found["w crank"][:, 1], found["w rod"][:, 1]])
    before = found.t < hit - step
    assert w[before] == pytest.approx(exact.sol(found.t[before])[2:].T, rel=2e-6)
    lengths = np.array([CRANK, ROD])
    across, along = lengths * np.cos(q), -lengths * np.sin(q)  # of the pin
    M, _ = mass_matrix(q)
    slip = np.sign(along @ v)
    push = np.linalg.solve(M, -across - slip * FRICTION * along)
    P = -(1.0 + RESTITUTION) * (across @ v) / (across @ push)
    after = v + P * push
    assert np.sign(along @ after) == slip
    first = int(np.flatnonzero(found.t > hit + step)[0])
    drift = free(0.0, np.concatenate([q, after]))[2:]
    assert w[first] == pytest.approx(after + drift * (found.t[first] - hit), rel=2e-4)
    assert np.abs(found["w slider"][first]).max() < 1e-2 * abs(v[0])


def test_it_stays_in_its_guide():
    """Through impacts and rest on the upper side, with steps of two fifths the same turns of the crank."""
    turns = []
    for step in (1e-4, 4e-5):
        found = fmb.simulate(mechanism(), 0.02, integrator=fmb.MoreauJean(step=step), samples=201)
        angle = np.unwrap(np.arctan2(found["crank"][:, 2], found["crank"][:, 0]))
        turns.append(angle[-1] / (2.0 * np.pi))
        assert np.abs(found["slider"][1:, 2]).max() < 1.05 * PLAY
    assert turns[0] == pytest.approx(turns[1], rel=2e-4)
