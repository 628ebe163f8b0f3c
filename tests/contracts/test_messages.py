"""Every field of every registered kind is given values of a wrong kind: refused by a message in the words of the user.

A message names the part, and has nothing of Python's inside: no class of numpy, address, private name or `dtype`.
"""

import re
import warnings
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from contracts import every_kind
from contracts.every_kind import KINDS

import flexmb as fmb
from flexmb import fem, reduction, system
from flexmb.errors import FlexmbError
from flexmb.io import kind_lists

MESH = Path(__file__).parents[2] / "meshes" / "bracket_hex8.msh"

WRONG = (
    *(None, np.float64("nan"), np.int64(-1), "no such", (), np.full((2, 2), -1.0), object(), {"x": 1}),
    *(lambda x: x, ("ground.nowhere", "b.A")),
    *(10**400, 1e308, True, 1j, b"bytes", "\0", [[1, 2], [3]], {1: 2}, np.array("a"), np.array([None, 1], object)),
    *([object()], range(3), {1}, int),
)
INSIDE = re.compile(
    r"np\.\w+\(|numpy|dtype|NoneType|\barray\(| object at 0x|<class|<function|<lambda|(?<![\w'])_[a-z]\w+|<[\w.]+>"
)


@pytest.fixture(scope="module")
def data():
    fe = fem.solid(fem.read_mesh(MESH), fmb.MATERIALS["steel"])
    return reduction.reduce(fe, interfaces={"a": "foot", "b": "load"}, modes=2, loads={"push": "load"}, compare=0)


@pytest.fixture(scope="module")
def stage(data):
    return every_kind.stage(data)


def complaint(table, stage, kind, values) -> str:
    """Return the message about a part of these values in a model, or "" if it is taken."""
    try:
        part = kind(**values)
        if table == "body":
            fmb.Model(bodies=[*(body for body in stage.bodies if body.name != part.name), part])
        else:
            system.compile(stage.with_parts(**{kind_lists.FAMILIES[table]: [part]}))
    except FlexmbError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("turn", [0, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("table", "name"), KINDS)
def test_wrong_values(table, name, turn, stage, data):
    """Every second value for each field, and the others for the next one; the rest is a long test."""
    _, part = every_kind.model_with(table, name, stage, data)
    given = {f.name: getattr(part, f.name) for f in fields(part) if f.init}
    refused = 0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for k, field in enumerate(given):
            for value in WRONG[(k + turn) % 2 :: 2]:
                text = complaint(table, stage, type(part), {**given, field: value})
                refused += bool(text)
                assert not INSIDE.search(text), f"{field}: {text}"
                assert not text or field == "name" or f"'{part.name}'" in text, f"{field}: {text}"
    assert refused >= 3 * (len(given) - 1)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (np.float64(-1.5), "-1.5"),
        (np.array([[1, 2], [3, 4]], dtype=np.int32), "[[1, 2], [3, 4]]"),
        (np.zeros(3000), "[0., 0., 0., ..., 0., 0., 0.]"),
        ([np.float64(2.0), np.True_], "[2.0, True]"),
        (pytest, "<module 'pytest'"),
        (fmb.Revolute, "the class Revolute"),
        (len, "the function len"),
        (lambda: 0, "a lambda function"),
        (fmb.RigidBody.rod, "the function rod"),
        (object(), "an object of the class object"),
    ],
)
def test_values_in_words(value, words):
    assert words in str(FlexmbError("Body 'b'", found=f"mass = {value!r}", expected="a number", remedy="Give one"))
