"""A sensor that a signal of a model file follows and that is not there: told with file, table and field."""

import pytest

import flexmb as fmb
from flexmb.errors import ModelError

RAIL = """
[[body]]
kind = "Ground"
[[body]]
kind = "PointMass"
name = "b"
mass = 1.0
[[force]]
kind = "PointLoad"
name = "push"
marker = "b.center"
force = [0, 0, SIGNAL]
[[sensor]]
kind = "Position"
name = "tip"
marker = "b.center"
"""


@pytest.fixture
def file(tmp_path):
    def write(signal):
        path = tmp_path / "rail.toml"
        path.write_text(RAIL.replace("SIGNAL", signal))
        return path

    return write


@pytest.mark.parametrize(
    ("signal", "place"),
    [
        ('{ measured = "tipp" }', "force, measured"),
        ('{ measured = { of = "tipp", column = 2 } }', "force, measured"),
        ('{ limit = { of = { measured = "tipp" }, limits = [-1, 1] } }', "force, limit, of, measured"),
        ('{ formula = { text = "-x[2]", over = { x = "tipp" } } }', "force, formula, over.x"),
    ],
)
def test_a_misspelt_sensor(file, signal, place):
    with pytest.raises(ModelError) as told:
        fmb.load_model(file(signal))
    assert str(told.value).startswith(f"rail.toml, [[force]] 'push', {place}: sensor 'tipp' does not exist")
    assert "Did you mean 'tip'?" in str(told.value)


def test_column_and_rate_of_a_sensor_in_a_file(file):
    """A force of -3 times the velocity: v = exp(-3 t) of a mass of 1 kg that starts with 1 m/s."""
    damper = '{ formula = { text = "-3*v", over = { v = { measured = { of = "tip", column = 2, rate = true } } } } }'
    path = file(damper)
    path.write_text(path.read_text().replace("mass = 1.0", "mass = 1.0\nvelocity = [0, 0, 1]"))
    run = fmb.simulate(fmb.load_model(path), 1.0, samples=11)
    z = run["tip"][:, 2]
    assert z[-1] == pytest.approx((1.0 - 2.718281828459045**-3) / 3.0, rel=1e-4)


OUTER = """
[[assembly]]
file = "rail.toml"
prefix = "left"
"""
OTHER = """
[[sensor]]
kind = "Position"
name = "other"
marker = "left_b.center"
"""


@pytest.mark.parametrize("name", ["tip", "other"])
def test_sensors_within_an_assembly(file, tmp_path, name):
    """Its own, or one of the file around it."""
    file(f'{{ measured = {{ of = "{name}", column = 2 }} }}')
    outer = tmp_path / "outer.toml"
    outer.write_text(OUTER + OTHER)
    fmb.check(fmb.load_model(outer))


def test_a_misspelt_sensor_within_an_assembly(file, tmp_path):
    """What neither file has is told when the model is checked, without the file."""
    file('{ measured = { of = "tipp", column = 2 } }')
    outer = tmp_path / "outer.toml"
    outer.write_text(OUTER)
    with pytest.raises(ModelError, match=r"Force 'left_push': sensor 'tipp' does not exist\. The model has: left_tip"):
        fmb.check(fmb.load_model(outer))
