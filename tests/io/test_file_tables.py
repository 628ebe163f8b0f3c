"""Model files that take over from others: a base, shared data; parts that a parameter leaves out; lists."""

import warnings

import pytest

from flexmb import io
from flexmb.errors import ModelError, ValidityWarning
from flexmb.io.file_tables import flat_parameters
from flexmb.model.expression import evaluate, evaluate_values

DATA = """
title = "not read"
[flap]
span = 5.75
points = [1.0, 2.0, 4.0]
tube = { outer = 0.07, wall = 0.005 }
[[flap.tracks]]
y = 3.3
[[flap.tracks]]
y = 6.85
"""

BASE = """
parameters_from = [{ file = "data.toml", table = "flap" }]
[parameters]
rigid = true
mass = "= 2*span"
places = "= points + tracks_1_y"
[signals]
pull = 100.0
[[body]]
kind = "Ground"
markers = { A = ["= places[0]", 0, 0] }
[[body]]
if = "= rigid"
kind = "PointMass"
name = "ball"
mass = "= mass"
at = ["= places[0]", 0, 0]
[[body]]
unless = "= rigid"
kind = "RigidBody"
name = "ball"
mass = "= mass"
inertia = [1, 1, 1]
at = ["= places[0]", 0, 0]
[[force]]
kind = "PointLoad"
name = "pull"
marker = "ball.center"
force = ["= pull", 0, 0]
[simulation]
t_end = 1.0
samples = 11
"""

CASE = """
base = "base.toml"
[parameters]
mass = "= 3*span"
[signals]
pull = 50.0
[[sensor]]
kind = "Position"
name = "place"
marker = "ball.center"
[simulation]
t_end = 2.0
"""

WING = """
[parameters]
span = 2.0
rigid = false
[[assembly]]
file = "base.toml"
prefix = "a"
inherit = true
[[assembly]]
file = "base.toml"
prefix = "b"
"""


@pytest.fixture
def folder(tmp_path):
    for name, text in (("data", DATA), ("base", BASE), ("case", CASE), ("wing", WING)):
        (tmp_path / f"{name}.toml").write_text(text)
    return tmp_path


def test_shared_data_and_lists(folder):
    """Nested tables are flat names; a list is computed as a whole, and its elements are numbers."""
    model = io.load_model(folder / "base.toml")
    assert model.parameters["tube_outer"] == 0.07
    assert model.parameters["tracks_2_y"] == 6.85
    assert model.parameters["places"] == pytest.approx((4.3, 5.3, 7.3))
    assert model.body("ball").mass == 11.5
    assert model.body("ball").at[0] == pytest.approx(4.3)
    assert io.load_model(folder / "base.toml", {"span": 3.0}).body("ball").mass == 6.0


def test_base(folder):
    """A case has the parts of its base and its own; its values replace those of the base."""
    model = io.load_model(folder / "case.toml")
    assert [part.name for part in (*model.bodies, *model.forces, *model.sensors)] == [
        "ground",
        "ball",
        "pull",
        "place",
    ]
    assert model.body("ball").mass == 3 * 5.75
    assert model.force("pull").force[0].value == 50.0
    simulation = io.load_simulation(folder / "case.toml")
    assert simulation.t_end == 2.0
    assert simulation.samples == 11


def test_parts_that_are_left_out(folder):
    """`if` and `unless` choose parts by a parameter."""
    assert type(io.load_model(folder / "case.toml").body("ball")).__name__ == "PointMass"
    assert type(io.load_model(folder / "case.toml", {"rigid": False}).body("ball")).__name__ == "RigidBody"


def test_inherit(folder):
    """An assembly that inherits has the parameters of the file around it where it knows their names."""
    model = io.load_model(folder / "wing.toml")
    assert model.body("a_ball").mass == 4.0
    assert model.body("b_ball").mass == 11.5
    assert type(model.body("a_ball")).__name__ == "RigidBody"


