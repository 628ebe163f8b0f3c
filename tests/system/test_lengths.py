"""Tolerances from what bodies do to each other: coordinates far away, markers that coincide, models in other units."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import ModelError, ValidityWarning
from flexmb.system import assemble

MU, RADIUS = 3.986004418e14, 7.0e6  # m3/s2, m: the Earth, a low orbit
SPEED = np.sqrt(MU / RADIUS)


def gravity_of(mass):
    return lambda t, d, v, R, w: (-MU * mass * d / np.dot(d, d) ** 1.5, np.zeros(3))


APART, DRIFT, STIFFNESS, LENGTH = np.array([0.3, 1.75, 0.4]), np.array([0.0, 1.0, 2.0]), 5e3, 1.8


def spacecraft() -> fmb.Model:
    """Two bodies of 100 and 60 kg on a spring of 1.8 m in a low orbit, the ground at the centre of the Earth."""
    at = np.array([RADIUS, 0.0, 0.0])
    return fmb.Model(
        name="spacecraft",
        bodies=[
            fmb.Ground(),
            fmb.PointMass("a", mass=100.0, at=tuple(at), velocity=(0, SPEED, 0)),
            fmb.PointMass("b", mass=60.0, at=tuple(at + APART), velocity=tuple(DRIFT + [0, SPEED, 0])),
        ],
        forces=[
            fmb.UserForce("Earth a", markers=("ground.origin", "a.center"), function=gravity_of(100.0)),
            fmb.UserForce("Earth b", markers=("ground.origin", "b.center"), function=gravity_of(60.0)),
            fmb.SpringDamper("tether", markers=("a.center", "b.center"), stiffness=STIFFNESS, length=LENGTH),
        ],
        sensors=[fmb.Position("a at", marker="a.center"), fmb.Position("b at", marker="b.center")],
    )


def relative_motion(times) -> np.ndarray:
    """b from a by scipy: the difference of the two pulls is formed without cancellation (Battin 1987, sec. 8.4)."""

    def rates(t, y):
        a, r = y[:3], y[3:6]
        q = r @ (r + 2.0 * a) / (a @ a)
        f = np.expm1(-1.5 * np.log1p(q))
        pull = -MU / (a @ a) ** 1.5
        length = np.linalg.norm(r)
        tension = STIFFNESS * (length - LENGTH) * r / length
        apart = pull * (r * (1.0 + f) + a * f) - tension / 60.0 - tension / 100.0
        return np.concatenate([y[6:], pull * a + tension / 100.0, apart])

    start = np.concatenate([[RADIUS, 0, 0], APART, [0, SPEED, 0], DRIFT])
    solution = solve_ivp(rates, (0, times[-1]), start, t_eval=times, method="DOP853", rtol=1e-13, atol=1e-12)
    return solution.y[3:6].T


@pytest.mark.parametrize(("integrator", "within"), [(fmb.GeneralizedAlpha(), 2e-3), (fmb.IDA(), 1e-4)])
def test_a_spacecraft_in_earth_coordinates(integrator, within):
    """1.8 m apart at 7000 km from the origin: the distance swings by 0.2 m and the error is a small part of that."""
    model = spacecraft()
    system, _ = assemble(model)
    assert system.lengths.whole == pytest.approx(np.linalg.norm(APART))
    solution = fmb.simulate(model, t_end=0.4, samples=5, integrator=integrator)
    error = solution["b at"] - solution["a at"] - relative_motion(solution.t)
    assert np.abs(error).max() < within


@pytest.mark.parametrize(
    ("integrator", "within"), [(fmb.GeneralizedAlpha(), 3e-3), (fmb.IDA(), 1e-5), (fmb.Implicit(), 1e-3)]
)
def test_a_swinging_spacecraft_stays_within_tolerance(integrator, within):
    """Four swings: steps follow the distance of the bodies, not that of the Earth. Reached: 6e-4, 1e-6 and 1e-4 m."""
    solution = fmb.simulate(spacecraft(), t_end=2.0, samples=5, integrator=integrator)
    error = solution["b at"] - solution["a at"] - relative_motion(solution.t)
    assert np.abs(error).max() < within


def test_a_tolerance_that_coordinates_do_not_have_is_told():
    """A hundredth of a micrometre at 7000 km: the double numbers there are 1e-9 m apart, and sums lose two digits."""
    with pytest.warns(
        ValidityWarning, match=r"Body 'a' is 7e\+06 m from the origin.*not below the 2e-08 m of rtol = 1e-08"
    ):
        fmb.simulate(spacecraft(), t_end=0.01, samples=2, integrator=fmb.GeneralizedAlpha(rtol=1e-8))


@pytest.fixture(scope="module")
def blade():
    steel = fmb.Material(young=210e9, poisson=0.3, density=7850.0)
    fe = fem.frame(np.linspace((0, 0, 0), (1, 0, 0), 6), section=fem.Section.rectangle(0.02, 0.02), material=steel)
    return reduction.reduce(fe, {"root": [0]}, modes=4, frame="root")


@pytest.mark.parametrize("gap", [0.0, 1e-20, 1e-10, 1e-6])
def test_markers_that_nearly_coincide(blade, gap):
    """An elastic blade on a driven hub: m W^2 L / 2 at its root, however little it is beside the hub's centre."""
    model = fmb.Model(
        name="hub",
        bodies=[
            fmb.Ground(),
            fmb.RigidBody("hub", mass=1.0, inertia=(0.01, 0.01, 0.01)),
            fmb.FloatingBody("blade", data=blade, at=(0, 0, gap)),
        ],
        joints=[
            fmb.Revolute("axis", markers=("ground.origin", "hub.center")),
            fmb.Drive("motor", joint="axis", angle=fmb.expression("20 * t")),
            fmb.Fixed("root", markers=("hub.center", "blade.root")),
        ],
        sensors=[fmb.Reaction("pull", joint="root")],
    )
    steady = fmb.statics(model)
    assert steady["pull"][-1, 0] == pytest.approx(-0.5 * blade.mass * 20.0**2, rel=1e-6)
    coincident = fmb.linearize(model.changed("blade", at=(0, 0, 0)), fmb.statics(model.changed("blade", at=(0, 0, 0))))
    found = fmb.linearize(model, steady).frequencies
    np.testing.assert_allclose(found[:4], coincident.frequencies[:4], rtol=1e-5)


