"""Values that jump: relays, quantisers, samplers: against closed forms of a cart and scipy's discrete systems."""

from __future__ import annotations

import numpy as np
import pytest
from by_turns import every_second
from scipy import signal as reference

import flexmb as fmb
from flexmb.errors import IntegrationError, ModelError

MASS = 2.0
ALONG_X = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))
FINE = fmb.Explicit(rtol=1e-9)
EVERY = [fmb.GeneralizedAlpha(), fmb.GeneralizedAlpha(step=1e-3), FINE, fmb.Implicit(), fmb.IDA()]
X = fmb.measured(fmb.JointCoordinate("place", joint="rail"))
V = fmb.measured(fmb.JointCoordinate("place", joint="rail"), rate=True)


def rail(effort, sensors=(), events=(), **cart) -> fmb.Model:
    """Return a cart on a rail along x, driven by an actuator."""
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"x": ALONG_X}),
            fmb.RigidBody("cart", mass=MASS, inertia=(1, 1, 1), markers={"x": ALONG_X}, **cart),
        ],
        joints=[fmb.Prismatic("rail", markers=("ground.x", "cart.x"))],
        forces=[fmb.Actuator("motor", joint="rail", effort=effort)],
        sensors=[fmb.JointCoordinate("x", joint="rail"), *sensors],
        events=events,
    )


def bang_bang() -> fmb.Model:
    """Return a cart that a relay pushes back, 3 N this way or that."""
    relay = fmb.Relay(X, limits=(-0.1, 0.1), values=(3.0, -3.0), name="relay")
    return rail(relay, [fmb.SignalValue("push", of=relay)])


def parabolas(times: np.ndarray) -> np.ndarray:
    """Return the place of that cart: parabolas between the times at which it passes a limit, all in closed form."""
    t, x, v, a, found = 0.0, 0.0, 0.0, 1.5, []
    for sample in times:
        while True:
            limit = 0.1 * np.sign(a)
            passes = (-v + np.sign(a) * np.sqrt(v * v + 2.0 * a * (limit - x))) / a
            if t + passes > sample:
                break
            t, x, v, a = t + passes, limit, v + a * passes, -a
        s = sample - t
        found.append(x + v * s + 0.5 * a * s * s)
    return np.array(found)


@pytest.mark.parametrize("integrator", EVERY, ids=repr)
def test_a_relay_switches_where_its_limits_are_passed(integrator):
    solution = fmb.simulate(bang_bang(), t_end=2.0, samples=201, integrator=integrator)
    wanted = parabolas(solution.t)
    assert np.abs(wanted).max() > 0.35
    assert solution["x"] == pytest.approx(wanted, abs=2e-11)
    assert set(np.round(solution["push"], 12)) == {-3.0, 3.0}


@pytest.mark.parametrize(("integrator", "unit"), every_second(EVERY, [1e-9, 1e9]))
def test_the_unit_of_what_a_relay_reads_says_nothing(integrator, unit):
    """Places in nanometres or gigametres: it switches at the same times, in closed form.

    They were located as metres: of numbers of 1e9 `Explicit` came to no end.
    """
    relay = fmb.Relay(unit * X, limits=(-0.1 * unit, 0.1 * unit), values=(3.0, -3.0), name="relay")
    solution = fmb.simulate(rail(relay), t_end=2.0, samples=201, integrator=integrator)
    assert solution["x"] == pytest.approx(parabolas(solution.t), abs=2e-11)


def test_a_stepper_and_a_resumed_run_switch_alike():
    model, whole = bang_bang(), parabolas(np.array([2.0]))[0]
    half = fmb.simulate(model, t_end=1.0, integrator=FINE)
    assert fmb.resume(half, 2.0, integrator=FINE)["x"][-1] == pytest.approx(whole, abs=1e-9)
    with fmb.stepper(model, integrator=FINE) as run:
        run.advance(to=0.3)
        moment = run.save()
        found = []
        for _ in range(2):
            for k in range(4, 21):
                run.advance(to=0.1 * k)
            found.append(run["x"])
            run.restore(moment)
    assert found[0] == found[1] == pytest.approx(whole, abs=1e-9)


