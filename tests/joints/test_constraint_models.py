"""`Constraint` in whole models: joints written as equations, formulations, redundancy, model files, messages."""

import math
import warnings

import numpy as np
import pytest
from numba import njit
from scipy.linalg import sqrtm
from scipy.special import ellipk

import flexmb as fmb
from flexmb.constraints.by_function import FunctionOfScalars
from flexmb.errors import CompileError, ModelError

L = 0.7


def pendulum(joint, **fields) -> fmb.Model:
    bob = fmb.PointMass("bob", mass=1.3, at=(L, 0, 0), velocity=(0, 0.4, 0))
    ground = fmb.Ground(markers={"A": (0, 0, 0)})
    sensors = [fmb.Position("p", marker="bob.center"), fmb.Multiplier("m", joint="c"), fmb.Reaction("r", joint="c")]
    return fmb.Model(gravity=(0, 0, -9.81), bodies=[ground, bob], joints=[joint], sensors=sensors, **fields)


SPHERE = fmb.Constraint("c", over=["p"], equation="p[0]**2 + p[1]**2 + p[2]**2 = L**2", parameters={"L": L})
INTEGRATORS = [
    (fmb.GeneralizedAlpha(rtol=1e-7), 1e-4),
    (fmb.IDA(), 1e-5),
    (fmb.Explicit(rtol=1e-9), 1e-7),
    (fmb.Explicit(rtol=1e-9, formulation=fmb.Recursive()), 1e-7),
    (fmb.Explicit(rtol=1e-9, formulation=fmb.NullSpace()), 1e-7),
]


@pytest.mark.parametrize(("integrator", "within"), INTEGRATORS)
def test_pendulum_by_its_equation_is_the_rod(integrator, within):
    """The multiplier of x^2 + y^2 + z^2 - L^2 is the force of the rod over 2 L."""
    own = fmb.simulate(pendulum(SPHERE), t_end=0.5, samples=11, integrator=integrator)
    rod = pendulum(fmb.Rod("c", markers=("ground.A", "bob.center")))
    exact = fmb.simulate(rod, t_end=0.5, samples=11, integrator=fmb.Explicit(rtol=1e-11))
    np.testing.assert_allclose(own["p"], exact["p"], atol=within)
    np.testing.assert_allclose(2.0 * L * own["m"], exact["m"], atol=1e2 * within)
    np.testing.assert_allclose(own["r"], exact["r"], atol=1e2 * within)


KINDS = {
    "holonomic": ("d = D + 0.1*c*d", {}),
    "rheonomic": ("d**2 + 0.1*p[2] = E + 0.2*sin(3*t)", {}),
    "pfaffian": ("v[1] + 0.3*rate(c) = 0.1*cos(t)", {}),
    "nonlinear": ("w[0]**2 + v[0]*w[1] + f[2] = 0.4", {}),
    "non-ideal": ("f[1] - 0.2*w[2]", {"forces": {"f[1]": "-3*f[0] + t", "p[1]": "2*p[0]"}}),
}


