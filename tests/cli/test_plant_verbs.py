"""statics, modes, linearize and bode on the command line: a mass on a spring and a damper."""

import csv

import numpy as np
import pytest
import scipy.io

import flexmb as fmb
from flexmb.cli import main

K, DAMPING, MASS, GRAVITY = 400.0, 3.0, 2.0, 9.81

OSCILLATOR = """
name = "oscillator"
gravity = [0, 0, -9.81]

[parameters]
stiffness = 400.0

[[body]]
kind = "Ground"
markers = { foot = [0, 0, 0], above = [0, 0, 1] }

[[body]]
kind = "RigidBody"
name = "ball"
mass = 2.0
inertia = [1, 1, 1]

[[joint]]
kind = "Prismatic"
name = "guide"
markers = ["ground.foot", "ball.center"]

[[force]]
kind = "SpringDamper"
name = "spring"
markers = ["ground.above", "ball.center"]
stiffness = "= stiffness"
damping = 3.0
length = 1.0

[[force]]
kind = "PointLoad"
name = "push"
marker = "ball.center"
force = [0, 0, 0]

[[sensor]]
kind = "Position"
name = "place"
marker = "ball.center"
"""


@pytest.fixture
def oscillator(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "oscillator.toml").write_text(OSCILLATOR)
    return tmp_path


def rows(path):
    with path.open(encoding="utf-8") as file:
        table = list(csv.reader(file))
    return table[0], np.array(table[1:], float)


def test_statics(oscillator, capsys):
    """z = -m g / k."""
    assert main(["statics", "oscillator.toml", "-o", "rest.csv", "--vtk", "rest.pvd"]) == 0
    assert "place: x [m] = 0, y [m] = 0, z [m] = -0.04905" in capsys.readouterr().out
    titles, values = rows(oscillator / "rest.csv")
    assert titles == ["t [s]", "place x [m]", "place y [m]", "place z [m]"]
    assert values.shape == (1, 4)
    assert values[0, 3] == pytest.approx(-MASS * GRAVITY / K, rel=1e-6)
    assert len(list((oscillator / "rest").glob("ball_*.vtu"))) == 1


def test_modes(oscillator, capsys):
    """w = sqrt(k / m - (d / 2 m)^2), zeta = d / (2 sqrt(k m)); a parameter changes them."""
    for stiffness in (400.0, 900.0):
        arguments = ["--set", f"stiffness={stiffness}", "--statics", "--vtk", f"shapes{stiffness:g}"]
        assert main(["modes", "oscillator.toml", *arguments]) == 0
        printed = capsys.readouterr().out
        number, frequency, ratio = printed.splitlines()[1].split()
        assert number == "1"
        damped = np.sqrt(stiffness / MASS - (DAMPING / (2 * MASS)) ** 2) / (2 * np.pi)
        assert float(frequency) == pytest.approx(damped, rel=1e-5)
        assert float(ratio) == pytest.approx(DAMPING / (2 * np.sqrt(stiffness * MASS)), rel=1e-3)
        assert "about the equilibrium\nstable\n" in printed
        assert (oscillator / f"shapes{stiffness:g}" / "mode_1.pvd").exists()


def test_damping_of_nothing_is_zero(tmp_path, capsys):
    """What rounding leaves of it, and its sign, is not printed."""
    (tmp_path / "free.toml").write_text(OSCILLATOR.replace("damping = 3.0", "damping = 0.0"))
    assert main(["modes", str(tmp_path / "free.toml"), "--statics"]) == 0
    assert capsys.readouterr().out.splitlines()[1].split()[2] == "0"


