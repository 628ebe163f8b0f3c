"""A falling mass on the command line: z = -g t^2/2."""

import pytest

FALL = """
name = "fall"
gravity = [0, 0, "= -g"]

[parameters]
g = 9.81
duration = 1.0

[[body]]
kind = "Ground"

[[body]]
kind = "PointMass"
name = "stone"
mass = 2.0

[[force]]
kind = "PointLoad"
name = "wind"
marker = "stone.center"
force = ["= 4*t", 0, 0]

[[sensor]]
kind = "Position"
name = "place"
marker = "stone.center"

[simulation]
t_end = "= duration"
samples = 11
"""


@pytest.fixture
def fall(tmp_path, monkeypatch):
    """Return the path of the model file; the working folder is its folder."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "fall.toml"
    path.write_text(FALL)
    return path
