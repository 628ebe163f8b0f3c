"""Force elements with states in cases of their own: impedance, a ramp, a drum, oil against a spring, whole steps."""

import numpy as np
import pytest
from by_turns import slow
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import flexmb as fmb

ALONG = fmb.Pose.axes(z=(1, 0, 0))


def rail(forces, *, mass=1.0, speed=0.0, sensors=(), displacement=None) -> fmb.Model:
    """Return a mass on a rail with forces on it, perhaps driven."""
    body = fmb.RigidBody("m", mass=mass, inertia=(1, 1, 1), velocity=(speed, 0, 0), markers={"x": ALONG})
    joints = [fmb.Prismatic("rail", markers=("ground.x", "m.x"))]
    if displacement is not None:
        joints.append(fmb.Drive("drive", joint="rail", displacement=displacement))
    coordinate = fmb.JointCoordinate("x", joint="rail")
    ground = fmb.Ground(markers={"x": ALONG})
    return fmb.Model(bodies=[ground, body], joints=joints, forces=forces, sensors=[coordinate, *sensors])


def first(solution, sensor) -> np.ndarray:
    """Return the first column of a sensor."""
    return np.reshape(solution[sensor], (len(solution.t), -1))[:, 0]


def test_motor_on_alternating_voltage():
    """The current is V / (R + i w L + (n k)^2 / (i w m)) once the start has died away."""
    R, L, k, n, m, w = 2.0, 0.05, 0.9, 4.0, 0.5, 30.0
    motor = fmb.DcMotor(
        "motor", joint="rail", voltage=fmb.expression("10*sin(30*t)"), resistance=R, inductance=L, constant=k, ratio=n
    )
    current = fmb.State("current", of="motor", state="current")
    seen = fmb.simulate(rail([motor], mass=m, sensors=[current]), 6.0, integrator=fmb.Implicit(), samples=1201)
    late = seen.t > 3.0
    waves = np.exp(1j * w * seen.t[late])
    columns = np.stack([waves.imag, waves.real, np.ones(len(waves))], axis=1)
    sine, cosine, _ = np.linalg.lstsq(columns, first(seen, "current")[late], rcond=None)[0]
    impedance = R + 1j * w * L + (n * k) ** 2 / (1j * w * m)
    assert complex(sine, cosine) == pytest.approx(10.0 / impedance, rel=1e-6)


def test_relaxing_spring_on_a_ramp():
    """At a constant rate v the force is k v t + sum k_j tau_j v (1 - exp(-t / tau_j))."""
    branches, k, v = ((100.0, 0.1), (50.0, 0.7)), 20.0, 0.2
    spring = fmb.MaxwellDamper("spring", joint="rail", branches=branches, stiffness=k)
    pull = fmb.Reaction("pull", joint="drive")
    model = rail([spring], speed=v, sensors=[pull], displacement=fmb.expression("0.2*t"))
    seen = fmb.simulate(model, 1.0, integrator=fmb.Implicit(), samples=51)
    force = k * v * seen.t + sum(s * tau * v * (1.0 - np.exp(-seen.t / tau)) for s, tau in branches)
    found = np.abs(np.reshape(seen["pull"], (len(seen.t), -1))[:, :3]).max(axis=1)
    np.testing.assert_allclose(found, force, atol=1e-6 * force.max())


def muscle_over_a_drum(turn: float) -> fmb.Model:
    """Return an arm that is held, turned down by an angle, with a muscle over a drum at its joint."""
    arm = fmb.RigidBody(
        "arm", mass=1.0, inertia=(1, 1, 1), rotation=(0, 0, -turn), markers={"axis": (0, 0, 0), "end": (0.25, 0, 0)}
    )
    muscle = fmb.Muscle(
        "muscle",
        through=("ground.o", "ground.axis", "arm.end"),
        radii=(0, -0.04, 0),
        excitation=0.6,
        strength=1000.0,
        fibre=0.1,
        tendon=0.35,
        pennation=0.2,
    )
    return fmb.Model(
        bodies=[fmb.Ground(markers={"o": (-0.25, 0.04, 0), "axis": (0, 0, 0)}), arm],
        joints=[
            fmb.Revolute("elbow", markers=("ground.axis", "arm.axis")),
            fmb.Drive("held", joint="elbow", angle=-turn),
        ],
        forces=[muscle],
        sensors=[fmb.Reaction("moment", joint="held"), fmb.State("fibre", of="muscle", state="fibre length")],
    )


