"""Rate and second rate of every function and every kind of signal are the derivatives of its value.

Reference: sixth-order central differences of the value, in the mean of the domain where the function is smooth.
"""

import numpy as np
import pytest
from tolerances import MACHINE

from flexmb.math.operations import FUNCTIONS
from flexmb.model.input_signal import input
from flexmb.model.signal import Constant, Product, Sum, expression
from flexmb.model.simple_signals import harmonic, ramp, step
from flexmb.model.table_signal import SIGNALS, table

FIRST = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60.0
SECOND = np.array([2, -27, 270, -490, 270, -27, 2]) / 180.0

EXPRESSIONS = {
    "sin": "sin(2*t)",
    "cos": "cos(t**2)",
    "tan": "tan(t/2)",
    "asin": "asin(t/3)",
    "acos": "acos(t**2/5)",
    "atan": "atan(3*t)",
    "atan2": "atan2(sin(t), 2 + t)",
    "sinh": "sinh(t**2)",
    "cosh": "cosh(t)",
    "tanh": "tanh(t**2)",
    "exp": "exp(-t**2)",
    "log": "log(1 + t)",
    "sqrt": "sqrt(1 + t**3)",
    "abs": "abs(t - 9)*t**2",
    "min": "min(t**3, 9 + t)",
    "max": "max(t**3, t/9)",
    "sign": "sign(t - 9)*t**2",
    "step": "step(t - 0.1)*t**2",
    "smooth": "smooth(t/2 + t**2/20)",
    "where": "where(t > 0.2, t**3, 1/t)",
    "polynomial": "3*t**4 - t**2.5 + (2 - t)/(1 + t) - -t",
    "powers": "2**t + (1 + t)**sin(t)",
    "chained": "where(0 < t < 5 and not t > 6, exp(t), 1)",
}
KINDS = {
    "constant": Constant(2.0),
    "ramp": ramp(rate=3.0, rise=1.7, start=0.1),
    "step": step(value=2.0, initial=-1.0, at=0.1, rise=2.0),
    "harmonic": harmonic(amplitude=2.0, frequency=0.7, phase=0.2, offset=0.1),
    "table": table([0.0, 0.3, 2.0], [1.0, 4.0, 2.0], of=ramp(rate=0.5, rise=4.0)),
    "expression": expression("a*t**3", a=2.0),
    "input": input("torque", 2.0),
    "sum": Sum((ramp(rate=1.0, rise=2.0), expression("t**2"))),
    "product": Product((ramp(rate=1.0, rise=2.0), expression("t**2"), 3.0)),
}
SIGNAL_CASES = {
    **{name: expression(text) for name, text in EXPRESSIONS.items()},
    **{f"kind {name}": signal for name, signal in KINDS.items()},
}


@pytest.mark.parametrize("name", SIGNAL_CASES)
def test_rates_are_derivatives(name):
    signal, h = SIGNAL_CASES[name], 2e-2
    for t in (0.7, 1.1, 1.4):
        x = signal.sample(t + h * np.arange(-3, 4))[:, 0]
        value, rate, second = signal.sample(t)
        assert value == x[3]
        assert rate == pytest.approx(FIRST @ x / h, rel=1e-7, abs=1e-8)
        assert second == pytest.approx(SECOND @ x / h**2, rel=1e-6, abs=1e-7)


def test_every_function_and_kind_is_here():
    assert set(FUNCTIONS) <= set(EXPRESSIONS)
    assert set(SIGNALS) == set(KINDS)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("t**2", (0.0, 0.0, 2.0)),
        ("t**1", (0.0, 1.0, 0.0)),
        ("t**0", (1.0, 0.0, 0.0)),
        ("sqrt(0)*t", (0.0, 0.0, 0.0)),
        ("sqrt(where(t < 1, 0, t))", (0.0, 0.0, 0.0)),
        ("max(t, 0)", (0.0, 1.0, 0.0)),
        ("min(t, 0)", (0.0, 0.0, 0.0)),
        ("max(0, t**2)", (0.0, 0.0, 2.0)),
        ("step(t)", (1.0, 0.0, 0.0)),
    ],
)
def test_at_zero(text, found):
    """Where a naive chain rule gives 0 * inf, and at kinks: the derivative to the right."""
    assert tuple(expression(text).sample(0.0)) == found


def test_derivatives_are_exact():
    """f = exp(sin(t)^3): f' = 3 s^2 c f, f'' = (9 s^4 c^2 + 6 s c^2 - 3 s^3) f, without the error of differences."""
    t = np.linspace(-3.0, 3.0, 25)
    s, c = np.sin(t), np.cos(t)
    f = np.exp(s**3)
    exact = np.column_stack([f, 3 * s**2 * c * f, (9 * s**4 * c**2 + 6 * s * c**2 - 3 * s**3) * f])
    assert expression("exp(sin(t)**3)").sample(t) == pytest.approx(exact, rel=100 * MACHINE, abs=100 * MACHINE)
