"""Steps end where contacts begin and end, and follow friction through sticking, by default settings.

References: conservation of energy of an elastic ball; momentum and energy of two spheres that meet; free flight between
stops; the oscillator on a belt by SciPy's Radau.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fmb

ALL = [
    fmb.GeneralizedAlpha(),
    fmb.Implicit(),
    fmb.Explicit(),
    fmb.Explicit(formulation=fmb.Recursive()),
    fmb.Explicit(method="RK45"),
    fmb.IDA(),
]
ADAPTIVE = [*ALL[:3], ALL[-1]]
PASSING = [*ALL, fmb.MoreauJean(step=0.05)]


@pytest.mark.parametrize("integrator", ALL, ids=repr)
def test_an_elastic_ball_keeps_its_energy(integrator):
    """Dropped from 1 m, it bounces four times in 4 s, with 0.6 ms of contact each; samples are 0.8 s apart."""
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("ball", mass=1.0, inertia=(4e-3,) * 3, at=(0, 0, 1.1))],
        gravity=(0, 0, -9.81),
        forces=[fmb.Contact("floor", markers=("ground.origin", "ball.center"), radius=0.1, stiffness=1e9)],
        sensors=[fmb.Energy("energy"), fmb.Position("r", marker="ball.center")],
    )
    solution = fmb.simulate(model, 4.0, samples=6, integrator=integrator)
    above_floor = solution["energy"] - 9.81 * 0.1
    np.testing.assert_allclose(above_floor, 9.81, rtol=0.02)
    assert solution["r"][:, 2].min() > 0.09


@pytest.mark.parametrize("integrator", PASSING, ids=repr)
@pytest.mark.parametrize("against", ["sphere", "cylinder", "plane"])
def test_fast_bodies_do_not_pass_through_each_other(integrator, against):
    """A sphere of 1 kg at 10 m/s meets one at rest (or a wall), 3 m away: it hands over its speed, or comes back."""
    across = fmb.Pose.axes((0, 0, 0), z=(0, 1, 0))
    bodies = [
        fmb.RigidBody("a", mass=1.0, inertia=(1e-4,) * 3, at=(3, 0, 0), markers={"m": across}),
        fmb.RigidBody("b", mass=1.0, inertia=(1e-4,) * 3, velocity=(10, 0, 0)),
    ]
    joints = [fmb.Planar("table", markers=("ground.origin", "a.center"))]
    other, marker = (None if against == "plane" else 0.01), "a.m"
    if against == "plane":
        marker, joints, bodies = "ground.wall", [], bodies[1:]
    wall = fmb.Pose.axes((3, 0, 0), z=(-1, 0, 0))
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"wall": wall}), *bodies],
        gravity=(0, 0, 0),
        joints=joints,
        forces=[
            fmb.Contact(
                "hit", markers=(marker, "b.center"), radius=0.01, against=against, other_radius=other, stiffness=1e7
            )
        ],
        sensors=[fmb.Velocity("v", marker="b.center")],
    )
    solution = fmb.simulate(model, 1.0, samples=2, integrator=integrator)
    expected = -10.0 if against == "plane" else 0.0
    assert solution["v"][-1, 0] == pytest.approx(expected, abs=0.1)


def slide(force, speed=10.0):
    """Return a mass of 1 kg on a slide along z with a force."""
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("mass", mass=1.0, inertia=(1, 1, 1), velocity=(0, 0, speed))],
        joints=[fmb.Prismatic("A", markers=("ground.origin", "mass.center"))],
        gravity=(0, 0, 0),
        forces=[force],
        sensors=[fmb.JointCoordinate("x", joint="A"), fmb.Velocity("v", marker="mass.center")],
    )


@pytest.mark.parametrize("integrator", [*ADAPTIVE, fmb.MoreauJean(step=0.05)], ids=repr)
def test_a_mass_between_stops(integrator):
    """At 10 m/s between stops 1 m away, stiff enough to throw it back within 1 ms: five times in 0.95 s."""
    solution = fmb.simulate(
        slide(fmb.BiStop("stops", joint="A", travel=(-1.0, 1.0), stiffness=1e7)), 0.95, samples=2, integrator=integrator
    )
    contact = np.pi / np.sqrt(1e7)  # half a period of the linear stop
    path = 10.0 * (0.95 - 5 * contact) - 1.0 - 4 * 2.0
    assert solution["x"][-1] == pytest.approx(1.0 - path, abs=0.02)
    assert abs(solution["v"][-1, 2]) == pytest.approx(10.0, abs=0.1)


@pytest.mark.parametrize("integrator", ADAPTIVE, ids=repr)
def test_a_one_sided_spring_throws_back(integrator):
    spring = fmb.OneSidedSpring("buffer", joint="A", length=1.0, pulls=True, stiffness=1e8, exponent=1.5)
    solution = fmb.simulate(slide(spring), 1.0, samples=2, integrator=integrator)
    assert solution["v"][-1, 2] == pytest.approx(-10.0, abs=0.1)


def test_a_fixed_step_goes_over_no_contact():
    """100 steps of 10 ms, each ten times as long as the contact: they are cut only where they would miss it."""
    stop = fmb.BiStop("stops", joint="A", travel=(-1.0, 1.005), stiffness=1e7)
    solution = fmb.simulate(slide(stop, 9.97), 0.15, samples=2, integrator=fmb.GeneralizedAlpha(step=0.01))
    assert solution["x"].max() < 1.5


MASS, K, NORMAL, STANDING, MOVING, STRIBECK, TRANSITION, BELT = 1.0, 100.0, 9.81, 0.5, 0.3, 1e-3, 1e-5, 0.1


def belt():
    along = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))
    bodies = [fmb.RigidBody(name, mass=MASS, inertia=(1, 1, 1), markers={"rail": along}) for name in ("belt", "block")]
    rub = {"moving": MOVING, "standing": STANDING, "stribeck": STRIBECK, "transition": TRANSITION, "preload": NORMAL}
    return fmb.Model(
        bodies=[fmb.Ground(markers={"rail": along}), *bodies],
        joints=[
            fmb.Prismatic("rollers", markers=("ground.rail", "belt.rail")),
            fmb.Drive("motor", joint="rollers", displacement=fmb.expression(f"{BELT}*t")),
            fmb.Prismatic("contact", markers=("belt.rail", "block.rail")),
        ],
        forces=[
            fmb.JointFriction("rub", joint="contact", from_reaction=False, **rub),
            fmb.Bushing("spring", markers=("ground.rail", "block.rail"), stiffness=(0, 0, K, 0, 0, 0)),
        ],
        gravity=(0, 0, 0),
        sensors=[fmb.Position("r", marker="block.center")],
    )


@pytest.fixture(scope="module")
def on_the_belt():
    """Times and places of the block, by SciPy's Radau."""

    def rates(t, y):
        v = y[1] - BELT
        mu = MOVING + (STANDING - MOVING) * np.exp(-((v / STRIBECK) ** 2))
        return y[1], (-K * y[0] - mu * NORMAL * np.tanh(v / TRANSITION)) / MASS

    t = np.linspace(0.0, 4.0, 201)
    return t, solve_ivp(rates, (0.0, 4.0), (0.0, 0.0), "Radau", t, rtol=1e-9, atol=1e-12, max_step=0.005).y[0]


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(), fmb.Implicit(), fmb.IDA()], ids=repr)
def test_a_block_sticks_to_its_belt(integrator, on_the_belt):
    """Four periods of 0.81 s: the spring draws the block off at the full force of standing friction."""
    t, exact = on_the_belt
    solution = fmb.simulate(belt(), 4.0, samples=t, integrator=integrator)
    np.testing.assert_allclose(solution["r"][:, 0], exact, atol=1e-3)  # of 0.05 m


