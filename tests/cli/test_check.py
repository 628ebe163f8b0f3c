"""`flexmb check`: the state that its frequencies belong to; and files that belong to other verbs."""

import warnings

import numpy as np
import pytest

from flexmb.cli import main

MASS, STIFFNESS, LENGTH, G = 1.0, 100.0, 0.5, 9.81

HANGING = f"""
name = "hanging"
gravity = [0, 0, {-G}]
[[body]]
kind = "Ground"
markers = {{ O = [0, 0, 0] }}
[[body]]
kind = "PointMass"
name = "bob"
mass = {MASS}
at = [0, 0, {-LENGTH}]
[[force]]
kind = "SpringDamper"
name = "spring"
markers = ["ground.O", "bob.center"]
stiffness = {STIFFNESS}
length = {LENGTH}
"""


def test_frequencies_about_the_equilibrium_that_the_file_asks_for(tmp_path, capsys):
    """A mass on a spring sags by m g / k: it swings as a pendulum of that length, and bobs with sqrt(k / m)."""
    path = tmp_path / "hanging.toml"
    path.write_text(HANGING + '[simulation]\nt_end = 1.0\nstart = "equilibrium"\n')
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # that the state is no equilibrium
        assert main(["check", str(path)]) == 0
    printed = capsys.readouterr().out
    assert "frequencies about the equilibrium at the start:" in printed
    found = printed.partition("at the start: ")[2].partition(" Hz")[0].split(", ")
    swings, bobs = np.sqrt(G / (LENGTH + MASS * G / STIFFNESS)), np.sqrt(STIFFNESS / MASS)
    np.testing.assert_allclose([float(f) for f in found], np.array([swings, swings, bobs]) / (2.0 * np.pi), rtol=5e-4)


@pytest.mark.parametrize("table", ["", "[simulation]\nt_end = 1.0\n"])
def test_frequencies_about_the_start_as_drawn(tmp_path, capsys, table):
    path = tmp_path / "hanging.toml"
    path.write_text(HANGING.replace(f"gravity = [0, 0, {-G}]", "") + table)
    assert main(["check", str(path)]) == 0
    assert "frequencies about the start: 1.592 Hz; 2 without oscillation" in capsys.readouterr().out


def test_a_rigid_law_has_no_frequencies(tmp_path, capsys):
    """It is said, and is no error; so is what is not seen of edges."""
    path = tmp_path / "falling.toml"
    cam = 'kind = "ExtrudedProfile", length = 0.1, profile = { kind = "Disc", radius = 0.1 }'
    path.write_text(
        HANGING.partition("[[force]]")[0].replace('"PointMass"', '"RigidBody"\ninertia = [1, 1, 1]')
        + f"""
[[surface]]
kind = "Surface"
name = "cam"
marker = "bob.center"
shape = {{ {cam} }}
[[surface]]
kind = "Surface"
name = "block"
marker = "ground.origin"
shape = {{ kind = "Cuboid", size = [0.1, 0.1, 0.1] }}
[[force]]
kind = "SurfaceContact"
name = "touch"
surfaces = ["block", "cam"]
law = {{ kind = "Rigid" }}
"""
    )
    assert main(["check", str(path)]) == 0
    printed = capsys.readouterr().out
    assert "frequencies: not looked for, Force 'touch' has a rigid law" in printed
    assert "edges of 'block' and 'cam' that cross are not seen" in printed


def test_show_names_the_verb_for_model_files(tmp_path, capsys):
    path = tmp_path / "hanging.toml"
    path.write_text(HANGING)
    assert main(["show", str(path)]) != 0
    assert f"Model file '{path}': it describes a model" in (told := capsys.readouterr().err)
    assert f"flexmb check {path}" in told


@pytest.mark.parametrize("verb", ["run", "check"])
def test_verbs_of_models_name_the_verb_for_decks(tmp_path, capsys, verb):
    path = tmp_path / "panel.bdf"
    path.write_text("BEGIN BULK\nGRID,1,,0.,0.,0.\nENDDATA\n")
    assert main([verb, str(path)]) != 0
    told = capsys.readouterr().err
    assert "it is a deck of finite elements" in told
    assert f"flexmb show {path}" in told


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ('t_end = "2*period"', "Simulation: t_end = '2*period'"),
        ("t_end = 1.0\nsamples = 0", "Simulation: samples = 0"),
        ('integrator = "IDAA"', "Did you mean 'IDA'"),
    ],
)
def test_what_a_run_would_refuse_is_told(tmp_path, capsys, table, told):
    path = tmp_path / "hanging.toml"
    path.write_text(HANGING + f"[simulation]\n{table}\n")
    assert main(["check", str(path)]) != 0
    assert told in capsys.readouterr().err


def test_the_end_may_be_given_by_the_command(tmp_path):
    path = tmp_path / "hanging.toml"
    path.write_text(HANGING + "[simulation]\nsamples = 11\n")
    assert main(["check", str(path)]) == 0


def test_gravity_that_is_a_number_is_shown_how_to_write(tmp_path, capsys):
    path = tmp_path / "hanging.toml"
    path.write_text(HANGING.replace(f"gravity = [0, 0, {-G}]", "gravity = -9.81"))
    assert main(["check", str(path)]) != 0
    assert "gravity = (0.0, 0.0, -9.81)" in capsys.readouterr().err
