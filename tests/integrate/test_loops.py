"""Measurements in the loop, and blocks: against scipy.signal, poles by hand, differences of the residual.

The plant of most tests is a cart of mass m on a rail, with an actuator that follows signals.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal as reference
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from tolerances import SOLVER

import flexmb as fmb
from flexmb.errors import CompileError, ModelError
from flexmb.integrate.matrices import tangent_at
from flexmb.system import assemble
from flexmb.system.program import advance, evaluate

MASS = 2.0
ALONG_X = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))
TIMES = np.linspace(0.0, 2.0, 201)
FINE = fmb.Explicit(rtol=1e-9)


def rail(effort, sensors=(), forces=(), **cart) -> fmb.Model:
    """Return a cart on a rail along x, driven by an actuator."""
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"x": ALONG_X}),
            fmb.RigidBody("cart", mass=MASS, inertia=(1, 1, 1), markers={"x": ALONG_X}, **cart),
        ],
        joints=[fmb.Prismatic("rail", markers=("ground.x", "cart.x"))],
        forces=[fmb.Actuator("motor", joint="rail", effort=effort), *forces],
        sensors=[fmb.JointCoordinate("x", joint="rail"), *sensors],
    )


def answers(blocks: dict) -> fmb.Solution:
    """Return the values of blocks, which nothing else follows, over two seconds."""
    sensors = [fmb.SignalValue(name, of=block) for name, block in blocks.items()]
    return fmb.simulate(rail(0.0, sensors), t_end=2.0, samples=TIMES, integrator=FINE)


U = fmb.harmonic(amplitude=2.0, frequency=1.3, offset=0.4)
u = 2.0 * np.sin(2.0 * np.pi * 1.3 * TIMES) + 0.4


def by_scipy(A, B, C, D, inputs) -> np.ndarray:
    """Return the outputs of a linear system for the harmonic inputs, integrated by scipy."""
    found = solve_ivp(
        lambda t, x: A @ x + B @ inputs(t), (0.0, 2.0), np.zeros(len(A)), "DOP853", TIMES, rtol=1e-11, atol=1e-12
    )
    return (C @ found.y + D @ np.array([inputs(t) for t in TIMES]).T).T


def given(t):
    """Return the input."""
    return np.array([2.0 * np.sin(2.0 * np.pi * 1.3 * t) + 0.4])


def test_blocks_against_scipy():
    """Every linear block answers as its state space does in scipy, every limit as numpy has it."""
    numerator, denominator = [0.3, 1.0, 40.0], [1.0, 6.0, 90.0, 120.0]
    system = reference.tf2ss(numerator, denominator)
    proper = reference.tf2ss([2.0, 1.0], [0.5, 1.0])
    A, B = np.array([[0.0, 1.0], [-30.0, -2.0]]), np.array([[0.0, 1.0], [1.0, 0.5]])
    C, D = np.array([[1.0, 0.0], [0.3, 0.2]]), np.array([[0.0, 0.0], [0.1, 0.2]])
    found = answers(
        {
            "lag": fmb.Lag(U, time=0.05),
            "integral": fmb.Integral(U, gain=3.0, start=0.5),
            "tf": fmb.TransferFunction(U, numerator=numerator, denominator=denominator),
            "proper": fmb.TransferFunction(U, numerator=[2.0, 1.0], denominator=[0.5, 1.0]),
            "gain": fmb.TransferFunction(U, numerator=[3.0], denominator=[2.0]),
            "object": fmb.StateSpace(U, A=reference.StateSpace(*system)),
            "two": fmb.StateSpace([U, 1.5 * U], A=A, B=B, C=C, D=D, row=1),
            "limit": fmb.Limit(U, limits=(-0.5, 1.0)),
            "dead": fmb.DeadZone(U, limits=(-0.5, 1.0)),
            "cubed": fmb.Function([U, U], function=lambda t, x: x[0] * x[1] ** 2 + t),
        }
    )
    assert found["lag"] == pytest.approx(
        by_scipy(*map(np.array, ([[-20]], [[20]], [[1]], [[0]])), given)[:, 0], abs=1e-7
    )
    w = 2.0 * np.pi * 1.3
    assert found["integral"] == pytest.approx(0.5 + 3.0 * (0.4 * TIMES + 2.0 / w * (1.0 - np.cos(w * TIMES))), abs=1e-7)
    for name, of in (("tf", system), ("object", system), ("proper", proper)):
        assert found[name] == pytest.approx(by_scipy(*of, given)[:, 0], abs=1e-6), name
    both = by_scipy(A, B, C, D, lambda t: np.array([1.0, 1.5]) * given(t)[0])
    assert found["two"] == pytest.approx(both[:, 1], abs=1e-6)
    assert found["gain"] == pytest.approx(1.5 * u, abs=1e-12)
    assert found["limit"] == pytest.approx(np.clip(u, -0.5, 1.0), abs=1e-12)
    assert found["dead"] == pytest.approx(u - np.clip(u, -0.5, 1.0), abs=1e-12)
    assert found["cubed"] == pytest.approx(u**3 + TIMES, abs=1e-12)


def test_delay_and_rate_limit():
    """A smooth signal comes later by the delay; a ramp that is too fast is followed with the limited rate."""
    found = answers(
        {
            "late": fmb.Delay(fmb.harmonic(amplitude=1.0, frequency=0.5), time=0.2, order=4),
            "slow": fmb.RateLimit(fmb.ramp(rate=5.0), limits=(-1.0, 2.0), time=0.001),
        }
    )
    later = TIMES > 1.0
    assert found["late"][later] == pytest.approx(np.sin(np.pi * (TIMES[later] - 0.2)), abs=2e-5)
    assert found["slow"] == pytest.approx(2.0 * TIMES, abs=1e-2)


KP, KI, KD, T = 40.0, 20.0, 10.0, 0.02
CLOSED = np.array(
    [
        [0, 1, 0, 0],
        [-(KP + KD / T) / MASS, 0, 1 / MASS, -KD / T / MASS],
        [-KI, 0, 0, 0],
        [-1 / T, 0, 0, -1 / T],
    ]
)
DRIVEN = np.array([0, (KP + KD / T) / MASS, KI, 1 / T])


def controlled() -> fmb.Model:
    """Return the cart with a PID controller of its place."""
    pid = fmb.Pid(1.0 - fmb.measured("x"), kp=KP, ki=KI, kd=KD, filter=T, name="pid")
    return rail(pid, [fmb.SignalValue("u", of=pid), fmb.State("i", of="pid", state="integral")])


def closed_loop(times) -> np.ndarray:
    """Return (x, x', integral, filtered) of the closed loop: the step response of a linear system."""
    rest = -np.linalg.solve(CLOSED, DRIVEN)
    return np.array([rest - expm(CLOSED * t) @ rest for t in times])


@pytest.mark.parametrize(
    ("integrator", "tolerance"),
    [
        (fmb.GeneralizedAlpha(rtol=1e-7), 3e-5),
        (fmb.Implicit(rtol=1e-8), 1e-8),
        (fmb.Explicit(rtol=1e-9), 1e-9),
        (fmb.Explicit(rtol=1e-9, formulation=fmb.Recursive()), 1e-9),
        (fmb.IDA(rtol=1e-8), 5e-7),
    ],
)
def test_step_response_of_a_controlled_cart(integrator, tolerance):
    """Every integrator finds the closed loop's response."""
    solution = fmb.simulate(controlled(), t_end=1.0, samples=51, integrator=integrator)
    exact = closed_loop(solution.t)
    assert solution["x"] == pytest.approx(exact[:, 0], abs=tolerance)
    assert solution["i"] == pytest.approx(exact[:, 2], abs=tolerance)
    wanted = (KP + KD / T) * (1.0 - exact[:, 0]) + exact[:, 2] - KD / T * exact[:, 3]
    assert solution["u"] == pytest.approx(wanted, abs=1e3 * tolerance)


@pytest.mark.parametrize(
    ("integrator", "steps", "order"),
    [(fmb.GeneralizedAlpha, (0.004, 0.002), 2.0), (fmb.Implicit, (0.02, 0.01), 4.0)],
)
def test_order_with_a_controller_in_the_loop(integrator, steps, order):
    """Errors fall with the order of the method."""
    exact = closed_loop([1.0])[0, 0]
    errors = [
        fmb.simulate(controlled(), t_end=1.0, samples=3, integrator=integrator(step=h))["x"][-1] - exact for h in steps
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.15)


def test_poles_of_the_closed_loop():
    """Statics settles the integral, and the linear model there has the poles of the loop by hand."""
    settled = fmb.statics(controlled())
    assert settled["x"][-1] == pytest.approx(1.0, abs=1e-9)
    values = fmb.linearize(controlled(), about=settled).eigenvalues
    both = np.concatenate([values, values[values.imag > 0.0].conj()])
    assert np.sort_complex(both) == pytest.approx(np.sort_complex(np.linalg.eigvals(CLOSED)), rel=1e-9)


def test_limits_stop_the_integral():
    """A saturated controller tracks its output: the same equations, integrated by scipy."""
    low, high, kp, ki = -3.0, 3.0, 8.0, 12.0
    pid = fmb.Pid(1.0 - fmb.measured("x"), kp=kp, ki=ki, limits=(low, high), name="pid")
    drag = fmb.Actuator("drag", joint="rail", effort=fmb.formula("-6*rate(x)", over={"x": "x"}))
    model = rail(pid, [fmb.State("i", of="pid", state="integral")], [drag])
    solution = fmb.simulate(model, t_end=2.0, samples=TIMES, integrator=FINE)

    def rates(t, y):
        v = kp * (1.0 - y[0]) + y[2]
        force = min(max(v, low), high)
        return [y[1], (force - 6.0 * y[1]) / MASS, ki * (1.0 - y[0]) + (force - v) / (kp / ki)]

    exact = solve_ivp(rates, (0.0, 2.0), np.zeros(3), "RK45", TIMES, rtol=1e-10, atol=1e-12).y
    assert solution["x"] == pytest.approx(exact[0], abs=SOLVER)
    assert solution["i"] == pytest.approx(exact[2], abs=10.0 * SOLVER)


def test_work_of_a_controller_is_accounted():
    """What an actuator does that follows measurements is work of loads; the balance closes."""
    model = controlled()
    solution = fmb.simulate(
        fmb.Model(bodies=model.bodies, joints=model.joints, forces=model.forces,
                  sensors=[*model.sensors, fmb.Energy("energy")]),
        t_end=1.0, samples=51, integrator=fmb.Implicit(rtol=1e-9),
    )  # fmt: skip
    assert solution["energy"] - solution.phases[0].works @ (1.0, 1.0, -1.0) == pytest.approx(np.zeros(51), abs=1e-6)


def spatial() -> fmb.Model:
    """Return two bodies in space with loads that follow measurements of every sort, and a block."""
    sensors = [
        fmb.Position("p", marker="a.m"),
        fmb.Velocity("v", marker="b.m", axes="a.m"),
        fmb.AngularVelocity("w", marker="a.m", axes="b.m"),
        fmb.Distance("d", markers=("a.m", "b.m")),
        fmb.AxisCosine("c", markers=("a.m", "b.m"), axes=("x", "y")),
        fmb.JointCoordinate("turn", joint="hinge"),
    ]
    over = {s.name: s for s in sensors}
    lag = fmb.Lag(fmb.formula("p[0]*v[1] + d**2", over), time=0.3, start=0.4)
    turned = {"at": (0.3, 0.1, -0.2), "rotation": (0.3, -0.5, 0.2)}
    marker = fmb.Pose((0.2, 0.1, 0.3), (0.4, 0.1, -0.3))
    return fmb.Model(
        bodies=[
            fmb.Ground(),
            fmb.RigidBody("a", mass=1.0, inertia=(1, 2, 3), markers={"m": marker}, **turned),
            fmb.RigidBody("b", mass=2.0, inertia=(2, 2, 3), markers={"m": marker, "n": fmb.Pose((0.1, 0, 0))},
                          at=(1.0, 0.5, 0.2)),
        ],
        joints=[fmb.Revolute("hinge", markers=("ground.origin", "b.n"))],
        forces=[
            fmb.PointLoad("load", marker="a.m", axes="b.m",
                          force=(fmb.formula("sin(d)*w[2] + c", over), lag, fmb.measured(sensors[0], 2)),
                          moment=(fmb.formula("v[0]*rate(p[1]) + rate(c)", over), 0.0, lag * fmb.measured(sensors[3]))),
            fmb.Actuator("motor", joint="hinge", effort=fmb.table([-9, 0, 9], [2, 1, 5], of=lag)
                         + fmb.Function([sensors[5], lag], function=lambda t, x: np.sin(x[0]) * x[1])),
        ],
    )  # fmt: skip


def test_tangents_are_the_derivatives_of_the_residual():
    """K and D of measurements, formulas, tables, functions and states equal differences of the residual."""
    system, state = assemble(spatial())
    work = system.workspace()
    random = np.random.default_rng(19)
    state.u[:] = random.normal(size=system.nu)
    tangent = tangent_at(system, state, system.workspace())
    work.weights[0].wanted = 0

    def residual(q, u):
        evaluate(system.program, state._replace(q=q, u=u), work)
        return work.residual.copy()

    h, K, D = 1e-3, np.zeros((system.nu, system.nu)), np.zeros((system.nu, system.nu))
    for k, unit in enumerate(np.eye(system.nu)):
        for way, weight in ((1, 8.0), (-1, -8.0), (2, -1.0), (-2, 1.0)):
            q = np.zeros(system.nq)
            advance(system.program, state.q, unit, way * h, q)
            K[:, k] += weight / (12.0 * h) * residual(q, state.u)
            D[:, k] += weight / (12.0 * h) * residual(state.q, state.u + way * h * unit)
    size = max(np.abs(K).max(), np.abs(D).max())
    assert tangent.D.toarray() == pytest.approx(D, abs=1e-9 * size)
    assert tangent.K.toarray() == pytest.approx(K, abs=1e-9 * size)


def test_kinks_and_references_know_their_times():
    """A reference that jumps is a signal of time: steps end there."""
    model = rail(fmb.Pid(fmb.step(value=1.0, at=0.5) - fmb.measured("x"), kp=KP))
    solution = fmb.simulate(model, t_end=1.0, samples=11, integrator=fmb.Explicit(rtol=1e-10))
    w = np.sqrt(KP / MASS)
    later = np.maximum(solution.t - 0.5, 0.0)
    assert solution["x"] == pytest.approx(1.0 - np.cos(w * later), abs=1e-9)


def test_states_of_blocks_are_carried_over_an_event():
    """A block keeps its state when the force before it is released; a shared one without a name is refused."""
    lag = fmb.Lag(2.0, time=1.0)
    second = fmb.Actuator("second", joint="rail", effort=lag)
    release = fmb.Event("off", at=0.5, then=fmb.Release("motor"))
    for first in (fmb.Lag(1.0, time=1.0), lag):
        made = rail(first, forces=[second])
        model = fmb.Model(
            bodies=made.bodies, joints=made.joints, forces=made.forces, sensors=made.sensors, events=[release]
        )
        if first is lag:
            with pytest.raises(fmb.IntegrationError, match="Give the block a name"):
                fmb.simulate(model, t_end=1.0, samples=3, integrator=FINE)
            continue
        final = fmb.simulate(model, t_end=1.0, samples=3, integrator=FINE).final
        assert final.u[-1] == pytest.approx(2.0 * (1.0 - np.exp(-1.0)), abs=1e-8)


def test_an_algebraic_loop_is_named():
    """Two signals that follow each other without a state are refused, with their names."""
    model = rail(fmb.measured("one"), [
        fmb.SignalValue("one", of=fmb.formula("2*y", over={"y": "two"})),
        fmb.SignalValue("two", of=fmb.Limit(fmb.measured("one"), limits=(-1, 1))),
    ])  # fmt: skip
    with pytest.raises(ModelError, match=r"algebraic loop: .*formula.*limit.*sensor 'one'"):
        assemble(model)


def test_an_algebraic_loop_of_formulas_names_all_sensors():
    """Formulas read sensors by name: the chain has both, not only the words of what they are made of."""
    model = rail(fmb.formula("a + 3", over={"a": "one"}), [
        fmb.SignalValue("one", of=fmb.formula("2*b + x", over={"b": "two", "x": "x"})),
        fmb.SignalValue("two", of=fmb.formula("a - 1", over={"a": "one"})),
    ])  # fmt: skip
    with pytest.raises(ModelError, match="sensor 'one' -> formula -> sensor 'two' -> formula -> sensor 'one'"):
        assemble(model)


def test_an_unknown_column_is_told_with_those_that_are_known():
    """ "v x" is none of "v vx", "v vy", "v vz"."""
    model = rail(fmb.formula("1 - v", over={"v": "v x"}), [fmb.Velocity("v", marker="cart.x")])
    with pytest.raises(ModelError, match=r"sensor 'v x' does not exist. The columns of 'v': v vx, v vy, v vz"):
        assemble(model)


def test_a_loop_by_way_of_a_state_is_none():
    """With a lag in between the same loop is x' = (2 x - x) / T."""
    lag = fmb.Lag(fmb.formula("2*y", over={"y": "x of it"}), time=0.5, start=1.0)
    solution = fmb.simulate(rail(0.0, [fmb.SignalValue("x of it", of=lag)]), t_end=1.0, samples=3, integrator=FINE)
    assert solution["x of it"][-1] == pytest.approx(np.exp(2.0), rel=1e-7)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: rail(fmb.measured(fmb.Momentum("m"))), "Momentum cannot be measured"),
        (lambda: rail(fmb.measured("y")), "sensor 'y' does not exist"),
        (lambda: rail(fmb.measured("x", 3)), "column 3"),
        (lambda: rail(fmb.measured(fmb.Velocity("v", marker="cart.x"), rate=True)), "rate of Sensor 'v'"),
        (lambda: rail(fmb.StateSpace(1.0, A=[[1, 2]], B=[[1]], C=[[1]])), "A of the shape"),
        (lambda: rail(fmb.StateSpace(1.0, A=[[1], [1, 2]], B=[[1]], C=[[1]])), "A = .*no finite numbers"),
        (lambda: rail(fmb.StateSpace(1.0, A="lag", B=[[1]], C=[[1]])), "A = 'lag'"),
        (lambda: rail(fmb.StateSpace(1.0, A=[[-1]], B=[[1]])), "C = None"),
        (lambda: rail(fmb.StateSpace(1.0, A=[[-1]], B=[[1]], C=[[1]], row="y")), "row = 'y'"),
        (lambda: rail(fmb.TransferFunction(1.0, numerator=[1, 0, 0], denominator=[1, 1])), "degree 2"),
        (lambda: rail(fmb.Pid(fmb.measured("x"), kp=1.0, limits=(2.0, 1.0))), "limits"),
        (lambda: rail(fmb.Lag(fmb.measured("x"), time=0.0)), "time = 0.0"),
        (lambda: rail(fmb.Lag(1.0, time=1.0, name="a") + fmb.Lag(1.0, time=1.0, name="a")), "used twice"),
        (lambda: rail(0.0, [fmb.State("z", of="pid")]), "'pid' has no states"),
    ],
)
def test_bad_input_is_refused(make, message):
    """Errors name the part and what was found, before anything is computed."""
    with pytest.raises(ModelError, match=message):
        assemble(make())


