"""Runs that are moved on from outside: inputs, readings, roll back, events, and bad input."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from by_turns import slow
from scipy.integrate import solve_ivp

import flexmb as fmb
from flexmb.errors import ModelError

INTEGRATORS = {
    "alpha": fmb.GeneralizedAlpha(rtol=1e-8),
    "explicit": fmb.Explicit(),
    "joint coordinates": fmb.Explicit(formulation=fmb.Recursive()),
    "scipy": fmb.Explicit(formulation=fmb.NullSpace()),
    "implicit": fmb.Implicit(rtol=1e-8),
    "ida": fmb.IDA(rtol=1e-9, atol=1e-11),
}
EXACT = {"alpha": 1e-5, "explicit": 1e-9, "joint coordinates": 1e-9, "scipy": 1e-9, "implicit": 1e-8, "ida": 1e-6}
MASS, ARM, INERTIA, GRAVITY = 2.0, 0.5, 0.2, 9.81


def pendulum(*, effort=None, events=(), sensors=()) -> fmb.Model:
    """A rod that hangs from a hinge about y, with a torque."""
    y = fmb.Pose.axes(z=(0, 1, 0))
    top = fmb.Pose.axes((0, 0, ARM), z=(0, 1, 0))
    rod = fmb.RigidBody("rod", mass=MASS, inertia=(INERTIA, INERTIA, 0.01), at=(0, 0, -ARM), markers={"top": top})
    return fmb.Model(
        bodies=[fmb.Ground(markers={"y": y}), rod],
        joints=[fmb.Revolute("hinge", markers=("ground.y", "rod.top"))],
        forces=[fmb.Actuator("motor", joint="hinge", effort=fmb.input("torque") if effort is None else effort)],
        sensors=[
            fmb.JointCoordinate("angle", joint="hinge"),
            fmb.Reaction("pin", joint="hinge"),
            fmb.Velocity("speed", marker="rod.center"),
            *sensors,
        ],
        events=events,
        gravity=(0, 0, -GRAVITY),
    )


def held(torques, h: float) -> np.ndarray:
    """Angle and rate of the pendulum after torques that are held for the time h each, by the equation of the rod."""
    x, J = np.zeros(2), INERTIA + MASS * ARM**2
    for torque in torques:
        x = solve_ivp(
            lambda t, x, torque=torque: [x[1], (torque - MASS * GRAVITY * ARM * np.sin(x[0])) / J],
            (0.0, h),
            x,
            method="DOP853",
            rtol=1e-13,
            atol=1e-14,
        ).y[:, -1]
    return x


def pushed_cart() -> fmb.Model:
    """A mass of 2 kg that an input pushes along x."""
    x = fmb.Pose.axes(x=(0, 1, 0), z=(1, 0, 0))
    return fmb.Model(
        bodies=[fmb.Ground(markers={"x": x}), fmb.RigidBody("cart", mass=2.0, inertia=(1, 1, 1), markers={"x": x})],
        joints=[fmb.Prismatic("rail", markers=("ground.x", "cart.x"))],
        forces=[fmb.Actuator("push", joint="rail", effort=fmb.input("force"))],
        sensors=[fmb.JointCoordinate("x", joint="rail"), fmb.Velocity("v", marker="cart.x")],
        gravity=(0, 0, 0),
    )


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("step", [None, 0.1, 0.05])
def test_the_work_of_forces_that_jump_is_the_energy_of_the_cart(step):
    """Powers jump with the inputs; what they do in a step is force times way, and nothing is warned of."""
    with fmb.stepper(pushed_cart(), integrator=fmb.GeneralizedAlpha(step=step), t_end=20.0) as run:
        work = 0.0
        for k in range(200):
            force, before = 2.0 * np.cos(0.1 * k + 0.3), run["x"]
            run.set("force", force)
            run.advance(by=0.1)
            work += force * (run["x"] - before)
        assert run["v"][0] ** 2 == pytest.approx(work, rel=1e-9)
        assert run.state.works[0] == pytest.approx(work, rel=1e-9)


TORQUES = 3.0 * np.random.default_rng(7).normal(size=25)


@pytest.mark.parametrize("name", INTEGRATORS)
def test_torques_that_are_held_give_the_motion_of_the_rod(name):
    with fmb.stepper(pendulum(), integrator=INTEGRATORS[name]) as run:
        for torque in TORQUES:
            run.set("torque", torque)
            run.advance(by=0.04)
        angle, rate = held(TORQUES, 0.04)
        assert run.t == pytest.approx(1.0, abs=1e-12)
        assert run["angle"] == pytest.approx(angle, abs=EXACT[name])
        assert np.linalg.norm(run["speed"]) == pytest.approx(abs(rate) * ARM, abs=10.0 * EXACT[name])


def test_generalized_alpha_keeps_its_order_across_jumps():
    angle, errors = held(TORQUES, 0.04)[0], []
    for step in (2e-3, 1e-3, 5e-4):
        with fmb.stepper(pendulum(), integrator=fmb.GeneralizedAlpha(step=step)) as run:
            for torque in TORQUES:
                run.set("torque", torque)
                run.advance(by=0.04)
            errors.append(abs(run["angle"] - angle))
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(orders, 2.0, atol=0.1)


@pytest.mark.parametrize("name", INTEGRATORS)
def test_a_step_that_is_taken_back_leaves_nothing(name):
    def go(run, torques):
        for torque in torques:
            run.set("torque", torque)
            run.advance(by=0.04)
        return run.state, run["angle"]

    with fmb.stepper(pendulum(), integrator=INTEGRATORS[name]) as run:
        go(run, TORQUES[:5])
        moment = run.save()
        before, angle = run.state, run["angle"]
        first, end = go(run, TORQUES[5:10])
        for _ in range(2):
            go(run, -TORQUES[12:20])
            run.restore(moment)
            assert (run.t, run["angle"], run.inputs["torque"]) == (before.t, angle, TORQUES[4])
            np.testing.assert_array_equal(run.state.u, before.u)
            again, end_again = go(run, TORQUES[5:10])
            np.testing.assert_array_equal(again.q, first.q)
            np.testing.assert_array_equal(again.lam, first.lam)
            assert end_again == end
        assert len(run.solution.t) == 11  # the start and ten steps: what was taken back is not kept


@pytest.mark.parametrize("method", ["DOP853", slow("RK45"), slow("Radau")])
def test_turns_are_counted_again_after_a_step_is_taken_back(method):
    """SciPy's solvers hold functions; a copy that shared them would count turns from where the discarded run went."""
    spring = fmb.TorsionSpring("wound", joint="hinge", stiffness=0.5)
    model = replace(pendulum(), gravity=(0.0, 0.0, 0.0))
    model = replace(model, forces=[*model.forces, spring])

    def go(run, torque, duration):
        run.set("torque", torque)
        run.advance(by=duration)
        return run["angle"], *run.state.u

    integrator = fmb.Explicit(formulation=fmb.NullSpace(), method=method, rtol=1e-5, atol=1e-7)
    with fmb.stepper(model, integrator=integrator) as run:
        go(run, 7.0, 1.0)
        moment = run.save()
        straight = go(run, 7.0, 1.0)
        run.restore(moment)
        assert go(run, -60.0, 1.0)[0] < -2.0 * np.pi  # other turns
        run.restore(moment)
        assert go(run, 7.0, 1.0) == straight
    assert straight[0] > 2.0 * np.pi


