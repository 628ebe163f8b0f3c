"""The reference page of parts, as text: fields of all kinds are those of the kinds, sets are those that are made."""

import importlib.util
import inspect
import re
from pathlib import Path

import numpy as np
import pytest
from parts.flap import FLAP

import flexmb as fmb
from flexmb import parts
from flexmb.io.part_tables import _kinds

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "reference" / "parts.md").read_text(encoding="utf-8")
BAR = fmb.fem.Section.rectangle(0.02, 0.02)


@pytest.fixture(scope="module")
def entries():
    spec = importlib.util.spec_from_file_location("part_entries", DOCS / "part_entries.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_tables_are_those_of_today(entries):
    """If this fails: python docs/part_entries.py."""
    assert entries.filled(PAGE) == PAGE


def test_every_kind_of_model_files_is_there(entries):
    """All kinds that the table `data` of a model file takes have an entry."""
    shown = {kind for kinds in entries.GROUPS.values() for kind in kinds}
    taken = {kind for kinds in _kinds().values() for kind in kinds.values()}
    assert taken - shown == {fmb.fem.Section}  # as `Section.values`


def test_every_field_has_its_row_and_is_described(entries):
    """A field of a description without a word on its type or unit would be an empty row."""
    for kinds in entries.GROUPS.values():
        for kind in kinds:
            head, described = entries.described(kind)
            assert head, kind
            body = PAGE[PAGE.index(f"### `{kind.__qualname__}`\n") :]
            body = body[: body.find("\n### ", 1)]
            for field, parameter in inspect.signature(kind).parameters.items():
                if field in entries.NOT_IN_FILES.get(kind, ()) or parameter.kind is inspect.Parameter.VAR_KEYWORD:
                    continue
                row = re.search(rf"^\| `{field}` \| (.*) \|$", body, re.MULTILINE)
                assert row, (kind, field)
                assert (row[1].startswith("required")) == (parameter.default is inspect.Parameter.empty)
                assert any(field in entry.names and (entry.unit or entry.meaning) for entry in described), (kind, field)


def sets_of(piece):
    part = parts.Part(name="p", pieces=[piece], interfaces={"a": [0]})
    fe = part.finite_elements()
    return {*fe.node_sets, *fe.facet_sets}, fe


def test_sets_of_lines_and_plates():
    line = {"points": [(0, 0, 0), (1, 0, 0)], "elements": 2, "section": BAR, "material": "steel"}
    assert sets_of(parts.Line(**line, nodes={"middle": 0.5}))[0] == {"start", "end", "middle"}
    assert sets_of(parts.Line(**line, name="spar"))[0] == {"spar", "spar.start", "spar.end"}
    plate = {"corners": [(0, 0, 0), (1, 0, 0), (1, 0.5, 0), (0, 0.5, 0)], "thickness": 0.01, "size": 0.5}
    found, fe = sets_of(parts.Plate(**plate, material="steel", stress_side=1))
    names = [f"plate.{what}_{k}" for what in ("edge", "corner") for k in (1, 2, 3, 4)]
    assert found == {"plate", *names}
    assert np.allclose(fe.nodes[fe.node_sets["plate.edge_4"]][:, 0], 0.0)  # from corner 4 to corner 1
    assert np.allclose(fe.nodes[fe.node_sets["plate.corner_3"]], [[1.0, 0.5, 0.0]])
    assert "skin.edge_1" in sets_of(parts.Plate(**plate, material="steel", stress_side=1, name="skin"))[0]
    for name in ("plate.edge_4", "plate.corner_4", "spar.start", "skin.edge_1"):
        assert f"`{name}`" in PAGE


def test_sets_of_solids():
    """The lug's foot is at x = -length, its straight flanks at y = -+width/2."""
    pytest.importorskip("gmsh")
    lug = parts.Extrusion.lug(length=0.1, width=0.04, thickness=0.01, bore=0.02, material="steel", size=0.02, around=8)
    found, fe = sets_of(lug)
    assert {"bottom", "top", "sides", "bore", "side_1", "side_3", "side_4"} <= found
    at = {name: fe.nodes[np.unique(fe.facet_sets[name])] for name in found & set(fe.facet_sets)}
    assert np.allclose(at["side_4"][:, 0], -0.1)
    assert np.allclose(at["side_1"][:, 1], -0.02)
    assert np.allclose(at["side_3"][:, 1], 0.02)
    assert np.allclose(np.hypot(*at["bore"][:, :2].T), 0.01, rtol=0.02)
    tube = parts.Extrusion.tube(outer_diameter=0.1, wall=0.01, length=0.05, material="steel", size=0.03, around=8)
    assert {"bottom", "top", "inside"} <= sets_of(tube)[0]


def test_a_described_part_is_saved(tmp_path, monkeypatch):
    """As on the page: the file has the values it was made with, and another value refuses it."""
    monkeypatch.setenv("FLEXMB_BODIES", str(tmp_path / "kept"))
    described = f"""
[parameters]
GJ = 1.5e6
{FLAP}interfaces = {{ root = "start" }}
modes = 1
[[body.data.pieces]]
kind = "Line"
points = [[0, 0, 0], [0, 2, 0]]
elements = 2
material = "aluminium"
section = {{ kind = "Section.values", area = 4e-3, inertia_y = 3e-5, inertia_z = 3e-4, torsion = "= GJ/27e9" }}
"""
    file = tmp_path / "flap.toml"
    file.write_text(described)
    fmb.load_model(file, {"GJ": 1e6}).body("flap").data.save(tmp_path / "flap_soft.h5")
    head = described.partition("[body.data]")[0]
    file.write_text(head + 'data = "flap_soft.h5"\n')
    assert fmb.load_model(file, {"GJ": 1e6}).body("flap").data.mass > 0.0
    with pytest.raises(fmb.errors.ModelError, match=r"was made with GJ = 1000000"):
        fmb.load_model(file)