def constrained(rng, kinds) -> fmb.Model:
    """Two bodies under gravity, joined by a ball, with equations of their own; the last one twice, in other words."""
    ball = tuple(rng.normal(size=3) * 0.3)
    a = fmb.RigidBody(
        "a",
        mass=1.4,
        inertia=(0.2, 0.3, 0.4),
        markers={"m": ball},
        velocity=rng.normal(size=3),
        angular_velocity=(1, 2, 3),
    )
    b = fmb.RigidBody("b", mass=0.6, inertia=(0.1, 0.1, 0.15), at=ball, markers={"m": (0, 0, 0), "n": (0.5, 0.4, 0.3)})
    origin, end = rng.normal(size=3) * 0.2 - 0.6, np.array(ball) + (0.5, 0.4, 0.3)
    ground = fmb.Ground(markers={"o": tuple(origin)})
    far = float(np.linalg.norm(end - origin))
    numbers = {"D": 1.01 * far, "E": far**2 + 0.1 * end[2] + 0.02}
    over = [
        fmb.Position("p", marker="b.n"),
        fmb.Distance("d", markers=("ground.o", "b.n")),
        fmb.AxisCosine("c", markers=("a.center", "b.n"), axes=("x", "y")),
        fmb.Velocity("v", marker="a.center"),
        fmb.Velocity("f", marker="b.n", axes="a.m"),
        fmb.AngularVelocity("w", marker="b.n"),
    ]
    joints = [fmb.Spherical("ball", markers=("a.m", "b.m"))]
    for name in kinds:
        equation, more = KINDS[name]
        joints.append(fmb.Constraint(name, over=over, equation=equation, parameters=numbers, **more))
    left, equals, right = KINDS[kinds[-1]][0].partition(" = ")
    again = f"2.5*({left})" + (f" = 2.5*({right})" if equals else "")
    joints.append(fmb.Constraint("again", over=over, equation=again, parameters=numbers))
    return fmb.Model(gravity=(0.3, 0, -9.81), bodies=[ground, a, b], joints=joints, sensors=[])


@pytest.mark.parametrize("kinds", [(name,) for name in KINDS] + [("rheonomic", "pfaffian", "nonlinear", "non-ideal")])
def test_formulations_agree_and_dependence_is_named(kinds, rng):
    model = constrained(rng, kinds)
    assert fmb.check(model).redundant == ("again: Formula",)
    found = [
        fmb.accelerations(model, formulation=formulation)
        for formulation in (fmb.Augmented(), fmb.NullSpace(), fmb.UdwadiaPhohomsiri(), fmb.Recursive(), fmb.Baumgarte())
    ]
    for other in found[1:]:
        np.testing.assert_allclose(other.a, found[0].a, rtol=1e-9, atol=1e-9)
        for joint, wrench in found[0].reactions.items():
            np.testing.assert_allclose(other.reactions[joint], wrench, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize(
    ("integrator", "within"),
    [(fmb.Explicit(), 1e-6), (fmb.Implicit(), 1e-3), (fmb.IDA(), 2e-3), (fmb.GeneralizedAlpha(), 2e-3)],
    ids=lambda value: type(value).__name__,
)
def test_equations_given_three_times_move_as_one(integrator, within):
    """A pendulum let go level is back after 4 K(sin 45 deg) / sqrt(g); which reactions are shared is told."""
    period = 4.0 * ellipk(0.5) / np.sqrt(9.81)
    over = {"p": fmb.Position("p", marker="bob.center")}
    rod = [fmb.Constraint(f"rod {k}", over=over, equation=f"{k}*(p[0]**2 + p[1]**2 + p[2]**2 - 1)") for k in (1, 2, 3)]
    model = fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[fmb.Ground(), fmb.PointMass("bob", mass=1.0, at=(1, 0, 0))],
        joints=rod,
        sensors=[fmb.Position("x", marker="bob.center")],
    )
    run = fmb.simulate(model, t_end=period, samples=51, integrator=integrator)
    np.testing.assert_allclose(run["x"][-1], (1.0, 0.0, 0.0), atol=within)
    assert len(run.statistics["reactions not unique"]) == 3