@pytest.mark.parametrize("name", INTEGRATORS)
def test_without_inputs_it_is_a_simulation(name):
    model = pendulum(effort=fmb.step(2.0, at=0.35) + fmb.harmonic(amplitude=1.0, frequency=2.0))
    reference = fmb.simulate(model, 1.0, integrator=INTEGRATORS[name], samples=11)
    with fmb.stepper(model, integrator=INTEGRATORS[name], t_end=1.0) as run:
        read = [run["angle"]]
        for k in range(1, 11):
            run.advance(to=0.1 * k)
            read.append(run["angle"])
        np.testing.assert_allclose(read, reference["angle"], atol=5.0 * EXACT[name])
        np.testing.assert_allclose(run.solution["angle"], read, atol=1e-14)


def test_energy_of_the_inputs_is_accounted():
    with fmb.stepper(pendulum(sensors=[fmb.Energy("energy")]), integrator=fmb.Explicit()) as run:
        for torque in TORQUES:
            run.set("torque", torque)
            run.advance(by=0.04)
        solution = run.solution
    turned = np.diff(solution["angle"])
    np.testing.assert_allclose(solution.phases[0].works[-1, 0], TORQUES @ turned, rtol=1e-9)
    stored = solution["energy"]
    np.testing.assert_allclose(stored[-1] - stored[0], solution.phases[0].works[-1, 0], rtol=1e-8)


