"""Every example of the repository: four formulations give the same accelerations and reactions at random states.

The examples are found in their folder: scripts by the models that they hand to their analyses, model files by their
table of the simulation, with the models that their events leave. A new example takes part without a word here.
"""

import ast
import contextlib
import runpy
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tolerances import SOLVER
from tree.models import random_consistent
from tree.test_agreement import AGREED

import flexmb as fmb
from flexmb.integrate.runs.watch import next_phase
from flexmb.io.file_tables import read_tables
from flexmb.results import Phase, Series
from flexmb.system import assemble

EXAMPLES = Path(__file__).parents[2] / "examples"
HIGHLIFT = EXAMPLES / "highlift"
ANALYSES = ("accelerations", "check", "inverse_dynamics", "kinematics", "linearize", "simulate", "statics", "JointTree")
MOST = 3
"""Models of a script that are compared: variants of one mechanism say little more. Scripts of the high-lift system load
the model files, which are compared below, with other parameters: one of each."""
OTHERS = (fmb.Augmented(), fmb.NullSpace(), fmb.UdwadiaPhohomsiri())
LONG = (
    "highlift/wing.toml",
    "highlift/wing_driven.toml",
    "highlift/slats_driven.toml",
    "highlift/shaft_ruptures.toml",
    "highlift/station_4_jams.toml",
)
"""Files whose parts are compared by default as well: the wing, the line of shafts, the driven stations and slats."""
MEASURE = {"spread": 5e-4, "strain": 1e-6}
"""Of the random states: small enough for rollers at the ends of their tracks and for stiff supports."""


def analyses(path: Path) -> list[str]:
    """Return the analyses that a script asks of flexmb."""
    calls = [node.func for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Call)]
    return [call.attr for call in calls if isinstance(call, ast.Attribute) and call.attr in ANALYSES]


SCRIPTS = [path for path in sorted(EXAMPLES.rglob("*.py")) if analyses(path)]
FILES = [
    path for path in sorted(EXAMPLES.rglob("*.toml")) if {"simulation", "base"} & set(tomllib.loads(path.read_text()))
]


def name(path: Path) -> str:
    return str(path.relative_to(EXAMPLES))


LONG_SCRIPTS = ("belt_drive.py", "optimise_linkage.py", "snapping_strip.py")


def long(path: Path):
    return pytest.param(path, marks=pytest.mark.slow)


class _Enough(Exception):
    """Ends a script whose models are known."""


def models_of(path: Path, monkeypatch, tmp_path) -> list[fmb.Model]:
    """Return the first models that a script hands to its analyses;
    simulations are cut short, the last is not made at all.
    """
    found: list[fmb.Model] = []

    def recorded(analysis):
        def asked(model, *given, **options):
            if not any(model is other for other in found):
                found.append(model)
            if len(found) == (1 if HIGHLIFT in path.parents else MOST):
                raise _Enough
            if analysis is simulate:
                t_end = options.pop("t_end", given[0] if given else None)
                given, options = (1e-3 * t_end,), {"samples": 3} | options
            return analysis(model, *given, **options)

        return asked

    simulate = fmb.simulate
    for each in ANALYSES:
        monkeypatch.setattr(fmb, each, recorded(getattr(fmb, each)))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [str(path)])
    # a script may go on with bodies that another has to make first: those models are compared below
    with contextlib.suppress(_Enough, fmb.ModelError):
        runpy.run_path(str(path))["main"]()
    monkeypatch.undo()
    return found


def later_models(model: fmb.Model) -> list[fmb.Model]:
    """Return what each event of a model makes of it."""
    system, state = assemble(model)
    rows = {name: np.array([getattr(state, name)]) for name in ("t", "q", "u", "a", "lam")}
    series = Series(Phase(model=model, system=system, works=np.zeros((1, 3)), **rows))
    after = [next_phase(model, event, series) for event in model.events]
    return [other for other in after if other is not None]


def assert_agreement(model: fmb.Model, rng) -> None:
    """Compare accelerations and multipliers, relative to the largest of their kind;
    bodies of nodes are named instead.
    """
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
    assert {
        "puma_arm.py",
        "four_bar_flexible.py",
        "flap_station/flap_station.py",
        "highlift/trailing_edge.toml",
    } <= found
    assert len(later_models(fmb.load_model(HIGHLIFT / "strut_2_breaks.toml"))) == 1


@pytest.mark.parametrize("path", [long(path) if path.name in LONG_SCRIPTS else path for path in SCRIPTS], ids=name)
def test_models_of_a_script(path, monkeypatch, tmp_path, rng):
    models = models_of(path, monkeypatch, tmp_path)
    assert models
    for model in models:
        assert_agreement(model, rng)


@pytest.mark.parametrize("path", [file if name(file) not in LONG else long(file) for file in FILES], ids=name)
def test_models_of_a_file(path, rng):
    model = fmb.load_model(path)
    for each in (model, *later_models(model)):
        assert_agreement(each, rng)


@pytest.mark.slow
@pytest.mark.parametrize(
    "path", [path for path in FILES if "rigid" in read_tables(path).get("parameters", {})], ids=name
)
def test_elastic_model_of_a_file(path, rng):
    assert_agreement(fmb.load_model(path, {"rigid": False}), rng)


@pytest.mark.slow
@pytest.mark.parametrize("path", FILES, ids=name)
def test_motions_of_a_file(path):
    """The first 0.15 s by two implicit methods, in joint coordinates and in those of the bodies: every marker's place.

    Local errors are 1e-10 of the size; what rings adds them up.
    """
    model = replace(fmb.load_model(path), events=())
    places = [
        fmb.simulate(model, 0.15, samples=3, integrator=integrator).series(0).observation.r
        for integrator in (fmb.Implicit(rtol=1e-10), fmb.GeneralizedAlpha(rtol=1e-10))
    ]
    size = np.ptp(places[0][0], axis=0).max()
    np.testing.assert_allclose(*places, atol=SOLVER * size, rtol=0)
    assert np.abs(places[0][-1] - places[0][0]).max() > 0.0