def pendulum(length=1.0, mass=1.0, time=1.0, offset=(0.0, 0.0, 0.0)) -> fmb.Model:
    """A double pendulum, a rod on a point mass on a rod, in units of so many m, kg and s."""
    o = np.asarray(offset, float)
    at = [tuple(o + np.array(x) / length) for x in ((0.3, 0, -0.4), (0.3, 0, -0.9))]
    half = 0.25 / length
    return fmb.Model(
        name="pendulum",
        gravity=(0, 0, -9.81 / length * time**2),
        bodies=[
            fmb.Ground(markers={"pivot": tuple(o)}),
            fmb.PointMass("bob", mass=2.0 / mass, at=at[0]),
            fmb.RigidBody(
                "rod",
                mass=1.5 / mass,
                inertia=np.array((0.03, 0.03, 0.001)) / (mass * length**2),
                at=(at[1][0], at[1][1], at[1][2] + half),
                markers={"top": (0, 0, half)},
            ),
        ],
        joints=[
            fmb.Rod("string", markers=("ground.pivot", "bob.center")),
            fmb.Spherical("ball", markers=("bob.center", "rod.top")),
        ],
        sensors=[fmb.Position("bob", marker="bob.center"), fmb.Reaction("tension", joint="string")],
    )


UNITS = {
    "mm": {"length": 1e-3},
    "km, t, h": {"length": 1e3, "mass": 1e3, "time": 3600.0},
    "um, ng, us": {"length": 1e-6, "mass": 1e-12, "time": 1e-6},
    "g, ms": {"mass": 1e-3, "time": 1e-3},
}


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(), fmb.Implicit(), fmb.IDA(), fmb.Explicit()], ids=repr)
@pytest.mark.parametrize("units", UNITS)
def test_motion_in_other_units(units, integrator):
    """Positions over 1 s and reactions are those in SI, within what tolerances mean: 1e-4 of the lengths."""
    scale = {"length": 1.0, "mass": 1.0, "time": 1.0, **UNITS[units]}
    si = fmb.simulate(pendulum(), t_end=1.0, samples=5, integrator=integrator)
    other = fmb.simulate(pendulum(**scale), t_end=1.0 / scale["time"], samples=5, integrator=integrator)
    np.testing.assert_allclose(scale["length"] * other["bob"], si["bob"], rtol=0.0, atol=2e-4)
    force = scale["mass"] * scale["length"] / scale["time"] ** 2
    np.testing.assert_allclose(force * other["tension"][:, :3], si["tension"][:, :3], rtol=0.0, atol=2e-2)