def test_events_change_the_model_and_end_the_run():
    events = [
        fmb.Event("weaker", at=0.203, then=fmb.Change("motor", effort=fmb.input("torque") * 0.5)),
        fmb.Event("far", sensor="angle", above=0.3, then=fmb.Stop()),
    ]
    model = pendulum(events=events)
    with fmb.stepper(model, integrator=fmb.Explicit()) as run:
        run.set("torque", 4.0)
        assert run.advance(to=0.2)
        moment = run.save()
        assert not run.advance(to=2.0)
        stopped, angle = run.t, run["angle"]
        assert angle == pytest.approx(0.3, abs=1e-9)
        assert run.status.kind == "stopped"
        assert [phase.ended for phase in run.solution.phases] == ["weaker", "far"]
        with pytest.raises(fmb.ModelError, match="far"):
            run.advance(by=0.1)
        run.restore(moment)
        assert run.model.forces[0].effort is model.forces[0].effort
        assert not run.advance(to=2.0)
        assert run.t == stopped
    J = INERTIA + MASS * ARM**2

    def rates(t, x):
        return [x[1], ((4.0 if t < 0.203 else 2.0) - MASS * GRAVITY * ARM * np.sin(x[0])) / J]

    first = solve_ivp(rates, (0, 0.203), [0.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    passes = lambda t, x: x[0] - 0.3  # noqa: E731
    passes.terminal = True
    second = solve_ivp(rates, (0.203, 2.0), first, method="DOP853", rtol=1e-12, atol=1e-13, events=passes)
    assert stopped == pytest.approx(second.t_events[0][0], abs=1e-8)


def test_many_reads_one_input_and_signals_made_of_it():
    model = pendulum(
        effort=fmb.input("torque", 1.0) * 2.0 + fmb.table([0.0, 2.0], [0.0, 6.0], of=fmb.input("torque", 1.0))
    )
    with fmb.stepper(model, integrator=fmb.Explicit()) as run:
        assert run.inputs == {"torque": 1.0}
        run.set({"torque": 0.25})
        run.advance(to=0.1)
        assert run["angle"] == pytest.approx(held([0.25 * 2.0 + 0.25 * 3.0], 0.1)[0], abs=1e-11)


def test_what_is_wrong_is_named_and_nothing_changes():
    with fmb.stepper(pendulum(), integrator=fmb.Explicit()) as run:
        run.set("torque", 1.0)
        run.advance(to=0.1)
        for wrong, said in (
            (("torgue", 1.0), "torque"),
            (("torque", float("nan")), r"'torque' = nan at t = 0.1 s.*finite"),
            (("torque", None), "finite number"),
        ):
            with pytest.raises(fmb.ModelError, match=said):
                run.set(*wrong)
        with pytest.raises(fmb.ModelError, match="torque"):
            run.set({"torque": 2.0, "other": 1.0})
        assert run.inputs == {"torque": 1.0}
        with pytest.raises(fmb.ModelError, match="later time"):
            run.advance(to=0.05)
        with pytest.raises(fmb.ModelError, match="time or a duration"):
            run.advance()
        with pytest.raises(fmb.ModelError, match="angle"):
            run["angel"]
    with pytest.raises(fmb.ModelError, match="closed"):
        run.advance(by=0.1)
    with fmb.stepper(pendulum()) as other, pytest.raises(fmb.ModelError, match="this run"):
        other.restore(run.save())


def test_inputs_do_not_prescribe_motions_and_have_one_value():
    model = pendulum()
    drive = fmb.Drive("drive", joint="hinge", angle=fmb.input("angle"))
    with pytest.raises(fmb.CompileError, match=r"drive.*input 'angle'.*jump"):
        fmb.stepper(replace(model, joints=(*model.joints, drive)))
    two = fmb.Actuator("two", joint="hinge", effort=fmb.input("torque", 2.0))
    with pytest.raises(fmb.CompileError, match=r"torque.*0 and 2"):
        fmb.stepper(replace(model, forces=(*model.forces, two)))
    with pytest.raises(fmb.ModelError, match="name"):
        fmb.input("")


def test_a_run_that_fails_can_go_back():
    with fmb.stepper(pendulum(), integrator=fmb.Explicit(most_steps=50)) as run:
        run.advance(to=0.1)
        moment = run.save()
        run.set("torque", 1e12)
        with pytest.raises(fmb.IntegrationError, match="torque"):
            run.advance(to=1.0)
        assert run.status.kind == "failed"
        with pytest.raises(fmb.ModelError, match=r"[Rr]estore"):
            run.advance(to=1.0)
        run.restore(moment)
        assert run.advance(to=0.2)
        assert run["angle"] == 0.0


def test_long_runs_keep_two_samples_when_asked():
    with fmb.stepper(pendulum(), keep=False) as run:
        for _ in range(20):
            run.advance(by=0.01)
        assert len(run.solution.t) == 2


def test_model_files_have_inputs(tmp_path):
    model = pendulum(effort=fmb.input("torque", 0.5) * 2.0)
    path = tmp_path / "model.toml"
    fmb.save_model(model, path)
    read = fmb.load_model(path)
    with fmb.stepper(read) as run:
        assert run.inputs == {"torque": 0.5}


def test_elastic_bodies_are_stepped_as_simulated():
    cable = fmb.AncfCable(
        "cable",
        points=((0, 0, 0), (1, 0, 0)),
        elements=4,
        section=fmb.fem.Section.solid_circle(0.01),
        material=fmb.MATERIALS["steel"],
    )
    model = fmb.Model(
        bodies=[fmb.Ground(), cable],
        joints=[fmb.Spherical("wall", markers=("ground.origin", "cable.start"))],
        forces=[fmb.PointLoad("tip", marker="cable.end", force=(0, 0, fmb.input("push", 5.0)))],
        sensors=[fmb.Position("end", marker="cable.end")],
    )
    reference = fmb.simulate(model, 0.2, samples=5)
    with fmb.stepper(model, t_end=0.2) as run:
        for t in reference.t[1:]:
            run.advance(to=t)
        np.testing.assert_allclose(run["end"], reference["end"][-1], atol=1e-12)


def test_sensors_follow_steps_and_steps_back():
    """Read in any order, twice, after a step and after going back: sin(angle) is where the centre is."""
    with fmb.stepper(pendulum(), integrator=fmb.Explicit()) as run:
        run.set("torque", 2.0)
        run.advance(to=0.1)
        moment, angle, speed = run.save(), run["angle"], run["speed"]
        run.advance(to=0.2)
        assert run["speed"][0] != speed[0]
        assert run["angle"] != angle
        for _ in range(2):  # the second finds the markers where they are
            assert np.sin(np.ravel(run["angle"])[0]) == pytest.approx(-run.state.q[0] / ARM, abs=1e-12)
        run.restore(moment)
        np.testing.assert_array_equal(run["speed"], speed)
        np.testing.assert_array_equal(run["angle"], angle)


def test_what_a_stepper_reads_is_what_its_solution_tells():
    """Sensors of places and velocities are measured by kernels of their own, others by the way of a solution."""
    along = fmb.Pose.axes((0, 0, 0.5), z=(0, 1, 0))
    rod = fmb.RigidBody(
        "rod", mass=2.0, inertia=(0.2, 0.2, 0.01), at=(0, 0, -0.5), markers={"top": along, "tip": (0, 0, -0.5)}
    )
    ground = fmb.Ground(markers={"o": fmb.Pose.axes((0, 0, 0), z=(0, 1, 0))})
    sensors = [
        fmb.JointCoordinate("angle", joint="hinge"),
        fmb.Position("place", marker="rod.tip"),
        fmb.Velocity("speed", marker="rod.tip", axes="rod.tip"),
        fmb.AngularVelocity("spin", marker="rod.tip"),
        fmb.AxisCosine("cosine", markers=("ground.o", "rod.tip"), axes=("x", "z")),
        fmb.Distance("far", markers=("ground.origin", "rod.tip")),
        fmb.Acceleration("acceleration", marker="rod.tip"),
        fmb.Reaction("reaction", joint="hinge"),
        fmb.SignalValue("given", of=fmb.input("torque")),
    ]
    model = fmb.Model(
        bodies=[ground, rod],
        joints=[fmb.Revolute("hinge", markers=("ground.o", "rod.top"))],
        forces=[fmb.Actuator("motor", joint="hinge", effort=fmb.input("torque"))],
        sensors=sensors,
        gravity=(0, 0, -9.81),
    )
    with fmb.stepper(model, integrator=fmb.Explicit(rtol=1e-9)) as run:
        told = []
        for k in range(12):
            run.set("torque", 40.0 + k)
            run.advance(by=0.25)
            told.append({sensor.name: run[sensor.name] for sensor in sensors})
        solution = run.solution
    assert solution["angle"][-1] > 7.0  # more than a turn
    for sensor in sensors:
        read = np.array([one[sensor.name] for one in told])
        assert read == pytest.approx(solution[sensor.name][1:], rel=1e-9, abs=1e-9), sensor.name


def test_a_saved_stepped_run_keeps_its_inputs(tmp_path):
    """Forces that nobody has asked for before are those of the inputs then; and no run goes on with other inputs."""
    along = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))
    model = fmb.Model(
        bodies=[
            fmb.Ground(markers={"x": along}),
            fmb.RigidBody("cart", mass=2.0, inertia=(1, 1, 1), markers={"x": along}),
        ],
        joints=[fmb.Prismatic("rail", markers=("ground.x", "cart.x"))],
        forces=[fmb.Actuator("motor", joint="rail", effort=fmb.input("push"))],
    )
    with fmb.stepper(model) as run:
        for k in range(3):
            run.set("push", 1.0 + k)
            run.advance(by=0.1)
        run.solution.save(tmp_path / "run.h5", write_model=fmb.model_text)
    again = fmb.Solution.load(tmp_path / "run.h5", read_model=fmb.read_model_text)
    assert again[fmb.ForceOf("f", force="motor")][1:, 0] == pytest.approx([1.0, 2.0, 3.0])
    assert "inputs set from outside" not in again.sensor_names
    with pytest.raises(ModelError, match=r"input 'push' was set to 3 from outside"):
        fmb.resume(again, 1.0)


