"""What the integrators say when they cannot go on, and what they leave behind."""

import re
import warnings

import numpy as np
import pytest
from by_turns import slow

import flexmb as fmb
from flexmb.errors import FlexmbError, IntegrationError, ModelError
from flexmb.integrate.runs.arrival import arrived
from flexmb.integrate.runs.outcome import Outcome
from flexmb.system import compile

INTEGRATORS = [fmb.GeneralizedAlpha(), fmb.GeneralizedAlpha(step=1e-3), fmb.IDA()]
NAMES = ["alpha adaptive", "alpha", "IDA"]
IMPLICIT = [fmb.Implicit(), fmb.Implicit(step=1e-3)]


def four_parts(error: FlexmbError) -> str:
    """Check that a message has its four parts and return it."""
    assert all((error.part, error.found, error.expected, error.remedy)), error
    return str(error)


def overstretched() -> fmb.Model:
    """A crank of 1 m and a rod of 1 m; the slider is pulled to 2.5 m: beyond its reach of 2 m at t = 0.7 s."""
    along = fmb.Pose.axes((0, 0, 0), x=(0, 1, 0), z=(1, 0, 0))
    slider = fmb.RigidBody(
        "slider", mass=1.0, inertia=(1, 1, 1), at=(1.6, 0, 0), markers={"rail": along, "pin": (0, 0, 0)}
    )
    crank = fmb.RigidBody.rod("crank", length=1.0, mass=1.0, radius=0.05, rotation=(0, 0, np.arccos(0.8)))
    return fmb.Model(
        name="stretch",
        bodies=[fmb.Ground(markers={"rail": along}), crank, slider],
        joints=[
            fmb.Revolute("pivot", markers=("ground.origin", "crank.start")),
            fmb.Prismatic("rail", markers=("ground.rail", "slider.rail")),
            fmb.Rod("link", markers=("crank.end", "slider.pin")),
            fmb.Drive("pull", joint="rail", displacement=fmb.expression("1.6 + t**2")),
        ],
        sensors=[fmb.Position("pin", marker="slider.pin")],
    )


@pytest.mark.parametrize("integrator", [*INTEGRATORS, *IMPLICIT], ids=[*NAMES, "implicit adaptive", "implicit"])
def test_dead_centre_keeps_the_samples_before_it(integrator):
    with pytest.raises(IntegrationError) as caught:
        fmb.simulate(overstretched(), 1.0, samples=101, integrator=integrator)
    message = four_parts(caught.value)
    assert "Model 'stretch'" in message
    assert "t = 0.6" in message
    solution = caught.value.solution
    assert solution.status.kind == "failed"
    assert 0.5 < solution.t[-1] < 0.6330
    assert solution.statistics["steps"] < 20_000  # IDA took 100 000 steps of 1e-18 s, and kept a state of any of them
    np.testing.assert_allclose(solution["pin"][:, 0], 1.6 + solution.t**2, atol=1e-5)


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_what_implicit_steps_say_at_a_dead_centre(integrator):
    with pytest.raises(IntegrationError) as caught:
        fmb.simulate(overstretched(), 1.0, samples=11, integrator=integrator)
    least = re.search(r"steps fail down to (\S+) s at t = 0\.63", four_parts(caught.value))
    assert least
    assert float(least[1]) < 6e-16  # four roundings of the time


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=NAMES)
def test_an_interrupted_run_leaves_a_file_that_can_be_read(integrator, tmp_path):
    def interrupt(t, t_end):
        if t > 0.1:
            raise KeyboardInterrupt

    path = tmp_path / "run.h5"
    solution = fmb.simulate(overstretched(), 0.5, samples=20001, output=path, integrator=integrator, progress=interrupt)
    assert solution.status.kind == "interrupted"
    again = fmb.Solution.load(path)
    assert again.status.kind == "interrupted"
    assert 0.0 < again.t[-1] < 0.5
    np.testing.assert_array_equal(again.t, solution.t)
    np.testing.assert_array_equal(again["pin"], solution["pin"])


@pytest.mark.parametrize(
    ("settings", "found"),
    [
        ({"rho_inf": 1.5}, "rho_inf = 1.5"),
        ({"step": 0.0}, "step = 0.0"),
        ({"rtol": -1.0}, "rtol = -1.0"),
        ({"largest": float("nan")}, "largest = nan"),
    ],
)
def test_settings_of_generalized_alpha(settings, found):
    with pytest.raises(ModelError) as caught:
        fmb.GeneralizedAlpha(**settings)
    assert found in four_parts(caught.value)