def test_a_prescribed_motion_cannot_follow_measurements():
    """Its rates would be accelerations; the message says what can be done."""
    model = rail(0.0)
    drive = fmb.Drive("drive", joint="rail", displacement=fmb.measured("x"))
    with pytest.raises((CompileError, ModelError), match=r"follows measurements|follows what is measured"):
        assemble(fmb.Model(bodies=model.bodies, joints=[*model.joints, drive], sensors=model.sensors))


def test_functions_that_fail_are_named():
    """What a function of the user raises ends the run with its message, and results are kept."""

    def wrong(t, x):
        if t > 0.5:
            raise ValueError("out of range")
        return 2.0 * x[0]

    model = rail(fmb.Function(fmb.measured("x"), function=wrong))
    with pytest.raises(fmb.IntegrationError, match="out of range") as caught:
        fmb.simulate(model, t_end=1.0, samples=11)
    assert len(caught.value.solution.t) >= 5


def test_functions_of_the_array_are_told_what_it_is():
    """x holds all arguments: what is computed of it as a whole is no number."""
    with pytest.raises(fmb.CompileError, match=r"returns an array \(1,\) in the place of a number.*read x\[0\]"):
        fmb.simulate(rail(fmb.Function(fmb.measured("x"), function=lambda t, x: 1.0 - 2.0 * x)), t_end=1.0)