@pytest.mark.parametrize("name", INTEGRATORS)
def test_what_watches_a_run_forgets_a_step_that_is_taken_back(name):
    """Energy, contacts, and the steps and looks by which growth is judged are those of the run that is kept."""
    x = fmb.JointCoordinate("angle", joint="hinge")
    model = pendulum(effort=fmb.input("torque") + fmb.formula("-k*a", over={"a": x}, k=0.5))
    stop = fmb.BiStop("stops", joint="hinge", travel=(-0.3, 0.3), stiffness=1e4)
    model = replace(model, forces=[*model.forces, stop])

    def known(run):
        phase = run._phase
        watch = phase.growth.saved(phase._steps())[1:]
        return watch, phase.energy.samples, phase.energy.worst, phase.energy.left, phase.looked, phase.statistics()

    with fmb.stepper(model, integrator=INTEGRATORS[name]) as run:
        for _ in range(3):
            run.advance(by=0.04)
        assert run.solution.status.ok
        moment, before = run.save(), known(run)
        run.set("torque", 9.0)
        for _ in range(20):
            run.advance(by=0.04)
        assert run.solution.statistics["contacts ended"] > 0
        assert known(run)[0] != before[0]
        run.restore(moment)
        after = known(run)
        assert after[:5] == before[:5]
        assert after[5].get("contacts ended", 0) == before[5].get("contacts ended", 0)


