"""Tracks, moving loads and bases of runs in model files and on the command line, beside Inglis' closed form
(A Mathematical Treatise on Vibrations in Railway Bridges, 1934)."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import ModelError

LENGTH, SIDE, FORCE, SPEED = 4.0, 0.05, 200.0, 12.0
STEEL = fmb.MATERIALS["steel"]

BRIDGE = """
[parameters]
force = 200.0
speed = 12.0
[[body]]
kind = "Ground"
markers = { A = { at = [0, 0, 0], z = [0, 1, 0] }, B = [4, 0, 0] }
[[body]]
kind = "FloatingBody"
name = "beam"
markers = { a = { at = [0, 0, 0], z = [0, 1, 0] } }
[body.data]
interfaces = { a = "start", b = "end" }
stations = { mid = "middle" }
modes = 0
compare = 0
BASIS
loads = { rail = { kind = "Track", where = "rail", direction = [0, 0, -1] } }
[[body.data.pieces]]
kind = "Line"
points = [[0, 0, 0], [4, 0, 0]]
section = { kind = "Section.rectangle", width = 0.05, height = 0.05 }
material = "steel"
elements = 32
nodes = { middle = 0.5, rail = RAIL }
[[joint]]
kind = "Revolute"
name = "left"
markers = ["ground.A", "beam.a"]
[[joint]]
kind = "PointOnPlane"
name = "right"
markers = ["ground.B", "beam.b"]
[[moving_load]]
name = "roller"
load = "beam.rail"
amount = "= force"
along = { ramp = { rate = "= speed" } }
[[sensor]]
kind = "Position"
name = "mid"
marker = "beam.mid"
"""


def bridge(tmp_path, basis="", **changes):
    text = BRIDGE.replace("BASIS", basis).replace("RAIL", str([round(k / 32, 6) for k in range(33)]))
    for old, new in changes.items():
        text = text.replace(old, new)
    path = tmp_path / "bridge.toml"
    path.write_text(text)
    return path


def inglis(t, x):
    """Deflection of a simply supported beam without damping under a force that came onto it at t = 0."""
    EI, rhoA = STEEL.young * SIDE**4 / 12, STEEL.density * SIDE**2
    n = np.arange(1, 200)[:, None]
    w = (n * np.pi / LENGTH) ** 2 * np.sqrt(EI / rhoA)
    drive = n * np.pi * SPEED / LENGTH
    share = 2.0 * FORCE / (rhoA * LENGTH * (w**2 - drive**2))
    return np.sum(share * (np.sin(drive * t) - drive / w * np.sin(w * t)) * np.sin(n * np.pi * x / LENGTH), axis=0)


def crossed(model):
    solution = fmb.simulate(model, LENGTH / SPEED, samples=101)
    t = np.linspace(0.0, LENGTH / SPEED, 101)
    exact = inglis(t, LENGTH / 2)
    return solution, np.abs(-solution["mid"][:, 2] - exact).max() / np.abs(exact).max()


def test_a_model_file_lets_a_load_cross_a_bridge_with_a_basis_of_a_run(tmp_path, monkeypatch):
    """The file alone meets Inglis, and so does a smaller basis of what that run did, with fewer shapes."""
    monkeypatch.setenv("FLEXMB_BODIES", str(tmp_path / "bodies"))  # a reduction that is kept warns no more
    model = fmb.load_model(bridge(tmp_path))
    assert len(model.forces) == 33
    solution, error = crossed(model)
    assert error < 0.01
    solution.save(tmp_path / "first.h5", fmb.model_text)
    pod = 'basis = { kind = "Pod", run = "first.h5#beam", energy = 0.9999 }'
    with pytest.warns(UserWarning, match="5 independent ways"):  # the run did not stretch the beam
        small = fmb.load_model(bridge(tmp_path, pod, **{"modes = 0\n": ""}))
    before, after = (one.body("beam").data.n_modes for one in (model, small))
    assert after <= before
    assert small.body("beam").data.quality["basis"].startswith("Pod(")
    assert crossed(small)[1] < 0.012
    again = fmb.load_model(save(small, tmp_path / "again.toml"))
    assert [force.load for force in again.forces] == [force.load for force in small.forces]


def test_all_loads_join_but_the_tracks(tmp_path, monkeypatch):
    """Their shapes join by themselves: "all" are the others, and a track that is named is told to be left out."""
    monkeypatch.setenv("FLEXMB_BODIES", str(tmp_path / "bodies"))
    side = {"loads = {": 'loads = { side = { kind = "Forces", on = "middle", force = [0, 1, 0] },'}
    without, every = (
        fmb.load_model(bridge(tmp_path, basis, **side)).body("beam").data for basis in ("", 'residual_vectors = "all"')
    )
    assert every.load_names == without.load_names
    assert every.n_modes == without.n_modes + 1
    with pytest.raises(fmb.FlexmbError, match=r"its shapes join by themselves\. One of: side\. Leave it out"):
        fmb.load_model(bridge(tmp_path, 'residual_vectors = ["rail"]', **side))


def save(model, path):
    fmb.save_model(model, path)
    return path


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('load = "beam.rail"', 'load = "beam.rial"', "no track 'rial'"),
        ('load = "beam.rail"', 'load = "rail"', "load = 'rail'"),
        ('load = "beam.rail"\namount', "amount", "no field 'load'"),
        ('load = "beam.rail"', 'load = "ground.rail"', "no reduced data"),
        ('load = "beam.rail"', 'load = "bean.rail"', "'beam'"),
        ('amount = "= force"', "", "'amount' is missing"),
        ('amount = "= force"', 'size = "= force"', "no field 'size'"),
    ],
)
def test_wrong_moving_loads_are_named(tmp_path, old, new, words):
    with pytest.raises(ModelError, match=r"\[\[moving_load\]\]") as caught:
        fmb.load_model(bridge(tmp_path, **{old: new}))
    assert words in str(caught.value)


@pytest.mark.parametrize("run", ["3", '"first.h5"', '"absent.h5#beam"'])
def test_a_basis_of_a_run_needs_that_run(tmp_path, run):
    with pytest.raises(fmb.FlexmbError, match="absent" if "absent" in run else "run"):
        fmb.load_model(bridge(tmp_path, f'basis = {{ kind = "Pod", run = {run} }}', **{"modes = 0\n": ""}))
