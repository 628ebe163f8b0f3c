"""A tether of 100 km and a gyroscope of 50 um, at default tolerances.

References: an integration about the origin of the orbit by scipy; steady precession of a heavy top (Goldstein, section
5.7), ``J1 O^2 cos - J3 w3 O + m g L = 0``.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fmb

MU = 3.986004418e14


@pytest.mark.parametrize(
    ("integrator", "within"),
    [(None, 1e-9), (fmb.GeneralizedAlpha(), 5e-5), (fmb.IDA(), 5e-5), (fmb.Implicit(), 5e-5)],
    ids=["default", "generalised-alpha", "IDA", "Implicit"],
)
def test_tether_of_100_km(integrator, within):
    """Two masses over an orbit, the tether along the vertical: places relative to its length, and its force."""
    L, masses, orbit = 1e5, np.array((1000.0, 500.0)), fmb.Orbit.circular(7.0e6)
    n = 2 * np.pi / orbit.period
    x = L * np.array((-masses[1], masses[0])) / masses.sum()
    model = fmb.Model(
        bodies=[
            fmb.Ground(),
            *(fmb.PointMass(k, mass=m, at=(r, 0, 0), velocity=(0, n * r, 0)) for k, m, r in zip("ab", masses, x)),
        ],
        forces=[fmb.CentralGravity(f"g{k}", body=k) for k in "ab"],
        joints=[fmb.Rod("tether", markers=("a.center", "b.center"))],
        sensors=[fmb.Reaction("T", joint="tether"), *(fmb.Position(k, marker=f"{k}.center") for k in "ab")],
        origin=orbit,
    )
    run = fmb.simulate(model, orbit.period, samples=5, integrator=integrator)

    def forces(t, y):
        r, v = y[:6].reshape(2, 3), y[6:].reshape(2, 3)
        rho = orbit.at(t)[0]
        far = np.linalg.norm(rho + r, axis=1)[:, None]
        pull = -MU * ((rho + r) / far**3 - rho / np.linalg.norm(rho) ** 3)
        d, dv = r[1] - r[0], v[1] - v[0]
        return pull, d, (d @ (pull[1] - pull[0]) + dv @ dv) / (d @ d * np.sum(1 / masses)), v

    def rate(t, y):
        pull, d, tension, v = forces(t, y)
        return np.concatenate([v.ravel(), (pull + np.outer(1 / masses * (1, -1), d * tension)).ravel()])

    y0 = np.array((x[0], 0, 0, x[1], 0, 0, 0, n * x[0], 0, 0, n * x[1], 0))
    own = solve_ivp(rate, (0, run.t[-1]), y0, method="DOP853", t_eval=run.t, rtol=1e-12, atol=1e-6).y
    np.testing.assert_allclose(run["b"] - run["a"], (own[3:6] - own[:3]).T, atol=within * L)
    tension = [forces(t, y)[2] * L for t, y in zip(run.t, own.T, strict=True)]
    np.testing.assert_allclose(np.linalg.norm(run["T"][:, :3], axis=1), tension, rtol=1e-3)
    # the leading term, 3 n^2 m L of the reduced mass
    assert tension[0] == pytest.approx(3 * n**2 * L / np.sum(1 / masses), rel=1e-2)


@pytest.mark.parametrize("length", [1e-9, 1e-6, 1e6])
@pytest.mark.parametrize(
    "integrator", [fmb.Implicit(), fmb.Explicit(formulation=fmb.Recursive())], ids=["Implicit", "Explicit"]
)
def test_pendulum_of_any_size_in_the_recursion(integrator, length):
    """Three swings from 0.5 rad; theta'' = -3 g / 2 L sin theta. One of a micrometre had no inertia beside its mass."""
    inertia = 1e3 * length**5 * np.array((1e-4, 1 / 12, 1 / 12))
    place = 0.5 * length * np.array((np.sin(0.5), 0, -np.cos(0.5)))
    rod = fmb.RigidBody("rod", mass=1e3 * length**3, inertia=inertia, at=place, rotation=(0, np.pi / 2 - 0.5, 0))
    rod = replace(rod, markers={"end": (-0.5 * length, 0, 0)})
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), rod],
        joints=[fmb.Spherical("pin", markers=("ground.origin", "rod.end"))],
        sensors=[fmb.Position("x", marker="rod.center")],
    )
    run = fmb.simulate(model, 19.0 * np.sqrt(length / 9.81), samples=21, integrator=integrator)
    rates = lambda _, y: (y[1], -1.5 * 9.81 / length * np.sin(y[0]))  # noqa: E731
    exact = solve_ivp(rates, (0, run.t[-1]), (0.5, 0.0), "DOP853", run.t, rtol=1e-12, atol=1e-14).y[0]
    np.testing.assert_allclose(run["x"][:, 0], 0.5 * length * np.sin(exact), rtol=0, atol=1e-4 * length)


def top(size: float) -> tuple[fmb.Model, float]:
    """A disc of silicon that precesses steadily about its tip, `size` away; and its rate, rad/s."""
    radius, height, w, tilt, g = 0.5 * size, 0.1 * size, 0.7 / np.sqrt(size / 50e-6) * 1e5, 0.3, 9.81
    mass = np.pi * radius**2 * height * 2330.0
    J3, J1 = 0.5 * mass * radius**2, mass * (3 * radius**2 + height**2) / 12
    at_tip, weight = J1 + mass * size**2, mass * g * size
    rate = 2 * weight / (J3 * w + np.sqrt((J3 * w) ** 2 - 4 * at_tip * np.cos(tilt) * weight))
    axis = np.array((np.sin(tilt), 0, np.cos(tilt)))
    turning = w * axis + rate * (np.array((0, 0, 1.0)) - np.cos(tilt) * axis)
    body = fmb.RigidBody(
        "top",
        mass=mass,
        inertia=(J1, J1, J3),
        at=size * axis,
        rotation=(0, tilt, 0),
        velocity=np.cross(turning, size * axis),
        angular_velocity=turning,
        markers={"tip": (0, 0, -size)},
    )
    tip = fmb.Spherical("tip", markers=("ground.origin", "top.tip"))
    place = fmb.Position("p", marker="top.center")
    return fmb.Model(bodies=[fmb.Ground(), body], joints=[tip], gravity=(0, 0, -g), sensors=[place]), rate


@pytest.mark.parametrize("size", [50e-6, 50e-3])
@pytest.mark.parametrize(
    ("integrator", "within"),
    [(fmb.Explicit(), 1e-8), (fmb.IDA(), 1e-4), (fmb.GeneralizedAlpha(), 5e-3), (fmb.Implicit(), 1e-4)],
)
def test_gyroscope_of_50_micrometres(size, integrator, within):
    """The same errors relative to its size as that of a gyroscope a thousand times as large, over 20 turns."""
    model, rate = top(size)
    w = float(np.linalg.norm(model.body("top").angular_velocity))
    run = fmb.simulate(model, 20 * 2 * np.pi / w, samples=5, integrator=integrator)
    tilt, angle = 0.3, rate * run.t
    expected = np.stack([np.sin(tilt) * np.cos(angle), np.sin(tilt) * np.sin(angle), np.cos(tilt) + 0 * angle], axis=1)
    np.testing.assert_allclose(run["p"] / size, expected, atol=within)
