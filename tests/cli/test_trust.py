"""Code that a file names is imported only by those who trust the file."""

import sys

import pytest

import flexmb as fmb
from flexmb.cli import main

MODEL = """
name = "pushed"

[[body]]
kind = "Ground"

[[body]]
kind = "PointMass"
name = "stone"
mass = 2.0

[[force]]
kind = "UserForce"
name = "push"
markers = ["ground.origin", "stone.center"]
function = "{module}:push"

[[sensor]]
kind = "Position"
name = "place"
marker = "stone.center"

[simulation]
t_end = 0.1
samples = 3
"""
CODE = """
from pathlib import Path
Path("imported.txt").write_text("yes")

def push(t, d, v, R, w):
    return (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)
"""


@pytest.fixture
def pushed(tmp_path, monkeypatch, request):
    """A model file that names a module of its own folder, which leaves a trace when it is imported."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    module = f"pushing_{abs(hash(request.node.name))}"
    (tmp_path / f"{module}.py").write_text(CODE)
    path = tmp_path / "pushed.toml"
    path.write_text(MODEL.format(module=module))
    yield path
    sys.modules.pop(module, None)


def imported(path):
    return (path.parent / "imported.txt").exists()


def test_without_trust_it_can_be_looked_at_only(pushed):
    model = fmb.load_model(pushed)
    assert model.forces[0].function.endswith(":push")
    with pytest.raises(fmb.ModelError, match=r"Force 'push'.*names Python code.*--trust"):
        fmb.check(model)
    assert not imported(pushed)


@pytest.mark.parametrize("change", ["renamed", "stored", "assembled"])
def test_copies_are_not_trusted_either(pushed, change):
    """Nor the model that a run folder holds, nor a file inside of another."""
    model = fmb.load_model(pushed)
    if change == "renamed":
        model = model.with_parts(sensors=[fmb.Position("other", marker="stone.center")])
    elif change == "stored":
        model = fmb.read_model_text(fmb.model_text(fmb.load_model(pushed, trust=True)))
    else:
        outer = pushed.with_name("outer.toml")
        outer.write_text('[[assembly]]\nfile = "pushed.toml"\nprefix = "a"\n')
        model = fmb.load_model(outer)
    with pytest.raises(fmb.ModelError, match="names Python code"):
        fmb.simulate(model, 0.1)
    assert not imported(pushed)


def test_with_trust_it_computes(pushed):
    solution = fmb.simulate(fmb.load_model(pushed, trust=True), 1.0, samples=2)
    assert solution["place"][-1, 0] == pytest.approx(0.25, rel=1e-6)  # F t^2 / (2 m)
    assert imported(pushed)


@pytest.fixture
def foreign(pushed, capsys):
    """A run folder that somebody else has made, whose code has not been imported here."""
    assert main(["run", str(pushed), "--out", "run", "--trust"]) == 0
    (pushed.parent / "imported.txt").unlink()
    sys.modules.pop(next(name for name in sys.modules if name.startswith("pushing_")))
    capsys.readouterr()
    return pushed


OF_MODELS = (["check"], ["run", "--out", "new"], ["sweep", "--over", "none=1,2", "--out", "sweep"])
OF_LINEAR_MODELS = (
    ["statics", "-o", "rest.csv"],
    ["modes"],
    ["linearize", "-o", "plant.mat"],
    ["bode", "-o", "bode.png"],
    ["psd", "--density", "1", "-o", "psd.png"],
    ["locus", "--over", "none=1:2:2", "-o", "locus.png"],
    ["campbell", "--over", "none=1:2:2", "-o", "campbell.png"],
)
OF_RUNS = (
    ["resume", "--t-end", "0.2"],
    ["report", "--no-pictures"],
    ["export", "--vtk"],
    ["export", "--vtkhdf"],
    ["export", "--csv", "--to", "tables"],
    ["plot"],
    ["verify"],
    pytest.param(["render"], marks=pytest.mark.render),
)


@pytest.mark.parametrize("verb", OF_MODELS, ids=lambda verb: verb[0])
def test_verbs_that_read_a_model_ask_for_trust(pushed, verb):
    assert main([verb[0], str(pushed), *verb[1:]]) == 2
    assert not imported(pushed)


@pytest.mark.parametrize("verb", OF_LINEAR_MODELS, ids=lambda verb: verb[0])
def test_linear_analyses_ask_for_trust(pushed, verb, capsys):
    with pushed.open("a") as file:
        file.write("\n[parameters]\nnone = 1.0\n")
    assert main([verb[0], str(pushed), *verb[1:]]) == 2
    assert "names Python code" in capsys.readouterr().err
    assert not imported(pushed)


def test_a_unit_of_fmi_is_written_without_the_import(pushed):
    pytest.importorskip("pythonfmu3")
    assert main(["fmu", str(pushed), "-o", "pushed.fmu"]) == 0
    assert not imported(pushed)


@pytest.mark.parametrize("verb", OF_RUNS, ids=" ".join)
def test_verbs_that_read_a_run_ask_for_trust(foreign, verb, capsys):
    """What can be shown without computing is shown; what cannot says why. The code is imported with --trust only."""
    code = main([verb[0], "run", *verb[1:]])
    told = capsys.readouterr()
    assert "Traceback" not in told.err
    assert code == 0 or "names Python code" in told.err + told.out
    assert code in (0, 2)
    assert not imported(foreign)
    assert main([verb[0], "run", *verb[1:], "--trust"]) in ((0, 1) if verb[0] == "verify" else (0,))


@pytest.mark.parametrize("verb", [["resume", "--t-end", "0.2"], ["verify"]], ids=lambda verb: verb[0])
def test_verbs_that_compute_again_are_refused(foreign, verb, capsys):
    assert main([verb[0], "run", *verb[1:]]) == 2
    assert "names Python code" in capsys.readouterr().err
    assert not imported(foreign)
    main([verb[0], "run", *verb[1:], "--trust"])
    assert imported(foreign)
