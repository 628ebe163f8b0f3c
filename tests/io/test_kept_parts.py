"""A model file that is opened once for many values of its parameters keeps parts, but never one for another."""

import pytest

from flexmb.errors import ModelError
from flexmb.io.model_file import OpenModelFile, load_model

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


POLE = """
[parameters]
mass = 1.0
length = 0.5

[[body]]
kind = "Ground"

[[body]]
kind = "RigidBody"
name = "pole"
mass = "= mass"
inertia = [1.0, 1.0, 1.0]
markers = {pin = {at = [-0.5, 0, 0], z = [0, 1, 0]}, tip = {at = ["= length", 0, 0], z = [0, 1, 0]}}
"""


def test_markers_without_expressions_are_the_same_in_every_variant(tmp_path):
    path = tmp_path / "pole.toml"
    path.write_text(POLE)
    opened = OpenModelFile(path)
    one, two = (opened.model(values).body("pole") for values in ({}, {"mass": 2.0, "length": 0.7}))
    assert (one.mass, two.mass) == (1.0, 2.0)
    assert one.markers["pin"] is two.markers["pin"]
    assert [body.markers["tip"].at for body in (one, two)] == [(0.5, 0.0, 0.0), (0.7, 0.0, 0.0)]
    fresh = load_model(path, {"mass": 2.0, "length": 0.7}).body("pole")
    for name, pose in fresh.markers.items():
        assert pose.at == two.markers[name].at
        assert pose.matrix.tolist() == two.markers[name].matrix.tolist()


def test_a_wrong_marker_is_refused_as_in_a_file_read_once(tmp_path):
    path = tmp_path / "pole.toml"
    path.write_text(POLE.replace("z = [0, 1, 0]}, tip", "z = [0, 0, 0]}, tip"))
    told = []
    for read in (lambda: load_model(path), OpenModelFile(path).model):
        with pytest.raises(ModelError, match="zero or parallel") as caught:
            read()
        told.append(str(caught.value))
    assert told[0] == told[1]
