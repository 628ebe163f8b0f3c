"""Runs whose statistics, samples and sensors hold what no run writes: a page, a plot or a message."""

import json
import shutil

import h5py
import numpy as np
import pytest

import flexmb as fmb
from flexmb import hdf5_seal
from flexmb.cli import main

VALUES = (
    np.nan,
    None,
    np.inf,
    1e308,
    10**400,
    "x",
    [],
    {},
    [1, [2]],
    {"a": {"b": None}},
    {"a": 1},
    True,
    -1,
    "9" * 4000,
)
COLUMNS = ("not json", "[]", "[1]", "{}", "null")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A run folder."""
    folder = tmp_path_factory.mktemp("whole")
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(),
            fmb.RigidBody("arm", mass=1.0, inertia=(1, 1, 1), at=(0.5, 0, 0), markers={"A": (-0.5, 0, 0)}),
        ],
        joints=[fmb.Revolute("hinge", markers=("ground.origin", "arm.A"))],
        sensors=[fmb.Position("place", marker="arm.center"), fmb.Energy("energy")],
    )
    fmb.save_model(model, folder / "arm.toml", fmb.Simulation(t_end=0.1, samples=11))
    assert main(["run", str(folder / "arm.toml"), "--out", str(folder / "run")]) == 0
    return folder / "run"


@pytest.fixture
def changed(whole, tmp_path):
    """Return a function that changes the file of a copy of the run, with a right seal, and uses it."""

    def use(change) -> list[int]:
        shutil.copytree(whole, tmp_path / "run", dirs_exist_ok=True)
        path = tmp_path / "run" / "solution.h5"
        with h5py.File(path, "r+") as file:
            change(file)
        hdf5_seal.seal(path)
        run = str(tmp_path / "run")
        return [main(["report", run, "--no-pictures"]), main(["plot", run, "place"]), main(["export", run, "--csv"])]

    return use


@pytest.mark.parametrize("number", range(len(VALUES)))
def test_statistics(changed, number):
    def change(file):
        found = json.loads(file.attrs["statistics"])
        for name in (*found, "share of validity", "errors added up", "seconds"):
            if name not in ("warnings", "notes"):  # lists of sentences: refused where they are none
                found[name] = VALUES[number]
        file.attrs["statistics"] = json.dumps(found)

    assert changed(change) == [0, 0, 0]


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e308, -1e308, 5e-324])
def test_sensors(changed, value):
    def change(file):
        data = file["phases/0/sensors/0"]
        data[...] = np.where(np.arange(11)[:, None] == 5, value, -data[...])

    assert changed(change) == [0, 0, 0]


@pytest.mark.parametrize("name", ["t", "q", "u"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_samples(changed, capsys, name, value):
    def change(file):
        file[f"phases/0/{name}"][7] = value

    assert changed(change) == [2, 2, 2]
    assert f"samples whose {name} are no numbers" in capsys.readouterr().err


@pytest.mark.parametrize("text", COLUMNS)
def test_titles(changed, text):
    def change(file):
        file["phases/0/sensors/0"].attrs["columns"] = text

    assert set(changed(change)) <= {0, 2}


def test_another_end(whole, tmp_path, capsys):
    """A phase that ended by an event that its model does not have."""
    shutil.copytree(whole, tmp_path / "run")
    path = tmp_path / "run" / "solution.h5"
    with h5py.File(path, "r+") as file:
        file["phases/0"].attrs["ended"] = "{}"
    hdf5_seal.seal(path)
    assert main(["resume", str(tmp_path / "run"), "--t-end", "0.2"]) == 2
    assert "ended by '{}', which is no event of its model" in capsys.readouterr().err


def test_another_integrator(whole, tmp_path):
    """`verify` of a run whose integrator is a number knows none."""
    shutil.copytree(whole, tmp_path / "run")
    path = tmp_path / "run" / "solution.h5"
    with h5py.File(path, "r+") as file:
        found = json.loads(file.attrs["statistics"])
        file.attrs["statistics"] = json.dumps({**found, "integrator": 1e308})
    hdf5_seal.seal(path)
    solution = fmb.Solution.load(path, read_model=fmb.read_model_text)
    assert "no other runs: the solution does not say by which integrator" in str(fmb.verify(solution))
