"""A load whose kind is no text: refused by name, not a traceback."""

import pytest

import flexmb as fmb
from flexmb.errors import ModelError

MODEL = """
[[body]]
kind = "Ground"
[[body]]
kind = "FloatingBody"
name = "bar"
[body.data]
modes = 2
interfaces = { a = "start", b = "end" }
loads = { f = { kind = KIND, on = "mid", force = [0, 0, 1.0] } }
[[body.data.pieces]]
kind = "Line"
points = [[0, 0, 0], [1.0, 0, 0]]
section = { kind = "Section.rectangle", width = 0.02, height = 0.03 }
material = "steel"
elements = 4
nodes = { mid = 0.5 }
"""


@pytest.mark.parametrize("kind", ["[0, 0, 1.0]", "{ a = 1 }", "3", "[[1, 2]]"])
def test_the_kind_of_a_load(kind, tmp_path):
    path = tmp_path / "bar.toml"
    path.write_text(MODEL.replace("KIND", kind))
    with pytest.raises(ModelError, match=r"data.loads.f: kind = .* is unknown"):
        fmb.load_model(path)
