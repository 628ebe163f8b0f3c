"""One vocabulary of sensors and columns, wherever a sensor is named."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.fmi.inside import output_names
from flexmb.model.sensor_columns import columns_named, sensor_columns, unknown
from flexmb.study.outputs import columns
from flexmb.view.diagrams import Diagram, of_one_unit

KNOWN = sensor_columns(
    {
        "tip": ("dx [m]", "dy [m]"),
        "lever": ("angle [rad]",),
        "law": ("law 1", "law 2"),
        "tip dy": ("distance [m]",),
        "a": ("x", "b c"),
        "a b": ("c", "c"),
        "pin": ("fx [N]", "mx [N m]", "my [N m]"),
    }
)


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("tip", [("tip", 0), ("tip", 1)]),
        ("tip dx", [("tip", 0)]),
        ("tip dx [m]", [("tip", 0)]),
        ("tip dy", [("tip dy", 0)]),  # a sensor goes before a column
        ("tip: dy", [("tip", 1)]),
        ("tip: dy [m]", [("tip", 1)]),
        ("tip dx [mm]", []),  # nothing is converted
        ("tip dx [ m ]", [("tip", 0)]),
        ("pin [N m]", [("pin", 1), ("pin", 2)]),
        ("tip dy distance", [("tip dy", 0)]),
        ("lever", [("lever", 0)]),
        ("lever angle", [("lever", 0)]),
        ("law 2", [("law", 1)]),
        ("law law 2", [("law", 1)]),
        ("tip dz", []),
        ("dx", []),
        ("", []),
    ],
)
def test_what_a_name_means(name, found):
    assert [(one.sensor, one.number) for one in columns_named(name, KNOWN)] == found


def test_what_is_offered():
    assert unknown("tip dz", KNOWN).expected == "One of: tip dx, tip: dy"
    wrong = unknown("tip dx [mm]", KNOWN)
    assert (wrong.found, wrong.remedy) == ("the unit [mm] of 'tip dx'", "Write 'tip dx'")
    assert wrong.expected.startswith("[m]:")
    assert unknown("leaver", KNOWN).remedy == "Did you mean 'lever'?"
    assert unknown("x", {}).expected == "a model with sensors"


def test_every_column_has_a_name_of_its_own():
    """What a list offers means the column it stands for: beside a sensor of the same name, twice the same title."""
    columns = [column for sensor in KNOWN.values() for column in sensor]
    assert all(columns_named(column.name, KNOWN) in ((column,), KNOWN[column.sensor]) for column in columns)
    assert len({column.name for column in columns}) == len({(column.sensor, column.number) for column in columns})
    assert [column.name for column in KNOWN["a b"]] == ["a b: c", "a b: column 1"]


def crane():
    """A mass on a spring along x, drawn out by 1 m."""
    ball = fmb.PointMass("ball", mass=1.0, at=(1.0, 0, 0))
    return fmb.Model(
        bodies=[fmb.Ground(markers={"o": (0, 0, 0), "far": (-1.0, 0, 0)}), ball],
        forces=[fmb.PointLoad("pull", marker="ball.center", force=(0, 0, 0))],
        sensors=[
            fmb.Position("ball place", marker="ball.center"),
            fmb.Distance("way", markers=("ground.far", "ball.center")),
        ],
    )


@pytest.mark.parametrize("name", ["ball place x", "ball place x [m]"])
def test_every_user_of_a_name_takes_it(name):
    """Solutions, diagrams, outputs of sweeps, plants, steppers: the same column."""
    model = crane()
    run = fmb.simulate(model, t_end=0.1, samples=3)
    assert np.array_equal(run[name], run["ball place"][:, 0])
    assert run.column_titles(name) == ("x [m]",)
    (line,), _, _ = Diagram(y=[name]).curves({"run": run})
    assert np.array_equal(line.y, run["ball place"][:, 0])
    assert columns([f"final({name})"], model)[0].value(run) == run["ball place"][-1, 0]
    assert fmb.linearize(model, inputs="pull.force.x", outputs=name).outputs == ("ball place x",)
    with fmb.stepper(model, t_end=0.1) as steps:
        assert steps[name] == steps["ball place"][0]
        assert steps["way distance"] == steps["way"]


def test_whole_sensors_in_diagrams():
    """All columns of a sensor; those of one unit together, and those that are zero left out."""
    run = fmb.simulate(crane(), t_end=0.1, samples=3)
    lines, _, _ = Diagram(y=["ball place"]).curves({"run": run})
    assert [line.label for line in lines] == ["ball place x", "ball place y", "ball place z"]
    assert of_one_unit({"run": run}) == [["ball place x"], ["way"]]
    assert of_one_unit({"run": run}, ["ball place y", "way"]) == [["ball place y", "way"]]


def test_a_sensor_with_the_name_of_a_column():
    """Diagrams drew the sensor "ball place x" as a column of "ball place", units for FMI lost the column."""
    plain = crane()
    other = fmb.Distance("ball place x", markers=("ground.far", "ball.center"))
    model = fmb.Model(bodies=plain.bodies, forces=plain.forces, sensors=[*plain.sensors, other])
    run = fmb.simulate(model, t_end=0.1, samples=3)
    lines, _, _ = Diagram(y=["ball place"]).curves({"run": run})
    assert np.array_equal(lines[0].y, run["ball place"][:, 0])
    assert np.array_equal(run["ball place: x"], run["ball place"][:, 0])
    assert run["ball place x"][0] == pytest.approx(2.0)
    assert len(columns(None, model)) == 3 * 5
    outputs = output_names(model)
    assert outputs["ball.place.x"] == ("ball place x", 0, "m")
    assert outputs["'ball place: x'"] == ("ball place", 0, "m")
    names = fmb.linearize(model, inputs="pull.force.x").outputs
    assert len(set(names)) == 5
    with fmb.stepper(model, t_end=0.1) as steps:
        assert steps["ball place: x"] == 1.0
        assert steps["ball place x"] == pytest.approx(2.0)


def test_units_in_names():
    """Another unit is refused, and of a sensor with several columns it names those of this unit."""
    plain = crane()
    load = fmb.ForceOf("load", force="pull")
    run = fmb.simulate(
        fmb.Model(bodies=plain.bodies, forces=plain.forces, sensors=[*plain.sensors, load]), t_end=0.1, samples=3
    )
    assert run["load [N]"].shape == (3, 3)
    assert run.column_titles("load [N]") == ("fx [N]", "fy [N]", "fz [N]")
    with pytest.raises(fmb.errors.FlexmbError, match=r"Write 'ball place x', which has \[m\]"):
        run["ball place x [mm]"]
    with pytest.raises(fmb.errors.ModelError, match=r"the unit \[mm\] of 'ball place x'"):
        columns(["max(ball place x [mm])"], run.model)
    _, label, _ = Diagram(y=["ball place x [m]"]).curves({"run": run})
    assert label == "ball place x [m]"


def test_a_constraint_reads_columns():
    """A bob at a wire x^2 + z^2 = 1 m^2, by two columns and by the vector."""
    bob = fmb.PointMass("bob", mass=1.0, at=(1.0, 0, 0))
    place = fmb.Position("bob place", marker="bob.center")

    def motion(over, equation):
        law = fmb.Constraint("wire", over=over, equation=equation)
        model = fmb.Model(bodies=[fmb.Ground(), bob], joints=[law], sensors=[place], gravity=(0, 0, -9.81))
        return fmb.simulate(model, t_end=0.2, samples=5)["bob place"]

    by_columns = motion({"x": "bob place x", "z": "bob place z [m]"}, "x**2 + z**2 = 1")
    assert np.abs(by_columns[:, 2]).max() > 0.1
    assert np.allclose(by_columns, motion({"p": "bob place"}, "p[0]**2 + p[2]**2 = 1"), rtol=0, atol=1e-12)
    with pytest.raises(fmb.errors.ModelError, match="sensor 'bob place q' does not exist"):
        motion({"x": "bob place q"}, "x = 1")


def test_an_event_and_a_measurement_take_columns():
    """The spring that follows "ball place x" moves the ball as x = cos(10 t): it passes 0 at t = pi/20."""
    model = crane()
    spring = fmb.PointLoad("pull", marker="ball.center", force=(-100.0 * fmb.measured("ball place x"), 0, 0))
    stop = fmb.Event("through", sensor="ball place x", below=0.0, then=fmb.Stop())
    run = fmb.simulate(
        fmb.Model(bodies=model.bodies, forces=[spring], sensors=model.sensors, events=[stop]),
        t_end=1.0,
        samples=101,
        integrator=fmb.GeneralizedAlpha(rtol=1e-8),
    )
    assert run.t[-1] == pytest.approx(np.pi / 20.0, rel=1e-5)
    with pytest.raises(fmb.errors.ModelError, match=r"column = 2 of sensor 'ball place x'"):
        fmb.Event("e", sensor="ball place x", below=0.0, column=2, then=fmb.Stop()).check(model)


def test_a_sensor_with_the_name_of_its_own_column():
    """A position called "x" has the columns "x x", "x y", "x z"; a distance called so is "x"."""
    names = [column.name for column in sensor_columns({"x": ("x [m]", "y [m]", "z [m]")})["x"]]
    assert names == ["x x", "x y", "x z"]
    (only,) = sensor_columns({"x": ("x [m]",)})["x"]
    assert only.name == "x"
