"""Forces against closed forms."""

import numpy as np
import pytest
from scipy.special import ellipj
from tolerances import SOLVER

import flexmb as fmb

FINE = fmb.GeneralizedAlpha(rho_inf=0.95, step=2e-4)
AXIS_X = fmb.Pose.axes(z=(1, 0, 0))


def block(joint=fmb.Prismatic, at=(0.0, 0, 0), gravity=(0.0, 0, 0), **parts):
    """A block of 2 kg (0.5 kg m2) on a joint along (or about) x."""
    sensors = parts.pop("sensors", [])
    speed = {k: parts.pop(k) for k in ("velocity", "angular_velocity") if k in parts}
    return fmb.Model(
        gravity=gravity,
        bodies=[
            fmb.Ground(markers={"x": AXIS_X}),
            fmb.RigidBody("block", mass=2.0, inertia=(0.5, 0.5, 0.5), at=at, markers={"x": AXIS_X}, **speed),
        ],
        joints=[joint("j", markers=("ground.x", "block.x"))],
        sensors=[
            fmb.JointCoordinate("x", joint="j"),
            fmb.Energy("energy"),
            fmb.Energy("lost", kind="dissipated"),
            *sensors,
        ],
        **parts,
    )


def test_cubic_spring_is_the_oscillator_of_duffing():
    """m x'' + k x + k3 x^3 = 0 from rest at A: x = A cn(W t | s), W^2 = (k + k3 A^2) / m, s = k3 A^2 / (2 m W^2)."""
    m, k, k3, A = 2.0, 30.0, 4000.0, 0.15
    bodies = [fmb.Ground(), fmb.RigidBody("b", mass=m, inertia=(1, 1, 1), at=(1.0 + A, 0, 0))]
    spring = fmb.SpringDamper("s", markers=("ground.origin", "b.center"), stiffness=k, cubic=k3, length=1.0)
    sensors = [fmb.Position("x", marker="b.center"), fmb.Energy("energy")]
    model = fmb.Model(bodies=bodies, forces=[spring], sensors=sensors, gravity=(0, 0, 0))
    found = fmb.simulate(model, 2.0, samples=41, integrator=fmb.Explicit(rtol=1e-10))
    W = np.sqrt((k + k3 * A**2) / m)
    expected = A * ellipj(W * found.t, 0.5 * k3 * A**2 / (m * W**2))[1]
    np.testing.assert_allclose(found["x"][:, 0] - 1.0, expected, atol=1e-7 * A)
    np.testing.assert_allclose(found["energy"], 0.5 * k * A**2 + 0.25 * k3 * A**4, rtol=1e-8)


@pytest.mark.parametrize("integrator", [FINE, fmb.IDA(rtol=1e-9, atol=1e-11)], ids=["alpha", "IDA"])
def test_torsion_spring_counts_turns(integrator):
    """Spun up to 5 turns and back: theta = (w0/w) sin(w t)."""
    w0, k = 30.0, 0.5 * 0.9**2
    model = block(
        fmb.Revolute,
        angular_velocity=(w0, 0, 0),
        forces=[fmb.TorsionSpring("spring", joint="j", stiffness=k)],
        sensors=[fmb.ForceOf("torque", force="spring")],
    )
    solution = fmb.simulate(model, 8.0, samples=161, integrator=integrator)
    exact = w0 / 0.9 * np.sin(0.9 * solution.t)
    assert exact.max() > 10 * np.pi
    np.testing.assert_allclose(solution["x"], exact, atol=1e-4)
    np.testing.assert_allclose(solution["torque"][:, 3], -k * exact, atol=1e-4)


def test_torsion_spring_rests_at_its_free_angle():
    model = block(fmb.Revolute, forces=[fmb.TorsionSpring("s", joint="j", stiffness=4.0, damping=1.0, free_angle=0.7)])
    assert fmb.statics(model)["x"][-1] == pytest.approx(0.7, abs=1e-8)