@pytest.mark.parametrize(
    ("settings", "found"),
    [
        ({"rtol": 0.0}, "rtol = 0.0"),
        ({"atol": -1e-8}, "atol = -1e-08"),
        ({"max_order": 6}, "max_order = 6"),
        ({"most_steps": 0}, "most_steps = 0"),
        ({"largest": 0.0}, "largest = 0.0"),
    ],
)
def test_settings_of_ida(settings, found):
    with pytest.raises(ModelError) as caught:
        fmb.IDA(**settings)
    assert found in four_parts(caught.value)


def test_steps_of_a_given_size_that_fail_ask_for_shorter_ones():
    with pytest.raises(IntegrationError) as caught:
        fmb.simulate(overstretched(), 1.0, samples=3, integrator=fmb.GeneralizedAlpha(step=0.01))
    assert "give a shorter step than 0.01 s, or none" in four_parts(caught.value)


def test_undamped_multipliers_are_refused():
    with pytest.raises(ModelError) as caught:
        fmb.simulate(overstretched(), 0.1, integrator=fmb.GeneralizedAlpha(rho_inf=1.0))
    assert "rho_inf = 1 in a model with joints" in four_parts(caught.value)


def test_a_free_body_may_keep_all_its_energy():
    body = fmb.RigidBody("body", mass=1.0, inertia=(1, 2, 3), angular_velocity=(0.1, 1, 0.1))
    model = fmb.Model(bodies=[fmb.Ground(), body], sensors=[fmb.Energy("energy")])
    solution = fmb.simulate(model, 10.0, integrator=fmb.GeneralizedAlpha(rho_inf=1.0, step=1e-2))
    assert np.ptp(solution["energy"]) < 1e-4


def test_ida_counts_its_steps():
    with pytest.raises(IntegrationError) as caught:
        fmb.simulate(overstretched(), 0.5, samples=2, integrator=fmb.IDA(rtol=1e-10, atol=1e-12, most_steps=5))
    assert "5 steps between two samples" in four_parts(caught.value)
    assert len(caught.value.solution.t) == 1


def test_forces_that_are_not_finite_are_named():
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("mass", mass=1.0)],
        forces=[fmb.PointLoad("load", marker="mass.center", force=(fmb.expression("log(0.5 - t)"), 0, 0))],
    )
    for integrator in [*INTEGRATORS, *IMPLICIT]:
        with pytest.raises(IntegrationError) as caught:
            fmb.simulate(model, 1.0, samples=11, integrator=integrator)
        assert "Body 'mass'" in four_parts(caught.value)
        if integrator in IMPLICIT:
            assert "the accelerations are not finite at t = 0.5 s" in str(caught.value)
        t = caught.value.solution.t  # perhaps with a state behind it, kept when the clock struck
        assert t[4] == pytest.approx(0.4)
        assert np.all(t[5:] <= 0.5)
    for integrator in (fmb.Explicit(), fmb.Explicit(formulation=fmb.Recursive())):
        with pytest.raises(IntegrationError, match=r"at t = 0\.5 s") as caught:
            fmb.simulate(model, 1.0, samples=11, integrator=integrator)
        t = caught.value.solution.t  # perhaps with a state behind it, kept when the clock struck
        assert t[4] == pytest.approx(0.4)
        assert np.all(t[5:] <= 0.5)


@pytest.mark.parametrize(
    ("arguments", "found"),
    [
        ({"t_end": 0.0}, "t_end = 0.0"),
        ({"t_end": float("nan")}, "t_end = nan"),
        ({"t_end": 1.0, "samples": 1}, "samples = 1"),
        ({"t_end": 1.0, "samples": [0.0, 0.5, 0.4]}, "do not increase"),
        ({"t_end": 1.0, "samples": [0.0, 2.0]}, "outside the run"),
    ],
)
def test_times(arguments, found):
    with pytest.raises(ModelError) as caught:
        fmb.simulate(overstretched(), **arguments)
    assert found in four_parts(caught.value)


def pushed(force, displacement=None) -> fmb.Model:
    """A mass on a slide, pushed by a force, or driven."""
    rail = [fmb.Prismatic("rail", markers=("ground.origin", "mass.center"))]
    drive = [] if displacement is None else [fmb.Drive("pull", joint="rail", displacement=displacement)]
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("mass", mass=1.0, inertia=(1, 1, 1))],
        joints=[*rail, *drive],
        forces=[] if force is None else [fmb.PointLoad("push", marker="mass.center", force=(0, 0, force))],
    )


