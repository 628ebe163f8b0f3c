"""Plots of sensors: what is drawn is what the sensors tell."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from results.spinning import observe, spinning_model, spinning_phase

from flexmb import sensors
from flexmb.errors import FlexmbError
from flexmb.results import Solution
from flexmb.view import plot


@pytest.fixture
def solution(monkeypatch):
    monkeypatch.setattr("flexmb.system.observe", observe, raising=False)
    model = spinning_model(
        [sensors.Position("tip", marker="rod.end"), sensors.Reaction("force", joint="weld"), sensors.Energy("E")]
    )
    return Solution(phases=(spinning_phase(model),))


def test_curves_are_the_sensors_values(solution, tmp_path, monkeypatch):
    """Columns of another unit go to an axis of their own."""
    figures = []
    monkeypatch.setattr(Figure, "savefig", lambda self, path: figures.append(self))
    plot(solution, ["tip", "force"], tmp_path / "x.png")
    tip, force, moment = figures[0].axes
    for k, line in enumerate(tip.lines):
        np.testing.assert_array_equal(line.get_xdata(), solution.t)
        np.testing.assert_array_equal(line.get_ydata(), solution["tip"][:, k])
    assert (tip.get_ylabel(), force.get_ylabel(), moment.get_ylabel()) == ("[m]", "[N]", "[N m]")
    np.testing.assert_array_equal(moment.lines[2].get_ydata(), solution["force"][:, 5])


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_all_sensors_in_any_format(solution, tmp_path, ending):
    path = plot(solution, None, tmp_path / "out" / f"x.{ending}")
    assert path.stat().st_size > 5000


def test_messages(solution, tmp_path):
    with pytest.raises(FlexmbError, match=r"sensor 'tipp' does not exist.*'tip'"):
        plot(solution, "tipp", tmp_path / "x.png")
    with pytest.raises(FlexmbError, match=r"the ending '.doc'.*\.pdf"):
        plot(solution, "tip", tmp_path / "x.doc")
    with pytest.raises(FlexmbError, match=r"there is no sensor to plot"):
        plot(Solution(phases=(spinning_phase(),)), None, tmp_path / "x.png")
