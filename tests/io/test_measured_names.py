"""A sensor that a signal of a model file follows and that is not there: told with file, table and field."""

import pytest

import flexmb as fmb
from flexmb.cli import main
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


def test_the_ending_of_a_plant_is_looked_at_first(tmp_path, capsys):
    """Before the model, which does not even exist here."""
    assert main(["linearize", str(tmp_path / "none.toml"), "-o", "x.npz"]) == 2
    assert "Expected: .mat" in capsys.readouterr().err