@pytest.mark.parametrize("integrator", [EVERY[1], FINE, fmb.IDA()], ids=repr)
def test_a_sampled_controller_equals_its_difference_equation(integrator):
    """Force -(k x + d v) held over 0.05 s: x and v of a mass go on by x + v T + a T^2/2, v + a T."""
    period, k, d = 0.05, 40.0, 12.0
    force = fmb.Sampled(-k * X - d * V, period=period, name="hold")
    model = rail(force, [fmb.SignalValue("force", of=force)], at=(0.3, 0, 0))
    solution = fmb.simulate(model, t_end=2.0, samples=81, integrator=integrator)
    x, v, wanted, held = 0.3, 0.0, [], []
    for n in range(81):
        if n % 2 == 0:
            x0, v0, t0, f = x, v, n * 0.025, -k * x - d * v
        s = n * 0.025 - t0 + 0.025
        wanted.append(x)
        held.append(f)
        x, v = x0 + v0 * s + 0.5 * f / MASS * s * s, v0 + f / MASS * s
    assert solution["x"] == pytest.approx(np.array(wanted), abs=1e-9)
    assert solution["force"] == pytest.approx(np.array(held), abs=1e-7)


def test_a_controller_in_discrete_time_equals_scipy():
    """Two discrete systems in a row: the second sees what the first gives at the same instant."""
    first = reference.cont2discrete((np.array([[0.0, 1.0], [-30.0, -2.0]]), np.eye(2)[:, 1:], np.eye(2)[:1], 0), 0.02)
    system = reference.dlti(*first[:4], dt=0.02)
    u = fmb.harmonic(amplitude=2.0, frequency=1.3, offset=0.4)
    one = fmb.SampledStateSpace(u, A=system, name="one")
    two = fmb.SampledStateSpace(one, A=[[0.5]], B=[[1.0]], C=[[1.0]], D=[[0.3]], period=0.02, name="two")
    solution = fmb.simulate(
        rail(0.0, [fmb.SignalValue("one", of=one), fmb.SignalValue("two", of=two)]), 1.0, samples=51, integrator=FINE
    )
    given = 2.0 * np.sin(2.0 * np.pi * 1.3 * solution.t) + 0.4
    _, y, _ = reference.dlsim(system, given)
    _, z, _ = reference.dlsim(reference.dlti([[0.5]], [[1.0]], [[1.0]], [[0.3]], dt=0.02), y)
    assert solution["one"] == pytest.approx(y[:, 0], abs=1e-12)
    assert solution["two"] == pytest.approx(z[:, 0], abs=1e-12)


def test_a_quantiser_tells_the_nearest_step():
    coarse = fmb.Quantiser(X, step=0.05, name="encoder")
    model = rail(-40.0 * coarse, [fmb.SignalValue("told", of=coarse)], at=(0.12, 0, 0))
    solution = fmb.simulate(model, 1.0, samples=51, integrator=FINE)
    assert solution["told"] == pytest.approx(0.05 * np.round(solution["x"] / 0.05), abs=1e-12)
    # the force has a potential, 2 J/m2 per step: the energy at the turning points stays
    levels = solution["told"] / 0.05
    edges = 0.5 * np.sign(levels) * np.maximum(2.0 * np.abs(levels) - 1.0, 0.0)
    whole = np.array([0.05**2 * 40.0 * sum(range(int(abs(n)))) for n in np.round(levels)])
    potential = whole + 40.0 * 0.05 * np.abs(levels) * 0.05 * np.abs(solution["x"] / 0.05 - edges)
    speed = solution[fmb.Velocity("v", marker="cart.x")][:, 0]
    energy = potential + 0.5 * MASS * speed**2
    assert energy == pytest.approx(energy[0], rel=1e-7)