def test_force_of_a_constraint_that_is_not_ideal_is_udwadias(rng):
    """M a = Q + A^T multipliers + M^1/2 (I - B^+ B) M^-1/2 C (Udwadia & Kalaba 2000), by hand for a point mass.

    The multipliers' part is M^1/2 B^+ (b - A M^-1 Q), B = A M^-1/2; here A v = 0 with A = (1, x, 0), C = given forces.
    """
    mass, r, v, c = 1.7, np.array([0.4, -0.3, 0.2]), np.array([-0.4 * 0.5, 0.5, 0.9]), 2.2
    given = {"v[0]": "-c*v[0]", "v[1]": "-c*v[1]*p[2]", "p[2]": "3*v[1]"}
    over = [fmb.Position("p", marker="b.center"), fmb.Velocity("v", marker="b.center")]
    own = fmb.Constraint("own", over=over, equation="v[0] + p[0]*v[1]", forces=given, parameters={"c": c})
    model = fmb.Model(gravity=(1, 2, 3), bodies=[fmb.PointMass("b", mass=mass, at=r, velocity=v)], joints=[own])
    A, b = np.array([[1.0, r[0], 0.0]]), np.array([-v[0] * v[1]])
    M, Q = mass * np.diag((1.0, 1.0, 1.0)), mass * np.array((1.0, 2.0, 3.0))
    C = np.array([-c * v[0], -c * v[1] * r[2], 3 * v[1]])
    root = np.real(sqrtm(M))
    B = A @ np.linalg.inv(root)
    ideal = root @ np.linalg.pinv(B) @ (b - A @ np.linalg.solve(M, Q))
    other = root @ (np.eye(3) - np.linalg.pinv(B) @ B) @ np.linalg.solve(root, C)
    np.testing.assert_allclose(fmb.accelerations(model)["b"][:3], np.linalg.solve(M, Q + ideal + other), rtol=1e-12)


def test_given_forces_count_as_loads():
    """A knife edge with drag along it: what the drag takes is the loss of energy."""
    over = [fmb.Velocity("v", marker="s.center", axes="s.center")]
    knife = fmb.Constraint("knife", over=over, equation="v[1]", forces={"v[0]": "-0.8*v[0]"})
    sleigh = fmb.RigidBody("s", mass=2.0, inertia=(1, 1, 0.3), velocity=(1.0, 0, 0), angular_velocity=(0, 0, 2.0))
    energies = [fmb.Energy("E", kind="total")]
    model = fmb.Model(bodies=[fmb.Ground(), sleigh], joints=[knife], sensors=energies)
    run = fmb.simulate(model, t_end=1.0, samples=11, integrator=fmb.Explicit(rtol=1e-10))
    speed = np.exp(-0.4 * run.t)  # m v' = -c v: the edge at the centre of mass does not slow it down
    np.testing.assert_allclose(run["E"] - run["E"][0], np.cumsum(0 * run.t) + 0.5 * 2.0 * (speed**2 - 1.0), atol=1e-8)
    np.testing.assert_allclose(run.phases[0].works[:, 0], 0.5 * 2.0 * (speed**2 - 1.0), atol=1e-8)


def test_model_file_with_named_and_own_sensors(tmp_path):
    text = """
    gravity = [0, 0, -9.81]
    [parameters]
    L = 0.7
    [[body]]
    kind = "PointMass"
    name = "bob"
    mass = 1.3
    at = ["= L", 0, 0]
    velocity = [0, 0.4, 0]
    [[sensor]]
    kind = "Position"
    name = "p"
    marker = "bob.center"
    [[joint]]
    kind = "Constraint"
    name = "c"
    over = ["p"]
    equation = "p[0]**2 + p[1]**2 + p[2]**2 = L**2"
    parameters = { L = "= L" }
    [[joint]]
    kind = "Constraint"
    name = "slow"
    over = { u = { kind = "Velocity", name = "vel", marker = "bob.center" } }
    equation = "u[1] = 0.4*exp(-t)"
    """
    path = tmp_path / "own.toml"
    path.write_text(text)
    model = fmb.load_model(path)
    fmb.save_model(model, tmp_path / "again.toml")
    again = fmb.load_model(tmp_path / "again.toml")
    a, b = fmb.accelerations(model), fmb.accelerations(again)
    assert a["bob"][1] == pytest.approx(-0.4, abs=1e-12)
    np.testing.assert_array_equal(a.a, b.a)


def test_placed_model_keeps_the_names_in_its_equations():
    model = pendulum(SPHERE).placed("left")
    assert fmb.check(model).mobility == 2
    assert fmb.accelerations(model)["left_bob"][0] == pytest.approx(-(0.4**2) / L)
    with pytest.raises(ModelError, match=r"'p' is a component in the axes of W.*Distance"):
        pendulum(SPHERE).placed("right", at=(1, 0, 0))