def test_modes_are_those_of_where_runs_begin(tmp_path, monkeypatch, capsys):
    """A pendulum drawn on its side: sqrt(g / l) about its equilibrium, nothing that swings as drawn."""
    monkeypatch.chdir(tmp_path)
    text = """
gravity = [0, 0, -9.81]
body = [{ kind = "Ground" }, { kind = "PointMass", name = "bob", mass = 1.0, at = [2, 0, 0] }]
joint = [{ kind = "Rod", name = "rope", markers = ["ground.origin", "bob.center"] }]
[simulation]
start = "START"
"""
    (tmp_path / "rest.toml").write_text(text.replace("START", "equilibrium"))
    (tmp_path / "drawn.toml").write_text(text.partition("[simulation]")[0])
    assert main(["modes", "rest.toml", "--count", "1"]) == 0
    printed = capsys.readouterr().out
    assert float(printed.splitlines()[1].split()[1]) == pytest.approx(np.sqrt(GRAVITY / 2.0) / (2.0 * np.pi), rel=1e-5)
    assert "about the equilibrium" in printed
    assert main(["modes", "drawn.toml"]) == 0
    printed = capsys.readouterr()
    assert "about the start as drawn" in printed.out
    assert "no equilibrium" in printed.err


def test_linearize(oscillator, capsys):
    arguments = ["--statics", "--input", "push.force.z", "--output", "place z"]
    assert main(["linearize", "oscillator.toml", *arguments]) == 0
    printed = capsys.readouterr().out
    assert "2 states" in printed
    assert "State space: oscillator_plant.mat" in printed
    found = scipy.io.loadmat(oscillator / "oscillator_plant.mat")
    s = 2j * np.pi * 1.7
    response = found["C"] @ np.linalg.solve(s * np.eye(2) - found["A"], found["B"]) + found["D"]
    np.testing.assert_allclose(response[0, 0], 1 / (K + DAMPING * s + MASS * s**2), rtol=1e-6)


def test_bode(oscillator, capsys):
    arguments = ["--statics", "--input", "push.force.z", "--output", "place", "--from", "0.5", "--to", "20"]
    assert main(["bode", "oscillator.toml", *arguments, "--points", "50", "-o", "plots/push.png"]) == 0
    assert (oscillator / "plots/push.png").read_bytes().startswith(b"\x89PNG")
    titles, values = rows(oscillator / "plots/push.csv")
    assert titles[5:] == ["gain place z / push.force.z [m]", "phase place z / push.force.z [deg]"]
    s = 2j * np.pi * values[:, 0]
    assert values[[0, -1], 0] == pytest.approx([0.5, 20.0])
    closed = 1 / (K + DAMPING * s + MASS * s**2)
    np.testing.assert_allclose(values[:, 5], np.abs(closed), rtol=1e-6)
    np.testing.assert_allclose(values[:, 6], np.degrees(np.angle(closed)), atol=1e-4)


PUSHED = """
[[sensor]]
kind = "JointCoordinate"
name = "rise"
joint = "guide"

[[force]]
kind = "Actuator"
name = "drive"
joint = "guide"
effort = { formula = { text = "g*rate(x)", over = { x = "rise" }, parameters = { g = "= gain" } } }
"""


