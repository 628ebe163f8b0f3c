"""Assemblies in model files: several tracks are one file and several tables."""

import numpy as np
import pytest
from tolerances import MACHINE

from flexmb import io
from flexmb.errors import ModelError

TRACK = """
name = "track"
gravity = [0, 0, -9.81]
[parameters]
radius = 0.1
mass = "= 10*radius"
[[body]]
kind = "Ground"
markers = { A = { at = [0, 0, "= radius"], z = [0, 1, 0] } }
[[body]]
kind = "RigidBody"
name = "lever"
mass = "= mass"
inertia = [1, 1, 1]
velocity = [1, 0, 0]
[[joint]]
kind = "Revolute"
name = "A"
markers = ["ground.A", "lever.center"]
[[joint]]
kind = "Drive"
name = "motor"
joint = "A"
angle = { ramp = { rate = 1 } }
[[force]]
kind = "PointLoad"
name = "lift"
marker = "lever.center"
force = [0, 0, 100]
[[sensor]]
kind = "Reaction"
name = "bearing"
joint = "A"
"""

WING = """
name = "wing"
[parameters]
span = 4.0
[[assembly]]
file = "parts/track.toml"
prefix = "t2"
at = [0, "= span", 0]
[[assembly]]
file = "parts/track.toml"
prefix = "t3"
at = [0, "= 2*span", 0]
rotation = [0, 0, "= 90*deg"]
parameters = { radius = "= span/10" }
[[body]]
kind = "Ground"
markers = { tip = [0, 20, 0] }
[[joint]]
kind = "Rod"
name = "link"
markers = ["t2_lever.center", "t3_lever.center"]
[[sensor]]
kind = "Position"
name = "at t3"
marker = "t3_lever.center"
"""


@pytest.fixture
def wing(tmp_path):
    def files(text=WING, track=TRACK):
        (tmp_path / "parts").mkdir(exist_ok=True)
        (tmp_path / "parts" / "track.toml").write_text(track)
        path = tmp_path / "wing.toml"
        path.write_text(text)
        return path

    return files


def test_two_tracks_of_one_file(wing):
    model = io.load_model(wing())
    assert [b.name for b in model.bodies] == ["ground", "t2_lever", "t3_lever"]
    assert [j.name for j in model.joints] == ["t2_A", "t2_motor", "t3_A", "t3_motor", "link"]
    assert [s.name for s in model.sensors] == ["t2_bearing", "t3_bearing", "at t3"]
    assert model.name == "wing"
    assert model.gravity == (0, 0, -9.81)
    assert model.parameters == {"span": 4.0}
    assert model.joint("t3_motor").joint == "t3_A"
    assert model.joint("t3_A").markers == ("ground.t3_A", "t3_lever.center")
    assert model.sensors[1].joint == "t3_A"
    assert (model.body("t2_lever").mass, model.body("t3_lever").mass) == (1.0, 4.0)


def test_placement(wing):
    model = io.load_model(wing())
    R = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    lever, ground = model.body("t3_lever"), model.body("ground").marker_poses()
    assert lever.at == (0, 8, 0)
    assert lever.rotation == pytest.approx(R, abs=MACHINE)
    assert lever.velocity == pytest.approx((0, 1, 0), abs=MACHINE)
    assert ground["t3_A"].at == pytest.approx((0, 8, 0.4), abs=MACHINE)
    assert ground["t3_A"].matrix[:, 2] == pytest.approx((-1, 0, 0), abs=MACHINE)
    assert ground["t3_origin"].at == (0, 8, 0)
    assert model.force("t2_lift").axes is None
    assert model.force("t3_lift").axes == "ground.t3_origin"


def test_assemblies_in_assemblies(wing, tmp_path):
    wing()
    (tmp_path / "aircraft.toml").write_text("""
    [[assembly]]
    file = "wing.toml"
    prefix = "left"
    at = [0, 1, 0]
    parameters = { span = 2 }
    """)
    model = io.load_model(tmp_path / "aircraft.toml")
    assert model.body("left_t3_lever").at == pytest.approx((0, 5, 0), abs=MACHINE)
    assert model.joint("left_link").markers == ("left_t2_lever.center", "left_t3_lever.center")
    assert "left_t2_A" in model.body("ground").marker_poses()