POINT = [fmb.Position("p", marker="bob.center"), fmb.Velocity("v", marker="bob.center")]


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"equation": "p[0] + q"}, "Constraint|the name 'q' is unknown"),
        ({"equation": "p + 1"}, r"'p', which has 3 components.*Write p\[0\]"),
        ({"equation": "p[3]"}, r"p\[3\] of a quantity with 3 components"),
        ({"equation": "rate(v[0])"}, "an acceleration"),
        (
            {"equation": "p[0] = rate(s)", "parameters": {"s": fmb.expression("-0.01*cos(10*t)")}},
            r"rate\(s\) of a signal in 'p\[0\] = rate\(s\)', which restricts positions.*Give the rate a signal",
        ),
        ({"equation": "abs(p[0]) = 1"}, "'abs' of a measured quantity"),
        ({"equation": "where(p[0] > 0, p[1], p[2])"}, "'where' of a measured quantity"),
        ({"equation": "2*t"}, "reads no measured quantity"),
        ({"equation": "p[0]", "level": "velocity"}, "level = 'velocity', and the equation reads no velocity"),
        ({"equation": "v[0]", "level": "position"}, "reads velocities"),
        ({"equation": "v[0]", "level": "speed"}, "level = 'speed'"),
        ({"equation": "p[0] ="}, "not arithmetic"),
        ({"equation": "p[0] + L", "parameters": {"L": np.nan}}, "the parameter L = nan"),
        ({"equation": "p[0]", "parameters": {"p": 1.0}}, "'p' has two meanings"),
        ({"equation": "p[0]", "over": ["other"]}, "sensor 'other' does not exist"),
        ({"equation": "p[0]", "over": [fmb.Energy("p")]}, "cannot be measured while the motion is computed"),
        ({"equation": "p[0]", "over": []}, "at least one measured quantity"),
        ({"equation": "p[0]", "forces": {"3": "1"}}, "forces on '3'"),
        ({"equation": "p[0]", "over": [fmb.Position("p", marker="bob.nose")]}, "marker 'bob.nose' does not exist"),
    ],
)
def test_what_does_not_fit_is_named(fields, message):
    with pytest.raises(ModelError, match=message):
        pendulum(fmb.Constraint("c", **{"over": POINT, **fields}))


@pytest.mark.parametrize(
    ("equation", "message"),
    [
        ("p[0]**2 + 1", "cannot be assembled: joint 'c' stays open"),
        ("sqrt(p[0] - 2)", r"joint 'c'.*has no value \(nan\)"),
        ("1/p[1] = 0", r"joint 'c'.*has no value"),
        ("p[1]**2", "has no gradient at the start"),
        ("(p[1] - 0.1)**2", "has no gradient at the start"),
        ("v[0]**2 + 1 = 0", "has no gradient at the start"),
        ("v[1]**2 + 1 = 0", "derivative misses zero"),
    ],
)
def test_what_cannot_be_satisfied_is_named(equation, message):
    with pytest.raises(CompileError, match=message):
        fmb.check(pendulum(fmb.Constraint("c", over=POINT, equation=equation)))


def test_contradictory_constraints_are_named():
    joints = [
        fmb.Constraint("low", over=POINT, equation="p[2]"),
        fmb.Constraint("high", over=POINT, equation="p[2] = 1"),
    ]
    model = pendulum(SPHERE)
    with pytest.raises(CompileError, match=r"joint '(low|high)' stays open by"):
        fmb.check(model.without("c", "m", "r").with_parts(joints=joints))


def sphere(t, x):
    return x[0] ** 2 + x[1] ** 2 + x[2] ** 2 - (L + 0.1 * np.sin(3 * t)) ** 2


def sphere_slope(t, x):
    return 2.0 * np.asarray(x)


def swept(t, x, v):
    return v[0] * v[1] + x[2] * v[3] - 0.2 * t