@pytest.mark.parametrize(
    ("integrator", "off"),
    [(fmb.GeneralizedAlpha(), 2e-3), (FINE, 1e-8), (fmb.Implicit(), 1e-5), (fmb.IDA(), 1e-4)],
    ids=repr,
)
def test_steps_end_at_the_corners_of_limits(integrator, off):
    """A free cart at 1 m/s meets a push that lasts 1 ms, made of limits of its place: dv from energy, exactly."""
    stiff, width = 2e6, 5e-4
    bump = fmb.Limit(X, limits=(0.5, 0.5 + width)) - fmb.Limit(X, limits=(0.5 + width, 0.5 + 2.0 * width)) + width
    model = rail(-stiff * bump, velocity=(1, 0, 0))
    solution = fmb.simulate(model, 1.0, samples=3, integrator=integrator)
    left = np.sqrt(1.0 - 2.0 * stiff * width**2 / MASS)
    assert solution[fmb.Velocity("v", marker="cart.x")][-1, 0] == pytest.approx(left, rel=off)


def test_values_between_samples_are_held():
    force = fmb.Sampled(-40.0 * X, period=0.25)
    solution = fmb.simulate(rail(force, at=(0.3, 0, 0)), 1.0, samples=[0.0, 0.2, 0.4, 1.0], integrator=FINE)
    between, place = solution.state(0.3), solution.phases[0].q.shape[1]
    assert set(np.round(between.q[-2:], 9)) <= set(np.round(solution.phases[0].q[1, -2:], 9))
    assert place == len(between.q)


def test_analyses_of_smooth_systems_refuse_values_that_jump():
    for analysis in (fmb.linearize, fmb.statics, fmb.first_frequencies):
        with pytest.raises(ModelError, match=r"Block 'relay' holds values that jump"):
            analysis(bang_bang())
    with pytest.raises(ModelError, match="holds values that jump"):
        fmb.kinematics(bang_bang(), 1.0)


def test_bad_held_blocks_are_refused():
    with pytest.raises(ModelError, match="Block relay"):
        fmb.Relay(X, limits=(0.1, 0.1))
    with pytest.raises(ModelError, match="period"):
        fmb.Sampled(X, period=0.0)
    with pytest.raises(ModelError, match="hysteresis"):
        fmb.Quantiser(X, step=0.1, hysteresis=1.0)
    with pytest.raises(ModelError, match="period"):
        fmb.SampledStateSpace(X, A=[[0.5]], B=[[1.0]], C=[[1.0]])
    again = fmb.Relay(1.0 * X, limits=(-1.0, 1.0), name="r")
    both = fmb.formula("a + b", over={"a": again, "b": fmb.Relay(X, limits=(0.0, 1.0), name="r")})
    with pytest.raises(ModelError, match="used twice"):
        fmb.simulate(rail(both), 0.1)


def test_a_relay_that_feeds_itself_is_told():
    """Its own output lifts the signal over the limit, and lets it fall at once."""
    relay = fmb.Relay(fmb.formula("1 - 2*y", over={"y": "own"}), limits=(-0.5, 0.5), name="bell")
    with pytest.raises(IntegrationError, match=r"Block 'bell'.*switches without end"):
        fmb.simulate(rail(relay, [fmb.SignalValue("own", of=relay)]), 0.1)


def test_a_change_between_two_looks_is_told():
    """400 Hz over 10 s: the looks, 10 ms apart, always find the cart in the middle."""
    stiff = MASS * (2.0 * np.pi * 400.0) ** 2
    relay = fmb.Relay(X, limits=(-0.5, 0.5), name="fast")
    fast = rail(-stiff * X + relay, velocity=(0.6 * 2.0 * np.pi * 400.0, 0, 0))
    with pytest.raises(IntegrationError, match=r"Block 'fast'.*came back between two looks"):
        fmb.simulate(fast, 10.0, samples=3, integrator=FINE)


def test_model_files_hold_them(tmp_path):
    relay = fmb.Relay(fmb.Sampled(X, period=0.01), limits=(-0.1, 0.1), values=(3.0, -3.0))
    model = rail(
        relay + fmb.Quantiser(X, step=0.1) + fmb.SampledStateSpace([X, V], A=[[0.5]], B=[[1, 2]], C=[[1]], period=0.1)
    )
    fmb.save_model(model, tmp_path / "model.toml")
    again = fmb.load_model(tmp_path / "model.toml")
    ends = [fmb.simulate(one, 0.5, integrator=FINE)["x"][-1] for one in (model, again)]
    assert ends[0] == ends[1] != 0.0