def test_locus(oscillator, capsys):
    """A drive that pushes with the speed takes the damping away: the limit of stability is where both agree.

    The table has the roots of m s^2 + (c - g) s + k.
    """
    text = OSCILLATOR.replace("stiffness = 400.0", "stiffness = 400.0\ngain = 0.0") + PUSHED
    (oscillator / "pushed.toml").write_text(text)
    assert main(["locus", "pushed.toml", "--statics", "--over", "gain=0.5:9.5:7", "-o", "plots/g.png"]) == 0
    printed = capsys.readouterr().out
    limit, _, speed = printed.partition("Limit of stability: gain = ")[2].partition(" rad/s")[0].partition(", at ")
    assert float(limit) == pytest.approx(DAMPING, rel=1e-6)
    assert float(speed) == pytest.approx(np.sqrt(K / MASS), rel=1e-5)
    assert (oscillator / "plots/g.png").read_bytes().startswith(b"\x89PNG")
    titles, values = rows(oscillator / "plots/g.csv")
    parts = [f"{part} part {k} [{unit}]" for k in (1, 2) for part, unit in (("real", "1/s"), ("imaginary", "rad/s"))]
    assert titles == ["gain", *parts]
    for g, *numbers in values:
        found = np.sort_complex([complex(*numbers[:2]), complex(*numbers[2:])])
        np.testing.assert_allclose(found, np.sort_complex(np.roots([MASS, DAMPING - g, K])), atol=1e-5)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["locus", "--over", "stiffness"], "NAME=START:STOP:COUNT"),
        (["locus", "--over", "stifness=1:2:3"], "stiffness"),
        (["locus", "--over", "stiffness=1:2:3", "-o", "a.xyz"], "the ending '.xyz'"),
        (["bode", "--input", "pusch.force.z"], "Did you mean 'push.force.z'?"),
        (["bode", "--output", "plase"], "Did you mean 'place'?"),
        (["bode", "--from", "0"], "600 frequencies from 0 to 100 Hz"),
        (["bode", "--points", "1"], "1 frequencies"),
        (["bode", "--input", "push.force.z", "-o", "a.xyz"], "the ending '.xyz'"),
        (["bode", "--input", "push.force.x"], "no output answers any input"),
        (["linearize", "--input", "push"], "input 'push' may be 6 signals"),
        (["linearize", "-o", "plant.txt"], "the ending '.txt'"),
        (["modes", "--count", "0"], "--count 0"),
        (["statics", "--time", "nan"], "t = nan"),
    ],
)
def test_what_cannot_be_asked(oscillator, capsys, arguments, told):
    verb, *rest = arguments
    assert main([verb, "oscillator.toml", *rest]) == 2
    assert told in capsys.readouterr().err


def test_psd(oscillator, capsys):
    """White noise G of the force: variance of the place G / (4 c k), density at the bottom G / k^2."""
    command = ["psd", "oscillator.toml", "--statics", "--input", "push.force.z", "--output", "place z"]
    assert main([*command, "--density", "0.5", "--from", "1e-3", "--to", "1e3", "--points", "20000"]) == 0
    said = capsys.readouterr().out
    root = float(said.split("place z: ")[1].split()[0])
    assert root == pytest.approx(np.sqrt(0.5 / (4.0 * DAMPING * K)), rel=1e-3)
    titles, values = rows(oscillator / "oscillator_psd.csv")
    assert titles == ["f [Hz]", "psd place z [(m)^2/Hz]"]
    assert values[0, 1] == pytest.approx(0.5 / K**2, rel=1e-6)
    assert (oscillator / "oscillator_psd.png").stat().st_size > 5000


@pytest.mark.parametrize("damping", [0.3, 3e-3, 1e-6])
def test_root_mean_square_over_a_narrow_resonance(oscillator, capsys, damping):
    """White noise: G / (4 c k), also where the peak is a thousandth of a step of the frequencies or less."""
    text = OSCILLATOR.replace("damping = 3.0", f"damping = {damping}")
    (oscillator / "oscillator.toml").write_text(text)
    command = ["psd", "oscillator.toml", "--statics", "--input", "push.force.z", "--output", "place z"]
    assert main([*command, "--density", "0.5", "--from", "0.1", "--to", "50"]) == 0
    root = float(capsys.readouterr().out.split("place z: ")[1].split()[0])
    assert root == pytest.approx(np.sqrt(0.5 / (4.0 * damping * K)), rel=1e-3)
    assert len(rows(oscillator / "oscillator_psd.csv")[1]) == 600


def test_psd_of_a_table(oscillator, capsys):
    """Between rows the density is a power of the frequency, outside zero."""
    (oscillator / "push.csv").write_text("f,G\n1.0,2.0\n100.0,0.02\n")
    command = ["psd", "oscillator.toml", "--statics", "--input", "push.force.z", "--output", "place z"]
    assert main([*command, "--density", "push.csv", "--from", "0.5", "--to", "50", "--points", "41"]) == 0
    f, found = rows(oscillator / "oscillator_psd.csv")[1].T
    w = 2.0 * np.pi * f
    gain = 1.0 / ((K - MASS * w**2) ** 2 + (DAMPING * w) ** 2)
    assert found == pytest.approx(np.where(f >= 1.0, 2.0 / f, 0.0) * gain, rel=1e-6)


