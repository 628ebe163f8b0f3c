"""Periodic tables and tables over two signals: against scipy's splines, polynomials, and energies."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, RegularGridInterpolator

import flexmb as fmb
from flexmb.errors import ModelError

ALONG_X = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))
X = np.array([0.2, 0.9, 1.4, 2.2, 3.1])
Y = np.array([1.0, 3.0, -2.0, 0.5, 1.0])


def rail(effort, **cart) -> fmb.Model:
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"x": ALONG_X}),
            fmb.RigidBody("cart", mass=2.0, inertia=(1, 1, 1), markers={"x": ALONG_X}, **cart),
        ],
        joints=[fmb.Prismatic("rail", markers=("ground.x", "cart.x"))],
        forces=[fmb.Actuator("motor", joint="rail", effort=effort)],
        sensors=[fmb.JointCoordinate("x", joint="rail")],
    )


def test_a_periodic_table_goes_on_as_scipys_periodic_spline():
    t = np.linspace(-7.0, 11.0, 401)
    found = fmb.table(X, Y, periodic=True).sample(t)
    spline = CubicSpline(X, Y, bc_type="periodic")
    for order in range(3):
        assert found[:, order] == pytest.approx(spline(t, order, extrapolate="periodic"), abs=1e-11)
    line = fmb.table(X, Y, kind="linear", periodic=True).sample(t)[:, 0]
    assert line == pytest.approx(np.interp(t, X, Y, period=X[-1] - X[0]), abs=1e-12)


def test_steps_end_at_the_corners_of_a_periodic_table():
    """A triangular load over forty periods: the speed is its integral, the place the double one."""
    tooth = fmb.table([0.0, 0.01, 0.025], [0.0, 8.0, 0.0], kind="linear", periodic=True)
    solution = fmb.simulate(rail(tooth), 1.0, samples=[0.0, 0.5, 1.0], integrator=fmb.Explicit(rtol=1e-9))
    assert solution[fmb.Velocity("v", marker="cart.x")][1:, 0] == pytest.approx([1.0, 2.0], rel=1e-9)


def test_a_periodic_force_over_a_place_keeps_the_energy():
    place = fmb.measured(fmb.JointCoordinate("p", joint="rail"))
    spline = CubicSpline(X, Y - Y[0], bc_type="periodic")
    model = rail(fmb.table(X, Y - Y[0], of=place, periodic=True), velocity=(4, 0, 0))
    solution = fmb.simulate(model, 3.0, samples=31, integrator=fmb.Explicit(rtol=1e-10))
    x, v = solution["x"], solution[fmb.Velocity("v", marker="cart.x")][:, 0]
    assert x[-1] > 3.0 * (X[-1] - X[0])
    work = [spline.integrate(0.0, b, extrapolate="periodic") for b in x]
    assert v**2 - np.array(work) == pytest.approx(16.0, rel=1e-7)


def polynomial(x, y):
    return 0.3 * x**3 * y**2 - x * y**3 + 2.0 * x**2 - 0.5 * y + 1.0


GRID = np.array([-1.0, -0.2, 0.7, 1.1, 2.0]), np.array([0.0, 0.6, 1.0, 1.8])


def test_a_table_over_two_signals_reproduces_cubic_polynomials_with_rates():
    x, y = GRID
    table = fmb.table2(x, y, polynomial(x[:, None], y), of=(fmb.expression("2*sin(t) - 0.2"), fmb.expression("0.3*t")))
    t = np.linspace(0.1, 0.6, 21)
    whole = "0.3*(2*sin(t)-0.2)**3*(0.3*t)**2 - (2*sin(t)-0.2)*(0.3*t)**3 + 2*(2*sin(t)-0.2)**2 - 0.15*t + 1"
    assert table.sample(t) == pytest.approx(fmb.expression(whole).sample(t), abs=1e-10)
    with_edges = fmb.table2(x, y, polynomial(x[:, None], y), of=(9.0, fmb.expression("t")))
    assert with_edges.sample(0.7) == pytest.approx(
        [polynomial(2.0, 0.7), 0.3 * 8 * 1.4 - 6 * 0.49 - 0.5, 0.6 * 8 - 12 * 0.7], abs=1e-11
    )


def test_a_bilinear_table_equals_scipy(rng):
    x, y = GRID
    z = rng.normal(size=(5, 4))
    known = RegularGridInterpolator(GRID, z)
    for a, b in rng.uniform((-1.0, 0.0), (2.0, 1.8), (20, 2)):
        found = fmb.table2(x, y, z, of=(float(a), float(b)), kind="linear").sample(0.0)
        assert found == pytest.approx([float(known((a, b))), 0.0, 0.0], abs=1e-12)


def test_a_table_over_place_and_speed_drives_a_cart():
    """Exactly as the formula it was made from."""
    place = fmb.measured(fmb.JointCoordinate("p", joint="rail"))
    speed = fmb.measured(fmb.JointCoordinate("p", joint="rail"), rate=True)
    x, v = np.linspace(-1.0, 1.0, 5), np.linspace(-3.0, 3.0, 6)
    force = -10.0 * x[:, None] ** 3 - 5.0 * x[:, None] - 0.2 * v * (1.0 + x[:, None])
    table = rail(fmb.table2(x, v, force, of=(place, speed)), at=(0.5, 0, 0))
    formula = fmb.formula("-10*p**3 - 5*p - 0.2*rate(p)*(1 + p)", over={"p": fmb.JointCoordinate("p", joint="rail")})
    ends = [
        fmb.simulate(model, 2.0, samples=3, integrator=fmb.Implicit())["x"]
        for model in (table, rail(formula, at=(0.5, 0, 0)))
    ]
    assert ends[0] == pytest.approx(ends[1], abs=1e-6)


def test_a_linear_model_knows_the_slopes_of_a_table():
    place = fmb.measured(fmb.JointCoordinate("p", joint="rail"))
    speed = fmb.measured(fmb.JointCoordinate("p", joint="rail"), rate=True)
    x, v = np.linspace(-1.0, 1.0, 5), np.linspace(-3.0, 3.0, 6)
    table = fmb.table2(x, v, -18.0 * x[:, None] - 4.0 * v + x[:, None] * v, of=(place, speed))
    found = fmb.linearize(rail(table)).eigenvalues
    assert abs(found[0].real + 1.0) + abs(abs(found[0].imag) - np.sqrt(8.0)) < 1e-9  # 2 s^2 + 4 s + 18 = 0


def test_steps_end_where_a_table_over_two_signals_bends():
    """A ridge of 2 ms that only the product of two signals of time meets: its impulse by Simpson's rule, exactly."""
    ridge = fmb.table2(
        [0.0, 1.0], [0.5, 0.501, 0.502], [[0, 0, 0], [0, 1e3, 0]], of=(fmb.expression("t"),) * 2, kind="linear"
    )
    solution = fmb.simulate(rail(ridge), 1.0, samples=3, integrator=fmb.Explicit(rtol=1e-9))
    assert solution[fmb.Velocity("v", marker="cart.x")][-1, 0] == pytest.approx(0.5 * 0.501, rel=1e-9)


def test_bad_tables_are_refused():
    with pytest.raises(ModelError, match="the same value at both"):
        fmb.table([0, 1], [0, 1], periodic=True)
    with pytest.raises(ModelError, match=r"z of the shape \(2, 2\)"):
        fmb.table2([0, 1, 2], [0, 1], [[1, 2], [3, 4]], of=(1.0, 2.0))
    with pytest.raises(ModelError, match="two signals"):
        fmb.table2([0, 1], [0, 1], [[1, 2], [3, 4]], of=(1.0,))
    with pytest.raises(ModelError, match="increase"):
        fmb.table2([0, 0], [0, 1], [[1, 2], [3, 4]], of=(1.0, 2.0))


def test_model_files_hold_them(tmp_path):
    grid = fmb.table2(
        [0, 1], [0, 1], [[1, 2], [3, 5]], of=(fmb.expression("t"), fmb.JointCoordinate("p", joint="rail"))
    )
    model = rail(grid + fmb.table(X, Y, periodic=True))
    fmb.save_model(model, tmp_path / "model.toml")
    again = fmb.load_model(tmp_path / "model.toml")
    ends = [fmb.simulate(one, 0.5, samples=3)["x"][-1] for one in (model, again)]
    assert ends[0] == ends[1] != 0.0