def test_actuator_and_its_limits():
    """Force 10 t cut at 4 N: x' = (5 t0^2 + 4 (t - t0)) / m."""
    model = block(
        forces=[fmb.Actuator("a", joint="j", effort=fmb.ramp(rate=10.0), limits=(-1.0, 4.0))],
        sensors=[fmb.Velocity("v", marker="block.center"), fmb.Energy("work", kind="work_of_loads")],
    )
    solution = fmb.simulate(model, 1.0, samples=[0.0, 0.4, 1.0], integrator=FINE)
    np.testing.assert_allclose(solution["v"][1:, 0], [0.4, 1.6], rtol=1e-6)
    np.testing.assert_allclose(solution["energy"], solution["work"], atol=1e-5)


@pytest.mark.parametrize("joint", [fmb.Prismatic, fmb.Revolute])
def test_actuator_with_a_characteristic(joint):
    """F = -300 x^3 (a cubic table is exact): m v0^2 / 2 = 75 a^4 gives the amplitude a, and the period of x'' = -c x^3
    is 7.4163 / (a sqrt(c)) (a complete elliptic integral; Nayfeh & Mook, Nonlinear Oscillations, 1979, ch. 2)."""
    x = np.linspace(-3.0, 3.0, 7)
    bent = fmb.Actuator("a", joint="j", effort=fmb.table(x, -300.0 * x**3, of="j") * fmb.step(value=1.0, at=-1.0))
    speed, inertia = ("velocity", 2.0) if joint is fmb.Prismatic else ("angular_velocity", 0.5)
    model = block(joint, forces=[bent], sensors=[fmb.Energy("work", kind="work_of_loads")], **{speed: (1.0, 0, 0)})
    amplitude = (inertia / 150.0) ** 0.25
    period = 7.416298709205487 / (amplitude * np.sqrt(300.0 / inertia))
    solution = fmb.simulate(model, period, samples=101, integrator=fmb.GeneralizedAlpha(rtol=1e-8))
    assert np.abs(solution["x"]).max() == pytest.approx(amplitude, rel=2e-4)
    assert solution["x"][-1] == pytest.approx(0.0, abs=2e-3 * amplitude)
    np.testing.assert_allclose(solution["energy"] - solution["energy"][0], solution["work"], atol=1e-4)


def test_motor_follows_and_stalls():
    """A mass m on k (s - x) + c (s' - x') follows s = v t without error of speed; at its limit it gains limit/m t."""
    motor = {"joint": "j", "target": fmb.ramp(rate=0.5), "stiffness": 400.0, "damping": 60.0}
    sensors = [fmb.Velocity("v", marker="block.center"), fmb.Energy("work", kind="work_of_loads")]
    free = fmb.simulate(block(forces=[fmb.Motor("m", **motor)], sensors=sensors), 3.0, integrator=FINE)
    assert free["v"][-1, 0] == pytest.approx(0.5, abs=1e-5)
    np.testing.assert_allclose(free["energy"], free["work"], atol=1e-5)
    mass = free.model.body("block").mass
    weak = block(forces=[fmb.Motor("m", limits=(-0.02, 0.02), **motor)], sensors=sensors)
    held = fmb.simulate(weak, 0.5, integrator=FINE)
    np.testing.assert_allclose(held["v"][:, 0], 0.02 / mass * held.t, atol=1e-6)


