"""Bounds of signals over cells of time hold what the signals are there: values, rates and second rates by jets."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.math.interval_jets import bounds
from flexmb.model.breakpoints import breakpoints
from flexmb.model.time_scale import entries, resolution

TEXTS = (
    "3*sin(7*t) - cos(t**2)/(2 + t)",
    "exp(-t)*tan(0.3*t) + sinh(t/3) - cosh(t - 1)*tanh(2*t)",
    "sqrt(1 + t)*log(2 + t) + atan(3*t - 4)",
    "asin(t/5) - acos(t/6) + (1 + t)**1.7 + (t - 2)**3 + (t - 1.5)**4 + (3 + t)**-2",
    "(1 + t)**sin(t) + atan2(sin(t), 2 + cos(t))",
    "abs(t - 1.1)*sign(t - 2) + smooth((t - 1)/2) - step(t - 3) + max(sin(3*t), min(t/4, 0.7))",
    "where(t**2 < 4 and not t < 1, t**3, where(sin(t) > 0.2, exp(t/3), 5))",
)
SIGNALS = (
    *(fmb.expression(text) for text in TEXTS),
    fmb.ramp(rate=2.0, rise=1.5, start=0.7),
    fmb.table([0.3, 1.0, 2.0, 3.1], [0.0, 1.0, -1.0, 2.0], of=fmb.expression("3*sin(t)**2")),
)


@pytest.mark.parametrize("signal", SIGNALS, ids=range(len(SIGNALS)))
def test_bounds_hold_the_signal(signal):
    rng = np.random.default_rng(5)
    program = signal.program()
    edges = breakpoints(program, 0.0, 4.0).pieces
    edges = np.unique(np.concatenate([edges, rng.uniform(0.0, 4.0, 40)]))
    a, b = edges[:-1], edges[1:]
    wide = b - a > 1e-6
    a, b = a[wide], b[wide]
    found = bounds(program.ops, program.args, program.tables, a, b, 0.5 * (a + b))
    for share in (1e-6, 0.2, 0.5, 0.9, 1.0 - 1e-6):
        jets = signal.sample(a + share * (b - a))
        for k, interval in enumerate((found.value, found.rate, found.second)):
            slack = 1e-9 * (1.0 + np.abs(jets[:, k]))
            assert np.all(interval[0] <= jets[:, k] + slack)
            assert np.all(interval[1] >= jets[:, k] - slack)
    # and they are sharp where cells are short
    t = np.linspace(0.05, 3.95, 60)
    t = t[np.min(np.abs(t[:, None] - breakpoints(program, 0.0, 4.0).pieces), axis=1) > 1e-3]
    found = bounds(program.ops, program.args, program.tables, t - 1e-7, t + 1e-7, t)
    for k, (lo, hi) in enumerate((found.value, found.rate, found.second)):
        assert np.all(hi - lo <= 1e-3 * (1.0 + np.abs(signal.sample(t)[:, k])))


def test_a_pulse_divides_time():
    """A Gaussian of 1 ms in 10 s: short cells over all of it, few in all; a steady oscillation: where it begins."""
    pulse = fmb.expression("1000*exp(-((t - 5)/1e-3)**2)").program()
    times, complete = resolution(pulse, np.array([0.0, 10.0]))
    near = times[np.abs(times - 5.0) < 2e-3]
    assert complete
    assert len(near) >= 5
    assert np.diff(near).max() < 2e-3
    assert np.diff(times[np.abs(times - 5.0) < 4e-3]).max() < 2e-3  # it is 1e-5 of its height at 3.4 ms
    assert len(times) < 150
    steady, _ = resolution(fmb.harmonic(1.0, 50.0).program(), np.array([0.0, 100.0]))
    assert steady.max() < 1.0
    assert not len(resolution(fmb.expression("3*t + 1").program(), np.array([0.0, 10.0]))[0][1:-1])


def test_entries_are_where_cells_become_finer():
    edges = np.concatenate([[0.0], 10.0 + 0.1 * np.arange(200), [40.0]])
    np.testing.assert_array_equal(entries(edges), edges[:141])