@pytest.mark.parametrize("jacobian", [None, sphere_slope])
def test_function_is_the_equation(jacobian):
    """Accelerations, multipliers and a motion; plain Python, and compiled by numba."""
    over = [fmb.Position("q", marker="bob.center")]
    text = "q[0]**2 + q[1]**2 + q[2]**2 = (L + 0.1*sin(3*t))**2"
    models = [
        pendulum(fmb.Constraint("c", over=over, equation=text, parameters={"L": L})),
        pendulum(fmb.Constraint("c", over=over, function=sphere, jacobian=jacobian)),
    ]
    if jacobian is None:
        models.append(pendulum(fmb.Constraint("c", over=over, function=njit(sphere))))
    for model in models[1:]:
        own, other = (fmb.accelerations(m) for m in (models[0], model))
        np.testing.assert_allclose(other.a, own.a, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(other.lam, own.lam, rtol=1e-9, atol=1e-9)
    a, b = (fmb.simulate(m, t_end=0.2, samples=5, integrator=fmb.GeneralizedAlpha(rtol=1e-5)) for m in models[:2])
    np.testing.assert_allclose(a["p"], b["p"], atol=1e-9)


def test_function_of_velocities():
    over = [fmb.Position("q", marker="bob.center"), fmb.Velocity("u", marker="bob.center")]
    text = "rate(q[0])*rate(q[1]) + q[2]*u[0] = 0.2*t"
    one = pendulum(fmb.Constraint("c", over=over, equation=text))
    two = pendulum(fmb.Constraint("c", over=over, function=swept, level="velocity"))
    np.testing.assert_allclose(fmb.accelerations(one).a, fmb.accelerations(two).a, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda t, x: float(np.real(x[0])) - 0.7, "by a complex step"),
        (lambda t, x: np.real(x[0]) - 0.7, "by a complex step and 1 by a difference; give jacobian="),
        (lambda t, x: x[7], "IndexError"),
        (lambda t, x: x[0] * np.nan, "no finite value"),
    ],
)
def test_functions_that_fail_are_named(function, message):
    with pytest.raises(CompileError, match=f"joint 'c' has no value.*{message}"):
        fmb.check(pendulum(fmb.Constraint("c", over=[fmb.Position("q", marker="bob.center")], function=function)))


def ramped(steep, w):
    """Point mass on p2 = a sin(k p0) + a sin(w t)."""

    def surface(t, x):
        return x[2] - 0.001 * np.sin(steep * x[0]) - 0.001 * np.sin(w * t)

    def real_time(t, x):
        return x[2] - 0.001 * np.sin(steep * x[0]) - 0.001 * math.sin(w * t)

    def slope(t, x):
        return [-0.001 * steep * np.cos(steep * x[0]), 0.0, 1.0]

    return {"plain": (surface, None), "jacobian": (surface, slope), "real time": (real_time, slope)}


@pytest.mark.parametrize("how", ["plain", "jacobian", "real time"])
@pytest.mark.parametrize(("steep", "w", "within"), [(60, 50, 1e-8), (600, 300, 1e-8), (1000, 1000, 2e-6)])
@pytest.mark.parametrize("at", [0.02, 40.0])
def test_drift_of_short_waves_late_and_far_away(how, steep, w, within, at):
    """p2'' = -a k^2 v^2 sin(k x) - a w^2 sin(w t) and dg/dt = -a w cos(w t), by hand, however late and far away."""
    function, jacobian = ramped(steep, w)[how]
    equation = FunctionOfScalars(function, jacobian, 3, 3, 0)
    jets = np.array([[at, 1.3, 0.0], [0.0, 0.2, 0.0], [0.1, 0.0, 0.0]])
    _, _, drift, by_time = equation.derivatives(at, jets, False)[:4]
    assert by_time == pytest.approx(-0.001 * w * np.cos(w * at), rel=within, abs=1e-3 * w * within)
    largest = 0.001 * ((1.3 * steep) ** 2 + w**2)
    expected = 0.001 * ((1.3 * steep) ** 2 * np.sin(steep * at) + w**2 * np.sin(w * at))
    assert drift == pytest.approx(expected, abs=within * largest + 1e-6)


