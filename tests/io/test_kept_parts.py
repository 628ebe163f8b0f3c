"""A model file that is opened once for many values of its parameters keeps parts, but never one for another."""

import pytest

from flexmb.errors import ModelError
from flexmb.io.model_file import OpenModelFile

TEXT = """
[parameters]
sunlit = true

[[body]]
kind = "Ground"

[[body]]
kind = "PointMass"
name = "b"
mass = 1.0

[[force]]
if = "= sunlit"
kind = "ThinDrag"
name = "drag"
marker = "b.center"
area = 1.0
density = 1e-12
both_faces = true

[[force]]
unless = "= sunlit"
kind = "ThinDrag"
name = "drag"
marker = "b.center"
area = 1.0
density = 1e-12
both_faces = 1
"""


def test_true_and_one_are_two_descriptions(tmp_path):
    """The second of two alternatives has a number where a flag belongs; it is refused whichever was read before."""
    path = tmp_path / "model.toml"
    path.write_text(TEXT)
    opened = OpenModelFile(path)
    first = opened.model({"sunlit": True})
    assert first.forces[0].both_faces is True
    with pytest.raises(ModelError, match="both_faces = 1"):
        opened.model({"sunlit": False})
    assert opened.model({"sunlit": True}).forces[0] is first.forces[0]
