"""Plots of sensors: what is drawn is what the sensors tell."""

import numpy as np
import pytest
from by_turns import slow
from matplotlib.figure import Figure
from results.spinning import observe, spinning_model, spinning_phase

import flexmb as fmb
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


def test_rounding_is_drawn_flat(tmp_path, monkeypatch):
    """Moments of 1e-11 N m beside a force of 98.1 N fill no panel; the force itself does."""
    along = {"x": fmb.Pose.axes((0, 0, 0), z=(1, 0, 0), x=(0, 1, 0))}
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(markers=along), fmb.RigidBody("b", mass=10.0, inertia=(1, 1, 1), markers=along)],
        joints=[fmb.Prismatic("slide", markers=("ground.x", "b.x"))],
        sensors=[fmb.Reaction("R", joint="slide")],
    )
    run = fmb.simulate(model, 1.0, samples=21)
    monkeypatch.setattr(Figure, "savefig", lambda self, path: figures.append(self))
    figures = []
    plot(run, None, tmp_path / "x.png")
    force, moment = figures[0].axes
    assert np.ptp(force.get_ylim()) == pytest.approx(98.1, rel=0.15)
    assert np.ptp(moment.get_ylim()) > 50.0 * np.abs(run["R"][:, 3:]).max()


@pytest.mark.parametrize("ending", ["png", slow("svg"), "pdf"])
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
