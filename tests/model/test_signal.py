"""Signals: their own formulas, how they combine, and what is said about wrong ones."""

import warnings

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from tolerances import MACHINE

from flexmb.errors import ModelError, ValidityWarning
from flexmb.model.signal import (
    Constant,
    Expression,
    Product,
    Sum,
    as_signal,
    expression,
    pack,
)
from flexmb.model.simple_signals import Ramp, harmonic, ramp, step
from flexmb.model.table_signal import table

T = np.linspace(0.0, 2.0, 41)


def test_ramp():
    """Integral of rate (1 - cos(pi tau/rise))/2: half of the rise is lost."""
    x = ramp(rate=30.0, rise=0.2, start=0.5).sample(T)
    tau = T - 0.5
    during, after = (tau > 0) & (tau < 0.2), tau >= 0.2
    assert np.all(x[tau <= 0] == 0.0)
    assert x[during, 0] == pytest.approx(15 * (tau - 0.2 / np.pi * np.sin(np.pi * tau / 0.2))[during], abs=MACHINE)
    assert x[after, 0] == pytest.approx(30 * (tau[after] - 0.1), abs=MACHINE)
    assert x[after, 1] == pytest.approx(30.0, abs=MACHINE)


def test_ramp_without_rise_starts_at_once():
    x = ramp(rate=3.0, start=1.0).sample(T)
    assert x[:, 0] == pytest.approx(3.0 * np.maximum(T - 1.0, 0.0), abs=MACHINE)
    assert x[T >= 1.0, 1].tolist() == [3.0] * 21


def test_step():
    x = step(value=5.0, initial=1.0, at=0.5, rise=1.0).sample(T)
    s = np.clip(T - 0.5, 0.0, 1.0)
    assert x[:, 0] == pytest.approx(1 + 4 * (10 * s**3 - 15 * s**4 + 6 * s**5), abs=MACHINE)
    assert step(value=5.0, initial=1.0, at=0.5).sample([0.49, 0.5])[:, 0].tolist() == [1.0, 5.0]


def test_harmonic():
    x = harmonic(amplitude=2.0, frequency=1.5, phase=0.3, offset=1.0, start=0.5).sample(T)
    a = 3 * np.pi * np.maximum(T - 0.5, 0.0) + 0.3
    assert x[:, 0] == pytest.approx(1 + 2 * np.sin(a), abs=MACHINE)
    assert x[T >= 0.5, 1] == pytest.approx(6 * np.pi * np.cos(a[T >= 0.5]), abs=100 * MACHINE)
    assert np.all(x[T < 0.5, 1] == 0.0)


def test_cubic_table_is_the_not_a_knot_spline(rng):
    x, y = np.cumsum(rng.uniform(0.1, 0.3, 9)), rng.normal(size=9)
    t = rng.uniform(x[0], x[-1], 50)
    spline = CubicSpline(x, y)
    assert table(x, y).sample(t) == pytest.approx(np.column_stack([spline(t, k) for k in range(3)]), rel=1e-9, abs=1e-9)
    held = table(x, y).sample([x[0] - 1, x[-1] + 1])
    assert held == pytest.approx(np.array([[y[0], 0, 0], [y[-1], 0, 0]]), abs=MACHINE)


def test_linear_table():
    x = table([0, 1, 3], [0, 2, 0], kind="linear").sample([-1, 0.5, 1.0, 2.0, 4.0])
    assert x[:, 0].tolist() == [0.0, 1.0, 2.0, 1.0, 0.0]
    assert x[:, 1].tolist() == [0.0, 2.0, -1.0, -1.0, 0.0]


@pytest.mark.parametrize(
    ("x", "y", "reached"),
    [
        ((0, 1, 10), (0, 1, 1), 3.025),  # the parabola 1.1 x - 0.1 x^2 at 5.5
        ((0, 1, 10), (0, -1, -1), -3.025),
        ((0, 0.2, 0.8, 1), (0, 1, 1, 0), 1.5625),  # the parabola 25/4 x (1 - x)
    ],
)
def test_spline_that_swings_beyond_its_points_is_told(x, y, reached):
    with pytest.warns(ValidityWarning, match=f"its cubic spline reaches {reached:.3g}"):
        told = table(x, y)
    values = [told.sample(t)[0] for t in np.linspace(x[0], x[-1], 401)]  # with the vertex
    np.testing.assert_allclose(max(values, key=abs), reached, rtol=1e-6)


@pytest.mark.parametrize("width", [1e-2, 1e-9])
def test_spline_that_leaves_its_points_is_refused(width):
    """A step written as a table: the spline through it reaches 5.7 / width."""
    x, y = (0.0, 0.05, 0.05 + width, 1.0), (0.0, 0.0, 1.0, 1.0)
    with pytest.raises(ModelError, match=r"between x = .* its cubic spline reaches .* kind='linear'"):
        table(x, y)
    assert table(x, y, kind="linear").sample(0.7)[0] == 1.0


@pytest.mark.parametrize("y", [(0.1,) * 5, (0.0, 0.0, 0.0, 1.0, 1.0), tuple(np.sin(np.linspace(0, 6, 5)))])
def test_splines_near_their_points_are_not_told(y):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made = table((0, 1, 2, 3, 4), y)
    np.testing.assert_allclose([made.sample(float(x))[0] for x in range(5)], y, atol=1e-14)
    between = [made.sample(x)[0] for x in np.linspace(0, 4, 401)]
    assert np.ptp(between) <= 1.5 * np.ptp(y) + 1e-14


