"""`flexmb cache`, and parts of finite elements in sweeps: every variant is reduced once, by whichever process is first.

Reference: frequencies and deflections of cantilevers in closed form.
"""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import flexmb as fmb
from flexmb.cli import main

SHAFT = """
[parameters]
GJ = 1.5e6
moment = 100.0
[[body]]
kind = "Ground"
markers = { wall = [0, 0, 0] }
[[body]]
kind = "FloatingBody"
name = "flap"
[body.data]
interfaces = { root = "start", tip = "end" }
modes = 2
[[body.data.pieces]]
kind = "Line"
points = [[0, 0, 0], [0, 2, 0]]
elements = 6
material = "aluminium"
[body.data.pieces.section]
kind = "Section.values"
area = 4e-3
inertia_y = 3e-5
inertia_z = 3e-4
torsion = "= GJ*2*(1 + 0.33)/71.7e9"
[[joint]]
kind = "Fixed"
name = "clamp"
markers = ["ground.wall", "flap.root"]
[[force]]
kind = "PointLoad"
name = "twist"
marker = "flap.tip"
moment = [0, "= moment", 0]
[[sensor]]
kind = "Orientation"
name = "turn"
marker = "flap.tip"
[simulation]
t_end = 1e-4
samples = 2
start = "equilibrium"
"""


@pytest.fixture
def file(tmp_path, monkeypatch):
    monkeypatch.setenv("FLEXMB_BODIES", str(tmp_path / "bodies"))
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "shaft.toml"
    path.write_text(SHAFT)
    return path


def test_threads_count_as_well(file):
    """The variants of an executor, and the first one, which is looked at before: each part once."""
    over = {"GJ": [1e6, 1.5e6, 2e6]}
    for expected in (3, 0):
        with ThreadPoolExecutor(1) as threads:
            results = fmb.sweep(file, over, outputs=["final(turn)"], executor=threads)
        assert results.reduced == expected
        assert not results.failed


@pytest.mark.slow
def test_a_sweep_reduces_each_variant_once(file, capsys):
    """Twenty values of G J on two processes: twenty reductions; a second sweep of the same values: none."""
    command = ["sweep", "shaft.toml", "--over", "GJ=5e5:2e6:20", "--jobs", "2", "--output", "final(turn)"]
    assert main([*command, "--out", "first"]) == 0
    assert "Parts of finite elements: 20 reduced" in capsys.readouterr().out
    assert main([*command, "--out", "second", "--set", "moment=50"]) == 0
    assert "Parts of finite elements: 0 reduced" in capsys.readouterr().out
    table = np.genfromtxt(file.parent / "first" / "results.csv", delimiter=",", names=True, usecols=range(10))
    angle = 2.0 * np.arcsin(table[next(n for n in table.dtype.names if n.startswith("finalturn_") and "2" in n)])
    assert angle * table["GJ"] == pytest.approx(100.0 * 2.0, rel=1e-6)  # M L / (G J)


def test_listing_and_clearing(file, capsys):
    assert main(["check", "shaft.toml"]) == 0
    assert "part 'flap' reduced in" in capsys.readouterr().err
    assert main(["check", "shaft.toml", "--set", "GJ=1e6"]) == 0
    assert main(["check", "shaft.toml"]) == 0
    capsys.readouterr()
    assert main(["cache"]) == 0
    out = capsys.readouterr().out
    assert out.count("flap-") == 2
    assert "2 parts," in out
    assert main(["cache", "--clear", "flab"]) == 0
    assert "Did you mean 'flap'" in capsys.readouterr().out
    assert main(["cache", "--clear", "flap"]) == 0
    assert "Removed 2 parts" in capsys.readouterr().out
    assert not list((file.parent / "bodies").glob("*.h5"))
    assert fmb.load_model(file)
    assert main(["cache", "--clear"]) == 0
    assert "Removed 1 parts" in capsys.readouterr().out
