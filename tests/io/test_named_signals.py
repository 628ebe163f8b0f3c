"""The table [signals]: a motion that several loads follow is written once."""

import pytest

import flexmb as fmb
from flexmb.errors import ModelError

FILE = """
[parameters]
rate = 2.0
[signals]
progress = {{ ramp = {{ rate = "= rate" }} }}
lift = {{ table = {{ x = [0, 1, 2], y = [0, 1, 4], of = "= progress" }} }}
{more}
[[body]]
kind = "Ground"
[[body]]
kind = "PointMass"
name = "m"
mass = 1.0
[[force]]
kind = "PointLoad"
name = "load"
marker = "m.center"
force = ["= progress", {{ product = ["= lift", -1] }}, "= weight"]
"""


def load(folder, more):
    path = folder / "model.toml"
    path.write_text(FILE.format(more=more))
    return fmb.load_model(path)


def test_a_signal_is_named_once_and_used_in_others(tmp_path):
    x, y, z = load(tmp_path, 'weight = "= 3*t"').force("load").force
    assert x.sample(0.75)[0] == pytest.approx(1.5)
    assert y.sample(0.75)[0] == pytest.approx(-(1.5**2))  # x -> x2 through (0, 0), (1, 1), (2, 4)
    assert z.sample(0.75)[0] == pytest.approx(2.25)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("rate = 1.0", r"\[signals\], rate: .*a parameter too"),
        ('"a b" = 1.0', r"'a b' is not a name"),
        ('weight = "heavy"', r"\[signals\].*weight = 'heavy'"),
    ],
)
def test_messages(tmp_path, line, message):
    with pytest.raises(ModelError, match=message):
        load(tmp_path, line)