def test_compiled_functions():
    """A C function with its derivatives acts as the formula does."""
    from numba import cfunc, types

    pointer = types.CPointer(types.float64)

    @cfunc(types.void(pointer, pointer))
    def spring(given, out):
        x = given[1]
        out[0] = -40.0 * x - 3.0 * x**3
        out[1] = -40.0 - 9.0 * x**2

    x = fmb.measured("x")
    runs = [
        fmb.simulate(rail(effort, at=(0.5, 0, 0)), t_end=1.0, samples=11)["x"]
        for effort in (fmb.Function(x, function=spring), fmb.formula("-40*x - 3*x**3", over={"x": x}))
    ]
    assert runs[0] == pytest.approx(runs[1], abs=1e-12)


def test_code_in_model_files_needs_trust(tmp_path):
    """A file that names a function is not run unless it is trusted."""
    path = tmp_path / "code.toml"
    path.write_text("""
[[body]]
kind = "Ground"

[[body]]
kind = "PointMass"
name = "p"
mass = 1.0

[[force]]
kind = "PointLoad"
name = "push"
marker = "p.center"
force = [{ function = { of = 1.0, function = "os:getpid" } }, 0, 0]
""")
    with pytest.raises(ModelError, match="names Python code to be imported"):
        assemble(fmb.load_model(path))


