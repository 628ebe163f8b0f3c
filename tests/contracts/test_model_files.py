"""Every registered kind survives a model file: written as TOML and read back, all its fields are the same."""

from pathlib import Path

import pytest
from contracts import every_kind
from contracts.every_kind import KINDS

import flexmb as fmb
from flexmb import fem, io, reduction
from flexmb.io import kind_lists
from flexmb.io.field_values import same

MESH = Path(__file__).parents[2] / "meshes" / "bracket_hex8.msh"


@pytest.fixture(scope="module")
def data():
    fe = fem.solid(fem.read_mesh(MESH), fmb.MATERIALS["steel"])
    return reduction.reduce(fe, interfaces={"a": "foot", "b": "load"}, modes=2, loads={"push": "load"}, compare=0)


@pytest.fixture(scope="module")
def stage(data):
    return every_kind.stage(data)


@pytest.mark.parametrize(("table", "name"), KINDS)
def test_round_trip(table, name, stage, data):
    model, part = every_kind.model_with(table, name, stage, data)
    text = io.model_text(model)
    bodies = {b.name: b.data for b in model.bodies if hasattr(b, "data")}
    twin = next(p for p in getattr(io.read_model_text(text, bodies), kind_lists.FAMILIES[table]) if p.name == part.name)
    assert type(twin) is type(part)
    for field, value in part.fields().items():
        assert same(twin.fields()[field], value), f"{field}: {value} became {twin.fields()[field]}"


def test_bodies_of_one_file_share_their_data(tmp_path, data):
    pair = fmb.Model(bodies=[fmb.FloatingBody("left", data=data), fmb.FloatingBody("right", data=data, at=(1, 0, 0))])
    io.save_model(pair, tmp_path / "pair.toml")
    assert [p.name for p in tmp_path.glob("*.h5")] == ["pair.bracket_hex8.h5"]
    left, right = io.load_model(tmp_path / "pair.toml").bodies
    assert left.data is right.data
    assert same(left.data, data)
    selected = fmb.Model(bodies=[fmb.FloatingBody("left", data=data), fmb.FloatingBody("right", data=data.selected(2))])
    io.save_model(selected, tmp_path / "two.toml")
    assert sorted(p.name for p in tmp_path.glob("two.*.h5")) == [
        "two.bracket_hex8.h5",
        "two.bracket_hex8_2.h5",
    ]
    assert [b.data.n_modes for b in io.load_model(tmp_path / "two.toml").bodies] == [data.n_modes, 2]