def test_generalised_alpha_takes_the_same_steps_in_all_units():
    counts = set()
    for units in UNITS.values():
        scale = {"time": 1.0, **units}
        solution = fmb.simulate(pendulum(**units), t_end=1.0 / scale["time"], samples=3)
        counts.add(solution.statistics["steps"])
    assert max(counts) - min(counts) <= 2


def test_far_from_the_origin():
    """1000 km away the pendulum moves as at the origin, to the digits that are left."""
    near = fmb.simulate(pendulum(), t_end=1.0, samples=5)
    offset = np.array([1e6, -1e6, 1e6])
    far = fmb.simulate(pendulum(offset=offset), t_end=1.0, samples=5)
    np.testing.assert_allclose(far["bob"] - offset, near["bob"], rtol=0.0, atol=1e-5)


def test_lost_digits_are_said():
    with pytest.warns(ValidityWarning, match=r"is 1e\+11 m from the origin.*rounded to 2e-05 m.*Put the origin"):
        assemble(pendulum(offset=(1e11, 0, 0)))


@pytest.mark.parametrize("offset", [(1e80, 0, 0), (0, -1.7e308, 0)])
def test_places_beyond_all_numbers_are_refused(offset):
    """Squares of these coordinates are infinite, distances no numbers."""
    with pytest.raises(ModelError, match=r"Body 'ground': a point with the coordinate .* within 1e\+60 m"):
        assemble(pendulum(offset=offset))


@pytest.mark.parametrize("length", [1e-6, 1e-3, 1.0, 1e3])
def test_equilibrium_and_frequency_of_any_size(length):
    """A silicon sphere on an arm: tension m g, sqrt(m g l / (J + m l^2)) / 2 pi, from a micrometre to a kilometre."""
    radius, across = 0.3 * length, {"x": (1, 0, 0), "z": (0, 1, 0)}
    ball = fmb.RigidBody.sphere("ball", radius=radius, density=2330.0, at=(0, 0, -length))
    ball = ball.replaced(markers={"top": fmb.Pose.axes((0, 0, length), **across)})
    model = fmb.Model(
        name="pendulum",
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(markers={"pivot": fmb.Pose.axes((0, 0, 0), **across)}), ball],
        joints=[fmb.Revolute("hinge", markers=("ground.pivot", "ball.top"))],
        sensors=[fmb.Reaction("hinge", joint="hinge")],
    )
    assert fmb.check(model).mobility == 1
    still = fmb.statics(model)
    assert still["hinge"][-1, 2] == pytest.approx(9.81 * ball.mass, rel=1e-9)
    rate = np.sqrt(ball.mass * 9.81 * length / (0.4 * ball.mass * radius**2 + ball.mass * length**2))
    np.testing.assert_allclose(2 * np.pi * fmb.linearize(model, still).frequencies, [rate], rtol=1e-9)