def test_code_beside_the_command_is_told_how_to_reach(tmp_path, monkeypatch):
    """Commands do not search the current folder for modules."""
    monkeypatch.chdir(tmp_path)
    law = fmb.Function([fmb.measured("x")], function="pilot_of_this_test:law")
    model = rail(law)
    with pytest.raises(ModelError, match=r"PYTHONPATH=folder"):
        fmb.simulate(model, 0.1)
    (tmp_path / "pilot_of_this_test.py").write_text("def law(t, x):\n    return -x[0]\n")
    with pytest.raises(ModelError, match=r"'pilot_of_this_test.py' lies in the current folder.*PYTHONPATH=\."):
        fmb.simulate(model, 0.1)


def test_model_files(tmp_path):
    """Blocks, measurements and formulas are read from model files, and written."""
    text = """
[[body]]
kind = "Ground"
markers = { x = { at = [0, 0, 0], rotation = [0, 1.5707963267948966, 0] } }

[[body]]
kind = "RigidBody"
name = "cart"
mass = 2.0
inertia = [1, 1, 1]
markers = { x = { at = [0, 0, 0], rotation = [0, 1.5707963267948966, 0] } }

[[joint]]
kind = "Prismatic"
name = "rail"
markers = ["ground.x", "cart.x"]

[[sensor]]
kind = "JointCoordinate"
name = "x"
joint = "rail"

[[sensor]]
kind = "SignalValue"
name = "error"
of = { formula = { text = "w - x", over = { x = "x" }, parameters = { w = 1.0 } } }

[[force]]
kind = "Actuator"
name = "motor"
joint = "rail"
effort = { pid = { of = { measured = "error" }, kp = 40.0, ki = 20.0, kd = 10.0, filter = 0.02 } }
"""
    path = tmp_path / "cart.toml"
    path.write_text(text)
    model = fmb.load_model(path)
    fmb.save_model(model, tmp_path / "again.toml")
    for one in (model, fmb.load_model(tmp_path / "again.toml")):
        solution = fmb.simulate(one, t_end=1.0, samples=11, integrator=FINE)
        assert solution["x"] == pytest.approx(closed_loop(solution.t)[:, 0], abs=1e-8)


