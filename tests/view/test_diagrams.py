"""Diagrams: sensors over others, of several runs on one scale, divided by a value.

Reference: free fall with wind, x = (4 N/m s) t^3/(6 m), z = -g t^2/2: known at every sample.
"""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import view
from flexmb.errors import FlexmbError
from flexmb.view.diagrams import as_diagram, laid_out


def fall(g):
    stone = fmb.PointMass("stone", mass=2.0)
    wind = fmb.PointLoad("wind", marker="stone.center", force=(fmb.expression("4*t"), 0, 0))
    sensors = [fmb.Position("place", marker="stone.center"), fmb.Velocity("speed", marker="stone.center")]
    model = fmb.Model(gravity=(0, 0, -g), bodies=[fmb.Ground(), stone], forces=[wind], sensors=sensors)
    return fmb.simulate(model, t_end=1.0, samples=11, integrator=fmb.GeneralizedAlpha(rtol=1e-9))


@pytest.fixture(scope="module")
def runs():
    return {"earth": fall(9.81), "moon": fall(1.62)}


def test_over_another_sensor(runs):
    """The path of the stone, z over x, of both runs, in one unit."""
    lines, y, x = as_diagram("place z over place x").curves(runs)
    assert [line.label for line in lines] == ["earth", "moon"]
    assert (y, x) == ("place z [m]", "place x [m]")
    t = runs["earth"].t
    for line, g in zip(lines, (9.81, 1.62)):
        assert np.allclose(line.x, 4.0 * t**3 / 12.0, atol=1e-5)
        assert np.allclose(line.y, -g * t**2 / 2.0, atol=1e-5)


def test_divided_by_a_value_of_the_first_run(runs):
    """All curves are divided by the same number, that of the first run at the time."""
    diagram = as_diagram("fall = place z / place z at 0.5")
    lines, y, _ = diagram.curves(runs)
    assert diagram.title == "fall"
    assert y == "place z / place z at 0.5"
    assert lines[0].y[5] == pytest.approx(1.0, abs=1e-6)
    assert lines[1].y[5] == pytest.approx(1.62 / 9.81, abs=1e-5)
    assert as_diagram("place x / 2").curves(runs)[0][0].y[-1] == pytest.approx(1.0 / 6.0, abs=1e-4)


def test_drawn_and_reported(runs, tmp_path):
    from matplotlib.image import imread

    path = view.draw_diagrams(runs, ["place z over place x", "place x, place z"], tmp_path / "two.png", columns=2)
    assert imread(path).shape[:2] == (510, 1800)  # 150 dpi
    page = view.report(runs, tmp_path / "r.html", pictures=False, diagrams=["path = place z over place x"]).read_text()
    assert "<h2>Diagrams</h2>" in page
    assert "place x [m]" in page


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("place zz", "Did you mean 'place z'"),
        ("place z over place", "has 3 columns.*place x, place y, place z"),
        ("place z over plac x", "Did you mean 'place x'"),
        ("place z, speed vz", "ordinates in m and m/s"),
        ("place z / 0", "a divisor"),
        ("place z / place z at noon", "SENSOR at TIME"),
    ],
)
def test_messages(runs, text, message):
    with pytest.raises(FlexmbError, match=message):
        as_diagram(text).curves(runs)


def test_runs_and_ranges(runs):
    """A diagram of one run; two diagrams on one scale: -g/2 = -4.905 m is the lowest of both, the margin 4 %."""
    first = view.Diagram(y=["place z"], of=["moon"], scale="fall")
    second = view.Diagram(y=["place z"], of=["earth"], scale="fall")
    made = laid_out(runs, [first, second, "place x"])
    assert [len(entry.lines) for entry in made] == [1, 1, 2]
    assert made[0].ordinates == made[1].ordinates == pytest.approx((-4.905 * 1.04, 4.905 * 0.04), rel=1e-6)
    assert made[2].ordinates is None
    half = view.Diagram(y=["place z"], of=["earth"], scale="fall", limits=(0.0, 0.5))
    assert laid_out(runs, [half])[0].ordinates[0] == pytest.approx(-9.81 / 8 * 1.04, rel=1e-5)
    with pytest.raises(FlexmbError, match=r"no run 'mars'.*earth, moon"):
        view.Diagram(y=["place z"], of=["mars"]).curves(runs)


def test_over_the_last_value(runs):
    """z and speed of both, each over its own last value: t^2 and t, whatever g is and whatever the unit."""
    lines, y, _ = as_diagram("place z, speed vz / final").curves(runs)
    t = runs["earth"].t
    assert len(lines) == 4
    assert y == "/ its last value"
    for line in lines:
        assert np.allclose(line.y, t**2 if "place" in line.label else t, atol=1e-6)
    with pytest.raises(FlexmbError, match="ends with 0"):
        as_diagram("place y / final").curves(runs)


def test_the_report_shows_the_range_asked_for(runs, tmp_path):
    """Ticks up to 0.5 s only; limits were not looked at in the page."""
    half = view.Diagram(y=["place z"], of=["earth"], limits=(0.0, 0.05), title="beginning")
    page = view.report(runs, tmp_path / "r.html", pictures=False, diagrams=[half]).read_text()
    figure = page[page.index("<h2>Diagrams</h2>") : page.index("<h2>Curves</h2>")]
    assert "0.05<" in figure
    assert "1.0<" not in figure


@pytest.mark.parametrize(("force", "dashes"), [(0.0, ["-", "--", "-"]), (9.0, ["-", "-", "-"])])
def test_a_curve_on_another_is_dashed(force, dashes):
    """Two stones fall alike, and would be one curve; with a force on the second they do not."""
    stones = [fmb.PointMass(name, mass=2.0) for name in "ab"]
    lift = fmb.PointLoad("lift", marker="b.center", force=(0, 0, force))
    sensors = [fmb.Position(name, marker=f"{name}.center") for name in "ab"]
    model = fmb.Model(gravity=(0, 0, -9.81), bodies=[fmb.Ground(), *stones], forces=[lift], sensors=sensors)
    run = fmb.simulate(model, t_end=1.0, samples=11)
    lines, *_ = as_diagram("a z, b z, a x").curves({"fall": run})
    assert [line.dash for line in lines] == dashes