@pytest.mark.parametrize(
    ("density", "told"),
    [
        (["1", "2"], "2 densities"),
        (["-1"], "density >= 0"),
        (["none.csv"], "a file with rows"),
        (["bad.csv"], "1 rows"),
    ],
)
def test_wrong_densities_are_said(oscillator, capsys, density, told):
    (oscillator / "bad.csv").write_text("1.0,2.0\n")
    given = [word for value in density for word in ("--density", value)]
    assert main(["psd", "oscillator.toml", "--input", "push.force.z", *given]) == 2
    assert told in capsys.readouterr().err


@pytest.mark.render
@pytest.mark.parametrize("stiffness", [400.0, 0.04])
def test_a_mode_begins_at_an_end(oscillator, stiffness):
    """Ends at the begin and after half a period, whatever phase the eigenvector has: pictures show these."""
    text = OSCILLATOR.replace("stiffness = 400.0", f"stiffness = {stiffness}").replace(
        "damping = 3.0", "damping = 0.01"
    )
    (oscillator / "oscillator.toml").write_text(text.replace("-9.81", "0"))
    model = fmb.load_model("oscillator.toml")
    mode = int(np.flatnonzero(fmb.linearize(model).frequencies > 0.0)[0])
    z = fmb.mode_motion(model, mode=mode)["place"][:, 2]
    assert abs(z[0] - z[12]) == pytest.approx(np.ptp(z), rel=1e-6)


def test_pictures_of_modes(oscillator, capsys):
    """The ball stands at three heights, so its colours cover more rows than in a picture of one."""
    from matplotlib.image import imread

    assert main(["modes", "oscillator.toml", "--statics", "--picture", "drawn"]) == 0
    assert "mode 1: 2.24" in capsys.readouterr().out
    picture = imread(oscillator / "drawn" / "mode_1.png")[..., :3]
    assert (np.abs(picture - picture[0, 0]).max(axis=2) > 0.1).mean() > 1e-3


def test_outputs_that_follow_rates_are_left_out_unless_they_are_named(oscillator, capsys):
    """A driven mass needs the force m s'': no state space has it; the ball on its spring does not move with it."""
    rail = """
[[body]]
kind = "PointMass"
name = "cart"
mass = 1.0

[[joint]]
kind = "Prismatic"
name = "rail"
markers = ["ground.above", "cart.center"]

[[joint]]
kind = "Drive"
name = "shaker"
joint = "rail"
displacement = 1.0

[[sensor]]
kind = "Reaction"
name = "needed"
joint = "shaker"
"""
    (oscillator / "driven.toml").write_text(OSCILLATOR + rail)
    command = ["linearize", "driven.toml", "--statics", "--input", "shaker"]
    assert main([*command, "--output", "needed fz", "-o", "named.mat"]) == 2
    assert "output 'needed fz' follows the rates of the input" in capsys.readouterr().err
    assert not (oscillator / "named.mat").exists()
    assert main([*command, "-o", "plant.mat"]) == 0
    told = capsys.readouterr().out
    assert "left out, as they follow the rates of an input, which no state space can say: needed fz\n" in told
    outputs = [str(name[0][0]) for name in scipy.io.loadmat(oscillator / "plant.mat")["outputs"]]
    assert "place z" in outputs
    assert "needed fx" in outputs  # zero
    assert "needed fz" not in outputs


def test_the_ending_of_a_plant_is_looked_at_first(tmp_path, capsys):
    """Before the model, which does not even exist here."""
    assert main(["linearize", str(tmp_path / "none.toml"), "-o", "x.npz"]) == 2
    assert "Expected: .mat" in capsys.readouterr().err
