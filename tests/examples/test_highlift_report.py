"""The high-lift report names bodies, runs and sensors that its models have: runs of minutes end well."""

import runpy
from pathlib import Path

import pytest

import flexmb as fmb
from flexmb.io.drawn_parts import drawn_parts
from flexmb.view.labels import LAYERS

FOLDER = Path(__file__).parents[2] / "examples" / "highlift"
REPORT = runpy.run_path(str(FOLDER / "report.py"))


@pytest.fixture(scope="module", params=[False, True], ids=["rigid", "elastic"])
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


def test_figures_name_sensors(models):
    """A text begins with the name of a sensor; its column, or a time, follows."""
    found, _ = models
    for figure in REPORT["FIGURES"]:
        names = [sensor.name for run in figure.of or found for sensor in found[run].sensors]
        words = {*figure.y, *({figure.per} - {None, "final"})}
        assert {word for word in words if not any(word.startswith(name) for name in names)} == set()
