"""The high-lift report names bodies, runs and sensors that its models have: runs of minutes end well."""

import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from by_turns import slow

import flexmb as fmb
from flexmb.errors import FlexmbError
from flexmb.io.drawn_parts import drawn_parts
from flexmb.view.labels import LAYERS

FOLDER = Path(__file__).parents[2] / "examples" / "highlift"
REPORT = runpy.run_path(str(FOLDER / "report.py"))


@pytest.fixture(scope="module", params=[slow(False, id="rigid"), pytest.param(True, id="elastic")])
def models(request):
    """The models of the runs by name, and whether they are elastic."""
    given = {"rigid": not request.param}
    found = {name: fmb.load_model(FOLDER / f"{file}.toml", given) for name, (file, _) in REPORT["CASES"].items()}
    return found, request.param


def test_labels_are_at_bodies_that_are_drawn(models):
    found, elastic = models
    drawn = {part.name for model in found.values() for part in drawn_parts(model, size=30.0) if part.look not in LAYERS}
    wanted = {**REPORT["LABELS"], **REPORT["FLAPS"][elastic]}
    assert {text: at for text, at in wanted.items() if at not in drawn} == {}


def test_directions_and_figures_name_runs(models):
    found, _ = models
    assert set(REPORT["CAMERAS"]) <= set(found)
    assert {name for figure in REPORT["FIGURES"] for name in figure.of or ()} <= set(found)


class Constant:
    """A run in which every sensor of a model is one: what a diagram asks of a solution."""

    def __init__(self, model):
        self.model, self.t = model, np.array([0.0, 2.0])
        self.sensor_names = [sensor.name for sensor in model.sensors]

    def column_titles(self, name):
        return next(sensor for sensor in self.model.sensors if sensor.name == name).columns(self.model)

    def __getitem__(self, name):
        return np.ones((2, len(self.column_titles(name))))


def test_figures_name_sensors_and_their_components(models):
    """By the function that draws them: it refuses a sensor, a component or a divisor that no run has."""
    found, _ = models
    runs = {name: Constant(model) for name, model in found.items()}
    for figure in REPORT["FIGURES"]:
        lines, *_ = figure.curves(runs)
        assert len(lines) >= len(figure.y)
    wrong = {"y": ["inboard_t2_flap anglee"], "per": "s2_drive strut force fxx at 0.7", "x": "inboard_t2_lever"}
    for field, value in wrong.items():
        with pytest.raises(FlexmbError, match="there is no sensor or component"):
            replace(REPORT["FIGURES"][0], **{field: value}).curves(runs)