@pytest.mark.parametrize(
    "integrator",
    [fmb.GeneralizedAlpha(), fmb.GeneralizedAlpha(step=1e-3), fmb.IDA(), fmb.Implicit(), fmb.Explicit()],
)
@pytest.mark.parametrize("at", [0.5, 0.52])
def test_no_run_goes_on_behind_an_infinite_force(integrator, at):
    """The integral of 1/(t - 0.5) has no value there. Steps ended a rounding before it, and began anew behind it."""
    model = pushed(fmb.expression(f"1/(t - {at})"))
    named = rf"Force 'push' on Body 'mass': its force and moment are \[nan nan -?inf .* from t = {at} s on"
    with pytest.raises(IntegrationError, match=named) as caught:
        fmb.simulate(model, 1.0, samples=11, integrator=integrator)
    reached = caught.value.solution.t
    assert np.array_equal(reached, np.linspace(0.0, 1.0, 11)[: len(reached)])
    assert reached[-1] == pytest.approx(0.4 if at == 0.5 else 0.5)
    with fmb.stepper(model, integrator=integrator) as run:
        run.advance(to=at - 0.1)
        with pytest.raises(IntegrationError, match=named):
            run.advance(to=at + 0.02)


def towards_a_pole(power: int) -> tuple[fmb.Model, fmb.GeneralizedAlpha]:
    """Return a mass on a spring with a force that has no value at 0.5 s, and an integrator with a given step."""
    spring = fmb.SpringDamper("spring", markers=("ground.A", "p.center"), stiffness=100.0, damping=0.1, length=1.0)
    push = fmb.PointLoad("push", marker="p.center", force=(fmb.expression(f"1/(t - 0.5)**{power}"), 0, 0))
    bodies = [fmb.Ground(markers={"A": (0, 0, 0)}), fmb.PointMass("p", mass=1.0, at=(1, 0, 0))]
    return fmb.Model(bodies=bodies, forces=[push, spring]), fmb.GeneralizedAlpha(step=1e-3)


def require_no_error_of_steps(solution) -> None:
    known = solution.statistics
    assert known["errors added up"] == "not estimated"
    assert not [text for text in known.get("warnings", []) if "have added up" in text]


@pytest.mark.filterwarnings("ignore:.*steps of the given size")
@pytest.mark.parametrize("power", [1, 2])
def test_steps_towards_an_infinite_force_tell_no_error_of_the_samples_before(power):
    """Steps of a given size go beside the pole, or over it: they told errors of 1e7 m and more."""
    model, integrator = towards_a_pole(power)
    with pytest.raises(IntegrationError, match="Force 'push'") as caught:
        fmb.simulate(model, 1.0, integrator=integrator, samples=11)
    require_no_error_of_steps(caught.value.solution)


@pytest.mark.filterwarnings("ignore:.*steps of the given size")
def test_a_stepper_goes_back_from_an_infinite_force_to_the_errors_of_then():
    model, integrator = towards_a_pole(1)
    with fmb.stepper(model, integrator=integrator) as run:
        run.advance(to=0.4)
        moment, before = run.save(), run.solution.statistics["errors added up"]
        with pytest.raises(IntegrationError, match="Force 'push'"):
            run.advance(to=0.6)
        require_no_error_of_steps(run.solution)
        run.restore(moment)
        assert run.solution.statistics["errors added up"] == before < 0.05


def test_a_step_that_ends_a_rounding_before_its_sample_is_that_sample():
    system = compile(pushed(1.0))
    short, marks = np.array([0.1, 0.2 - 2e-14]), np.array([0.1, 0.2, 0.3])
    rows = {"t": short, **{name: np.zeros((2, getattr(system, f"n{name}"))) for name in "qu"}, "a": np.zeros((2, 6))}
    outcome = arrived(system, Outcome(rows=rows), marks)
    assert not outcome.failure
    assert outcome.rows["t"].tolist() == [0.1, 0.2]


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(), fmb.IDA(), fmb.Implicit(), fmb.Explicit()])
def test_a_force_that_is_no_number_any_more_is_named(integrator):
    """The square root of a negative number is no dead centre."""
    model = pushed(fmb.expression("sqrt(0.55 - t)"))
    with pytest.raises(IntegrationError) as caught:
        fmb.simulate(model, 1.0, samples=11, integrator=integrator)
    text = four_parts(caught.value)
    assert "Force 'push' on Body 'mass': its force and moment are [nan nan nan" in text
    assert "from t = 0.55 s on" in text
    assert "Correct its signals" in text
    assert "singular" not in text
    assert caught.value.solution.t[-1] == pytest.approx(0.5)