@pytest.mark.parametrize("n", [1, 50])
def test_drift_is_compared_with_the_bodies_at_a_joint(n):
    """Rods of 1 m in a row, a bob without extent on the last: each equation goes by its own rods, however many."""
    rods = [fmb.RigidBody.rod(f"r{k}", length=1.0, mass=1.0, at=(float(k), 0, 0)) for k in range(n)]
    last = fmb.PointMass("bob", mass=1.0, at=(float(n), 0, 0))
    joints = [fmb.Spherical("s0", markers=("ground.origin", "r0.start"))]
    joints += [fmb.Spherical(f"s{k}", markers=(f"r{k - 1}.end", f"r{k}.start")) for k in range(1, n)]
    joints.append(fmb.Spherical("s", markers=(f"r{n - 1}.end", "bob.center")))
    system, _ = assemble(fmb.Model(bodies=[fmb.Ground(), *rods, last], joints=joints))
    assert system.lengths.whole == pytest.approx(n)
    np.testing.assert_allclose(system.lengths.equations, n)
    np.testing.assert_allclose(system.lengths.related, 1.0)
    np.testing.assert_allclose(system.drift_bounds(1e-10), 1e-10)
    np.testing.assert_allclose(system.bounds(1e-10), n * 1e-10)


def test_drift_is_not_held_closer_than_rounding():
    """Rods of 1 cm at the end of one of 4 km: where positions have 1e-10 m, 1e-12 m is not asked for."""
    long = fmb.RigidBody.rod("long", length=4e3, mass=1.0)
    short = [fmb.RigidBody.rod(f"r{k}", length=0.01, mass=1.0, at=(4e3 + 0.01 * k, 0, 0)) for k in range(2)]
    joints = [
        fmb.Spherical("a", markers=("long.end", "r0.start")),
        fmb.Spherical("b", markers=("r0.end", "r1.start")),
    ]
    system, _ = assemble(fmb.Model(bodies=[fmb.Ground(), long, *short], joints=joints))
    np.testing.assert_allclose(system.lengths.related, [4e3] * 3 + [0.01] * 3)
    np.testing.assert_allclose(system.drift_bounds(1e-10)[3:], 10.0 * system.lengths.rounding)
    assert np.all(system.drift_bounds(1e-10) <= system.bounds(1e-10))


def bar_away(far: float) -> fmb.Model:
    """Return a hinged bar of 1 m whose mesh is so far from its axes, at the same place."""
    points = np.column_stack([np.linspace(far, far + 1.0, 5), np.zeros(5), np.zeros(5)])
    fe = fem.frame(points=points, section=fem.Section.rectangle(0.02, 0.01), material=fmb.MATERIALS["steel"])
    data = reduction.reduce(fe, {"root": [0], "tip": [4]}, modes=0, stress=False)
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), fmb.FloatingBody("bar", data=data, at=(-far, 0, 0))],
        joints=[fmb.Revolute("pin", markers=("ground.origin", "bar.root"))],
    )


def test_a_body_far_from_its_own_axes():
    """Reactions of IDA were 45 % off at 1 km, without a word; at 30 km the body was said to have no inertia."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assemble(bar_away(50.0))
    said = r"'bar' is 1e\+03 m from its own axes, 1e\+03 times its size.*translated"
    with pytest.warns(ValidityWarning, match=said):
        motion = fmb.simulate(bar_away(1000.0), 1e-4, samples=3, integrator=fmb.Explicit())
    assert "do not settle, by SciPy" in motion.statistics["steps handed over"]
    said = r"'bar': .*3e\+05 m from its own axes"
    with pytest.warns(ValidityWarning), pytest.raises(fmb.CompileError, match=said):
        fmb.accelerations(bar_away(3e5))


def test_data_of_a_single_place_have_no_size():
    """Without nodes the box is that of the markers: of one marker beside the axes it was a division by zero."""
    fe = fem.frame(
        points=np.column_stack([np.linspace(0.0, 1.0, 5), np.zeros(5), np.zeros(5)]),
        section=fem.Section.rectangle(0.02, 0.01),
        material=fmb.MATERIALS["steel"],
    )
    data = reduction.reduce(fe, {"tip": [4]}, modes=2, stress=False)
    none = np.zeros((0, 3, data.n_modes))
    bare = replace(data, nodes=np.zeros((0, 3)), cells=(), shapes=none, rotation_shapes=none)
    model = fmb.Model(gravity=(0, 0, -9.81), bodies=[fmb.Ground(), fmb.FloatingBody("bar", data=bare)])
    np.testing.assert_allclose(fmb.accelerations(model)["bar"], [0, 0, -9.81, 0, 0, 0], atol=1e-9)