@pytest.mark.parametrize("turn", [0.3, 0.9])
def test_moment_of_a_muscle_over_a_drum(turn):
    """Tendon force times radius; the fibre's length from Thelen's curves by a search (2003, eq. 1 to 4)."""
    radius, arm = 0.04, 0.25
    way = arm + radius * (0.5 * np.pi + turn - np.arccos(radius / arm)) + np.sqrt(arm**2 - radius**2)
    height = 0.1 * np.sin(0.2)

    def tendon(strain):
        toe = 0.609 * 0.04
        if strain <= toe:
            return 0.33 / np.expm1(3.0) * np.expm1(3.0 * max(strain, 0.0) / toe)
        return 1.712 / 0.04 * (strain - toe) + 0.33

    def parts(length):
        x, cosine = length / 0.1, np.sqrt(1.0 - (height / length) ** 2)
        passive = np.expm1(5.0 * max(x - 1.0, 0.0) / 0.6) / np.expm1(5.0)
        fibre = (0.6 * np.exp(-((x - 1.0) ** 2) / 0.45) + passive) * cosine
        return tendon((way - length * cosine) / 0.35 - 1.0), fibre

    length = brentq(lambda x: np.subtract(*parts(x)), 1.01 * height, 0.22, xtol=1e-15)
    seen = fmb.statics(muscle_over_a_drum(turn))
    assert first(seen, "fibre")[-1] == pytest.approx(length, rel=1e-9)
    moment = np.ravel(seen["moment"][-1])[5]
    assert moment == pytest.approx(-1000.0 * parts(length)[0] * radius, rel=1e-7)


def test_oil_against_a_spring():
    """A valve that swings moves a mass against a spring: continuity and sharp edges by scipy."""
    a, b, bulk, dead, supply, flow, drop = 2e-3, 1.2e-3, 1.4e9, 2e-4, 2e7, 1e-3, 3.5e6
    stiffness, mass, damping = 4e5, 50.0, 800.0
    cylinder = fmb.HydraulicCylinder(
        "cylinder",
        joint="rail",
        valve=fmb.expression("0.4*sin(6*t)"),
        areas=(a, b),
        stroke=0.5,
        retracted=-0.25,
        dead_volume=dead,
        supply=supply,
        rated_flow=flow,
        bulk=bulk,
        pressures=(6e6, 1e7),
    )
    spring = fmb.Actuator("spring", joint="rail", effort=fmb.table([-1.0, 1.0], [stiffness, -stiffness], of="rail"))
    damper = fmb.Actuator("damper", joint="rail", effort=-damping * fmb.measured("x", rate=True))
    pressure = fmb.State("pressure", of="cylinder", state="pressure a")
    model = rail([cylinder, spring, damper], mass=mass, sensors=[pressure])

    def edge(high, low):
        return np.sign(high - low) * np.sqrt(abs(high - low) / drop) * flow

    def rates(t, y):
        x, v, pa, pb = y
        u = 0.4 * np.sin(6.0 * t)
        ends = (supply, 0.0) if u >= 0.0 else (0.0, supply)
        into_a, into_b = (abs(u) * edge(end, p) for end, p in zip(ends, (pa, pb), strict=True))
        rooms = dead + a * (x + 0.25), dead + b * (0.25 - x)
        force = pa * a - pb * b - stiffness * x - damping * v
        return v, force / mass, bulk / rooms[0] * (into_a - a * v), bulk / rooms[1] * (into_b + b * v)

    t = np.linspace(0.0, 2.0, 201)
    given = {"method": "LSODA", "rtol": 1e-9, "atol": [1e-10, 1e-9, 1e-2, 1e-2], "max_step": 1e-3}
    reference = solve_ivp(rates, (0.0, 2.0), (0.0, 0.0, 6e6, 1e7), t_eval=t, **given)
    for integrator, of_place, of_pressure in ((fmb.GeneralizedAlpha(), 1e-5, 1e-3), (fmb.Implicit(), 1e-6, 1e-4)):
        seen = fmb.simulate(model, 2.0, integrator=integrator, samples=201)
        np.testing.assert_allclose(first(seen, "x"), reference.y[0], atol=of_place)
        np.testing.assert_allclose(first(seen, "pressure"), reference.y[2], atol=of_pressure * supply)


def stairs(end: float) -> float:
    """Return where a mass of 1 kg with 1 m/s is that is pulled back by -2.5 N for each whole 0.05 m, by parabolas."""
    x, v, t, step = 0.0, 1.0, 0.0, 0
    while True:
        a, until, go = -2.5 * step, np.inf, 0
        for side, sense in (((step + 0.5) * 0.05, 1), ((step - 0.5) * 0.05, -1)):
            roots = np.roots([0.5 * a, v, x - side])
            for root in roots[np.isreal(roots)].real:
                if 1e-10 < root < until and sense * (v + a * root) > 0.0:
                    until, go = root, sense
        if t + until >= end:
            return x + v * (end - t) + 0.5 * a * (end - t) ** 2
        x, v, t, step = x + v * until + 0.5 * a * until**2, v + a * until, t + until, step + go


@pytest.mark.parametrize(
    "integrator", [fmb.GeneralizedAlpha(), *map(slow, (fmb.Implicit(), fmb.Explicit(), fmb.IDA()))], ids=repr
)
def test_force_that_knows_the_place_in_whole_steps(integrator):
    """Between the places at which the quantiser goes on the motion is a parabola."""
    pull = fmb.Actuator("pull", joint="rail", effort=-50.0 * fmb.Quantiser(fmb.measured("x"), step=0.05))
    seen = fmb.simulate(rail([pull], speed=1.0), 2.0, integrator=integrator, samples=21)
    np.testing.assert_allclose(first(seen, "x"), [stairs(t) for t in seen.t], atol=1e-9)