@pytest.mark.parametrize("analyse", [fmb.simulate, fmb.kinematics])
def test_a_drive_that_is_no_number_any_more_is_named(analyse):
    with pytest.raises(IntegrationError) as caught:
        analyse(pushed(None, fmb.expression("(0.55 - t)**2.5")), 1.0, samples=11)
    text = four_parts(caught.value)
    assert "Joint 'pull': its signal with its two rates is" in text
    assert "t = 0.55 s on" in text


def test_ida_counts_its_steps_and_prints_nothing(capfd):
    """A mass on a spring for one period: the steps of order up to five, each with its residual evaluations."""
    spring = fmb.SpringDamper("s", markers=("ground.far", "mass.center"), stiffness=1.0, length=1.0)
    mass = fmb.PointMass("mass", mass=1.0, at=(0.5, 0, 0))
    model = fmb.Model(bodies=[fmb.Ground(markers={"far": (-1, 0, 0)}), mass], forces=[spring])
    few, many = (
        fmb.simulate(model, 6.0, samples=7, integrator=fmb.IDA(rtol=rtol, atol=rtol)).statistics
        for rtol in (1e-4, 1e-9)
    )
    for counts in (few, many):
        assert 10 < counts["steps"] + counts["rejected"] <= counts["residuals"]
        assert counts["factorisations"] <= counts["residuals"]
    assert many["steps"] > 2 * few["steps"]
    with pytest.raises(IntegrationError):
        fmb.simulate(model, 6.0, samples=2, integrator=fmb.IDA(rtol=1e-10, atol=1e-12, most_steps=5))
    printed = capfd.readouterr()  # compiled libraries write past sys.stderr
    assert printed.out == printed.err == ""


@pytest.mark.parametrize(
    "integrator", [fmb.Explicit(method="DOP853", formulation=fmb.NullSpace()), slow(fmb.Explicit(method="Radau"))]
)
def test_forces_that_overflow_are_told_once(integrator):
    """By the error, without what the arithmetic behind it says."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        with pytest.raises(IntegrationError) as caught:
            fmb.simulate(pushed(fmb.expression("1e10 * exp(1500 * t)")), 1.0, samples=3, integrator=integrator)
    assert "t = 0." in four_parts(caught.value)


def test_sample_times_may_miss_the_ends_by_rounding():
    """0.1 * 3 is above 0.3 by one unit in the last place; a millionth beyond is an error."""
    times = fmb.simulate(pendulum_of_points(), 0.3, samples=np.arange(4) * 0.1).t
    assert times.tolist() == [0.0, 0.1, 0.2, 0.3]
    with pytest.raises(fmb.FlexmbError, match="outside the run"):
        fmb.simulate(pendulum_of_points(), 0.3, samples=np.arange(4) * 0.1000001)


def pendulum_of_points():
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("p", mass=1.0)], sensors=[fmb.Position("p", marker="p.center")]
    )


def following(how: str) -> fmb.Model:
    """A mass at 1 m/s under sqrt(1 - x) N, by a formula of its place or through a block: no number from x = 1 m on."""
    root = fmb.formula("sqrt(1 - x)", {"x": fmb.measured(fmb.Position("x", marker="p.center"))})
    force = {
        "formula": root,
        "pid": fmb.Pid(of=root, kp=1.0, ki=0.5, name="speed"),
        "lag": fmb.Lag(of=root, time=0.1, name="filter"),
    }[how]
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("p", mass=1.0, velocity=(1.0, 0, 0))],
        forces=[fmb.PointLoad("push", marker="p.center", force=(force, 0, 0))],
    )


@pytest.mark.parametrize(
    ("how", "named"), [("formula", "Force 'push' on Body 'p'"), ("pid", "Block 'speed"), ("lag", "Block 'filter")]
)
@pytest.mark.parametrize(
    "integrator",
    [fmb.GeneralizedAlpha(), fmb.Implicit(), fmb.Explicit(), fmb.IDA(), fmb.MoreauJean(step=1e-2)],
    ids=lambda i: type(i).__name__,
)
def test_what_follows_the_motion_and_is_no_number_any_more_is_named(integrator, how, named):
    with pytest.raises(fmb.IntegrationError) as caught:
        fmb.simulate(following(how), 3.0, samples=31, integrator=integrator)
    text = str(caught.value)
    assert named in text
    assert "nan" in text
    assert "so that it is a number until the end" in text
