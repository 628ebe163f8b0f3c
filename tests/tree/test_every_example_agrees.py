"""Every example of the repository: four formulations give the same accelerations and reactions at random states.

The examples are found in their folder: scripts by the model that they hand to their first analysis, model files by their
table of the simulation. A new example takes part without a word here.
"""

import ast
import runpy
import shutil
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from tree.models import random_consistent
from tree.test_agreement import AGREED

import flexmb as fmb

EXAMPLES = Path(__file__).parents[2] / "examples"
HIGHLIFT = EXAMPLES / "highlift"
ANALYSES = ("accelerations", "check", "inverse_dynamics", "kinematics", "linearize", "simulate", "statics", "JointTree")
OTHERS = (fmb.Augmented(), fmb.NullSpace(), fmb.UdwadiaPhohomsiri())
MEASURE = {"spread": 5e-4, "strain": 1e-6}
"""Of the random states: small enough for rollers at the ends of their tracks and for stiff supports."""


def analyses(path: Path) -> list[str]:
    """Return the analyses that a script asks of flexmb."""
    calls = [node.func for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Call)]
    return [call.attr for call in calls if isinstance(call, ast.Attribute) and call.attr in ANALYSES]


SCRIPTS = [path for path in sorted(EXAMPLES.rglob("*.py")) if analyses(path)]
FILES = [path for path in sorted(EXAMPLES.rglob("*.toml")) if {"simulation", "base"} & set(tomllib.loads(path.read_text()))]


def name(path: Path) -> str:
    return str(path.relative_to(EXAMPLES))


class _Found(Exception):
    """Carries the model out of a script."""


def model_of(path: Path, monkeypatch, tmp_path) -> fmb.Model:
    """Return the model of the first analysis of a script, which ends there."""

    def analysis(model, *_, **__):
        raise _Found(model)

    for each in ANALYSES:
        monkeypatch.setattr(fmb, each, analysis)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [str(path)])
    with pytest.raises(_Found) as found:
        runpy.run_path(str(path))["main"]()
    monkeypatch.undo()
    return found.value.args[0]


def assert_agreement(model: fmb.Model, rng) -> None:
    """Compare accelerations and multipliers, relative to the largest of their kind; bodies of nodes are named instead."""
    system, state = random_consistent(model, rng, **MEASURE)
    work = system.workspace()
    answers = [other.accelerate(system, state, work) for other in OTHERS]
    if any(body.block_size < body.n_velocities for body in model.bodies):
        with pytest.raises(fmb.CompileError, match="has no frame but nodes"):
            fmb.Recursive().accelerate(system, state, work)
    else:
        answers.append(fmb.Recursive().accelerate(system, state, work))
    reference = answers[1]
    for formulation, answer in zip((*OTHERS, fmb.Recursive()), answers, strict=False):
        for kind, one, two in zip(("accelerations", "multipliers"), answer, reference, strict=True):
            scale = max(np.abs(two).max(initial=0.0), 1.0)
            np.testing.assert_allclose(one / scale, two / scale, atol=AGREED, rtol=0, err_msg=f"{kind}, {formulation}")


def test_the_examples_are_found():
    found = {name(path) for path in (*SCRIPTS, *FILES)}
    assert {"puma_arm.py", "four_bar_flexible.py", "flap_station/flap_station.py", "highlift/trailing_edge.toml"} <= found


@pytest.mark.parametrize("path", SCRIPTS, ids=name)
def test_model_of_a_script(path, monkeypatch, tmp_path, rng):
    model = model_of(path, monkeypatch, tmp_path)
    for _ in range(2):
        assert_agreement(model, rng)


@pytest.mark.parametrize("path", FILES, ids=name)
def test_model_of_a_file(path, rng):
    assert_agreement(fmb.load_model(path), rng)


@pytest.fixture(scope="module")
def with_bodies(tmp_path_factory):
    """The high-lift model files with the reduced bodies beside them."""
    folder = tmp_path_factory.mktemp("highlift")
    for file in HIGHLIFT.glob("*.toml"):
        shutil.copy(file, folder)
    runpy.run_path(str(HIGHLIFT / "make_bodies.py"))["main"](folder)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("path", [path for path in FILES if "rigid" in fmb.load_model(path).parameters], ids=name)
def test_elastic_model_of_a_file(path, with_bodies, rng):
    assert_agreement(fmb.load_model(with_bodies / path.name, {"rigid": False}), rng)