@pytest.mark.parametrize("kind", ["cubic", "linear"])
@pytest.mark.parametrize("y", [(0.0, 1e308, 0.0, 1.0), (0.0, 1e300, -1e300, 1.0)])
def test_table_too_steep_for_numbers(kind, y):
    """Coefficients that overflow are a message with the points, not infinite loads or an error of scipy."""
    with pytest.raises(ModelError, match=r"x from 0 to 1 with gaps from 1e-12, y from .*slopes"):
        table((0.0, 1e-12, 2e-12, 1.0), y, kind=kind).numbers()


def test_table_of_another_signal():
    """y = x^3 of x = 2 t: y = 8 t^3, y' = 24 t^2, y'' = 48 t (a cubic is reproduced exactly)."""
    x = np.linspace(0, 5, 6)
    found = table(x, x**3, of=expression("2*t")).sample(T)
    assert found == pytest.approx(np.column_stack([8 * T**3, 24 * T**2, 48 * T]), abs=1e-11)


def test_arithmetic():
    a, b = expression("t**2"), harmonic(amplitude=1.0, frequency=1.0)
    A, B = T**2, np.sin(2 * np.pi * T)
    for signal, values in (
        (a + b, A + B),
        (a - b, A - B),
        (a * b, A * B),
        (2 * a + 1, 2 * A + 1),
        (3 - a, 3 - A),
        (-a / 2, -A / 2),
        (a + b + a, 2 * A + B),
        (table([0, 2], [0, 1]) * table([0, 2], [1, 0]), T / 2 * (1 - T / 2)),
    ):
        assert signal.sample(T)[:, 0] == pytest.approx(values, abs=10 * MACHINE)
    assert isinstance(a + b, Sum)
    assert len((a + b + a).terms) == 3
    assert isinstance(a * b * a, Product)


def test_as_signal():
    assert isinstance(as_signal(3, "Joint 'A'", "angle"), Constant)
    assert as_signal(np.float64(3.0), "Joint 'A'", "angle").value == 3.0
    assert as_signal("= 2*t", "Joint 'A'", "angle").text == "2*t"
    r = ramp(rate=1.0)
    assert as_signal(r, "Joint 'A'", "angle") is r


@pytest.mark.parametrize("value", [None, True, float("nan"), [1.0]])
def test_what_is_no_signal(value):
    with pytest.raises(
        ModelError, match=r"Joint 'A': angle = .*a signal: a number, a sensor, ramp.*Write angle = fmb.ramp"
    ):
        as_signal(value, "Joint 'A'", "angle")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ramp(rate="fast"), "Signal ramp: rate = 'fast'. Expected: a finite number. Use SI units"),
        (lambda: ramp(rate=1.0, rise=-1.0), "Signal ramp: rise = -1.0. Expected: a duration >= 0 s. Correct rise"),
        (lambda: step(value=1.0, rise=-1.0), "Signal step: rise = -1.0. Expected: a duration >= 0 s. Correct rise"),
        (
            lambda: harmonic(amplitude=float("inf"), frequency=1.0),
            "Signal harmonic: amplitude = inf. Expected: a finite number",
        ),
        (lambda: table([0, 1], [0, 1, 2]), "Signal table: 2 values x and 3 values y. Expected: as many x as y"),
        (
            lambda: table([0, 1, 1], [0, 1, 2]),
            "Signal table: x goes from 1.0 to 1.0. Expected: increasing x. Sort the points",
        ),
        (lambda: table([0], [0]), "Signal table: x has the shape (1,). Expected: two or more finite numbers"),
        (lambda: table("ab", [0]), "Signal table: x has no list of numbers. Expected: two or more finite numbers"),
        (
            lambda: table([0, 1], [0, 1], kind="quintic"),
            "Signal table: kind = 'quintic'. Expected: 'cubic' or 'linear'",
        ),
        (lambda: table([0, 1], [0, 1], of=["t"]), "Signal table: of = ['t']. Expected: a signal"),
        (lambda: Expression(3), "Signal expression: text = 3. Expected: a formula between quotes"),
        (lambda: expression("a*t"), "Expression 'a*t': the name 'a' is unknown"),
        (
            lambda: ramp(rate=1.0) / 0,
            "Signal: a division by zero. Expected: a divisor other than 0. Correct the divisor",
        ),
        (lambda: ramp(rate=1.0) / ramp(rate=1.0), "Signal: divisor = Ramp("),
        (lambda: Sum("ab"), "Signal sum: terms = 'ab'. Expected: a list of signals. Write sum = [first, second]"),
        (lambda: Product(()), "Signal product: terms = (). Expected: a list of signals"),
    ],
)
def test_messages(make, message):
    with pytest.raises(ModelError) as caught:
        make()
    assert message in str(caught.value)


def test_pack_puts_programs_one_after_another():
    signals = [table([0, 1], [0, 1]), ramp(rate=1.0), table([0, 1, 2], [0, 1, 0]), Constant(2.0)]
    starts, ops, args, tables, table_starts = pack([s.program() for s in signals])
    assert starts.tolist() == [0, 2, 9, 11, 12]
    assert len(ops) == len(args) == 12
    assert table_starts.tolist() == [0, 7, 19]
    assert len(tables) == 19


def test_pack_of_nothing():
    starts, ops, _, tables, table_starts = pack([])
    assert (starts.tolist(), len(ops), len(tables), table_starts.tolist()) == ([0], 0, 0, [0])


def test_descriptions_are_frozen():
    with pytest.raises(AttributeError):
        Ramp(rate=1.0).rate = 2.0


def test_a_model_may_have_many_signals():
    """What one signal needs at once is limited, not how many signals there are."""
    programs = [Expression(f"{k} + t").program() for k in range(100)]
    starts, ops, args, _, _ = pack(programs)
    assert len(starts) == 101
    assert starts[-1] == len(ops) == len(args)