def test_a_block_that_is_used_twice_is_one_block_in_the_file_too(tmp_path):
    """A controller that a sensor and a second force follow is written once, with what it follows; the poles of the
    model that is read are those of the model that was written, and a run resumes with it.
    """
    x = fmb.JointCoordinate("x", joint="rail")
    slow = fmb.Lag(x, time=0.3)
    pid = fmb.Pid(fmb.formula("0.5 - s - 0*z", over={"s": slow, "z": x}), kp=30.0, ki=5.0, kd=8.0, filter=0.05)
    load = fmb.PointLoad("load", marker="cart.center", force=(0.1 * pid - 2.0 * slow, 0.0, 0.0))
    model = rail(pid, [fmb.SignalValue("u", of=pid), fmb.SignalValue("s", of=slow)], [load])
    read = fmb.load_model(fmb.save_model(model, tmp_path / "twice.toml"))
    poles = fmb.linearize(model, fmb.statics(model)).eigenvalues
    again = fmb.linearize(read, fmb.statics(read)).eigenvalues
    assert len(again) == len(poles)
    assert np.abs(again - poles).max() <= SOLVER * np.abs(poles).max()
    file = tmp_path / "run.h5"
    fmb.simulate(model, t_end=0.2, samples=21, output=file, write_model=fmb.model_text)
    on = fmb.resume(file, t_end=0.4, samples=21, read_model=fmb.read_model_text, write_model=fmb.model_text)
    whole = fmb.simulate(model, t_end=0.4, samples=41)
    assert abs(on["u"][-1] - whole["u"][-1]) < 1e-4 * np.abs(whole["u"]).max()