def test_derivatives_are_looked_at_beside_the_start():
    """Where the slope is zero a function that drops imaginary parts looks right."""
    point = [fmb.Position("q", marker="bob.center")]
    bowl = fmb.Constraint("c", over=point, function=lambda t, x: x[2] - 0.5 * np.abs(x[1]) ** 2)
    with pytest.raises(CompileError, match=r"the derivative by argument 1 is .* by a complex step and"):
        fmb.check(pendulum(bowl))
    moving = fmb.Constraint("c", over=point, function=lambda t, x: x[2] - np.real(t) ** 2)
    with pytest.raises(CompileError, match="the derivative by time is 0 by a complex step and"):
        fmb.check(pendulum(moving))


def test_a_function_may_end_beside_the_start():
    """sqrt(x - 0.7) at x = 0.7 + 0 has no value to one side; a large circle has large terms that cancel."""
    point = [fmb.Position("q", marker="bob.center")]
    edge = fmb.Constraint("c", over=point, function=lambda t, x: x[2] * np.sqrt(x[0] - 0.6999))
    assert fmb.check(pendulum(edge)).mobility == 2
    far = FunctionOfScalars(lambda t, x: x[0] ** 2 + x[1] ** 2 - 1e6, None, 2, 2, 0)
    found = far.derivatives(0.0, np.array([[1e3, 0.0, 0.0], [0.0, 2.0, 0.0]]), False)
    assert found[2] == pytest.approx(8.0, rel=1e-6)


@pytest.mark.parametrize("equation", ["p[0]**2 + p[1]**2 + p[2]**2 = L**2", None])
@pytest.mark.parametrize(("drawn", "length"), [(1000.2, 1000.0), (1.5e-3, 1.4e-3)])
def test_length_of_an_equation_in_axes_of_the_world_is_that_of_the_rod(equation, drawn, length):
    """A point mass on a circle of 1 km, and on one of a millimetre, drawn a little beside it."""
    bodies = [fmb.Ground(markers={"A": (0, 0, 0)}), fmb.PointMass("b", mass=1.0, at=(drawn, 0, 0))]
    over = [fmb.Position("p", marker="b.center")]
    if equation is None:
        joint = fmb.Rod("c", markers=("ground.A", "b.center"), length=length)
    else:
        joint = fmb.Constraint("c", over=over, equation=equation, parameters={"L": length})
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        fmb.accelerations(fmb.Model(bodies=bodies, joints=[joint]))
    assert len(told) == (length < 1.0)
    if told and equation:
        assert f"its equation '{equation}' has the residual 2.9e-07" in str(told[0].message)
        assert "that meet" not in str(told[0].message)


def test_small_circle_drawn_at_twice_its_radius_is_refused():
    """As a rod would be; the message names the equation and its residual, and the marker once."""
    equation = "p[0]**2 + p[1]**2 + p[2]**2 = 1e-6"
    own = fmb.Constraint("c", over=[fmb.Position("p", marker="b.center")], equation=equation)
    model = fmb.Model(bodies=[fmb.PointMass("b", mass=1.0, at=(2e-3, 0, 0))], joints=[own])
    with pytest.raises(
        CompileError, match=r"open by 0.00075 m: its equation '.*' has the residual 3e-06, 'b.center' at"
    ):
        fmb.accelerations(model)


def test_function_that_raises_is_blamed_itself():
    point = [fmb.Position("q", marker="bob.center")]
    model = pendulum(fmb.Constraint("c", over=point, function=lambda t, x: {}["missing"]))
    with pytest.raises(CompileError, match=r"^Joint 'c'.*KeyError: 'missing' at t = 0 s") as told:
        fmb.check(model)
    assert "assembled" not in str(told.value)
