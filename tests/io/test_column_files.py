"""Tables from text files: what recorders and spreadsheets write, and what is refused."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import FlexmbError, ModelError
from flexmb.io import read_columns

T, F = [0.0, 0.5, 2.0], [1.0, -3.0, 4e3]
FORMS = {
    "commas": "0,1\n0.5,-3\n2,4e3\n",
    "titles": "t,F\n0,1\n0.5,-3\n2,4e3\n",
    "units": 't [s];"F [N]"\n0;1\n0.5;-3\n2;4e3\n',
    "tabs": "t\tF\n0\t1\n0.5\t-3\n2\t4e3\n",
    "blanks": "  0   1\n 0.5  -3\n\n 2 4e3",
    "comments": "# recorded\n# t, F\n0, 1\n# a pause\n0.5, -3\n2, 4e3\n",
    "mark of a spreadsheet": "\ufefft,F\r\n0,1\r\n0.5,-3\r\n2,4e3\r\n",
    "separator behind": "t;F;\n0;1;\n0.5;-3;\n2;4e3;\n",
}


@pytest.mark.parametrize("form", FORMS)
def test_forms(tmp_path, form):
    path = tmp_path / "load.csv"
    path.write_text(FORMS[form], encoding="utf-8")
    columns = [[0, 1], ["t", "F"]] if "F" in FORMS[form] and form != "comments" else [[0, 1]]
    for asked in columns:
        t, f = read_columns(path, asked)
        np.testing.assert_array_equal(t, T)
        np.testing.assert_array_equal(f, F)


@pytest.mark.parametrize(
    ("text", "columns", "told"),
    [
        ("", (0, 1), "0 rows of numbers"),
        ("t,F\n", (0, 1), "0 rows of numbers"),
        ("0,1\n1,nan\n", (0, 1), "line 2 has 'nan'. Expected: finite numbers"),
        ("t;F\n0;1\n0,5;2\n", (0, 1), "line 3 has '0,5'. Expected: numbers with decimal points"),
        ("0,1\n1\n", (0, 1), "line 2 has another number of fields than the 2 of the first row"),
        ("0,1\n1,two\n", (0, 1), "line 2 has 'two'"),
        ("t,force\n0,1\n", ("t", "forse"), "Did you mean 'force'?"),
        ("0,1\n1,2\n", ("t", "F"), "a line of titles, or numbers of columns"),
        ("0,1\n1,2\n", (0, 2), "a number from 0 to 1"),
        ("t,F,F\n0,1,2\n", ("t", "F"), "several columns 'F'"),
    ],
)
def test_what_is_refused(tmp_path, text, columns, told):
    path = tmp_path / "load.csv"
    path.write_text(text)
    with pytest.raises(ModelError) as error:
        read_columns(path, columns)
    assert told in str(error.value)


MODEL = """
[[body]]
kind = "Ground"
[[body]]
kind = "PointMass"
name = "mass"
mass = 2.0
[[force]]
kind = "PointLoad"
name = "load"
marker = "mass.center"
force = [{ table = { file = "data/load.csv", columns = ["t", "F"], kind = "linear" } }, 0, 0]
[[sensor]]
kind = "Velocity"
name = "v"
marker = "mass.center"
"""


def test_a_load_that_was_measured(tmp_path):
    """m v is the area below the polygon; the file is sought beside the model file, and the saved model needs none."""
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "load.csv").write_text("t [s],F [N]\n0,0\n1,6\n3,6\n")
    (tmp_path / "m.toml").write_text(MODEL)
    model = fmb.load_model(tmp_path / "m.toml")
    solution = fmb.simulate(model, 3.0, samples=4)
    assert 2.0 * solution["v"][:, 0] == pytest.approx([0.0, 3.0, 9.0, 15.0], abs=1e-6)
    (tmp_path / "elsewhere").mkdir()
    fmb.save_model(model, tmp_path / "elsewhere" / "m.toml")
    again = fmb.load_model(tmp_path / "elsewhere" / "m.toml")
    assert fmb.simulate(again, 3.0, samples=4)["v"] == pytest.approx(solution["v"])


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("load.csv", "lod.csv"), "Table file '.*lod.csv': no such file"),
        (('["t", "F"]', '["t"]'), "the two columns of x and y"),
        (('kind = "linear"', "x = [0, 1]"), r"m.toml, \[\[force\]\] 'load', force, table: .*and x"),
    ],
)
def test_messages_of_model_files(tmp_path, change, told):
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "load.csv").write_text("t,F\n0,0\n1,6\n")
    (tmp_path / "m.toml").write_text(MODEL.replace(*change))
    with pytest.raises(FlexmbError, match=told):
        fmb.load_model(tmp_path / "m.toml")


def test_times_that_go_back_are_refused(tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "load.csv").write_text("t,F\n0,0\n2,6\n1,6\n")
    (tmp_path / "m.toml").write_text(MODEL)
    with pytest.raises(FlexmbError, match=r"x goes from 2\.0 to 1\.0"):
        fmb.load_model(tmp_path / "m.toml")