def steered() -> tuple[fmb.Model, np.ndarray, np.ndarray]:
    """Return a cart whose controller follows an input, and A (4, 4) and B (4,) of x, x', integral, filtered error."""
    kp, ki, kd, T = 40.0, 30.0, 12.0, 0.02
    wanted = fmb.input("wanted")
    error = fmb.formula("r - x", over={"r": wanted, "x": fmb.JointCoordinate("x", joint="rail")})
    pid = fmb.Pid(error, kp=kp, ki=ki, kd=kd, filter=T, name="pid")
    sensors = [fmb.SignalValue("u", of=pid), fmb.SignalValue("r", of=wanted), fmb.ForceOf("F", force="motor")]
    A = np.array(
        [[0, 1, 0, 0], [-(kp + kd / T) / MASS, 0, 1 / MASS, -kd / T / MASS], [-ki, 0, 0, 0], [-1 / T, 0, 0, -1 / T]]
    )
    return rail(pid, sensors), A, np.array([0.0, (kp + kd / T) / MASS, ki, 1 / T])


def test_an_input_that_a_controller_follows_is_a_port_of_the_plant():
    """From the wanted place to the place: the closed loop by hand; what the controller asks for moves the mass."""
    model, A, B = steered()
    plant = fmb.linearize(model, fmb.statics(model), inputs=["wanted"], outputs=["x", "u"])
    for frequency, found in zip((0.1, 1.0, 5.0), plant.frequency_response(np.array([0.1, 1.0, 5.0]))):
        s = 2j * np.pi * frequency
        x = np.linalg.solve(s * np.eye(4) - A, B)[0]
        assert found[:, 0] == pytest.approx([x, MASS * s**2 * x], rel=SOLVER)
    assert set(fmb.linearize(model, fmb.statics(model), outputs=["x"]).inputs) == {"wanted"}