def test_a_station_is_exchanged(wing, tmp_path):
    """The file of an assembly is a parameter."""
    text = WING.replace("span = 4.0", 'span = 4.0\nstation = "parts/track.toml"').replace(
        'file = "parts/track.toml"', 'file = "= station"', 1
    )
    path = wing(text)
    (tmp_path / "parts" / "light.toml").write_text(TRACK.replace('"= 10*radius"', "0.5"))
    assert io.load_model(path).body("t2_lever").mass == 1.0
    assert io.load_model(path, {"station": "parts/light.toml"}).body("t2_lever").mass == 0.5


def test_the_whole_is_saved_as_one_file(wing, tmp_path):
    model = io.load_model(wing())
    again = io.load_model(io.save_model(model, tmp_path / "out" / "wing.toml"))
    assert io.model_text(again) == io.model_text(model)


@pytest.mark.parametrize(
    ("old", "new", "messages"),
    [
        (
            'file = "parts/track.toml"',
            'file = "parts/trak.toml"',
            ("wing.toml, [[assembly]] 1: Model file", "does not exist", "The folder holds: track.toml"),
        ),
        (
            'file = "parts/track.toml"\n',
            "",
            ("wing.toml, [[assembly]] 1: the field 'file' is missing", "Write file ="),
        ),
        ('prefix = "t2"', "prefix = 2", ("[[assembly]] 1: prefix = 2", "a text")),
        ('prefix = "t2"', 'prefix = "t.2"', ("prefix = 't.2'", "without dots")),
        (
            'prefix = "t2"',
            'prefx = "t2"',
            ("[[assembly]] 1: there is no field 'prefx'", "Did you mean 'prefix'?"),
        ),
        (
            'prefix = "t3"',
            'prefix = "t2"',
            ("Ground marker 't2_origin': it lies at", "Give the models different prefixes"),
        ),
        (
            'file = "parts/track.toml"',
            'file = "wing.toml"',
            ("the files form a circle: wing.toml -> wing.toml", "Remove one of these assemblies"),
        ),
        (
            'radius = "= span/10"',
            "radiu = 3",
            (
                "[[assembly]] 2: track.toml, [parameters]: there is no parameter 'radiu'",
                "Did you mean 'radius'?",
            ),
        ),
        (
            'parameters = { radius = "= span/10" }',
            "parameters = 3",
            ("[[assembly]] 2, parameters: 3", "a table"),
        ),
        (
            'radius = "= span/10"',
            "mass = -1",
            ("[[assembly]] 2: track.toml, [[body]] 'lever': Body 'lever': mass = -1",),
        ),
        (
            '"t3_lever.center"]',
            '"t4_lever.center"]',
            ("wing.toml: Joint 'link': marker 't4_lever.center'", "Did you mean 't"),
        ),
        (
            'rotation = [0, 0, "= 90*deg"]',
            "rotation = [0, 0, 1]\nx = [1, 0, 0]",
            ("[[assembly]] 2: placement has the entries",),
        ),
        (
            "[parameters]",
            "gravity = [0, 0, 1]\n[parameters]",
            ("gravity (0.0, 0.0, 1.0) and (0.0, 0.0, -9.81)", "one gravity"),
        ),
    ],
)
def test_messages(wing, old, new, messages):
    assert WING.count(old)
    path = wing(WING.replace(old, new, 1))
    with pytest.raises(ModelError) as caught:
        io.load_model(path)
    for message in messages:
        assert message in str(caught.value)


def test_a_circle_over_two_files(wing):
    path = wing(track=TRACK + '[[assembly]]\nfile = "../wing.toml"\nprefix = "x"\n')
    with pytest.raises(ModelError, match=r"a circle: wing\.toml -> track\.toml -> wing\.toml"):
        io.load_model(path)