def test_losses_at_an_undamped_stop_do_not_add_up():
    """Thirty bounces of 1 kg at 1 m/s between stops of 10 kN/m, 0.1 m apart, beside their closed form.

    At its plain tolerance `IDA` lost 1e-5 of the speed at each bounce: after thirty the place was off by 0.76 mm.
    """
    axis = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0), x=(0, 1, 0))
    cart = fmb.RigidBody("cart", mass=1.0, inertia=(0.1, 0.1, 0.1), markers={"c": axis}, velocity=(1.0, 0, 0))
    stop = fmb.BiStop("stop", joint="rail", travel=(-0.05, 0.05), stiffness=1e4, damping=0.0, depth=1e-3)
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"c": axis}), cart],
        joints=[fmb.Prismatic("rail", markers=("ground.c", "cart.c"))],
        forces=[stop],
        gravity=(0, 0, 0),
        sensors=[fmb.Position("x", marker="cart.center")],
    )
    run = fmb.simulate(model, 4.0, samples=401, integrator=fmb.IDA())
    once = 0.1 + np.pi / 100.0  # free way at 1 m/s, and half a period of the contact
    bounces, since = np.divmod(run.t + 0.05, once)
    x = np.where(since < 0.1, since - 0.05, 0.05 + 0.01 * np.sin(100.0 * np.maximum(since - 0.1, 0.0)))
    assert bounces[-1] == 30
    np.testing.assert_allclose(run["x"][:, 0], (-1.0) ** bounces * x, atol=0.005 * 0.06)