def test_samples_of_a_stepped_run_have_the_inputs_of_their_time():
    """Sensors of signals and forces, read after the run, are those of the run, though inputs were set since; after a
    restore too.
    """
    model, A, B = steered()
    x, seen = np.zeros(4), [(0.0, 0.0, 0.0)]
    with fmb.stepper(model, integrator=FINE) as run:
        for k in range(6):
            r = 0.1 * np.cos(1.7 * k)
            run.set("wanted", r)
            run.advance(by=0.02)
            if k == 3:
                moment = run.save()
            whole = expm(0.02 * np.block([[A, B[:, None] * r], [np.zeros((1, 5))]]))
            x = whole[:4, :4] @ x + whole[:4, 4]
            seen.append((x[0], MASS * (A[1] @ x + B[1] * r), r))
        run.restore(moment)
        run.set("wanted", 7.0)
        solution = run.solution
    exact = np.array(seen)[:5]
    assert solution["x"] == pytest.approx(exact[:, 0], abs=1e-7)
    assert solution["u"] == pytest.approx(exact[:, 1], abs=1e-4)
    assert solution["F"][:, 0] == pytest.approx(exact[:, 1], abs=1e-4)
    assert solution["r"] == pytest.approx(exact[:, 2], abs=1e-15)
    assert solution.last()["r"] == pytest.approx(exact[-1:, 2], abs=1e-15)
    with pytest.raises(ModelError, match="inputs that were set from outside"):  # other runs would not set them
        fmb.verify(solution)