def test_bushing_deflections():
    """Force and moment on the second marker over the six stiffnesses, in the axes of the first."""
    K = (1e3, 2e3, 3e3, 10.0, 20.0, 30.0)
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("b", mass=1.0, inertia=(1, 1, 1))],
        forces=[
            fmb.Bushing("bush", markers=("ground.origin", "b.center"), stiffness=K),
            fmb.PointLoad("load", marker="b.center", force=(3.0, 4.0, -6.0), moment=(0.0, 5.0, 0.0)),
        ],
        sensors=[
            fmb.Position("r", marker="b.center"),
            fmb.Orientation("o", marker="b.center"),
            fmb.ForceOf("f", force="bush"),
        ],
    )
    solution = fmb.statics(model)
    np.testing.assert_allclose(solution["r"][-1], [3e-3, 2e-3, -2e-3], rtol=SOLVER)
    assert 2 * np.arctan2(solution["o"][-1, 2], solution["o"][-1, 0]) == pytest.approx(0.25, rel=SOLVER)
    np.testing.assert_allclose(solution["f"][-1], [-3, -4, 6, 0, -5, 0], atol=1e-6)


def test_bushing_conserves_energy_in_large_rotations():
    K = np.diag((300.0, 200.0, 100.0, 8.0, 5.0, 3.0))
    K[0, 4] = K[4, 0] = 4.0
    model = fmb.Model(
        bodies=[
            fmb.Ground(),
            fmb.RigidBody(
                "b",
                mass=1.0,
                inertia=(0.2, 0.3, 0.4),
                velocity=(0.5, 0.2, 0.1),
                angular_velocity=(3.0, 2.0, 4.0),
            ),
        ],
        forces=[fmb.Bushing("bush", markers=("ground.origin", "b.center"), stiffness=K)],
        sensors=[fmb.Energy("energy")],
    )
    solution = fmb.simulate(model, 2.0, samples=41, integrator=fmb.GeneralizedAlpha(rho_inf=1.0, step=1e-3))
    assert np.ptp(solution["energy"]) < 2e-5 * solution["energy"][0]


@pytest.mark.parametrize("place", ["joint", "markers", "line"])
def test_bistop(place):
    """Free for 0.1 m, then the linear stop of k = 200 N/m is left after pi sqrt(m/k) with the same speed."""
    where = {
        "joint": {"joint": "j"},
        "markers": {"markers": ("ground.origin", "block.center"), "along": "x"},
        "line": {"markers": ("ground.far", "block.center")},
    }[place]
    model = block(velocity=(1.0, 0, 0), forces=[])
    bodies = [b.replaced(markers={**b.markers, "far": (-5.0, 0, 0)}) if b.name == "ground" else b for b in model.bodies]
    stop = fmb.BiStop("stop", travel=(-0.05, 0.1), stiffness=200.0, **where)
    model = fmb.Model(
        bodies=bodies,
        joints=model.joints,
        forces=[stop],
        sensors=[*model.sensors, fmb.ForceOf("f", force="stop")],
    )
    solution = fmb.simulate(model, 1.0, samples=1001, integrator=FINE)
    half = np.pi * np.sqrt(2.0 / 200.0)
    t, x = solution.t, solution["x"]
    assert x.max() == pytest.approx(0.1 + np.sqrt(2.0 / 200.0), rel=1e-4)
    free = (t < 0.1) | ((t > 0.1 + half) & (t < 0.1 + half + 0.15))
    np.testing.assert_allclose(solution["f"][free], 0.0)
    assert solution["f"][:, 0].min() == pytest.approx(-200.0 * np.sqrt(2.0 / 200.0), rel=1e-3)
    assert np.interp(0.1 + half + 0.1, t, x) == pytest.approx(0.0, abs=1e-4)
    assert np.ptp(solution["energy"]) < 1e-4


def test_stops_dissipate_and_never_pull():
    model = block(
        velocity=(1.0, 0, 0),
        sensors=[fmb.ForceOf("f", force="stop")],
        forces=[
            fmb.BiStop("stop", joint="j", travel=(-0.1, 0.1), stiffness=1e4, exponent=1.5, damping=60.0, depth=1e-3)
        ],
    )
    solution = fmb.simulate(model, 2.0, samples=4001, integrator=fmb.GeneralizedAlpha(rho_inf=0.9, step=1e-4))
    force, x = solution["f"][:, 0], solution["x"]
    assert force[x > 0.1].max(initial=0.0) <= 0.0
    assert force[x < -0.1].min(initial=0.0) >= 0.0
    assert np.all(np.diff(solution["lost"]) >= -1e-12)
    assert solution["energy"][-1] < 0.8 * solution["energy"][0]
    np.testing.assert_allclose(solution["energy"] + solution["lost"], solution["energy"][0], atol=2e-3)


