"""Plans: which values the parameters take."""

import numpy as np
import pytest

from flexmb import study
from flexmb.errors import ModelError


def test_a_grid_has_every_combination():
    plan = study.grid({"a": [1, 2], "b": np.array([0.1, 0.2, 0.3])})
    assert plan.names == ("a", "b")
    assert plan.rows == ((1, 0.1), (1, 0.2), (1, 0.3), (2, 0.1), (2, 0.2), (2, 0.3))
    assert plan.variant(4) == {"a": 2, "b": 0.2}
    assert all(type(value) in (int, float) for row in plan.rows for value in row)


def test_a_latin_hypercube_has_one_value_in_every_slice():
    """McKay, Beckman, Conover (1979): with n samples, each of n equal slices of each range holds one."""
    plan = study.latin_hypercube({"a": (0.0, 1.0), "b": (-3e3, 5e3)}, 40, seed=7)
    values = np.array(plan.rows)
    for column, (low, high) in zip(values.T, ((0.0, 1.0), (-3e3, 5e3))):
        slices = np.floor((column - low) / (high - low) * 40).astype(int)
        assert sorted(slices) == list(range(40))
    assert study.latin_hypercube({"a": (0.0, 1.0), "b": (-3e3, 5e3)}, 40, seed=7) == plan
    assert study.latin_hypercube({"a": (0.0, 1.0), "b": (-3e3, 5e3)}, 40, seed=8) != plan


def test_lists(tmp_path):
    plan = study.listed([{"a": 1.0, "lever": "x.h5"}, {"lever": "y.h5", "a": 2.0}])
    assert plan.rows == ((1.0, "x.h5"), (2.0, "y.h5"))
    path = tmp_path / "plan.csv"
    path.write_text("angle, lever\n180*deg, x.h5\n\n0.5, y.h5\n")
    plan = study.read_plan(path)
    assert plan.names == ("angle", "lever")
    assert plan.rows == ((np.pi, "x.h5"), (0.5, "y.h5"))


def test_ranges_have_both_ends():
    assert study.range_values("a", 1.0, 2.0, 3) == [1.0, 1.5, 2.0]
    assert study.range_values("a", 2.0, 2.0, 1) == [2.0]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: study.grid({}), r"Plan: it has no parameter\. .*--over pressure=4e3:6e3:5"),
        (lambda: study.grid({"a": []}), r"Plan, a: the list of values is empty.*Write a=1,2,3"),
        (lambda: study.grid({"a": 3.0}), r"Plan, a: 3\.0\. Expected: a list of values.*Write \[4e3, 5e3\]"),
        (lambda: study.grid({"a": "abc"}), r"Plan, a: 'abc'"),
        (lambda: study.grid({"a": [1.0, float("nan")]}), r"Plan, row 2, a: nan\. Expected: a finite number"),
        (lambda: study.grid({"a": [None]}), r"Plan, row 1, a: None"),
        (lambda: study.Plan(("a", "a"), ((1, 2),)), r"Plan, a: the parameter is given twice"),
        (lambda: study.Plan(("a", "b"), ((1, 2), (3,))), r"Plan, row 2: 1 values\. Expected: 2: a, b"),
        (lambda: study.listed([]), r"Plan: it has no parameter"),
        (
            lambda: study.listed([{"a": 1}, {"b": 1}]),
            r"Plan, row 2: it has b\. Expected: the parameters of the first row: a",
        ),
        (lambda: study.latin_hypercube({"a": (2.0, 1.0)}, 5), r"Range of 'a': \(2\.0, 1\.0\).*the lower one first"),
        (lambda: study.latin_hypercube({"a": (1.0, "x")}, 5), r"Range of 'a'"),
        (lambda: study.latin_hypercube({"a": (1.0, 2.0)}, 0), r"Latin hypercube: samples = 0.*--latin 50"),
        (lambda: study.latin_hypercube({}, 3), r"Plan: it has no parameter"),
        (lambda: study.range_values("a", 1.0, 1.0, 3), r"Range of 'a': start 1\.0, stop 1\.0, count 3.*a=3e3:6e3:7"),
        (lambda: study.range_values("a", 1.0, 2.0, 2.5), r"count 2\.5"),
        (lambda: study.range_values("a", 1.0, 2.0, 0), r"count 0"),
    ],
)
def test_plans_that_cannot_be(make, message):
    with pytest.raises(ModelError, match=message):
        make()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, r"Plan '.*plan\.csv': it cannot be read .*Correct the path"),
        ("a,b\n", r"Plan '.*': 1 lines\. Expected: a line with the names and at least one with values"),
        ("a,b\n1,2\n1,\n", r"Plan '.*', line 3: 1 values\. Expected: 2: a, b"),
    ],
)
def test_files_that_are_no_plan(tmp_path, text, message):
    path = tmp_path / "plan.csv"
    if text is not None:
        path.write_text(text)
    with pytest.raises(ModelError, match=message):
        study.read_plan(path)