def test_an_inherited_name_that_means_something_else(folder):
    """Two formulas of one name and different values are told; one formula, one value, a number, or a stated
    purpose is not."""
    wing = folder / "wing.toml"
    text = wing.read_text().replace("span = 2.0", 'span = 2.0\nmass = "= 300 + span"')
    wing.write_text(text)
    with pytest.warns(ValidityWarning, match=r"'mass' of base.toml the value 302.0 .* itself calculates 4.0 .*span"):
        assert io.load_model(wing).body("a_ball").mass == 302.0
    for old, new, mass in (
        ("300 + span", "2*span", 4.0),
        ("300 + span", "span + span", 4.0),
        ('"= 300 + span"', "302.0", 302.0),
        ("inherit = true", 'inherit = true\nparameters = { mass = "= mass" }', 302.0),
    ):
        wing.write_text(text.replace(old, new))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert io.load_model(wing).body("a_ball").mass == mass
            if "2*span" in new:  # set from outside, one formula in both files
                assert io.load_model(wing, {"mass": 7.0}).body("a_ball").mass == 7.0


def test_notes(folder):
    """A note is a warning where its condition holds, also from the base and from within an assembly."""
    base = folder / "base.toml"
    text = base.read_text()
    note = '\n[[note]]\nif = "= rigid"\ntext = "struts are 7 % low"\n'
    base.write_text(text + note)
    for file, parameters, told in (("base", {}, 1), ("base", {"rigid": False}, 0), ("case", {}, 1), ("wing", {}, 1)):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            io.load_model(folder / f"{file}.toml", parameters)
        assert [str(w.message).partition(": ")[2] for w in caught] == told * ["struts are 7 % low"]
    for old, new, message in (
        ('text = "struts', 'txt = "struts', "the field 'text' is missing"),
        ('text = "struts are 7 % low"', "text = 7", "text = 7"),
        ("\ntext", '\nkind = "Note"\ntext', "there is no field 'kind'"),
    ):
        base.write_text(text + note.replace(old, new))
        with pytest.raises(ModelError, match=message):
            io.load_model(base)


@pytest.mark.parametrize(
    ("file", "old", "new", "messages"),
    [
        ("case", '"base.toml"', '"../base.toml"', ("case.toml, base: base = '../base.toml'", "same folder")),
        ("case", '"base.toml"', '"case.toml"', ("form a circle: case.toml -> case.toml",)),
        ("case", '"base.toml"', '"bass.toml"', ("bass.toml': the file does not exist",)),
        ("base", '"data.toml"', '"date.toml"', ("date.toml': the file does not exist",)),
        (
            "base",
            'table = "flap"',
            'table = "flip"',
            ("data.toml has no table 'flip'", "Did you mean 'flap'?"),
        ),
        ("base", '{ file = "data.toml", table = "flap" }', "3", ("parameters_from: 3", "file and table")),
        ("base", 'if = "= rigid"', 'if = "yes"', ("'ball', if: 'yes'", "true, false or a number")),
        ("base", "points + tracks_1_y", "points + tracks", ("the name 'tracks' is unknown",)),
    ],
)
def test_messages(folder, file, old, new, messages):
    path = folder / f"{file}.toml"
    path.write_text(path.read_text().replace(old, new, 1))
    with pytest.raises(ModelError) as caught:
        io.load_model(folder / "case.toml")
    for message in messages:
        assert message in str(caught.value)


def test_lists_in_expressions():
    """Elements, also of lists of lists; arithmetic element by element; booleans as conditions."""
    known = {"x": (1.0, 2.0), "y": (3.0, 4.0), "z": ((1, 2), (3, 4)), "on": True, "w": (1.0, 2.0, 3.0)}
    assert evaluate("x[1] + z[1][0]", known) == 5.0
    assert evaluate_values("x*y + w[2]", known) == (6.0, 11.0)
    assert evaluate("where(on, 1, 2)", known) == 1.0
    assert evaluate("where(not on, 1, 2)", known) == 2.0
    for text, message in (
        ("x[2]", "x[2] of a list of 2"),
        ("x[on]", "something other than a whole number"),
        ("on[0]", "which is not a list"),
        ("q[0]", "which is not a list"),
        ("z[0]", "z[0] is (1, 2)"),
    ):
        with pytest.raises(ModelError, match=message.replace("[", r"\[").replace("(", r"\(").replace(")", r"\)")):
            evaluate(text, known)
    with pytest.raises(ModelError, match="lists of different length"):
        evaluate_values("x + w", known)


def test_flat_parameters():
    assert flat_parameters({"a": 1, "b": {"c": [1, 2], "d": {"e": "f"}}, "g": [{"h": 1}, {"h": 2}]}) == {
        "a": 1,
        "b_c": [1, 2],
        "b_d_e": "f",
        "g_1_h": 1,
        "g_2_h": 2,
    }
