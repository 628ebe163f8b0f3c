"""Whole numbers that arithmetic made floats: where a description or a number of modes takes 8, it takes 8.0.

8.5 is refused by the name of the field. Parameters of model files are floats as soon as they are computed, swept or
given by --set. Looked at: every field of every description, and the numbers of modes of the functions of `fem` and
`reduction`. Node numbers are not among them: floats are coordinates.
"""

import warnings
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np
import pytest
from contracts import every_kind
from contracts.every_description import DESCRIPTIONS, changed
from contracts.every_kind import KINDS
from contracts.test_messages import complaint
from contracts.test_wrong_descriptions import SLOW

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import FlexmbError

MESH = Path(__file__).parents[2] / "meshes" / "bracket_hex8.msh"
NODES = {"where", "nodes"}
"""Lists of node numbers are told from the coordinates of a point by their type, and stay apart."""


def with_floats(value):
    """Return a value whose whole numbers are floats, also those in lists."""
    if isinstance(value, list | tuple) and type(value) in (list, tuple):
        return type(value)(map(with_floats, value))
    return float(value) if type(value) is int else value


def has_counts(value) -> bool:
    if isinstance(value, list | tuple):
        return any(map(has_counts, value))
    return type(value) is int


def counts(kind: type) -> set[str]:
    """Return the fields of a kind whose annotation is one whole number."""
    return {f.name for f in fields(kind) if f.init and f.type in ("int", "int | None")} if is_dataclass(kind) else set()


@pytest.fixture(scope="module")
def data():
    fe = fem.solid(fem.read_mesh(MESH), fmb.MATERIALS["steel"])
    return reduction.reduce(fe, interfaces={"a": "foot", "b": "load"}, modes=2, loads={"push": "load"}, compare=0)


@pytest.fixture(scope="module")
def stage(data):
    return every_kind.stage(data)


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow if n in SLOW else ()) for n in DESCRIPTIONS])
def test_descriptions(name, tmp_path, monkeypatch):
    monkeypatch.setenv("FLEXMB_BODIES", str(tmp_path))
    description = DESCRIPTIONS[name]
    made = description.make(**description.fields)
    own = counts(type(made))
    for field, value in description.fields.items():
        if has_counts(value) and field not in NODES:
            other = description.make(**changed(description, field, with_floats(value)))
            description.use(other)
            if field in own:
                assert type(getattr(other, field)) is int
                assert getattr(other, field) == getattr(made, field)
    for field in own & set(description.fields):
        with pytest.raises(FlexmbError, match=rf"{field} = 8\.5"):
            description.make(**changed(description, field, 8.5))


def test_counts_of_a_part():
    part = DESCRIPTIONS["parts.Part"].fields
    for field in ("modes", "compare"):
        assert type(getattr(fmb.parts.Part(**{**part, field: np.float64(8.0)}), field)) is int
        with pytest.raises(FlexmbError, match=rf"Part 'part': {field} = 8\.5"):
            fmb.parts.Part(**{**part, field: 8.5})


@pytest.mark.parametrize(("table", "name"), KINDS)
def test_parts_of_models(table, name, stage, data):
    _, part = every_kind.model_with(table, name, stage, data)
    given = {f.name: getattr(part, f.name) for f in fields(part) if f.init}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for field, value in given.items():
            if has_counts(value):
                told = [complaint(table, stage, type(part), {**given, field: v}) for v in (value, with_floats(value))]
                assert told[0] == told[1]
        for field in counts(type(part)):
            with pytest.raises(FlexmbError, match=rf"'{part.name}'.*{field} = 8\.5"):
                type(part)(**{**given, field: 8.5})


@pytest.fixture(scope="module")
def rod():
    points = np.linspace((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), 5)
    return fem.frame(points=points, section=fem.Section.rectangle(0.02, 0.02), material=fmb.MATERIALS["steel"])


def buckled(fe, n):
    load = np.zeros((len(fe.nodes), 6, 1))
    load[-1, 0] = -1.0
    return fem.buckling(fe, fe.forces(load)[:, 0], "start", n)[0]


MODES = {
    "eigenmodes": lambda fe, n: fem.eigenmodes(fe, "start", n).frequencies,
    "buckling": buckled,
    "modes of reduce": lambda fe, n: reduction.reduce(fe, {"a": "start"}, modes=n, compare=0).frequencies,
    "compare of reduce": lambda fe, n: reduction.reduce(fe, {"a": "start"}, modes=1, compare=n).quality["frequencies"],
}


@pytest.mark.parametrize("function", MODES.values(), ids=MODES.keys())
def test_numbers_of_modes(rod, function):
    for n in (2.0, np.float64(2.0), np.int64(2)):
        assert str(function(rod, n)) == str(function(rod, 2))
    for wrong in (2.5, True, "two", None, -1.0):
        with pytest.raises(FlexmbError, match=r"(n|modes|compare) = |-1 \w+"):
            function(rod, wrong)


def test_elements_of_a_plate_as_an_array():
    """The number of elements along a cylinder's two directions; `rectangle` and the plate itself take the same."""
    stuff = {"thickness": 0.01, "material": fmb.MATERIALS["steel"]}
    for elements in (np.array([3, 2]), np.array([3.0, 2.0]), [3.0, 2], (3, 2)):
        cylinder = fmb.AncfPlate.cylinder("c", radius=1.0, angle=1.0, length=2.0, elements=elements, **stuff)
        assert (
            cylinder.elements
            == fmb.AncfPlate.rectangle("r", edges=(2, 1), elements=elements, **stuff).elements
            == (3, 2)
        )
    with pytest.raises(FlexmbError, match=r"elements = \[3. , 2.5\]"):
        fmb.AncfPlate.cylinder("c", radius=1.0, angle=1.0, length=2.0, elements=np.array([3.0, 2.5]), **stuff)
