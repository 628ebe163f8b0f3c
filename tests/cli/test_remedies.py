"""What messages tell users of Python to write is told on the command line as options and tables of model files."""

import re

import pytest

from flexmb.bodies.floating.validity import UNKNOWN
from flexmb.cli import main
from flexmb.cli.remedies import in_files_and_options

SAID = {
    "or start from fmb.statics(model), and": 'or begin in the equilibrium (start = "equilibrium" in the table '
    "[simulation]), and",
    "Begin at one: about=fmb.statics(model)": 'Begin at one: start = "equilibrium" in the table [simulation]',
    "Give the result of fmb.statics(model), or": 'Give start = "equilibrium" in the table [simulation], or',
    "Write shape=fmb.Sphere(radius=0.1); Box": 'Write shape={ kind = "Sphere", radius = 0.1 }; Box',
    "Write shape=fmb.Box(size=(0.4, 0.1, 0.1)), or": 'Write shape={ kind = "Box", size = [0.4, 0.1, 0.1] }, or',
    "Write angle = fmb.ramp(rate=1.0), or": "Write angle = { ramp = { rate = 1.0 } }, or",
    "Give a number, fmb.ramp(...) or fmb.table(..., of=fmb.ramp(...))": "Give a number, { ramp = { ... } } or "
    "{ table = { ..., of = { ramp = { ... } } } }",
    "Write 'top': fmb.Skin(..., faces=True), or": "Write 'top': { kind = \"Skin\", ..., faces = true }, or",
    "Keep more modes: reduction.reduce(..., modes=...)": "Keep more modes: flexmb reduce ... --modes, "
    "of a part modes = ...",
    "Reduce it with geometric_stiffness=True (--geometric-stiffness; of a part in a model file geometric_stiffness = "
    "true): it": "Reduce it with --geometric-stiffness, of a part in a model file geometric_stiffness = true: it",
    UNKNOWN: UNKNOWN.replace(
        "geometric_stiffness=True (--geometric-stiffness; of a part in a model file geometric_stiffness = true)",
        "--geometric-stiffness, of a part in a model file geometric_stiffness = true",
    ),
    "past it with path=flexmb.ArcLength()": "past it with statics(model, path=ArcLength()) of the Python package",
    "See flexmb.check(model): a flat toggle": "See `flexmb check`: a flat toggle",
    "Write 'ground.A', or (a) bracket": "Write 'ground.A', or (a) bracket",
    "Write fmb.equations(model).in_euler_parameters()": "Write fmb.equations(model).in_euler_parameters()",
    "an open fmb.ramp(rate=1": "an open fmb.ramp(rate=1",
}  # fmt: skip

PENDULUM = """
gravity = [0, 0, -9.81]
[[body]]
kind = "Ground"
markers = { pin = { at = [0, 0, 0], z = [0, 1, 0] } }
[[body]]
kind = "RigidBody"
name = "arm"
mass = 1.0
inertia = [0.1, 0.1, 0.1]
at = [0.5, 0, 0]
markers = { pin = { at = [-0.5, 0, 0], z = [0, 1, 0] } }
[[joint]]
kind = "Revolute"
name = "pin"
markers = ["ground.pin", "arm.pin"]
"""

DRIVEN = f"""{PENDULUM}
[[joint]]
kind = "Drive"
name = "motor"
joint = "pin"
angle = {{ ramp = {{ rate = 1.0 }} }}
[[sensor]]
kind = "Position"
name = "tip"
marker = "arm.pin"
"""


@pytest.mark.parametrize("said", SAID)
def test_words_of_python(said):
    assert in_files_and_options(said) == SAID[said]


def test_verbs_with_the_option_are_told_so():
    told = in_files_and_options("Begin at one: about=fmb.statics(model)", statics=True)
    assert told == 'Begin at one: --statics, or start = "equilibrium" in the table [simulation]'


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ("instead, or start from fmb.statics(model)", "instead"),
        ("no equilibrium: start from fmb.statics(model), and compare with", "no equilibrium: compare with"),
        ("Give the result of fmb.statics(model), or leave inputs out", "Leave inputs out"),
        (
            "forces. Begin at one: about=fmb.statics(model)",
            "forces. It is the equilibrium that was found: look at what moves or slides there, drives, contacts and "
            "friction",
        ),
    ],
)
def test_what_was_done_is_not_proposed(said, meant):
    assert in_files_and_options(said, statics=True, at_rest=True) == meant


@pytest.mark.parametrize("begin", ["option", "file"])
def test_a_drive_that_moves_in_the_equilibrium(begin, tmp_path, monkeypatch, capsys):
    """Inputs and outputs about a state that moves are refused; statics was asked for and is not proposed again."""
    monkeypatch.chdir(tmp_path)
    text = DRIVEN if begin == "option" else f'{DRIVEN}[simulation]\nt_end = 1.0\nstart = "equilibrium"\n'
    (tmp_path / "arm.toml").write_text(text)
    assert main(["linearize", "arm.toml", *(["--statics"] if begin == "option" else [])]) == 2
    told = re.sub(r"\s+", " ", capsys.readouterr().err)
    assert "a state that moves" in told
    assert "Leave inputs and outputs out" in told
    assert "statics" not in told
    assert "equilibrium (" not in told
    assert 'start = "equilibrium"' not in told


@pytest.mark.parametrize(("verb", "option"), [("check", False), ("modes", True)])
def test_a_start_that_is_no_equilibrium(verb, option, tmp_path, monkeypatch, capsys):
    """A pendulum that is let go: where it is told, the remedy is one of the terminal."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.toml").write_text(PENDULUM)
    assert main([verb, "arm.toml"]) == 0
    told = re.sub(r"\s+", " ", capsys.readouterr().err)
    assert "accelerates with" in told
    assert ("--statics, or start" in told) == option
    assert 'start = "equilibrium" in the table [simulation]' in told
    assert "fmb." not in told