@pytest.mark.parametrize("pulls", [False, True])
def test_one_sided_spring_with_backlash(pulls):
    """Static load F = c d^1.5: the overlap is (F/c)^(2/3), beyond a backlash of 1 mm."""
    sense = 1.0 if pulls else -1.0
    model = block(
        at=(0.3, 0, 0),
        forces=[
            fmb.OneSidedSpring(
                "roller",
                markers=("ground.origin", "block.center"),
                stiffness=1e6,
                backlash=1e-3,
                pulls=pulls,
                damping=1e3,
                length=0.3,
            ),
            fmb.Actuator("load", joint="j", effort=sense * 50.0),
        ],
    )
    x = fmb.statics(model)["x"][-1]
    assert sense * (x - 0.3) == pytest.approx(1e-3 + (50.0 / 1e6) ** (2 / 3), rel=1e-6)
    free = fmb.accelerations(model.changed("block", at=(0.3 + sense * 0.9e-3, 0, 0)))["block"][0]
    assert free == pytest.approx(sense * 25.0, rel=1e-9)  # nothing inside the backlash


def test_friction_of_a_loaded_slide():
    """On a slope: a = g (sin - mu cos); the normal force is the reaction of the joint."""
    slope, mu, g = 0.6, 0.25, 9.81
    gravity = (g * np.sin(slope), 0, -g * np.cos(slope))
    model = block(gravity=gravity, velocity=(1.0, 0, 0), forces=[fmb.JointFriction("mu", joint="j", moving=mu)])
    a = g * (np.sin(slope) - mu * np.cos(slope))
    for formulation in (fmb.Augmented(), fmb.NullSpace(), fmb.UdwadiaPhohomsiri()):
        assert fmb.accelerations(model, formulation=formulation)["block"][0] == pytest.approx(a, rel=1e-9)
    for integrator in (FINE, fmb.IDA(rtol=1e-8, atol=1e-10)):
        solution = fmb.simulate(model, 1.0, samples=11, integrator=integrator)
        np.testing.assert_allclose(solution["x"], solution.t + 0.5 * a * solution.t**2, atol=1e-5)


def test_friction_of_a_bearing():
    """A rotor of weight m g on a shaft of radius r slows down with mu m g r / J."""
    model = block(
        fmb.Revolute,
        gravity=(0, 0, -9.81),
        angular_velocity=(20.0, 0, 0),
        forces=[fmb.JointFriction("mu", joint="j", moving=0.1, radius=0.03, transition=1e-3)],
    )
    alpha = 0.1 * 2.0 * 9.81 * 0.03 / 0.5
    solution = fmb.simulate(model, 5.0, samples=11, integrator=FINE)
    np.testing.assert_allclose(
        solution["x"] - solution["x"][0], 20 * solution.t - 0.5 * alpha * solution.t**2, atol=1e-4
    )


def test_stribeck_coefficient():
    """mu(v) = mu_k + (mu_s - mu_k) exp(-(v/v_s)^2) times the preload."""
    friction = fmb.JointFriction("mu", joint="j", moving=0.1, standing=0.3, stribeck=0.2, transition=1e-4, preload=50.0)
    for v in (0.01, 0.2, 1.0):
        a = fmb.accelerations(block(velocity=(v, 0, 0), forces=[friction]))["block"][0]
        assert a == pytest.approx(-50.0 * (0.1 + 0.2 * np.exp(-((v / 0.2) ** 2))) / 2.0, rel=1e-9)


