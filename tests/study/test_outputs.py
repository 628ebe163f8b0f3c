"""Reductions of sensors against closed forms."""

import numpy as np
import pytest
from study.formulas import stone, thrown
from tolerances import MACHINE, SOLVER

import flexmb as fmb
from flexmb import study
from flexmb.errors import ModelError
from flexmb.study.outputs import columns


def test_reductions_of_a_triangle():
    """y from -1 to 3 to 1 on uneven times: mean and rms of a polygon are exact."""
    t, y = np.array([0.0, 1.0, 3.0]), np.array([-1.0, 3.0, 1.0])
    found = {name: reduce(t, y) for name, reduce in study.REDUCTIONS.items()}
    squares = (1 - 3 + 9) / 3 * 1 + (9 + 3 + 1) / 3 * 2  # integral of a squared line: h (a^2 + ab + b^2)/3
    assert found == pytest.approx(
        {
            "max": 3.0,
            "min": -1.0,
            "peak": 3.0,
            "final": 1.0,
            "mean": (1.0 + 4.0) / 3,
            "rms": np.sqrt(squares / 3),
            "time_of_max": 1.0,
            "time_of_min": 0.0,
            "time_of_peak": 1.0,
        },
        rel=MACHINE,
    )


def test_peak_is_the_largest_magnitude():
    t, y = np.array([0.0, 1.0]), np.array([-5.0, 3.0])
    assert study.REDUCTIONS["peak"](t, y) == 5.0
    assert study.REDUCTIONS["time_of_peak"](t, y) == 0.0


def test_one_sample_is_its_own_mean():
    t, y = np.array([2.0]), np.array([-4.0])
    assert study.REDUCTIONS["mean"](t, y) == -4.0
    assert study.REDUCTIONS["rms"](t, y) == 4.0


def test_columns_have_titles_and_units():
    """Free fall: z = -g t^2/2."""
    solution = thrown(9.81)
    asked = ["min(place z)", "depth = final(place z)", "time_of_min(place z)", "max(place)", "at = mean(place)"]
    found = {column.title: column.value(solution) for column in columns(asked, stone(9.81))}
    assert list(found) == [
        "min(place z) [m]",
        "depth [m]",
        "time_of_min(place z) [s]",
        "max(place x) [m]",
        "max(place y) [m]",
        "max(place z) [m]",
        "at x [m]",
        "at y [m]",
        "at z [m]",
    ]
    assert found["depth [m]"] == pytest.approx(-4.905, rel=SOLVER)
    assert found["time_of_min(place z) [s]"] == 1.0


def test_every_sensor_by_default():
    titles = [column.title for column in columns(None, stone(9.81))]
    assert titles == [f"{r}(place {x}) [m]" for r in ("max", "min", "final") for x in "xyz"]


@pytest.mark.parametrize(
    ("outputs", "message"),
    [
        (
            ["max(plaice z)"],
            r"Output 'max\(plaice z\)': there is no sensor or component 'plaice z'\. "
            r"One of: place\. Did you mean 'place z'\?",
        ),
        (["maxi(place)"], r"Output 'maxi\(place\)': there is no reduction 'maxi'\. .*Did you mean 'max'\?"),
        (["place z"], r"Output 'place z': no reduction and sensor\. REDUCTION\(SENSOR\)"),
        (["max(place z)", "max(place)"], r"Output 'max\(place z\) \[m\]': two outputs have this title"),
        ([], r"Study of 'model': there is nothing to keep"),
    ],
)
def test_outputs_that_cannot_be(outputs, message):
    with pytest.raises(ModelError, match=message):
        columns(outputs, stone(9.81))


def test_a_model_without_sensors():
    with pytest.raises(ModelError, match=r"there is nothing to keep: the model has no sensor\..*Add \[\[sensor\]\]"):
        columns(None, fmb.Model(bodies=[fmb.Ground()]))