def soft_arm(*, events=()) -> fmb.Model:
    """Return a reduced beam of 1 m, clamped, which an input bends."""
    square, points = fmb.fem.Section.rectangle(0.01, 0.01), np.linspace((0, 0, 0), (1, 0, 0), 5)
    fe = fmb.fem.frame(points=points, section=square, material=fmb.MATERIALS["steel"])
    data = fmb.reduction.reduce(fe, interfaces={"a": (0, 0, 0), "b": (1, 0, 0)}, modes=2)
    return fmb.Model(
        bodies=[fmb.Ground(markers={"A": (0, 0, 0)}), fmb.FloatingBody("arm", data=data, damping=0.1)],
        joints=[fmb.Fixed("wall", markers=("ground.A", "arm.a"))],
        forces=[fmb.PointLoad("pull", marker="arm.b", force=(0, fmb.input("pull"), 0))],
        events=events,
    )


def test_where_warnings_are_errors_an_event_still_counts():
    """The warning about the phase before it comes at the event, and finds the run behind it."""
    event = fmb.Event("later", at=0.15, then=fmb.Change("pull", force=(0, 0, 0)))
    with fmb.stepper(soft_arm(events=(event,)), integrator=fmb.GeneralizedAlpha(), t_end=1.0) as run:
        run.set("pull", 500.0)
        with warnings.catch_warnings():
            warnings.simplefilter("error", fmb.ValidityWarning)
            with pytest.raises(fmb.ValidityWarning, match="Body 'arm'"):
                run.advance(to=0.4)
        assert run.t == 0.15
        assert [of.value for of in run.model.force("pull").force] == [0.0, 0.0, 0.0]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", fmb.ValidityWarning)
            run.advance(to=0.2)
            assert len(run.solution.phases) == 2


@pytest.mark.filterwarnings("ignore::flexmb.errors.ValidityWarning")
@pytest.mark.parametrize(
    "events", [(), (fmb.Event("later", at=0.15, then=fmb.Change("pull", force=(0, fmb.input("pull"), 0.1))),)]
)
def test_warnings_of_a_branch_that_is_taken_back_are_forgotten(events):
    """On the branch alone the arm carries loads that change its stiffness by more than a tenth."""
    with fmb.stepper(soft_arm(events=events), integrator=fmb.GeneralizedAlpha(), t_end=1.0) as run:
        run.set("pull", 1.0)
        run.advance(to=0.1)
        before, moment = run.solution.statistics, run.save()
        for _ in range(2):
            run.set("pull", 500.0)
            run.advance(to=0.4)
            bent = run.solution.statistics
            assert any("Body 'arm' carries loads" in text for text in bent["warnings"])
            assert bent["share of validity"]["Body 'arm'"]["left out"] > 1.0
            run.restore(moment)
            again = run.solution.statistics
            assert again["share of validity"] == before["share of validity"]
            assert again.get("warnings", []) == before.get("warnings", [])
            assert again.get("notes", []) == before.get("notes", [])