def test_load_over_an_angle():
    """A pendulum held by a table of moments over its own angle, M = 1.5 (1 - 2 theta)."""
    angles = np.linspace(-1.5, 1.5, 61)
    moment = fmb.table(angles, -2.0 * angles + 1.0, of="hinge")
    axis = fmb.Pose.axes(x=(0, 0, -1), z=(1, 0, 0))
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(markers={"O": axis}),
            fmb.RigidBody("arm", mass=0.5, inertia=(0.1, 0.1, 0.1), center_of_mass=(0, 0, -0.4), markers={"O": axis}),
        ],
        joints=[fmb.Revolute("hinge", markers=("ground.O", "arm.O"))],
        forces=[
            fmb.PointLoad("air", marker="arm.O", moment=(moment * fmb.step(value=1.5), 0, 0)),
            fmb.TorsionSpring("damper", joint="hinge", stiffness=0.0, damping=0.5),
        ],
        sensors=[fmb.JointCoordinate("angle", joint="hinge")],
    )
    x = fmb.statics(model, t=1.0)["angle"][-1]
    assert 1.5 * (1.0 - 2.0 * x) == pytest.approx(0.5 * 9.81 * 0.4 * np.sin(x), abs=1e-8)
    settled = fmb.simulate(model.placed("p", at=(1, 2, 3)), 15.0, samples=301)["p_angle"][-1]
    assert settled == pytest.approx(x, abs=1e-5)
    linear = fmb.linearize(model, about=fmb.statics(model, t=1.0))
    J = 0.1 + 0.5 * 0.4**2
    stiffness = 0.5 * 9.81 * 0.4 * np.cos(x) + 3.0
    w2, damping = stiffness / J, 0.5 / J
    assert 2 * np.pi * linear.frequencies[0] == pytest.approx(np.sqrt(w2 - damping**2 / 4), rel=1e-6)


@pytest.mark.parametrize("against", ["sphere", "cylinder"])
def test_contact_of_two_bodies(against):
    """Equal spheres (or a cylinder) hit head on: they exchange their velocities; momentum stays."""
    other = {"against": against, "other_radius": 0.1}
    model = fmb.Model(
        bodies=[
            fmb.Ground(),
            fmb.RigidBody("a", mass=1.0, inertia=(1, 1, 1), velocity=(0, 0, 0)),
            fmb.RigidBody("b", mass=1.0, inertia=(1, 1, 1), at=(0.25, 0, 0), velocity=(-1.0, 0, 0)),
        ],
        forces=[fmb.Contact("hit", markers=("a.center", "b.center"), radius=0.1, stiffness=1e7, **other)],
        sensors=[fmb.Velocity("va", marker="a.center"), fmb.Velocity("vb", marker="b.center")],
    )
    solution = fmb.simulate(model, 0.1, samples=3, integrator=fmb.GeneralizedAlpha(rho_inf=0.95, step=1e-5))
    np.testing.assert_allclose(solution["va"][-1], [-1, 0, 0], atol=1e-4)
    np.testing.assert_allclose(solution["vb"][-1], [0, 0, 0], atol=1e-4)


def test_hunt_crossley_restitution():
    """e = 1 - 2/3 D v for small losses (Hunt & Crossley 1975)."""
    D, v = 0.05, 1.0
    model = fmb.Model(
        bodies=[
            fmb.Ground(),
            fmb.RigidBody("b", mass=1.0, inertia=(1, 1, 1), at=(0, 0, 0.1), velocity=(0, 0, -v)),
        ],
        forces=[fmb.Contact("hit", markers=("ground.origin", "b.center"), radius=0.1, stiffness=1e8, damping=D)],
        sensors=[fmb.Velocity("v", marker="b.center")],
    )
    solution = fmb.simulate(model, 0.01, samples=3, integrator=fmb.GeneralizedAlpha(rho_inf=0.95, step=1e-6))
    assert solution["v"][-1, 2] == pytest.approx(v * (1 - 2 / 3 * D * v), rel=2e-3)
