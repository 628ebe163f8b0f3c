"""Linear plants between signals and sensors, against closed forms and scipy.signal."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
import scipy.io
import scipy.signal

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import DataFileError, ModelError, ValidityWarning

UP = fmb.Pose.axes((0, 0, 0), z=(0, 0, 1), x=(1, 0, 0))
K, DAMPING, MASS = 400.0, 3.0, 2.0
SPRUNG, UNSPRUNG, STRUT, SHOCK, TYRE, ROAD = 300.0, 40.0, 2e4, 1.5e3, 1.8e5, 1.0


def oscillator():
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"a": UP, "above": (0, 0, 1)}),
            fmb.RigidBody("ball", mass=MASS, inertia=(1, 1, 1), markers={"a": UP}),
        ],
        joints=[fmb.Prismatic("guide", markers=("ground.a", "ball.a"))],
        forces=[
            fmb.SpringDamper(
                "spring", markers=("ground.above", "ball.center"), stiffness=K, damping=DAMPING, length=1.0
            ),
            fmb.PointLoad("push", marker="ball.center", force=(0, 0, 0)),
        ],
        sensors=[
            fmb.Position("place", marker="ball.center"),
            fmb.Velocity("speed", marker="ball.center"),
            fmb.Acceleration("rate", marker="ball.center"),
            fmb.Reaction("guide load", joint="guide"),
            fmb.Distance("way", markers=("ground.a", "ball.a")),
            fmb.Energy("work", kind="work_of_loads"),
        ],
    )


def quarter_car():
    def body(name, mass, z):
        return fmb.RigidBody(name, mass=mass, inertia=(1, 1, 1), at=(0, 0, z), markers={"m": UP})

    def guide(name, ground, other):
        return fmb.Prismatic(name, markers=(f"ground.{ground}", f"{other}.m"))

    heights = {"r": 0.0, "u": 1.0, "s": 2.0}
    return fmb.Model(
        gravity=(0, 0, 0),
        bodies=[
            fmb.Ground(markers={n: fmb.Pose.axes((0, 0, z), z=(0, 0, 1), x=(1, 0, 0)) for n, z in heights.items()}),
            body("road", ROAD, 0),
            body("wheel", UNSPRUNG, 1),
            body("car", SPRUNG, 2),
        ],
        joints=[
            guide("jr", "r", "road"),
            guide("ju", "u", "wheel"),
            guide("js", "s", "car"),
            fmb.Drive("profile", joint="jr", displacement=0.0),
        ],
        forces=[
            fmb.SpringDamper("tyre", markers=("road.m", "wheel.m"), stiffness=TYRE, length=1.0),
            fmb.SpringDamper("strut", markers=("wheel.m", "car.m"), stiffness=STRUT, damping=SHOCK, length=1.0),
        ],
        sensors=[
            fmb.Position("body", marker="car.m"),
            fmb.Acceleration("ride", marker="car.m"),
            fmb.ForceOf("tyre load", force="tyre"),
            fmb.Reaction("shaker", joint="profile"),
            fmb.Velocity("road speed", marker="road.m"),
        ],
    )


def quarter_car_closed_form(s):
    """Body and wheel per road displacement: two masses on springs, Milliken & Milliken, Race Car Vehicle Dynamics."""
    strut = SHOCK * s + STRUT
    upper, lower = SPRUNG * s**2 + strut, UNSPRUNG * s**2 + strut + TYRE
    body = TYRE * strut / (upper * lower - strut**2)
    return body, body * upper / strut


def test_mass_spring_damper_is_that_of_scipy():
    plant = fmb.linearize(oscillator(), inputs="push.force.z", outputs=["place z", "speed vz", "rate az"])
    assert plant.proper
    assert plant.outputs == ("place z", "speed vz", "rate az")
    assert plant.units == ("m", "m/s", "m/s2")
    assert plant.accuracy.max() < 1e-9
    f = np.array([0.3, 2.25, 5.0])
    w = 2 * np.pi * f
    _, receptance = scipy.signal.freqs([1.0], [MASS, DAMPING, K], w)
    found = plant.frequency_response(f)[:, :, 0]
    np.testing.assert_allclose(found, receptance[:, None] * np.stack([w**0, 1j * w, -(w**2)], axis=1), rtol=1e-9)
    _, step = scipy.signal.step(plant.to_scipy(), T=np.linspace(0, 3, 50))
    _, closed = scipy.signal.step(([1.0], [MASS, DAMPING, K]), T=np.linspace(0, 3, 50))
    np.testing.assert_allclose(step[:, 0], closed, rtol=0, atol=1e-9 * closed.max())


def test_quarter_car_on_a_driven_road():
    """A drive is an input too: the motion follows it with displacement, rate and second rate."""
    f = np.array([0.5, 1.2, 5.0, 10.8, 40.0])
    s = 2j * np.pi * f
    body, wheel = quarter_car_closed_form(s)
    plant = fmb.linearize(quarter_car(), inputs="profile", outputs=["body z", "ride az", "tyre load fz"])
    assert plant.inputs == ("profile.displacement",)
    assert plant.proper
    found = plant.frequency_response(f)[:, :, 0]
    np.testing.assert_allclose(found, np.stack([body, s**2 * body, TYRE * (1 - wheel)], axis=1), rtol=1e-9)


def test_gravity_makes_no_rates():
    """Accelerations that are differences of large forces follow no rate of the road but for rounding."""
    car = replace(quarter_car(), gravity=(0.3, 0.2, -9.81))
    plant = fmb.linearize(car, fmb.statics(car), inputs="profile", outputs=["body z", "ride", "tyre load"])
    assert plant.proper
    f = np.array([0.5, 1.2, 5.0, 10.8, 40.0])
    body, _ = quarter_car_closed_form(2j * np.pi * f)
    np.testing.assert_allclose(plant.frequency_response(f)[:, 0, 0], body, rtol=1e-9)


def test_a_driven_crank_leaves_no_states():
    """Slider crank in line, r at 30 degrees: dx/dtheta = -r sin t (1 + r cos t / sqrt(l^2 - r^2 sin^2 t))."""
    r, length, t = 0.1, 0.3, np.radians(30.0)
    pin, foot = r * np.array([np.cos(t), 0, np.sin(t)]), np.sqrt(length**2 - (r * np.sin(t)) ** 2)
    slider = np.array([pin[0] + foot, 0, 0])
    along = fmb.Pose.axes(tuple(slider), z=(1, 0, 0), x=(0, 0, 1))
    block = {"s": fmb.Pose.axes((0, 0, 0), z=(1, 0, 0), x=(0, 0, 1)), "q": hinge(np.zeros(3))}
    crank_end = fmb.Pose.axes((0, 0, 0), z=(0, -1, 0), x=(1, 0, 0))
    crank = {"o": crank_end, "p": hinge(pin)}
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(markers={"o": crank_end, "s": along}),
            fmb.RigidBody("crank", mass=0.4, inertia=(1e-3, 1e-3, 1e-3), markers=crank),
            hinged_bar("rod", pin, slider, 0.7),
            fmb.RigidBody("block", mass=2.0, inertia=(1e-3, 1e-3, 1e-3), at=tuple(slider), markers=block),
        ],
        joints=[
            fmb.Revolute("main", markers=("ground.o", "crank.o")),
            fmb.Revolute("big end", markers=("crank.p", "rod.p")),
            fmb.Revolute("small end", markers=("rod.q", "block.q")),
            fmb.Prismatic("guide", markers=("ground.s", "block.s")),
            fmb.Drive("motor", joint="main", angle=0.0),
        ],
        sensors=[fmb.Position("place", marker="block.q"), fmb.Velocity("speed", marker="block.q")],
    )
    plant = fmb.linearize(model, inputs="motor", outputs=["place x", "speed vx"])
    slope = -r * np.sin(t) * (1 + r * np.cos(t) / foot)
    assert plant.A.shape == (0, 0)
    np.testing.assert_allclose(plant.frequency_response(2.0)[0, :, 0], [slope, 4j * np.pi * slope], rtol=1e-8)
    assert plant.D1[0, 0] == 0.0


def test_outputs_that_follow_the_rates_of_a_drive():
    """The shaker accelerates its own mass; the speed of the road is the rate of its displacement."""
    f = np.array([0.5, 5.0, 40.0])
    s = 2j * np.pi * f
    _, wheel = quarter_car_closed_form(s)
    plant = fmb.linearize(quarter_car(), inputs="profile", outputs=["shaker fz", "road speed vz"])
    found = plant.frequency_response(f)[:, :, 0]
    np.testing.assert_allclose(found[:, 0], TYRE * (1 - wheel) + ROAD * s**2, rtol=1e-9)
    np.testing.assert_allclose(found[:, 1], s, rtol=1e-9)
    assert not plant.proper
    with pytest.raises(ModelError, match=r"'shaker fz' follows the rates of the input 'profile.displacement'"):
        plant.to_scipy()
    with pytest.raises(ModelError, match="follows the rates"):
        plant.with_proper_outputs()
    every = fmb.linearize(quarter_car(), inputs="profile", outputs=["shaker fz", "body z", "road speed vz"])
    kept = every.with_proper_outputs()
    assert (kept.outputs, kept.units) == (("body z",), ("m",))
    np.testing.assert_array_equal(kept.frequency_response(f), every.frequency_response(f)[:, 1:2])


@pytest.mark.parametrize("angle", [0.0, np.pi])
def test_pendulum_hanging_and_upright(angle):
    """l theta'' = -g sin theta + M / (m l): poles at +- i sqrt(g / l) and +- sqrt(g / l)."""
    g, length, mass = 9.81, 0.7, 1.3
    hinge = fmb.Pose.axes((0, 0, 0), z=(0, -1, 0), x=(1, 0, 0))
    model = fmb.Model(
        gravity=(0, 0, -g),
        bodies=[
            fmb.Ground(markers={"h": hinge}),
            fmb.RigidBody(
                "bob",
                mass=mass,
                inertia=(1e-9, 1e-9, 1e-9),
                center_of_mass=(0, 0, -length),
                rotation=(0, -angle, 0),
                markers={"h": hinge},
            ),
        ],
        joints=[fmb.Revolute("hinge", markers=("ground.h", "bob.h"))],
        forces=[fmb.PointLoad("motor", marker="bob.h", moment=(0, 0, 0))],
        sensors=[fmb.JointCoordinate("angle", joint="hinge"), fmb.Reaction("pin", joint="hinge")],
    )
    plant = fmb.linearize(model, inputs="motor.moment.y", outputs=["angle", "pin fx"])
    rate = np.sqrt(g / length)
    expected = [-1j * rate, 1j * rate] if angle == 0.0 else [-rate, rate]
    np.testing.assert_allclose(sorted(plant.poles, key=lambda s: (s.real, s.imag)), expected, atol=1e-6)
    inertia, stiffness = mass * length**2, mass * g * length * np.cos(angle)
    w = 2 * np.pi * np.array([0.1, 0.5, 3.0])
    turn = -1.0 / (stiffness - inertia * w**2)
    found = plant.frequency_response(w / (2 * np.pi))[:, :, 0]
    np.testing.assert_allclose(found[:, 0], turn, rtol=1e-6)
    np.testing.assert_allclose(abs(found[:, 1]), mass * length * w**2 * abs(turn), rtol=1e-6)


def hinged_bar(name, start, end, mass):
    middle = 0.5 * (start + end)
    ends = {"p": hinge(start - middle), "q": hinge(end - middle)}
    return fmb.RigidBody(name, mass=mass, inertia=(1e-3, 2e-3, 1e-3), at=tuple(middle), markers=ends)


def hinge(at):
    return fmb.Pose.axes(tuple(at), z=(0, 1, 0), x=(1, 0, 0))


def test_four_bar_at_zero_frequency_is_the_change_of_the_equilibrium():
    """With gravity and load in a closed loop: response at 0 Hz against two equilibria with other loads."""
    A, B, D = np.zeros(3), np.array([0.108, 0, 0.168]), np.array([0.5, 0, 0])
    along = D - B
    reach = np.hypot(*along[[0, 2]])
    x = (0.5**2 - 0.4**2 + reach**2) / (2 * reach)  # from B towards D, where circles of 0.5 and 0.4 m meet
    C = B + x / reach * along + np.sqrt(0.5**2 - x**2) / reach * np.array([-along[2], 0, along[0]])
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(markers={"A": hinge(A), "D": hinge(D)}),
            hinged_bar("crank", A, B, 0.5),
            hinged_bar("coupler", B, C, 1.0),
            hinged_bar("rocker", C, D, 0.8),
        ],
        joints=[
            fmb.Revolute("A", markers=("ground.A", "crank.p")),
            fmb.Revolute("B", markers=("crank.q", "coupler.p")),
            fmb.Revolute("C", markers=("coupler.q", "rocker.p")),
            fmb.Revolute("D", markers=("ground.D", "rocker.q")),
        ],
        forces=[
            fmb.TorsionSpring("spring", joint="A", stiffness=30.0, damping=0.2),
            fmb.PointLoad("push", marker="coupler.q", force=(5.0, 0, 0)),
        ],
        sensors=[fmb.JointCoordinate("angle", joint="A"), fmb.Reaction("pin", joint="C")],
    )
    rest = fmb.statics(model)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # moments that are zero in a hinge are no kinks, and not inaccurate
        plant = fmb.linearize(model, rest, inputs="push.force.z")
    step, found = 1e-2, []
    for sign in (1.0, -1.0):
        loaded = model.changed("push", force=(5.0, 0, sign * step))
        moved = fmb.statics(loaded, state=rest, tolerance=1e-12)
        found.append(np.append(moved["angle"][-1], moved["pin"][-1]))
    expected = (found[0] - found[1]) / (2 * step)
    assert abs(expected[3]) > 0.5
    np.testing.assert_allclose(plant.frequency_response(0.0)[0, :, 0], expected, rtol=1e-6, atol=1e-9)


def test_elastic_bodies_agree_with_the_response_between_markers():
    """The receptance of `Linearization.frequency_response` stems from exact Jacobians of the markers."""
    steel = fmb.Material(young=210e9, poisson=0.3, density=7850.0)
    fe = fem.frame(np.linspace([0, 0, 0], [1, 0, 0], 11), section=fem.Section.rectangle(0.01, 0.01), material=steel)
    model = fmb.Model(
        bodies=[
            fmb.Ground(),
            fmb.FloatingBody(
                "beam", data=reduction.reduce(fe, {"root": "start", "tip": "end"}, 4, stress=False), damping=0.02
            ),
        ],
        joints=[fmb.Fixed("clamp", markers=("ground.origin", "beam.root"))],
        forces=[fmb.PointLoad("push", marker="beam.tip", force=(0, 0, 0))],
        sensors=[fmb.Deflection("bow", marker="beam.tip"), fmb.Position("tip", marker="beam.tip")],
    )
    f = np.array([2.0, 8.3, 30.0, 120.0])
    rest = fmb.statics(model)
    exact = fmb.linearize(model, rest).frequency_response(f, "beam.tip", "beam.tip")
    plant = fmb.linearize(model, rest, inputs=["push.force.y", "push.force.z"], outputs="tip")
    scale = np.abs(exact[:, 1:3, 1:3]).max(axis=(1, 2), keepdims=True)
    assert np.abs(plant.frequency_response(f)[:, 1:3] / scale - exact[:, 1:3, 1:3] / scale).max() < 1e-7


def test_matlab_file(tmp_path):
    plant = fmb.linearize(oscillator(), inputs=["push.force.z", "push.force.x"], outputs="place")
    path = fmb.io.write_plant(plant, tmp_path / "plant.mat")
    read = scipy.io.loadmat(path)
    for name in "ABCD":
        np.testing.assert_array_equal(read[name], getattr(plant, name))
    assert [str(cell[0][0]) for cell in read["inputs"]] == ["push.force.z", "push.force.x"]
    assert [str(cell[0][0]) for cell in read["outputs"]] == ["place x", "place y", "place z"]
    with pytest.raises(DataFileError, match=r"the ending '\.csv'"):
        fmb.io.write_plant(plant, tmp_path / "plant.csv")


def test_python_control():
    control = pytest.importorskip("control")
    plant = fmb.linearize(quarter_car(), inputs="profile", outputs="body z")
    system = plant.to_control()
    assert isinstance(system, control.StateSpace)
    assert system.input_labels == ["profile_displacement"]
    f = np.array([0.5, 1.2, 5.0])
    np.testing.assert_allclose(
        system(2j * np.pi * f, squeeze=True), quarter_car_closed_form(2j * np.pi * f)[0], rtol=1e-9
    )


def test_a_load_over_a_joint_is_no_input_but_stiffness():
    """F = 50 - 100 z on the mass adds 100 N/m to the spring; it is no function of time that could be an input."""
    law = fmb.table([-1.0, 0.0, 1.0], [150.0, 50.0, -50.0], of="guide")
    model = oscillator().changed("push", force=(0, 0, law), moment=(0, 0, 0))
    plant = fmb.linearize(model, fmb.statics(model), outputs="place z")
    assert "push.force.z" not in plant.inputs
    assert "push.force.x" in plant.inputs
    size = np.abs(plant.poles[0])
    assert size == pytest.approx(np.sqrt((K + 100.0) / MASS), rel=1e-6)


def test_a_kink_is_told():
    """The distance of two points that coincide grows whichever way they part."""
    with pytest.warns(ValidityWarning, match=r"way has a kink at this state"):
        fmb.linearize(oscillator(), inputs="push.force.z", outputs="way")


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ({"inputs": "push.forze.z"}, r"input 'push.forze.z' does not exist.*Did you mean 'push.force.z'"),
        ({"inputs": "push"}, r"input 'push' may be 6 signals"),
        ({"inputs": [3]}, r"inputs = \[3\]"),
        ({"inputs": []}, r"no input"),
        ({"outputs": "plaze"}, r"output 'plaze' does not exist.*Did you mean 'place'"),
        ({"outputs": "work"}, r"output 'work' has no value at this state"),
    ],
)
def test_what_cannot_be_asked(asked, told):
    with pytest.raises(ModelError, match=told):
        fmb.linearize(oscillator(), **asked)


def test_a_state_that_moves_is_refused():
    model = oscillator().changed("ball", velocity=(0, 0, 1.0))
    moving = fmb.simulate(model, t_end=0.05, samples=3)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)  # it is no equilibrium either
        with pytest.raises(ModelError, match="about a state that moves"):
            fmb.linearize(model, moving, inputs="push.force.z", outputs="place")


def test_frequencies_that_have_no_response():
    free = oscillator().changed("spring", damping=0.0, stiffness=0.0)
    plant = fmb.linearize(free, inputs="push.force.z", outputs="place z")
    np.testing.assert_allclose(plant.frequency_response(1.0)[0, 0, 0], -1 / (MASS * (2 * np.pi) ** 2), rtol=1e-9)
    with pytest.raises(ModelError, match="no bound of the response at 0 Hz"):
        plant.frequency_response([0.0, 1.0])
    with pytest.raises(ModelError, match="frequencies"):
        plant.frequency_response([np.nan])


def test_mode_motion_is_the_mode():
    """At a quarter of the period the mass has left the middle by the amplitude, and is back at the half."""
    motion = fmb.mode_motion(oscillator(), mode=0, frames=5)
    z = motion[fmb.Position("z", marker="ball.center")][:, 2]
    assert motion.t[-1] == pytest.approx(1 / fmb.linearize(oscillator()).frequencies[0])
    middle = 0.5 * (z[0] + z[2])
    assert middle == pytest.approx(0.0, abs=1e-12)
    assert z[4] == pytest.approx(z[0])
    assert np.abs(z).max() > 0.01
    with pytest.raises(ModelError, match="mode = 7"):
        fmb.mode_motion(oscillator(), mode=7)


def test_named_inputs_are_ports_wherever_they_are_read():
    model = oscillator()
    throttle = fmb.input("throttle", 0.5)
    push = fmb.PointLoad("push", marker="ball.center", force=(0, 0, throttle * 3.0))
    lift = fmb.PointLoad("lift", marker="ball.center", force=(0, 0, throttle))
    plant = fmb.linearize(
        replace(model, forces=(model.forces[0], push, lift), gravity=(0, 0, -1.0)), outputs=["place z"]
    )
    assert plant.inputs == ("throttle",)
    s = 2j * np.pi * 3.0
    found = plant.frequency_response([3.0])[0, 0, 0]
    np.testing.assert_allclose(found, 4.0 / (MASS * s**2 + DAMPING * s + K), rtol=1e-7)
    with pytest.raises(ModelError, match="throttle"):
        fmb.linearize(replace(model, forces=(model.forces[0], push), gravity=(0, 0, -0.75)), inputs=["throttel"])


@pytest.mark.filterwarnings("ignore:.*accelerates:flexmb.errors.ValidityWarning")
def test_a_drive_at_its_crest_is_at_rest():
    """cos(pi / 2) = 6e-17 is rounding; a drive that moves by 1e-6 m/s is not."""
    along = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))
    found = []
    for phase in (0.0, 0.5 * np.pi, 0.5 * np.pi - 1e-4):
        lift = fmb.harmonic(amplitude=0.01 * (phase > 0.0), frequency=1.0, phase=phase)
        model = fmb.Model(
            bodies=[
                fmb.Ground(markers={"x": along}),
                fmb.RigidBody(
                    "base", mass=1.0, inertia=(1, 1, 1), markers={"x": along}, at=(0.01 * np.sin(phase), 0, 0)
                ),
                fmb.RigidBody(
                    "top", mass=2.0, inertia=(1, 1, 1), markers={"x": along}, at=(0.01 * np.sin(phase), 0, 0)
                ),
            ],
            joints=[
                fmb.Prismatic("slide", markers=("ground.x", "base.x")),
                fmb.Drive("road", joint="slide", displacement=lift),
                fmb.Prismatic("rail", markers=("base.x", "top.x")),
            ],
            forces=[fmb.Actuator("spring", joint="rail", effort=-50.0 * fmb.measured("x") + fmb.input("push"))],
            sensors=[fmb.JointCoordinate("x", joint="rail")],
        )
        if phase in (0.0, 0.5 * np.pi):
            found.append(fmb.linearize(model, inputs="push", outputs="x"))
        else:
            with pytest.raises(ModelError, match="state that moves"):
                fmb.linearize(model, inputs="push", outputs="x")
    assert found[1].frequency_response([0.3]) == pytest.approx(found[0].frequency_response([0.3]), rel=1e-9)
