"""Axes: rounding is flat, what is more is not, and no factor stands where a legend is."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from flexmb.view.curves import Line, svg_curves
from flexmb.view.ranges import factors_in_labels, least_range, widen
from flexmb.view.stage import bar

T = np.linspace(0.0, 1.0, 50)


def drawn(values, least=0.0):
    figure = Figure(layout="constrained")
    FigureCanvasAgg(figure)
    ax = figure.subplots()
    ax.plot(T, values)
    ax.set_ylabel("[N]")
    widen(ax, least)
    factors_in_labels(figure)
    return ax


@pytest.mark.parametrize(
    ("unit", "largest", "length", "least"),
    [
        ("N", 2000.0, 5.0, 2e-3),
        ("kN m", 8.0, 5.0, 8e-6),
        ("m", 2.8e-4, 4.0, 4e-12),
        ("mm", 0.28, 4.0, 4e-9),
        ("m", 7e6, 0.0, 7e-2),
        ("rad", 1.0, 4.0, 1e-8),
    ],
)
def test_what_is_rounding(unit, largest, length, least):
    """Forces have a zero of their own; a motion of a centimetre far from the origin is none."""
    assert least_range(unit, largest, length) == pytest.approx(least, rel=1e-12)


def test_a_constant_reaction_is_a_line():
    """2000 N with noise of 1e-9 N: within a thousandth of the axis; a ripple of 1 N fills it."""
    noise = 1e-9 * np.sin(40.0 * T)
    low, high = drawn(2000.0 + noise, least_range("N", 2000.0)).get_ylim()
    assert high - low > 1e3 * np.ptp(noise)
    low, high = drawn(2000.0 + 1e9 * noise, least_range("N", 2000.0)).get_ylim()
    assert high - low == pytest.approx(2.0, rel=0.15)


@pytest.mark.parametrize(
    ("values", "label"),
    [
        (1e-5 * T, "[N] (x 1e-5)"),
        (1e5 + 1e-3 * T, "[N] (+ 1e5)"),
        (-2.5e-4 - 1e-13 * (T - 0.5), "[N] (x 1e-13 - 2.5e-4)"),
        (T, "[N]"),
    ],
)
def test_factors_stand_in_the_label(values, label):
    ax = drawn(values)
    assert ax.get_ylabel() == label
    assert not (ax.yaxis.get_offset_text().get_visible() and ax.yaxis.get_offset_text().get_text())


def test_pages_too():
    """The tick labels of a report: one value for a constant force, the factor in the label."""
    page = svg_curves([Line("", T, 2e-7 * T, "#000000")], y_label="[N]")
    assert "[N] (x 1e-7)" in page
    flat = svg_curves([Line("", T, 2000.0 + 1e-9 * np.sin(40.0 * T), "#000000")], y_label="[N]")
    assert "1e-10" not in flat
    assert "1e-9" not in flat


@pytest.mark.parametrize(
    ("largest", "written"),
    [(6.001, ["1.5", "3", "4.5", "6"]), (4567.0, ["1142", "2284", "3425", "4567"]), (1.2e-4, ["3e-05", "0.00012"])],
)
def test_numbers_of_colour_bars(largest, written):
    """Three digits, or all before the point: "6.001" said no more than 6."""
    form = bar("stress [MPa]", largest, (1600, 900))["fmt"]
    parts = np.linspace(0.0, largest, 5)[1:]
    assert [form % x for x in (parts if len(written) == 4 else parts[[0, 3]])] == written
